//! The next job of the worker, and what follows from its results.

use super::SlamAlign;
use crate::background_worker::Outcome;
use crate::compared_elements::compared_elements;
use crate::in_force::InForce;
use crate::job::{Found, Job, JobResult, SearchArea, Task, TaskKind};
use crate::newest_inputs::JobInputs;
use crate::outputs::AlignSample;
use crate::robot_map::RobotMap;
use crate::stored_evidence;
use alignment::{Alignment, UnknownPlace};
use daemon::{ComparisonState, Decision, Failure, NewSample, Now, Published, SearchState, chain};
use messages::{AlignmentVerdict, Checked, ContentHash, InputHashes, PoseValidity, payload};
use std::sync::Arc;
use tracing::{info, warn};

impl SlamAlign {
    /// The next job of the idle worker, and its inputs.
    pub(super) fn next_job(&self, next: &mut InForce) -> Option<(JobInputs, Task)> {
        if self.is_busy || (self.done.is_some() && !next.used.outcome) {
            return None;
        }
        // Samples that do not belong together yet are on their way.
        let (inputs, map) = (JobInputs::of(&self.samples)?, next.map.clone()?);
        let task = Self::next_task(next, map)?;
        next.pending.refresh = false;
        next.pending.has_searched = task.kind() == TaskKind::Search;
        Some((inputs, task))
    }

    fn next_task(next: &mut InForce, map: Arc<RobotMap>) -> Option<Task> {
        let comparison = next.pending.wanted_comparison;
        let pose = next.follower.pose().copied().filter(|_| next.pending.begun_comparison < comparison);
        let comparable = pose.and_then(|pose| Some((pose, next.slam_frame()?)));
        if let Some((number, search_area)) = next.searches.begin() {
            next.pending.search = false;
            let evidence = next.evidence.clone().filter(|_| !search_area.is_narrowed);
            return Some(Task::Search { map, search_area, asked: Some(number), evidence });
        }
        // Maps that come as fast as they are searched must not keep the site from being compared.
        if next.pending.search && (comparable.is_none() || !next.pending.has_searched) {
            next.pending.search = false;
            let (search_area, evidence) = (next.search_area(), next.evidence.clone());
            return Some(Task::Search { map, search_area, asked: None, evidence });
        }
        if next.pending.refresh {
            return Some(Task::Draw);
        }
        let (pose, slam_frame) = comparable?;
        next.pending.begun_comparison = comparison;
        Some(Task::Compare { map, pose, slam_frame: Arc::new(slam_frame), comparison })
    }

    /// Takes the result of a job, unless its inputs have been replaced meanwhile: then it is done again.
    pub(super) fn finish(
        &self,
        decision: &mut Decision<Self>,
        Outcome { job: Job { inputs, task, .. }, result }: &Outcome<Job, JobResult>,
        now: &Now<'_, Self>,
    ) -> Result<(), Failure> {
        let next = &mut decision.next;
        if !self.newest.are_still(inputs) {
            begin_again(next, task);
            return Ok(());
        }
        let kind = task.kind();
        let JobResult { references, found } = match result {
            Ok(result) => result,
            Err(why) => {
                fail(next, task, inputs, &chain(why.as_ref()));
                return Ok(());
            }
        };
        // Every job draws the references first.
        next.job_errors.retain(|failed, _| *failed != kind && *failed != TaskKind::Draw);
        next.references.clone_from(references);
        next.reference_inputs = Some(*inputs);
        match (found, task) {
            (Found::Poses(alignment, evidence), Task::Search { map, asked, search_area, .. }) => {
                if let Some(evidence) = evidence {
                    decision.save.push(stored_evidence::saving(&self.state_folder, evidence));
                    next.evidence = Some(Arc::clone(evidence));
                }
                take_search(next, alignment, map, asked.is_some(), search_area.is_narrowed);
            }
            (Found::UnknownPlace(why), Task::Search { asked, .. }) => {
                next.follow();
                refuse_search(next, why, asked.is_some());
            }
            (Found::Deviations(deviations), Task::Compare { map, comparison, .. }) => {
                next.pending.done_comparison = *comparison;
                self.take_deviations(decision, deviations, inputs, map.content_hash, now);
            }
            _ => next.follow(),
        }
        Ok(())
    }

    /// Takes deviations, and the observations that count by themselves.
    fn take_deviations(
        &self,
        decision: &mut Decision<Self>,
        deviations: &Arc<Checked<payload::Deviations>>,
        inputs: &JobInputs,
        slam_map: ContentHash,
        now: &Now<'_, Self>,
    ) {
        let (next, view) = (&mut decision.next, deviations.view());
        let Some(site) = self.samples.site().filter(|site| view.check_site(&site.view()).is_ok()) else {
            // Its generation of the bus is gone, and the site of the next one has not come yet.
            next.pending.wanted_comparison += 1;
            return;
        };
        next.compared = Arc::new(compared_elements(&site.view(), &view));
        let observed = next.persisted.observed.with_additions(&site.view(), &view);
        if observed != next.persisted.observed {
            next.persisted_mut().set_observed(observed, &[]);
        }
        if now.outputs.deviations.last().is_none_or(|last| last.bytes().bytes() != deviations.bytes().bytes()) {
            let (elements, obstacles) = (view.elements.len(), view.obstacles.len());
            info!(service = "slam-align", elements, obstacles, "other deviations");
            let inputs_of = InputHashes { slam_map, ..inputs.hashes };
            let archive = Arc::clone(deviations);
            let sample = NewSample { archive, frame_epoch: inputs.frame_epoch, inputs: inputs_of };
            decision.publish.push(AlignSample::Deviations(sample));
        }
    }

