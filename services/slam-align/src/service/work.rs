//! The next job of the worker, and the use of its results.

use super::AlignService;
use crate::background_worker::Outcome;
use crate::job::{Found, Job, JobResult, SearchArea, Task, TaskKind};
use crate::newest_inputs::JobInputs;
use crate::robot_map::RobotMap;
use alignment::{Alignment, PoseField, UnknownPlace, track_map};
use daemon::{ComparisonState, Failure, SearchState, chain};
use messages::{Activity, AlignmentVerdict, PoseValidity};
use std::sync::Arc;
use tracing::{info, warn};

impl AlignService {
    /// Takes results of the worker, and starts its next job.
    pub(super) fn proceed(&mut self) -> Result<(), Failure> {
        while let Some(outcome) = self.worker.take()? {
            self.activity.set(if self.alignment.last().is_some() { Activity::Published } else { Activity::Idle });
            self.finish(outcome)?;
        }
        // Samples that do not belong together yet are on their way.
        let (false, Some(inputs)) = (self.worker.is_busy(), JobInputs::of(&self.samples)) else { return Ok(()) };
        let Some(task) = self.map.clone().and_then(|map| self.next_task(map)) else { return Ok(()) };
        self.activity.set(Activity::Reading);
        self.pending.refresh = false;
        self.pending.has_searched = task.kind() == TaskKind::Search;
        let generation = self.bus.as_ref().map_or(0, bus::Bus::generation);
        self.worker.begin(Job { samples: std::mem::take(&mut self.samples), inputs, generation, task })
    }

    fn next_task(&mut self, map: Arc<RobotMap>) -> Option<Task> {
        let comparison = self.pending.wanted_comparison;
        let pose = self.follower.pose().copied().filter(|_| self.pending.begun_comparison < comparison);
        let comparable = pose.and_then(|pose| Some((pose, self.slam_frame()?)));
        if let Some((number, search_area)) = self.searches.begin() {
            self.pending.search = false;
            let evidence = self.evidence.clone().filter(|_| !search_area.is_narrowed);
            return Some(Task::Search { map, search_area, asked: Some(number), evidence });
        }
        // Maps that come as fast as they are searched must not keep the site from being compared.
        if self.pending.search && (comparable.is_none() || !self.pending.has_searched) {
            self.pending.search = false;
            let (search_area, evidence) = (self.search_area(), self.evidence.clone());
            return Some(Task::Search { map, search_area, asked: None, evidence });
        }
        if self.pending.refresh {
            return Some(Task::Draw);
        }
        let (pose, slam_frame) = comparable?;
        self.pending.begun_comparison = comparison;
        Some(Task::Compare { map, pose, slam_frame: Box::new(slam_frame), comparison })
    }

    /// Takes the result of a job, unless its inputs have been replaced meanwhile: then it is done again.
    fn finish(&mut self, outcome: Outcome<Job, JobResult>) -> Result<(), Failure> {
        let Outcome { job: Job { samples, inputs, generation, task }, result } = outcome;
        if self.bus.as_ref().is_some_and(|bus| bus.generation() == generation) {
            // Newer samples have come meanwhile, or these are still the newest.
            self.samples.take_back(samples);
        }
        if !self.newest.are_still(&inputs) {
            self.begin_again(&task);
            return Ok(());
        }
        let kind = task.kind();
        let JobResult { references, found } = match result {
            Ok(result) => result,
            Err(why) => return self.fail(&task, &inputs, &chain(why.as_ref())),
        };
        // Every job draws the references first.
        self.job_errors.retain(|failed, _| *failed != kind && *failed != TaskKind::Draw);
        self.references = references;
        self.reference_inputs = Some(inputs);
        match (found, task) {
            (Found::Poses(alignment, evidence), Task::Search { map, asked, search_area, .. }) => {
                self.take_evidence(evidence)?;
                self.take_search(*alignment, &map, asked, search_area.is_narrowed)
            }
            (Found::UnknownPlace(why), Task::Search { asked, .. }) => {
                self.follow();
                self.refuse_search(&why, asked)
            }
            (Found::Deviations(deviations), Task::Compare { map, comparison, .. }) => {
                self.pending.done_comparison = comparison;
                self.publish_deviations(deviations, &inputs, map.content_hash)
            }
            _ => {
                self.follow();
                self.publish()
            }
        }
    }

    fn begin_again(&mut self, task: &Task) {
        match task {
            Task::Draw => self.pending.refresh = true,
            Task::Search { asked, .. } => {
                self.pending.search |= asked.is_none();
                self.searches.begin_again();
            }
            Task::Compare { .. } => self.pending.wanted_comparison += 1,
        }
    }

    /// A job that failed is not tried again by itself: it would fail again.
    fn fail(&mut self, task: &Task, inputs: &JobInputs, why: &str) -> Result<(), Failure> {
        warn!(service = "slam-align", job = task.kind().name(), error = why, "a job of the worker failed");
        self.job_errors.insert(task.kind(), why.to_owned());
        let is_drawn = self.reference_inputs.is_some_and(|drawn| drawn.hashes.site == inputs.hashes.site);
        if !is_drawn {
            // The pose is of a site that is replaced, and nothing says what it is worth on this one.
            self.follower.hold();
        }
        self.searches.end(SearchState::Failed { why: format!("{} failed: {why}", task.kind().name()) });
        self.publish()
    }

