//! The state in force of slam-align: the newest map, the pose in it and what that is worth, searches, observations.

use crate::compared_elements::ComparedElements;
use crate::job::{Evidence, ReferenceMaps, SearchArea, Task, TaskKind};
use crate::map_setting::MapSetting;
use crate::newest_inputs::{JobInputs, NewestInputs};
use crate::persisted_state::PersistedState;
use crate::robot_map::RobotMap;
use crate::searches::Searches;
use alignment::{
    Alignment, AlignmentSources, Follower, Hint, MaxJump, MaxUncertainty, PoseField, PoseStatus, track_map,
};
use daemon::facts::PoseHolds;
use daemon::{AlignConfig, Caller, HistoryEvent, HistoryKind, PoseHint};
use messages::{
    AlignmentVerdict, ArchiveBuffer, Checked, ContentHash, InputHashes, PoseRecord, PoseValidity, ScheduleStateHead,
    SearchOutcome, SlamFrame, payload,
};
use std::collections::BTreeMap;
use std::sync::Arc;
use tracing::{info, warn};

/// What a decision changes.
#[derive(Clone)]
pub struct InForce {
    pub(crate) config: Arc<AlignConfig>,
    /// What survives the daemon.
    pub(crate) persisted: Arc<PersistedState>,
    pub(crate) map_setting: MapSetting,
    /// The newest samples that were decided on.
    pub(crate) seen: NewestInputs,
    pub(crate) map: Option<Arc<RobotMap>>,
    /// Why the newest map cannot be used.
    pub(crate) map_error: Option<String>,
    /// Epoch and content hash of the last map from the bus that was decided on.
    pub(crate) seen_map: Option<(u64, ContentHash)>,
    /// Why the last job of a kind failed.
    pub(crate) job_errors: BTreeMap<TaskKind, String>,
    /// Of the site as planned, by map storey, and their inputs.
    pub(crate) references: ReferenceMaps,
    pub(crate) reference_inputs: Option<JobInputs>,
    pub(crate) follower: Follower,
    /// The pose from place to place in the newest map, from the published pose; `None` while nothing says how the map lies.
    pub(crate) field: Option<Arc<PoseField>>,
    /// The result of the last search, and the content hash of the map that it searched.
    pub(crate) last_search: Arc<Alignment>,
    pub(crate) searched_map_hash: ContentHash,
    /// Verdict of the last search that was not narrowed, or found a pose; and the content hash of its map.
    pub(crate) verdict: Option<(AlignmentVerdict, ContentHash)>,
    /// What looks at the map have said.
    pub(crate) evidence: Option<Arc<Evidence>>,
    pub(crate) searches: Searches,
    pub(crate) pending: PendingWork,
    /// Elements of the last comparison, for confirmations.
    pub(crate) compared: Arc<ComparedElements>,
    /// What is published of all this.
    pub(crate) alignment: Option<Arc<Checked<payload::Alignment>>>,
    /// What this decision has used.
    pub(crate) used: Used,
}

/// Work for the worker, beside searches that clients ask for.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct PendingWork {
    /// The site has changed: draw the references again.
    pub(crate) refresh: bool,
    /// A new map: search its pose.
    pub(crate) search: bool,
    /// Comparisons by number: the newest that is wanted, that has begun, and that is published.
    pub(crate) wanted_comparison: u64,
    pub(crate) begun_comparison: u64,
    pub(crate) done_comparison: u64,
    /// The last job was a search: a comparison goes before the next one.
    pub(crate) has_searched: bool,
}

/// What a decision has used of what came to it, and what it begins.
#[derive(Clone, Default)]
pub(crate) struct Used {
    /// The newest map.
    pub(crate) map: bool,
    /// The result of the worker.
    pub(crate) outcome: bool,
    /// The next job of the worker, and its inputs.
    pub(crate) begins: Option<(JobInputs, Task)>,
}

impl InForce {
    /// At the start of the daemon.
    pub(crate) fn new(
        config: &AlignConfig,
        persisted: PersistedState,
        map_setting: MapSetting,
        evidence: Option<Evidence>,
        searches: Searches,
    ) -> Self {
        Self {
            follower: Follower::new(max_jump(config), persisted.pose()),
            config: Arc::new(config.clone()),
            persisted: Arc::new(persisted),
            map_setting,
            seen: NewestInputs::default(),
            map: None,
            map_error: None,
            seen_map: None,
            job_errors: BTreeMap::new(),
            references: ReferenceMaps::new(),
            reference_inputs: None,
            field: None,
            last_search: Arc::new(Alignment::nothing_yet()),
            searched_map_hash: ContentHash::NONE,
            verdict: None,
            evidence: evidence.map(Arc::new),
            searches,
            pending: PendingWork::default(),
            compared: Arc::default(),
            alignment: None,
            used: Used::default(),
        }
    }