    /// Asks for a search of all poses; its number.
    ///
    /// # Errors
    /// No map, no site, samples that do not belong together yet.
    pub(super) fn ask_for_search(&self, next: &mut InForce, search_area: SearchArea) -> Result<u64, Failure> {
        if next.map.is_none() {
            return Err(NO_MAP.into());
        }
        self.check_inputs()?;
        next.searches.ask(search_area)
    }

    /// Refuses what cannot begin.
    pub(super) fn check_inputs(&self) -> Result<(), Failure> {
        self.newest.why_incomplete().map_or(Ok(()), |why| Err(why.into()))
    }

    /// What became of a comparison.
    pub(super) fn comparison(&self, at_least: Option<u64>, now: &Now<'_, Self>) -> ComparisonState {
        let impossible = |why: &str| ComparisonState::Impossible { why: why.to_owned() };
        let InForce { pending, searches, job_errors, .. } = &self.in_force;
        let wanted = at_least.unwrap_or(pending.wanted_comparison);
        if self.in_force.map.is_none() {
            return impossible(NO_MAP);
        }
        if let Some(why) = self.newest.why_incomplete() {
            return impossible(why);
        }
        let is_comparable = self.in_force.slam_frame().is_some();
        let is_waiting = self.in_force.validity() == Some(PoseValidity::WaitsForConfirm);
        let is_working = self.is_busy || self.done.is_some();
        let is_searching = searches.is_waiting() || pending.search || pending.refresh || is_working;
        if is_waiting || (!is_comparable && !is_searching) {
            return impossible(&self.in_force.why_not_effective().unwrap_or_default());
        }
        let is_done = is_comparable && !pending.refresh && wanted <= pending.done_comparison;
        if is_done && now.outputs.deviations.last().is_some() {
            return ComparisonState::Done(now.outputs.deviations.published());
        }
        match job_errors.get(&TaskKind::Compare) {
            Some(why) if !is_searching && pending.begun_comparison == pending.wanted_comparison => {
                impossible(&format!("{} failed: {why}", TaskKind::Compare.name()))
            }
            _ => ComparisonState::Running { comparison: wanted },
        }
    }
}

/// The inputs of a job have been replaced.
fn begin_again(next: &mut InForce, task: &Task) {
    match task {
        Task::Draw => next.pending.refresh = true,
        Task::Search { asked, .. } => {
            next.pending.search |= asked.is_none();
            next.searches.begin_again();
        }
        Task::Compare { .. } => next.pending.wanted_comparison += 1,
    }
}

/// A job that failed is not tried again by itself: it would fail again.
fn fail(next: &mut InForce, task: &Task, inputs: &JobInputs, why: &str) {
    warn!(service = "slam-align", job = task.kind().name(), error = why, "a job of the worker failed");
    next.job_errors.insert(task.kind(), why.to_owned());
    let is_drawn = next.reference_inputs.is_some_and(|drawn| drawn.hashes.site == inputs.hashes.site);
    if !is_drawn {
        // The pose is of a site that is replaced, and nothing says what it is worth on this one.
        next.follower.hold();
    }
    next.searches.end(SearchState::Failed { why: format!("{} failed: {why}", task.kind().name()) });
}

/// Takes the result of a search of a map, which may be an earlier one than the newest. A narrowed search that finds nothing
/// says nothing about the pose that is there.
fn take_search(next: &mut InForce, alignment: &Arc<Alignment>, map: &RobotMap, is_asked: bool, is_narrowed: bool) {
    next.follow();
    let best = alignment.poses.first().filter(|_| alignment.verdict == AlignmentVerdict::Accepted);
    let best = best.map(|pose| pose.record(&next.storeys()));
    next.follower.searched(best, map.content_hash, is_asked);
    let is_of_newest_map = next.map_hash() == Some(map.content_hash);
    match is_of_newest_map {
        true => next.find_field(map),
        false => next.follow(),
    }
    let (verdict, poses) = (alignment.verdict.name(), alignment.poses.len());
    info!(service = "slam-align", verdict, poses, reason = alignment.reason, "all poses searched");
    if !is_narrowed || alignment.verdict == AlignmentVerdict::Accepted {
        next.verdict = Some((alignment.verdict, map.content_hash));
    }
    (next.last_search, next.searched_map_hash) = (Arc::clone(alignment), map.content_hash);
    // Its epoch is known once it is published.
    next.searches.end(SearchState::Done { alignment: Published::default(), is_of_newest_map });
}

/// Ends a search that could not begin. What a client asked for is that client's mistake; what `site.toml` says stays wrong
/// until it is edited.
fn refuse_search(next: &mut InForce, why: &UnknownPlace, is_asked: bool) {
    let why = chain(why);
    if !is_asked {
        warn!(service = "slam-align", error = why, "the pose was not searched");
        next.job_errors.insert(TaskKind::Search, format!("[align]: {why}"));
    }
    next.searches.end(SearchState::Failed { why });
}

const NO_MAP: &str = "there is no SLAM map yet: give one with groundplan slam-map, or let the robot publish one";