    /// Takes the result of a search of a map, which may be an earlier one than the newest. A narrowed search that finds nothing
    /// says nothing about the pose that is there.
    fn take_search(
        &mut self,
        alignment: Alignment,
        map: &RobotMap,
        asked: Option<u64>,
        is_narrowed: bool,
    ) -> Result<(), Failure> {
        self.follow();
        let best = alignment.poses.first().filter(|_| alignment.verdict == AlignmentVerdict::Accepted);
        let best = best.map(|pose| pose.record(&self.storeys()));
        let had_pose = self.follower.pose().is_some();
        self.follower.searched(best, map.content_hash, asked.is_some());
        let is_of_newest_map = self.map.as_ref().is_some_and(|newest| newest.content_hash == map.content_hash);
        match is_of_newest_map {
            true => self.find_field(map),
            false => self.follow(),
        }
        let (verdict, poses) = (alignment.verdict.name(), alignment.poses.len());
        info!(service = "slam-align", verdict, poses, reason = alignment.reason, "all poses searched");
        if !is_narrowed || alignment.verdict == AlignmentVerdict::Accepted {
            self.verdict = Some((alignment.verdict, map.content_hash));
        }
        (self.last_search, self.searched_map_hash) = (alignment, map.content_hash);
        let published = self.publish();
        self.searches.end(match &published {
            Ok(()) => SearchState::Done { alignment: self.alignment.published(), is_of_newest_map },
            Err(why) => SearchState::Failed { why: chain(why.as_ref()) },
        });
        if let Some(pose) = self.effective_pose().filter(|_| !had_pose) {
            self.record_pose(None, "accepted", &pose);
        }
        published
    }

    /// Ends a search that could not begin. What a client asked for is that client's mistake; what `site.toml` says stays wrong
    /// until it is edited.
    fn refuse_search(&mut self, why: &UnknownPlace, asked: Option<u64>) -> Result<(), Failure> {
        let why = chain(why);
        if asked.is_none() {
            warn!(service = "slam-align", error = why, "the pose was not searched");
            self.job_errors.insert(TaskKind::Search, format!("[align]: {why}"));
        }
        self.searches.end(SearchState::Failed { why });
        self.publish()
    }

    /// Judges the pose by the newest map.
    pub(super) fn follow(&mut self) {
        let Some(map) = self.map.clone() else { return };
        let found = self.follower.pose().and_then(|last| {
            let last = (last.map_storey as usize, &last.map_from_slam());
            track_map(&self.references, &map.prepared, last)
        });
        self.follower.tracked(found.map(|pose| pose.record(&self.storeys())), map.content_hash);
        self.find_field(&map);
    }

    /// Finds how the newest map bends around the pose that is published, unless nothing bears that out.
    pub(super) fn find_field(&mut self, map: &RobotMap) {
        let pose = self.follower.pose().copied().filter(|_| self.follower.is_borne_out());
        self.field = pose.and_then(|pose| {
            let reference = self.references.get(pose.map_storey as usize)?;
            Some(PoseField::of(reference, &map.prepared, &pose.map_from_slam()))
        });
    }

    /// Asks for a search of all poses; its number.
    ///
    /// # Errors
    /// No map, no site, samples that do not belong together yet.
    pub(super) fn ask_for_search(&mut self, search_area: SearchArea) -> Result<u64, Failure> {
        if self.map.is_none() {
            return Err(NO_MAP.into());
        }
        self.check_inputs()?;
        let number = self.epochs.take()?;
        self.searches.ask(number, search_area)?;
        Ok(number)
    }

    /// Refuses what cannot begin.
    pub(super) fn check_inputs(&self) -> Result<(), Failure> {
        self.newest.why_incomplete().map_or(Ok(()), |why| Err(why.into()))
    }

    /// What became of a comparison.
    pub(super) fn comparison(&self, at_least: Option<u64>) -> ComparisonState {
        let impossible = |why: &str| ComparisonState::Impossible { why: why.to_owned() };
        let pending = self.pending;
        let wanted = at_least.unwrap_or(pending.wanted_comparison);
        let is_busy = self.worker.is_busy();
        if self.map.is_none() {
            return impossible(NO_MAP);
        }
        if let Some(why) = self.newest.why_incomplete() {
            return impossible(why);
        }
        let is_comparable = self.slam_frame().is_some();
        let is_waiting = self.validity() == Some(PoseValidity::WaitsForConfirm);
        let is_searching = self.searches.is_waiting() || pending.search || pending.refresh || is_busy;
        if is_waiting || (!is_comparable && !is_searching) {
            return impossible(&self.why_not_effective().unwrap_or_default());
        }
        let is_done = is_comparable && !pending.refresh && wanted <= pending.done_comparison;
        if is_done && self.deviations.last().is_some() {
            return ComparisonState::Done(self.deviations.published());
        }
        match self.job_errors.get(&TaskKind::Compare) {
            Some(why) if !is_searching && pending.begun_comparison == pending.wanted_comparison => {
                impossible(&format!("{} failed: {why}", TaskKind::Compare.name()))
            }
            _ => ComparisonState::Running { comparison: wanted },
        }
    }
}

const NO_MAP: &str = "there is no SLAM map yet: give one with groundplan slam-map, or let the robot publish one";
