//! The slam-align service: tracks the pose, searches in the background, publishes accepted poses.

mod publication;

use crate::persisted_state::PersistedState;
use crate::reference_inputs::ReferenceInputs;
use crate::robot_map::RobotMap;
use crate::worker::{Job, JobOutcome, SearchArea, Worker, WorkerTask};
use alignment::{Alignment, Follower, Hint, MaxJump, PreparedMap, track_map};
use bus::{Bus, CheckedSample, SiteSample, SiteSamples, topics};
use daemon::facts::{AlignFacts, AlignmentSummary};
use daemon::{
    AlignConfig, AlignRequest, Asked, CurrentActivity, Done, Epochs, Event, Failure, LatchedOutput, PoseHint,
    Published, Service, SiteConfig, Standing, StateFile,
};
use frames::Map;
use messages::{Activity, AlignmentVerdict, PoseState};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};
use tracing::{info, warn};

/// Interval at which the worker is polled.
const POLL_INTERVAL: Duration = Duration::from_millis(20);

daemon::inputs! {
    /// What poses and deviations are made from. The index of the grids names the robot.
    pub(crate) enum AlignInput { Site, ScheduleState, Grids, SlamMap }
}

/// Follows a robot's map.
pub(crate) struct AlignService {
    config: AlignConfig,
    state: StateFile,
    /// Table of observed progress, for schedule-eval.
    table: PathBuf,
    persisted: PersistedState,
    epochs: Epochs,
    activity: CurrentActivity,
    bus: Option<Bus>,
    alignment: LatchedOutput<topics::Alignment>,
    deviations: LatchedOutput<topics::Deviations>,
    /// The newest samples; those of a job are with the worker while it works.
    samples: SiteSamples,
    map: Option<Arc<RobotMap>>,
    worker: Worker,
    /// Of the site as planned, by map storey.
    references: Vec<Arc<PreparedMap<Map>>>,
    reference_inputs: ReferenceInputs,
    follower: Follower,
    /// The result of the last search.
    last_search: Alignment,
    /// The map that it searched.
    searched_map_hash: u64,
    pending: PendingWork,
}

/// Work for the worker.
#[derive(Debug, Clone, Copy, Default)]
struct PendingWork {
    /// The site has changed: draw the references again.
    refresh: bool,
    /// A new map: search its pose.
    search: bool,
    /// A new pose: compare its map with the site.
    compare: bool,
}

impl AlignService {
    /// From the configuration and the persisted state.
    ///
    /// # Errors
    /// State that cannot be used.
    pub(crate) fn new(config: &SiteConfig, activity: CurrentActivity) -> Result<Self, Failure> {
        let state = StateFile::at(&config.state, "alignment.json")?;
        let persisted: PersistedState = state.load()?.unwrap_or_default();
        Ok(Self {
            follower: Follower::new(max_jump(&config.align), persisted.pose()),
            config: config.align.clone(),
            table: config.state.join("slam-align-observed.csv"),
            state,
            persisted,
            epochs: Epochs::at(&config.state, "slam-align-epochs.json")?,
            activity,
            bus: None,
            alignment: LatchedOutput::new(topics::Alignment),
            deviations: LatchedOutput::new(topics::Deviations),
            samples: SiteSamples::default(),
            map: None,
            worker: Worker::start()?,
            references: Vec::new(),
            reference_inputs: ReferenceInputs::default(),
            last_search: Alignment::nothing_yet(),
            searched_map_hash: 0,
            pending: PendingWork::default(),
        })
    }

    fn handle_site(&mut self, site: CheckedSample<topics::Site>) -> Result<(), Failure> {
        let frame_epoch = site.bytes().header().frame_epoch;
        if self.persisted.is_of_another_frame(frame_epoch) {
            warn!(service = "slam-align", frame_epoch, "the map frame is another: the pose is forgotten");
            self.follower.forget();
            self.persist(|persisted| persisted.forget_pose())?;
        }
        let n_storeys = site.view().map_storeys.len();
        if self.follower.pose().is_some_and(|pose| pose.map_storey as usize >= n_storeys) {
            self.follower.forget();
        }
        self.samples.insert(SiteSample::Site(site));
        self.pending.refresh = true;
        Ok(())
    }

    /// A newer map of the robot: followed at once, searched later.
    fn handle_slam_map(&mut self, map: RobotMap) -> Result<(), Failure> {
        let begun = Instant::now();
        let map = self.map.insert(Arc::new(map)).clone();
        self.pending.search = true;
        if !self.references.is_empty() {
            self.follow(&map);
            let elapsed_us = u64::try_from(begun.elapsed().as_micros()).unwrap_or(u64::MAX);
            info!(service = "slam-align", state = self.follower.state().name(), elapsed_us, "map followed");
            self.publish()?;
        }
        Ok(())
    }

