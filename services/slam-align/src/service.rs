//! The slam-align service: tracks the pose, searches in the background, publishes poses and what they are worth.

mod confirmation;
mod map_input;
mod publication;
mod work;

use crate::background_worker::BackgroundWorker;
use crate::compared_elements::ComparedElements;
use crate::job::{Evidence, Job, JobResult, ReferenceMaps, SearchArea, TaskKind, work};
use crate::map_setting::MapSetting;
use crate::newest_inputs::{JobInputs, NewestInputs, NewestSite};
use crate::persisted_state::PersistedState;
use crate::robot_map::RobotMap;
use crate::searches::Searches;
use crate::stored_evidence;
use alignment::{Alignment, Follower, Hint, MaxJump, MaxUncertainty, PoseField, PoseStatus};
use bus::{Bus, CheckedSample, topics};
use daemon::facts::{AlignFacts, AlignmentSummary, PoseHolds};
use daemon::{
    AlignAnswer, AlignConfig, AlignRequest, Asked, CurrentActivity, Done, Epochs, Event, Failure, History,
    LatchedOutput, PoseHint, Service, SiteConfig, Standing, StateFile,
};
use messages::{AlignmentVerdict, ContentHash, PoseRecord, PoseValidity, SlamFrame};
use site_view::{SiteSample, SiteSamples};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;
use tracing::warn;

/// Interval at which the worker is polled.
const POLL_INTERVAL: Duration = Duration::from_millis(20);

daemon::inputs! {
    /// What poses and deviations are made from. The index of the grids names the robot.
    pub(crate) enum AlignInput { Site, ScheduleState, Grids, SlamMap }
}

/// Follows a robot's map. It never waits for its worker, so that newer maps, requests and generations of the bus come
/// through while a search runs.
pub(crate) struct AlignService {
    config: AlignConfig,
    state: StateFile,
    /// Table of observed progress, for schedule-eval.
    table: PathBuf,
    state_folder: PathBuf,
    persisted: PersistedState,
    history: History,
    map_setting: MapSetting,
    epochs: Epochs,
    activity: CurrentActivity,
    bus: Option<Bus>,
    alignment: LatchedOutput<topics::Alignment>,
    deviations: LatchedOutput<topics::Deviations>,
    /// The newest samples; those of a job are with the worker while it works.
    samples: SiteSamples,
    /// What the newest samples are, wherever they are.
    newest: NewestInputs,
    map: Option<Arc<RobotMap>>,
    /// Epoch and content hash of the last map from the bus.
    last_sample_of_map: Option<(u64, ContentHash)>,
    worker: BackgroundWorker<Job, JobResult>,
    /// Why the last job of a kind failed.
    job_errors: BTreeMap<TaskKind, String>,
    /// Of the site as planned, by map storey, and their inputs.
    references: ReferenceMaps,
    reference_inputs: Option<JobInputs>,
    follower: Follower,
    /// The pose from place to place in the newest map, from the published pose; `None` while nothing says how the map lies.
    field: Option<PoseField>,
    /// The result of the last search, and the content hash of the map that it searched.
    last_search: Alignment,
    searched_map_hash: ContentHash,
    /// Verdict of the last search that was not narrowed, or found a pose; and the content hash of its map.
    verdict: Option<(AlignmentVerdict, ContentHash)>,
    /// What looks at the map have said; it survives the daemon.
    evidence: Option<Arc<Evidence>>,
    /// What an operator should know of that.
    evidence_finding: Option<String>,
    searches: Searches,
    pending: PendingWork,
    /// Elements of the last comparison, for confirmations.
    compared: ComparedElements,
}

/// Work for the worker, beside searches that clients ask for.
#[derive(Debug, Clone, Copy, Default)]
struct PendingWork {
    /// The site has changed: draw the references again.
    refresh: bool,
    /// A new map: search its pose.
    search: bool,
    /// Comparisons by number: the newest that is wanted, that has begun, and that is published.
    wanted_comparison: u64,
    begun_comparison: u64,
    done_comparison: u64,
    /// The last job was a search: a comparison goes before the next one.
    has_searched: bool,
}