    /// What survives the daemon, to be changed.
    pub(crate) fn persisted_mut(&mut self) -> &mut PersistedState {
        Arc::make_mut(&mut self.persisted)
    }

    /// The references are to be drawn again, and the site is to be compared with them.
    pub(crate) fn refresh(&mut self) {
        self.pending.refresh = true;
        self.pending.wanted_comparison += 1;
    }

    /// Poses, references and searches of another site or frame say nothing: the map is searched again.
    pub(crate) fn forget_pose(&mut self) {
        self.follower.forget();
        self.field = None;
        self.references.clear();
        self.reference_inputs = None;
        (self.last_search, self.searched_map_hash, self.verdict) =
            (Arc::new(Alignment::nothing_yet()), ContentHash::NONE, None);
        self.pending.search = self.map.is_some();
    }

    /// A newer map of the robot: followed at once, searched later.
    pub(crate) fn take_map(&mut self, map: Arc<RobotMap>) {
        (self.map, self.map_error) = (Some(map), None);
        self.pending.search = true;
        self.pending.wanted_comparison += 1;
        self.follow();
        info!(service = "slam-align", state = self.follower.state().name(), "map followed");
    }

    /// Judges the pose by the newest map.
    pub(crate) fn follow(&mut self) {
        let Some(map) = self.map.clone() else { return };
        let found = self.follower.pose().and_then(|last| {
            let last = (last.map_storey as usize, &last.map_from_slam());
            track_map(&self.references, &map.prepared, last)
        });
        self.follower.tracked(found.map(|pose| pose.record(&self.storeys())), map.content_hash);
        self.find_field(&map);
    }

    /// Finds how the newest map bends around the pose that is published, unless nothing bears that out.
    pub(crate) fn find_field(&mut self, map: &RobotMap) {
        let pose = self.follower.pose().copied().filter(|_| self.follower.is_borne_out());
        self.field = pose.and_then(|pose| {
            let reference = self.references.get(pose.map_storey as usize)?;
            Some(Arc::new(PoseField::of(reference, &map.prepared, &pose.map_from_slam())))
        });
    }

    /// Indices of the references are map storeys.
    pub(crate) fn storeys(&self) -> Vec<u32> {
        (0..self.references.len() as u32).collect()
    }

    /// Content hash of the newest map.
    pub(crate) fn map_hash(&self) -> Option<ContentHash> {
        self.map.as_ref().map(|map| map.content_hash)
    }