    fn follow(&mut self, map: &RobotMap) {
        let Some(last) = self.follower.pose() else { return };
        let tracked = track_map(&self.references, &map.prepared, (last.map_storey as usize, &last.map_from_slam()));
        self.follower.tracked(tracked.map(|pose| pose.record(&self.storeys())));
    }

    /// Indices of the references are map storeys.
    fn storeys(&self) -> Vec<u32> {
        (0..self.references.len() as u32).collect()
    }

    /// Starts the next job and takes results of the last one.
    fn proceed(&mut self) -> Result<Done, Failure> {
        while let Some(outcome) = self.worker.take()? {
            self.finish(outcome, false)?;
        }
        if let Some(map) = self.map.clone().filter(|_| !self.worker.is_busy()) {
            let is_good = matches!(self.follower.state(), PoseState::Found | PoseState::Tracked);
            match self.follower.pose().copied() {
                _ if self.pending.search => self.begin(WorkerTask::Search(map, self.search_area()))?,
                _ if self.pending.refresh => self.begin(WorkerTask::Draw)?,
                Some(pose) if self.pending.compare && is_good => self.begin(WorkerTask::Compare(map, pose))?,
                _ => {}
            }
        }
        let wake_in = self.worker.is_busy().then_some(POLL_INTERVAL);
        Ok(Done { wake_in, ..self.done() })
    }

    /// Starts a job, if the samples belong together; if not, those that are missing are on their way.
    fn begin(&mut self, task: WorkerTask) -> Result<(), Failure> {
        if ReferenceInputs::of(&self.samples).is_none() {
            return Ok(());
        }
        self.activity.set(Activity::Reading);
        self.pending.refresh = false;
        match task {
            WorkerTask::Draw => {}
            WorkerTask::Search(..) => self.pending.search = false,
            WorkerTask::Compare(..) => self.pending.compare = false,
        }
        self.worker.begin(Job { samples: std::mem::take(&mut self.samples), task })
    }

    /// Takes the result of a job; `is_asked` if a client waits for it.
    fn finish(&mut self, outcome: JobOutcome, is_asked: bool) -> Result<(), Failure> {
        let JobOutcome { samples, found } = outcome;
        let reference_inputs = ReferenceInputs::of(&samples);
        // Newer samples have come meanwhile, or these are still the newest.
        self.samples.take_back(samples);
        let found = found?;
        self.references = found.references;
        self.reference_inputs = reference_inputs.unwrap_or_default();
        if let Some(deviations) = found.deviations {
            return self.publish_deviations(deviations);
        }
        if let Some(map) = self.map.clone() {
            self.follow(&map);
        }
        if let Some((alignment, searched_map_hash)) = found.alignment {
            let best = alignment.poses.first().filter(|_| alignment.verdict == AlignmentVerdict::Accepted);
            self.follower.searched(best.map(|pose| pose.record(&self.storeys())), is_asked);
            let (verdict, poses) = (alignment.verdict.name(), alignment.poses.len());
            info!(service = "slam-align", verdict, poses, reason = alignment.reason, "all poses searched");
            (self.last_search, self.searched_map_hash) = (alignment, searched_map_hash);
        }
        self.pending.compare = true;
        self.publish()
    }

    /// The search area of the configuration.
    fn search_area(&self) -> SearchArea {
        SearchArea { hint: self.config.hint.map(hint_of), storey: self.config.storey }
    }

    /// Searches all poses now, on request; without a site it is done when there is one.
    fn search_now(&mut self, search_area: SearchArea) -> Result<Done, Failure> {
        let map = self.map.clone().ok_or("there is no SLAM map yet: give one with slam-map")?;
        self.wait_for_worker()?;
        self.begin(WorkerTask::Search(map, search_area))?;
        if self.worker.is_busy() {
            let outcome = self.worker.wait()?;
            self.finish(outcome, true)?;
        }
        self.proceed()
    }

    /// Waits for the running job: then the samples are back.
    fn wait_for_worker(&mut self) -> Result<(), Failure> {
        if self.worker.is_busy() {
            let outcome = self.worker.wait()?;
            self.finish(outcome, false)?;
        }
        Ok(())
    }

    fn read_map(&mut self, file: PathBuf) -> Result<Done, Failure> {
        let map = RobotMap::read(&file)?;
        self.persist(|persisted| persisted.map = Some(file))?;
        self.handle_slam_map(map)?;
        self.search_now(self.search_area())
    }