impl AlignService {
    /// From the configuration and the persisted state.
    ///
    /// # Errors
    /// State that cannot be used.
    pub(crate) fn new(config: &SiteConfig, activity: CurrentActivity) -> Result<Self, Failure> {
        let state = StateFile::at(&config.state, "alignment.json")?;
        let persisted: PersistedState = state.load()?.unwrap_or_default();
        let map_setting = MapSetting::open(&config.state, &config.align, persisted.older_map.clone())?;
        let mut references = None;
        let (evidence, evidence_finding) = stored_evidence::read(&config.state);
        Ok(Self {
            follower: Follower::new(max_jump(&config.align), persisted.pose()),
            field: None,
            config: config.align.clone(),
            table: config.state.join("slam-align-observed.csv"),
            state_folder: config.state.clone(),
            state,
            persisted,
            history: History::at(&config.state),
            map_setting,
            epochs: Epochs::at(&config.state, "slam-align-epochs.json")?,
            activity,
            bus: None,
            alignment: LatchedOutput::new(topics::Alignment),
            deviations: LatchedOutput::new(topics::Deviations),
            samples: SiteSamples::default(),
            newest: NewestInputs::default(),
            map: None,
            last_sample_of_map: None,
            worker: BackgroundWorker::start(config.n_threads(), move |job: &Job| work(&mut references, job))?,
            job_errors: BTreeMap::new(),
            references: ReferenceMaps::new(),
            reference_inputs: None,
            last_search: Alignment::nothing_yet(),
            searched_map_hash: ContentHash::NONE,
            verdict: None,
            evidence: evidence.map(Arc::new),
            evidence_finding,
            searches: Searches::default(),
            pending: PendingWork::default(),
            compared: ComparedElements::default(),
        })
    }

    fn handle_site(&mut self, site: CheckedSample<topics::Site>) -> Result<(), Failure> {
        let newest = NewestSite { hash: site.content_hash(), frame_epoch: site.bytes().header().frame_epoch };
        let n_storeys = site.view().map_storeys.len();
        self.samples.insert(SiteSample::Site(site));
        let earlier = self.newest.site.replace(newest);
        if earlier == Some(newest) {
            return Ok(());
        }
        self.refresh();
        let frame_epoch = newest.frame_epoch;
        let is_other_frame = earlier.is_some_and(|earlier| earlier.frame_epoch != frame_epoch);
        if is_other_frame || self.persisted.is_of_another_frame(frame_epoch) {
            warn!(service = "slam-align", frame_epoch, "the map frame is another: the pose is forgotten");
            self.persist(|persisted| persisted.forget_poses())?;
            self.forget_pose();
        } else if self.follower.pose().is_some_and(|pose| pose.map_storey as usize >= n_storeys) {
            self.forget_pose();
        }
        // What was refused on the site before may be found on this one.
        self.pending.search |= self.map.is_some() && self.effective_pose().is_none();
        self.publish()
    }

    /// The references are to be drawn again, and the site is to be compared with them.
    fn refresh(&mut self) {
        self.pending.refresh = true;
        self.pending.wanted_comparison += 1;
    }

    /// Poses, references and searches of another site or frame say nothing: the map is searched again.
    fn forget_pose(&mut self) {
        self.follower.forget();
        self.field = None;
        self.references.clear();
        self.reference_inputs = None;
        (self.last_search, self.searched_map_hash, self.verdict) = (Alignment::nothing_yet(), ContentHash::NONE, None);
        self.pending.search = self.map.is_some();
    }

    /// Indices of the references are map storeys.
    fn storeys(&self) -> Vec<u32> {
        (0..self.references.len() as u32).collect()
    }

