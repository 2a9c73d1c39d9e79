//! Alignment as a daemon: follows the robot's map, searches in the background, publishes poses that are accepted.

use crate::alignment::{Alignment, Hint, MapFromSlam, PreparedMap};
use crate::archives::{Counting, MadeFrom};
use crate::follower::{Follower, MaxJump};
use crate::kept::Kept;
use crate::robot_map::RobotMap;
use crate::track::track_map;
use crate::worker::{Inputs, Job, Outcome, Where, Worker};
use bus::{Bus, Origin, Publisher, Sample, Topic};
use daemon::{AlignConfig, Answer, Done, Epochs, Event, Failure, Request, Service, SiteConfig, Stages, StateFile};
use messages::{ArchiveBuffer, CheckedSite, Grids, InputHashes, Phase, PoseRecord, PoseState, Site, Stage, Verdict};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};
use tracing::{info, warn};

/// How often a search is looked after.
const LOOK: Duration = Duration::from_millis(20);

/// Follows a robot's map.
pub struct AlignService {
    config: AlignConfig,
    state: StateFile,
    kept: Kept,
    epochs: Epochs,
    stages: Stages,
    publisher: Option<Publisher>,
    site: Option<CheckedSite<Sample>>,
    phase: Option<Sample>,
    index: Option<Sample>,
    map: Option<Arc<RobotMap>>,
    worker: Worker,
    /// Of the site as planned, by map storey.
    references: Vec<Arc<PreparedMap>>,
    /// What the references were made from.
    made_from: InputHashes,
    follower: Follower,
    /// What the last search found, of whatever map.
    searched: Alignment,
    to_do: ToDo,
    last: Option<Published>,
}

/// What the worker is to do next.
#[derive(Debug, Clone, Copy, Default)]
struct ToDo {
    /// The site looks different.
    refresh: bool,
    /// There is a map of which no pose was searched.
    search: bool,
}

struct Published {
    alignment: ArchiveBuffer,
    content_hash: u64,
    origin: Origin,
}

impl AlignService {
    /// From the configuration and what survived.
    ///
    /// # Errors
    /// State that cannot be used.
    pub fn new(config: &SiteConfig, stages: Stages) -> Result<Self, Failure> {
        let state = StateFile::at(&config.state, "alignment.json")?;
        let kept: Kept = state.load()?.unwrap_or_default();
        Ok(Self {
            follower: Follower::new(max_jump(&config.align), kept.pose()),
            config: config.align.clone(),
            state,
            kept,
            epochs: Epochs::at(&config.state, "slam-align-epochs.json")?,
            stages,
            publisher: None,
            site: None,
            phase: None,
            index: None,
            map: None,
            worker: Worker::start()?,
            references: Vec::new(),
            made_from: InputHashes::default(),
            searched: Alignment::nothing_yet(),
            to_do: ToDo::default(),
            last: None,
        })
    }

    fn see_site(&mut self, sample: Sample) -> Result<(), Failure> {
        let frame_epoch = sample.header().frame_epoch;
        if self.kept.is_of_another_frame(frame_epoch) {
            warn!(service = "slam-align", frame_epoch, "the map frame is another: the pose is forgotten");
            self.follower.forget();
            self.keep(|kept| kept.forget_pose())?;
        }
        let n_storeys = Site::open(sample.bytes())?.map_storeys.len();
        if self.follower.pose().is_some_and(|pose| pose.map_storey as usize >= n_storeys) {
            self.follower.forget();
        }
        self.site = Some(CheckedSite::new(sample)?);
        self.to_do.refresh = true;
        Ok(())
    }

    /// A newer map of the robot: followed at once, searched later.
    fn see_map(&mut self, map: RobotMap) -> Result<(), Failure> {
        let begun = Instant::now();
        let map = self.map.insert(Arc::new(map)).clone();
        self.to_do.search = true;
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
        let tracked = track_map(&self.references, &map.prepared, (last.map_storey as usize, &MapFromSlam::from(last)));
        self.follower.tracked(tracked.map(|pose| pose.record(&self.storeys())));
    }

    /// Places of the references are map storeys.
    fn storeys(&self) -> Vec<u32> {
        (0..self.references.len() as u32).collect()
    }

    /// Gives the worker what is to be done, and takes what it has done.
    fn proceed(&mut self) -> Result<Done, Failure> {
        while let Some(outcome) = self.worker.take()? {
            self.finish(outcome, false)?;
        }
        if !self.worker.is_busy() && self.map.is_some() && (self.to_do.refresh || self.to_do.search) {
            let map = self.map.clone().filter(|_| self.to_do.search);
            self.begin(map.map(|map| (map, self.place())))?;
        }
        let wake_in = self.worker.is_busy().then_some(LOOK);
        Ok(Done { wake_in, warning: self.warning(), ..self.done() })
    }