    /// Confirms the pending pose, or elements that are absent.
    fn confirm(&mut self, absent: &[String]) -> Result<Done, Failure> {
        if absent.is_empty() {
            let pose = self.follower.confirm().ok_or("no pose waits to be confirmed")?;
            self.persist_pose(&pose)?;
            info!(service = "slam-align", map_storey = pose.map_storey, "pose confirmed");
            (self.pending.refresh, self.pending.compare) = (true, true);
            self.publish()?;
            return self.proceed();
        }
        self.wait_for_worker()?;
        let (Some(site), Some(deviations)) = (self.samples.site(), self.deviations.last()) else {
            return Err("nothing was compared yet".into());
        };
        let deviations = deviations.view();
        deviations.check_site(&site.view())?;
        let observed = self.persisted.observed.with_absent(absent, &site.view(), &deviations)?;
        self.set_observed(observed)?;
        self.proceed()
    }

    fn done(&self) -> Done {
        Done { published: self.alignment.published(), ..Done::default() }
    }

    fn warning(&self) -> Option<String> {
        if self.follower.waiting().is_some() {
            return Some("pose_waits: the pose would change by more than max_jump: groundplan confirm".to_owned());
        }
        let is_held = self.map.is_some() && self.follower.state() == PoseState::Held;
        is_held.then(|| "pose_held: the newest SLAM map does not bear the pose out".to_owned())
    }

    fn configure(&mut self, config: &SiteConfig) -> Result<Done, Failure> {
        let is_other_map = self.config.map != config.align.map;
        let is_applied_otherwise = self.config.apply != config.align.apply;
        self.config = config.align.clone();
        self.follower.set_max_jump(max_jump(&self.config));
        if is_applied_otherwise {
            self.apply(&self.persisted.observed)?;
        }
        if is_other_map && self.persisted.map.is_none() {
            self.read_first_map()?;
        }
        self.proceed()
    }

    /// Reads the map of the last request, or the configured one.
    fn read_first_map(&mut self) -> Result<(), Failure> {
        match self.persisted.map.clone().or_else(|| self.config.map.clone()) {
            Some(file) => self.handle_slam_map(RobotMap::read(&file)?),
            None => Ok(()),
        }
    }
}

fn max_jump(config: &AlignConfig) -> MaxJump {
    MaxJump { m: config.max_jump_m, rad: config.max_jump_deg.to_radians() }
}

fn hint_of(hint: PoseHint) -> Hint {
    Hint::in_degrees([hint.x_m, hint.y_m, hint.yaw_deg], hint.radius_m, hint.radius_deg)
}

impl Service for AlignService {
    type Input = AlignInput;
    type Request = AlignRequest;
    type Facts = AlignFacts;

    fn attach(&mut self, bus: &Bus) -> Result<(), Failure> {
        if self.worker.is_busy() {
            // Its samples belong to a generation of the bus that is gone.
            drop(self.worker.wait()?);
        }
        self.samples = SiteSamples::default();
        self.bus = Some(bus.clone());
        self.alignment.attach(bus, &mut self.epochs)?;
        self.deviations.attach(bus, &mut self.epochs)
    }

    fn handle(&mut self, event: Event<AlignInput>) -> Result<Done, Failure> {
        match event {
            Event::Input(AlignInput::Site(site)) => self.handle_site(site)?,
            Event::Input(AlignInput::ScheduleState(state)) => {
                self.samples.insert(SiteSample::ScheduleState(state));
                self.pending.refresh = true;
            }
            Event::Input(AlignInput::SlamMap(map)) => self.handle_slam_map(RobotMap::of_archive(&map.view())?)?,
            Event::Input(AlignInput::Grids(index)) => self.samples.insert(SiteSample::Index(index)),
            Event::Configuration(config) => return self.configure(&config),
            Event::Attached if self.map.is_none() => self.read_first_map()?,
            Event::Attached => {}
            Event::Tick => {
                self.alignment.retry(&mut self.epochs)?;
                self.deviations.retry(&mut self.epochs)?;
            }
        }
        self.proceed()
    }

    fn answer(&mut self, request: AlignRequest, _asked: &Asked) -> Result<Done<Published>, Failure> {
        let done = match request {
            AlignRequest::ReadSlamMap { file } => self.read_map(file)?,
            AlignRequest::Align { hint, storey } => self.search_now(SearchArea { hint: hint.map(hint_of), storey })?,
            AlignRequest::Confirm { absent } => self.confirm(&absent)?,
        };
        Ok(done.answered_by_published())
    }

    fn standing(&self) -> Standing {
        Standing { error: None, warning: self.warning() }
    }

    fn facts(&self) -> AlignFacts {
        let epoch = self.alignment.epoch();
        let summary = self.alignment.last().map(|last| AlignmentSummary::of(epoch, &last.view()));
        AlignFacts { alignment: summary }
    }
}