    fn pose_status(&self) -> PoseStatus<'_> {
        let newest = self.map.as_ref().map(|map| map.content_hash);
        PoseStatus {
            max_uncertainty: MaxUncertainty::in_degrees(self.config.max_uncertainty_m, self.config.max_uncertainty_deg),
            verdict: self.verdict.filter(|(_, map_hash)| Some(*map_hash) == newest).map(|(verdict, _)| verdict),
            pose: self.follower.pose().copied(),
            state: self.follower.state(),
            waiting: self.follower.waiting().copied(),
            field: self.field.as_ref().filter(|_| self.follower.is_borne_out()),
            robot_m: None,
        }
    }

    /// What the pose is worth for the newest map; `None` without one.
    fn validity(&self) -> Option<PoseValidity> {
        self.map.as_ref()?;
        Some(self.pose_status().validity())
    }

    /// The pose, if it may be used.
    fn effective_pose(&self) -> Option<PoseRecord> {
        self.follower.pose().copied().filter(|_| self.validity() == Some(PoseValidity::Effective))
    }

    /// Where the newest map lies, by what was published of it; `None` if no part of it is known well enough to be compared.
    fn slam_frame(&self) -> Option<SlamFrame> {
        let alignment = self.alignment.last()?.view();
        let newest = self.map.as_ref().map(|map| map.content_hash);
        (Some(alignment.head.slam_map_hash) == newest).then(|| alignment.slam_frame())?
    }

    /// True if the newest map was searched; false while it waits for that.
    fn is_newest_map_searched(&self) -> bool {
        self.map.as_ref().is_some_and(|map| map.content_hash == self.searched_map_hash)
    }

    /// Why the pose must not be used, for people; `None` if it may, or if there is no map.
    fn why_not_effective(&self) -> Option<String> {
        match self.validity()? {
            PoseValidity::Effective => None,
            PoseValidity::Uncertain => {
                let holds = self.alignment.last().and_then(|last| PoseHolds::of(last.view().local_poses));
                let holds = holds.map_or_else(String::new, |holds| format!(": {holds}"));
                Some(format!(
                    "pose_uncertain: the pose is known less well than max_uncertainty somewhere in the SLAM map, and may be used only \
                     where /tf says that the robot is, if it is known there{holds}"
                ))
            }
            PoseValidity::WaitsForConfirm => {
                Some("pose_waits: the pose would change by more than max_jump: groundplan confirm".to_owned())
            }
            PoseValidity::Held if self.is_newest_map_searched() => {
                Some("pose_held: the newest SLAM map does not bear the pose out".to_owned())
            }
            PoseValidity::Held => Some("pose_held: the newest SLAM map waits for its search".to_owned()),
            PoseValidity::Refused => {
                let (verdict, reason) = (self.last_search.verdict, &self.last_search.reason);
                let name = if verdict == AlignmentVerdict::Accepted { "not in effect" } else { verdict.name() };
                Some(format!("pose_refused: the newest SLAM map is {name}: {reason}"))
            }
        }
    }

    /// The search area of the configuration.
    fn search_area(&self) -> SearchArea {
        search_area_of(&self.config)
    }

    fn done(&self) -> Done {
        let wake_in = self.worker.is_busy().then_some(POLL_INTERVAL);
        Done { published: self.alignment.published(), wake_in, ..Done::default() }
    }

    fn configure(&mut self, config: &SiteConfig) -> Result<(), Failure> {
        let is_applied_otherwise = self.config.apply != config.align.apply;
        let is_searched_elsewhere = search_area_of(&self.config) != search_area_of(&config.align);
        self.config = config.align.clone();
        self.pending.search |= is_searched_elsewhere && self.map.is_some();
        self.follower.set_max_jump(max_jump(&self.config));
        if is_applied_otherwise {
            self.apply(&self.persisted.observed)?;
        }
        self.follow_configured_map()
    }
}