    /// Starts a job, if the samples belong together; if not, those that are missing are on their way.
    fn begin(&mut self, search: Option<(Arc<RobotMap>, Where)>) -> Result<(), Failure> {
        let (Some(site), Some(phase), Some(index)) = (&self.site, &self.phase, &self.index) else { return Ok(()) };
        let site_hash = site.bytes().header().content_hash;
        let is_of_site = |hash: u64| hash == site_hash;
        let belong = is_of_site(Phase::open(phase.bytes())?.head.site_hash)
            && is_of_site(Grids::open(index.bytes())?.head.site_hash);
        if !belong {
            return Ok(());
        }
        if let (Some(site), Some(phase), Some(index)) = (self.site.take(), self.phase.take(), self.index.take()) {
            self.stages.set(Stage::Reading);
            self.to_do.refresh = false;
            self.to_do.search &= search.is_none();
            self.worker.begin(Job { inputs: Inputs { site, phase, index }, search })?;
        }
        Ok(())
    }

    /// Takes what the worker has done; somebody may have asked for it.
    fn finish(&mut self, outcome: Outcome, is_asked: bool) -> Result<(), Failure> {
        let Outcome { inputs, found } = outcome;
        let hash = |sample: &Sample| sample.header().content_hash;
        let made_from = InputHashes {
            site: hash(inputs.site.bytes()),
            phase: hash(&inputs.phase),
            robot: inputs.index.header().inputs.robot,
            ..InputHashes::default()
        };
        // Newer samples have come meanwhile, or these are still the newest.
        self.site.get_or_insert(inputs.site);
        self.phase.get_or_insert(inputs.phase);
        self.index.get_or_insert(inputs.index);
        let found = found?;
        (self.references, self.made_from) = (found.references, made_from);
        if let Some(map) = self.map.clone() {
            self.follow(&map);
        }
        if let Some((_, alignment)) = found.alignment {
            let best = alignment.poses.first().filter(|_| alignment.verdict == Verdict::Accepted);
            self.follower.searched(best.map(|pose| pose.record(&self.storeys())), is_asked);
            let (verdict, poses) = (alignment.verdict.name(), alignment.poses.len());
            info!(service = "slam-align", verdict, poses, reason = alignment.reason, "all poses searched");
            self.searched = alignment;
        }
        self.publish()
    }

    /// What the configuration knows of the pose.
    fn place(&self) -> Where {
        Where { hint: self.config.hint.map(hint_of), storey: self.config.storey }
    }

    /// Searches all poses now, because somebody asked; without a site it is done when there is one.
    fn search_now(&mut self, place: Where) -> Result<Done, Failure> {
        let map = self.map.clone().ok_or("there is no SLAM map yet: give one with slam-map")?;
        if self.worker.is_busy() {
            let outcome = self.worker.wait()?;
            self.finish(outcome, false)?;
        }
        self.begin(Some((map, place)))?;
        if self.worker.is_busy() {
            let outcome = self.worker.wait()?;
            self.finish(outcome, true)?;
        }
        self.proceed()
    }

    fn read_map(&mut self, file: PathBuf) -> Result<Done, Failure> {
        let map = RobotMap::read(&file)?;
        self.keep(|kept| kept.map = Some(file))?;
        self.see_map(map)?;
        self.search_now(self.place())
    }

    fn confirm(&mut self) -> Result<Done, Failure> {
        let pose = self.follower.confirm().ok_or("no pose waits to be confirmed")?;
        self.keep_pose(&pose)?;
        info!(service = "slam-align", map_storey = pose.map_storey, "pose confirmed");
        self.to_do.refresh = true;
        self.publish()?;
        self.proceed()
    }

    /// Changes what survives; on disk when this returns.
    fn keep(&mut self, change: impl FnOnce(&mut Kept)) -> Result<(), Failure> {
        let mut kept = self.kept.clone();
        change(&mut kept);
        self.state.save(&kept)?;
        self.kept = kept;
        Ok(())
    }

    fn keep_pose(&mut self, pose: &PoseRecord) -> Result<(), Failure> {
        let frame_epoch = self.site.as_ref().map_or(0, |site| site.bytes().header().frame_epoch);
        self.keep(|kept| kept.set_pose(pose, frame_epoch))
    }