    fn pose_status(&self) -> PoseStatus<'_> {
        PoseStatus {
            max_uncertainty: MaxUncertainty::in_degrees(self.config.max_uncertainty_m, self.config.max_uncertainty_deg),
            verdict: self.verdict.filter(|(_, of_map)| Some(*of_map) == self.map_hash()).map(|(verdict, _)| verdict),
            pose: self.follower.pose().copied(),
            state: self.follower.state(),
            waiting: self.follower.waiting().copied(),
            field: self.field.as_deref().filter(|_| self.follower.is_borne_out()),
            robot_m: None,
        }
    }

    /// What the pose is worth for the newest map; `None` without one.
    pub(crate) fn validity(&self) -> Option<PoseValidity> {
        self.map.as_ref()?;
        Some(self.pose_status().validity())
    }

    /// The pose, if it may be used.
    pub(crate) fn effective_pose(&self) -> Option<PoseRecord> {
        self.follower.pose().copied().filter(|_| self.validity() == Some(PoseValidity::Effective))
    }

    /// Where the newest map lies, by what is published of it; `None` if no part of it is known well enough to be compared.
    pub(crate) fn slam_frame(&self) -> Option<SlamFrame> {
        let alignment = self.alignment.as_ref()?.view();
        (Some(alignment.head.slam_map_hash) == self.map_hash()).then(|| alignment.slam_frame())?
    }

    /// True if the newest map was searched; false while it waits for that.
    fn is_newest_map_searched(&self) -> bool {
        self.map_hash() == Some(self.searched_map_hash)
    }

    /// Why the pose must not be used, for people; `None` if it may, or if there is no map.
    pub(crate) fn why_not_effective(&self) -> Option<String> {
        let validity = self.validity()?;
        let searched = SearchOutcome {
            is_of_newest_map: self.is_newest_map_searched(),
            verdict: self.last_search.verdict,
            reason: &self.last_search.reason,
        };
        let why = validity.why_not_usable(&searched, || self.why_uncertain())?;
        let code = match validity {
            PoseValidity::Effective => return None,
            PoseValidity::Uncertain => "pose_uncertain",
            PoseValidity::WaitsForConfirm => "pose_waits",
            PoseValidity::Held => "pose_held",
            PoseValidity::Refused => "pose_refused",
        };
        Some(format!("{code}: {why}"))
    }

    /// How well the pose is known, by what is published of it.
    fn why_uncertain(&self) -> String {
        let Some(last) = &self.alignment else {
            return "it is known less well than max_uncertainty asks for".to_owned();
        };
        let view = last.view();
        let holds = PoseHolds::of(view.local_poses).map_or_else(String::new, |holds| format!("; {holds}"));
        view.why_uncertain(None) + &holds
    }

    /// What there is to publish of the pose, and its inputs; nothing before there are a map and a site.
    pub(crate) fn archive(&self) -> Option<(ArchiveBuffer, JobInputs)> {
        let (slam_map, site) = (self.map_hash()?, self.seen.site?);
        // Before the references are drawn there is no plan time; there is no pose either.
        let mut inputs = self.reference_inputs.unwrap_or(JobInputs {
            hashes: InputHashes { site: site.hash, ..InputHashes::default() },
            plan_time_s: ScheduleStateHead::NO_TIME,
            frame_epoch: site.frame_epoch,
        });
        let sources = AlignmentSources {
            site_hash: inputs.hashes.site,
            slam_map_hash: slam_map,
            searched_map_hash: self.searched_map_hash,
            plan_time_s: inputs.plan_time_s,
        };
        inputs.hashes.slam_map = slam_map;
        Some((self.last_search.archive(&self.storeys(), &self.pose_status(), sources), inputs))
    }

    /// The newest map frame.
    pub(crate) fn frame_epoch(&self) -> u64 {
        self.seen.site.map_or(0, |site| site.frame_epoch)
    }

    /// What people are told when the pose that was in effect is not any more, and when it is again: nothing that a robot has
    /// relied on ends or changes in silence. A map that waits for its search says nothing yet.
    pub(crate) fn withdraw(&mut self) -> Option<HistoryEvent> {
        let (pose, validity) = (self.follower.pose().copied()?, self.validity()?);
        let is_withdrawn = match validity {
            PoseValidity::Effective | PoseValidity::Uncertain => false,
            PoseValidity::Refused | PoseValidity::WaitsForConfirm => true,
            PoseValidity::Held if self.is_newest_map_searched() => true,
            PoseValidity::Held => return None,
        };
        if is_withdrawn == self.persisted.is_withdrawn {
            return None;
        }
        self.persisted_mut().is_withdrawn = is_withdrawn;
        if !is_withdrawn {
            info!(service = "slam-align", "the pose is in effect again");
            return Some(pose_event(None, "in effect again", &pose));
        }
        let why = self.why_not_effective().unwrap_or_default();
        warn!(service = "slam-align", reason = why, "the pose is withdrawn");
        Some(pose_event(None, &format!("withdrawn ({why})"), &pose))
    }

    /// The search area of the configuration.
    pub(crate) fn search_area(&self) -> SearchArea {
        let (hint, storey, places) = (self.config.hint.map(hint_of), self.config.storey, self.config.known_places());
        SearchArea { hint, storey, places, is_narrowed: false }
    }
}

/// What the history says of a pose.
pub(crate) fn pose_event(by: Option<Caller>, what: &str, pose: &PoseRecord) -> HistoryEvent {
    let [x_m, y_m, yaw_rad] = pose.map_from_slam;
    let place = format!("x {x_m:.2} m, y {y_m:.2} m, yaw {:.2} degrees", yaw_rad.to_degrees());
    let summary = format!("pose of the SLAM map {what}: storey {} at {place}", pose.map_storey);
    HistoryEvent { kind: HistoryKind::Pose, by, summary }
}

pub(crate) fn max_jump(config: &AlignConfig) -> MaxJump {
    MaxJump { m: config.max_jump_m, rad: config.max_jump_deg.to_radians() }
}

pub(crate) fn hint_of(hint: PoseHint) -> Hint {
    Hint::in_degrees([hint.x_m, hint.y_m, hint.yaw_deg], hint.radius_m, hint.radius_deg)
}