fn search_area_of(config: &AlignConfig) -> SearchArea {
    let (hint, storey, places) = (config.hint.map(hint_of), config.storey, config.known_places());
    SearchArea { hint, storey, places, is_narrowed: false }
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
        // A job that runs keeps its samples, and with them their generation of the bus.
        self.samples = SiteSamples::default();
        self.bus = Some(bus.clone());
        self.alignment.attach(bus, &mut self.epochs)?;
        self.deviations.attach(bus, &mut self.epochs)
    }

    fn handle(&mut self, event: Event<AlignInput>) -> Result<Done, Failure> {
        match event {
            Event::Input(AlignInput::Site(site)) => self.handle_site(site)?,
            Event::Input(AlignInput::ScheduleState(state)) => {
                let newest = [state.view().head.site_hash, state.content_hash()];
                self.samples.insert(SiteSample::ScheduleState(state));
                if self.newest.schedule_state.replace(newest) != Some(newest) {
                    self.refresh();
                }
            }
            Event::Input(AlignInput::Grids(index)) => {
                let newest = [index.view().head.site_hash, index.bytes().header().inputs.robot];
                self.samples.insert(SiteSample::Index(index));
                if self.newest.index.replace(newest) != Some(newest) {
                    self.refresh();
                }
            }
            Event::Input(AlignInput::SlamMap(map)) => self.handle_map_sample(&map)?,
            Event::Configuration(config) => self.configure(&config)?,
            Event::Attached => self.take_first_map()?,
            Event::Tick => {
                self.retry_configured_map()?;
                self.alignment.retry(&mut self.epochs)?;
                self.deviations.retry(&mut self.epochs)?;
            }
        }
        self.proceed()?;
        Ok(self.done())
    }

    fn answer(&mut self, request: AlignRequest, asked: &Asked) -> Result<Done<AlignAnswer>, Failure> {
        let by = asked.by;
        let answer = match request {
            AlignRequest::ReadSlamMap { file } => AlignAnswer::Search(self.read_map(&file, by)?),
            AlignRequest::Align { hint, storey, places } => {
                let is_narrowed = hint.is_some() || storey.is_some() || !places.is_empty();
                let search_area = SearchArea { hint: hint.map(hint_of), storey, places, is_narrowed };
                AlignAnswer::Search(self.ask_for_search(search_area)?)
            }
            AlignRequest::SearchResult { search } => AlignAnswer::SearchState(self.searches.state(search)),
            AlignRequest::Comparison { at_least } => AlignAnswer::Comparison(self.comparison(at_least)),
            AlignRequest::ConfirmPose => AlignAnswer::Pose(self.confirm_pose(by)?),
            AlignRequest::ConfirmAbsent { elements } => AlignAnswer::Elements(self.confirm_absent(&elements, by)?),
            AlignRequest::UndoConfirm { elements } if elements.is_empty() => {
                AlignAnswer::Pose(self.undo_confirmed_pose(by)?)
            }
            AlignRequest::UndoConfirm { elements } => AlignAnswer::Elements(self.undo_absent(&elements, by)?),
            AlignRequest::ListConfirmed => AlignAnswer::Confirmations(self.confirmations()),
        };
        self.proceed()?;
        Ok(self.done().answered(answer))
    }

    fn standing(&self) -> Standing {
        let error = self.job_errors.iter().next().map(|(kind, why)| format!("{} failed: {why}", kind.name()));
        let of_state = [self.state.finding(), self.map_setting.finding(), self.evidence_finding.as_deref()];
        let of_files = of_state.into_iter().chain([self.map_setting.warning()]).flatten().map(str::to_owned);
        let warnings: Vec<String> = of_files.chain(self.why_not_effective()).collect();
        Standing { error, warning: (!warnings.is_empty()).then(|| warnings.join("; ")) }
    }

    fn facts(&self) -> AlignFacts {
        let published = self.alignment.last().map(|last| AlignmentSummary::of(self.alignment.epoch(), &last.view()));
        AlignFacts { alignment: published, setting: self.map_setting.in_force() }
    }
}