    /// Publishes what is known, if it differs from what is published.
    fn publish(&mut self) -> Result<(), Failure> {
        let (Some(publisher), Some(map), Some(phase), Some(site)) =
            (&self.publisher, &self.map, &self.phase, &self.site)
        else {
            return Ok(());
        };
        let made_from = MadeFrom {
            site_hash: self.made_from.site,
            slam_map_hash: map.content_hash,
            plan_time_s: Phase::open(phase.bytes())?.head.plan_time_s,
        };
        let pose = self.follower.pose().copied();
        let counting = Counting { pose, state: self.follower.state(), waiting: self.follower.waiting().copied() };
        let alignment = self.searched.archive(&self.storeys(), &counting, made_from);
        let content_hash = messages::Alignment::open(alignment.bytes())?.content_hash();
        if self.last.as_ref().is_some_and(|last| last.content_hash == content_hash) {
            return Ok(());
        }
        let frame_epoch = site.bytes().header().frame_epoch;
        let inputs = InputHashes { slam_map: map.content_hash, ..self.made_from };
        let origin = Origin { epoch: self.epochs.take()?, frame_epoch, inputs };
        publisher.publish_copy(alignment.bytes(), origin)?;
        self.last = Some(Published { alignment, content_hash, origin });
        self.stages.set(Stage::Published);
        // What others localise by survives this daemon; a movement that nobody can see is not worth a write.
        if let Some(pose) = pose.filter(|pose| self.kept.is_worth_keeping(pose)) {
            self.keep_pose(&pose)?;
        }
        Ok(())
    }

    fn done(&self) -> Done {
        let (content_hash, epoch) = self.last.as_ref().map_or((0, 0), |last| (last.content_hash, last.origin.epoch));
        Done { answer: Answer { content_hash, epoch, ..Answer::default() }, ..Done::default() }
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
        self.config = config.align.clone();
        self.follower.set_max_jump(max_jump(&self.config));
        if is_other_map && self.kept.map.is_none() {
            self.read_first_map()?;
        }
        self.proceed()
    }

    /// The map that somebody gave last, or that is configured.
    fn read_first_map(&mut self) -> Result<(), Failure> {
        match self.kept.map.clone().or_else(|| self.config.map.clone()) {
            Some(file) => self.see_map(RobotMap::read(&file)?),
            None => Ok(()),
        }
    }
}

fn max_jump(config: &AlignConfig) -> MaxJump {
    MaxJump { m: config.max_jump_m, rad: config.max_jump_deg.to_radians() }
}

fn hint_of(hint: daemon::PoseHint) -> Hint {
    Hint {
        map_from_slam: MapFromSlam { x_m: hint.x_m, y_m: hint.y_m, yaw_rad: hint.yaw_deg.to_radians() },
        radius_m: hint.radius_m,
        radius_rad: hint.radius_deg.to_radians(),
    }
}

impl Service for AlignService {
    fn inputs(&self) -> &'static [Topic] {
        // The index of the grids names the robot.
        &[Topic::Site, Topic::Phase, Topic::Grids, Topic::SlamMap]
    }

    fn attach(&mut self, bus: &Bus) -> Result<(), Failure> {
        if self.worker.is_busy() {
            // Its samples belong to a generation of the bus that is gone.
            drop(self.worker.wait()?);
        }
        (self.site, self.phase, self.index) = (None, None, None);
        let publisher =
            bus.publisher(Topic::Alignment, self.last.as_ref().map_or(1 << 14, |p| p.alignment.bytes().len()))?;
        if let Some(last) = &self.last {
            publisher.publish_copy(last.alignment.bytes(), last.origin)?;
        }
        self.publisher = Some(publisher);
        Ok(())
    }

    fn handle(&mut self, event: Event) -> Result<Done, Failure> {
        match event {
            Event::Input(Topic::Site, sample) => self.see_site(sample)?,
            Event::Input(Topic::Phase, sample) => {
                self.phase = Some(sample);
                self.to_do.refresh = true;
            }
            Event::Input(Topic::SlamMap, sample) => self.see_map(RobotMap::of_archive(sample.bytes())?)?,
            Event::Input(_, sample) => self.index = Some(sample),
            Event::Request(Request::ReadSlamMap { file }) => return self.read_map(file),
            Event::Request(Request::Align { hint, storey }) => {
                return self.search_now(Where { hint: hint.map(hint_of), storey });
            }
            Event::Request(Request::Confirm) => return self.confirm(),
            Event::Request(_) => return Err("slam-align follows the robot's map and nothing else".into()),
            Event::Configuration(config) => return self.configure(&config),
            Event::Attached if self.map.is_none() => self.read_first_map()?,
            Event::Attached | Event::Tick => {}
        }
        self.proceed()
    }
}
