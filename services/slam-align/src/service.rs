//! Decisions of slam-align: the pose of the robot's map, the next job of its worker, the observations that count.

mod confirmation;
mod jobs;

use crate::background_worker::{Outcome, Worker};
use crate::in_force::{InForce, Used, hint_of, max_jump, pose_event};
use crate::job::{Job, JobResult, SearchArea, work};
use crate::map_setting::{MapSetting, OtherMap};
use crate::newest_inputs::{NewestInputs, NewestSite};
use crate::observed_table::{GiveTable, ObservedTable, TableTaker, give_table};
use crate::outputs::{AlignOutputs, AlignSample};
use crate::persisted_state::PersistedState;
use crate::robot_map::RobotMap;
use crate::searches::Searches;
use crate::stored_evidence;
use bus::{Bus, CheckedSample, topics};
use daemon::facts::{AlignFacts, AlignmentSummary};
use daemon::{
    AlignAnswer, AlignRequest, Asked, Committed, CurrentActivity, Decide, Decision, Epochs, Failure, FileText,
    NewSample, Now, Occasion, SiteConfig, Standing, StateFile, chain, joined, state_files,
};
use deviations::AppliedObservations;
use messages::{Activity, Checked, ContentHash};
use site_view::{SiteSample, SiteSamples};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;
use tracing::warn;

/// Interval at which the worker is polled.
const POLL_INTERVAL: Duration = Duration::from_millis(20);

daemon::inputs! {
    /// What poses and deviations are made from. The index of the grids names the robot.
    pub enum AlignInput { Site, ScheduleState, Grids, SlamMap }
}

/// Follows a robot's map. It never waits for its worker, so that newer maps, requests and generations of the bus come
/// through while a search runs.
pub struct SlamAlign {
    in_force: InForce,
    state: StateFile,
    state_folder: PathBuf,
    /// What was damaged or removed of the state before this start.
    findings: Vec<String>,
    activity: CurrentActivity,
    /// Of the bus.
    generation: u64,
    /// The newest samples; those of a job are with the worker while it works.
    samples: SiteSamples,
    /// What the newest samples are, wherever they are.
    newest: NewestInputs,
    /// The newest map that was not decided on.
    newest_map: Option<NewestMap>,
    worker: Worker<Job, JobResult>,
    is_busy: bool,
    /// What the worker has done, until that is decided on; the samples are back.
    done: Option<Outcome<Job, JobResult>>,
}

/// A map of the robot, or why it cannot be used.
struct NewestMap {
    map: Result<Arc<RobotMap>, String>,
    /// Epoch and content hash of its sample; `None` for the one of a file that was in force at the start.
    sample: Option<(u64, ContentHash)>,
}

impl SlamAlign {
    /// The daemon on this machine, from the configuration and the persisted state.
    ///
    /// # Errors
    /// State that cannot be used.
    pub fn start(config: &SiteConfig, activity: CurrentActivity) -> Result<Committed<Self>, Failure> {
        let mut references = None;
        let worker = Worker::start(config.n_threads(), move |job: &Job| work(&mut references, job))?;
        let taker = TableTaker::of(config);
        let give = move |bus: &Bus, table: FileText, waits: bool| give_table(bus, taker, table, waits);
        Self::start_with(config, activity, worker, Box::new(give))
    }

    /// The same with another worker, and other means to give schedule-eval a table of observed progress.
    ///
    /// # Errors
    /// State that cannot be used.
    pub fn start_with(
        config: &SiteConfig,
        activity: CurrentActivity,
        worker: Worker<Job, JobResult>,
        give: Box<GiveTable>,
    ) -> Result<Committed<Self>, Failure> {
        config.align.check()?;
        let state = StateFile::at(&config.state, state_files::ALIGNMENT)?;
        let persisted: PersistedState = state.load()?.unwrap_or_default();
        let map_setting = MapSetting::open(&config.state, &config.align)?;
        let epochs = Epochs::at(&config.state, state_files::ALIGNMENT_EPOCHS)?;
        let (evidence, of_evidence) = stored_evidence::read(&config.state);
        let (map, of_map) = match map_setting.map() {
            Ok(found) => found.map_or((None, None), |(map, finding)| (Some(Ok(Arc::new(map))), finding)),
            Err(why) => (Some(Err(chain(&why))), None),
        };
        let file = config.state.join(state_files::OBSERVED_BY_ALIGNMENT);
        let (table, empty) =
            (persisted.observed.table(config.align.apply), AppliedObservations::default().table(false));
        let observed = ObservedTable::new(give, file, table, &empty);
        let searches = Searches::of_process(epochs.reserved());
        let service = Self {
            in_force: InForce::new(&config.align, persisted, map_setting, evidence, searches),
            findings: [state.finding().map(str::to_owned), of_map, of_evidence].into_iter().flatten().collect(),
            state,
            state_folder: config.state.clone(),
            activity: activity.clone(),
            generation: 0,
            samples: SiteSamples::default(),
            newest: NewestInputs::default(),
            newest_map: map.map(|map| NewestMap { map, sample: None }),
            worker,
            is_busy: false,
            done: None,
        };
        Ok(Committed::new(service, AlignOutputs::new(observed), epochs, &config.state, activity))
    }

    /// A map from the bus; in a new generation of it the last one comes again.
    fn take_map(&mut self, sample: &CheckedSample<topics::SlamMap>) {
        let identity = Some((sample.bytes().header().epoch, sample.content_hash()));
        let waiting = self.newest_map.as_ref().and_then(|newest| newest.sample);
        if identity != self.in_force.seen_map && identity != waiting {
            let map = RobotMap::of_archive(&sample.view()).map(Arc::new).map_err(|why| chain(&why));
            self.newest_map = Some(NewestMap { map, sample: identity });
        }
    }

    /// Looks at all that has come; true if it changes anything.
    fn look(&self, decision: &mut Decision<Self>, now: &Now<'_, Self>) -> Result<bool, Failure> {
        let other_map = decision.next.map_setting.retry(&self.in_force.config)?;
        let mut is_changed = Self::take_other_map(decision, other_map);
        is_changed |= self.take_newest(&mut decision.next);
        if let Some(NewestMap { map, sample }) = &self.newest_map {
            let next = &mut decision.next;
            next.used.map = true;
            next.seen_map = sample.or(next.seen_map);
            match map {
                // A file's waits for nothing but a map from elsewhere.
                _ if sample.is_none() && next.map.is_some() => {}
                Ok(map) => next.take_map(Arc::clone(map)),
                Err(why) => next.map_error = Some(why.clone()),
            }
            is_changed = true;
        }
        if let Some(done) = &self.done {
            decision.next.used.outcome = true;
            self.finish(decision, done, now)?;
            is_changed = true;
        }
        Ok(is_changed)
    }

    /// Takes the newest site, schedule state and index; true if any of them is another one.
    fn take_newest(&self, next: &mut InForce) -> bool {
        let earlier = std::mem::replace(&mut next.seen, self.newest);
        if earlier == self.newest {
            return false;
        }
        next.refresh();
        let is_other_site = earlier.site != self.newest.site;
        if let Some(NewestSite { frame_epoch, n_storeys, .. }) = self.newest.site.filter(|_| is_other_site) {
            let is_other_frame = earlier.site.is_some_and(|earlier| earlier.frame_epoch != frame_epoch);
            if is_other_frame || next.persisted.is_of_another_frame(frame_epoch) {
                warn!(service = "slam-align", frame_epoch, "the map frame is another: the pose is forgotten");
                next.persisted_mut().forget_poses();
                next.forget_pose();
            } else if next.follower.pose().is_some_and(|pose| pose.map_storey as usize >= n_storeys) {
                next.forget_pose();
            }
            // What was refused on the site before may be found on this one.
            next.pending.search |= next.map.is_some() && next.effective_pose().is_none();
        }
        true
    }

    /// Takes what follows from another setting; true if the map is another.
    fn take_other_map(decision: &mut Decision<Self>, OtherMap { map, saves }: OtherMap) -> bool {
        decision.save.extend(saves);
        map.map(|map| decision.next.take_map(Arc::new(map))).is_some()
    }

    /// Takes another configuration.
    fn configure(&self, decision: &mut Decision<Self>, config: &SiteConfig) -> Result<(), Failure> {
        config.align.check()?;
        let next = &mut decision.next;
        let earlier = next.search_area();
        next.config = Arc::new(config.align.clone());
        next.pending.search |= earlier != next.search_area() && next.map.is_some();
        next.follower.set_max_jump(max_jump(&config.align));
        let other_map = next.map_setting.edit(&config.align)?;
        Self::take_other_map(decision, other_map);
        Ok(())
    }

    /// Takes the map of a file, and asks for a search of its pose; the number of the search.
    ///
    /// # Errors
    /// A map that cannot be used, no site to compare it with: the map before it stays.
    fn read_map(&self, decision: &mut Decision<Self>, file: &Path, by_uid: u32) -> Result<u64, Failure> {
        self.check_inputs()?;
        let map = decision.next.map_setting.command(file, by_uid)?;
        Self::take_other_map(decision, map);
        let search_area = decision.next.search_area();
        self.ask_for_search(&mut decision.next, search_area)
    }

    /// Carries a request out, and answers; `decision` says what follows.
    fn carry_out(
        &self,
        decision: &mut Decision<Self>,
        request: AlignRequest,
        Asked { by, .. }: &Asked,
        now: &Now<'_, Self>,
    ) -> Result<Option<AlignAnswer>, Failure> {
        let next = &mut decision.next;
        Ok(Some(match request {
            AlignRequest::ReadSlamMap { file } => AlignAnswer::Search(self.read_map(decision, &file, by.uid)?),
            AlignRequest::Align { hint, storey, places } => {
                hint.iter().try_for_each(daemon::PoseHint::check).map_err(|why| format!("the hint: {why}"))?;
                let is_narrowed = hint.is_some() || storey.is_some() || !places.is_empty();
                let search_area = SearchArea { hint: hint.map(hint_of), storey, places, is_narrowed };
                AlignAnswer::Search(self.ask_for_search(next, search_area)?)
            }
            AlignRequest::SearchResult { search } => AlignAnswer::SearchState(next.searches.state(search)),
            AlignRequest::Comparison { at_least } => AlignAnswer::Comparison(self.comparison(at_least, now)),
            AlignRequest::ConfirmAbsent { elements } => {
                AlignAnswer::Elements(self.confirm_absent(decision, &elements, *by, now)?)
            }
            AlignRequest::UndoAbsent { elements } => AlignAnswer::Elements(self.undo_absent(decision, &elements, *by)?),
            AlignRequest::ListConfirmed => AlignAnswer::Confirmations(self.confirmations()),
            // Their answer is what is published then.
            AlignRequest::ConfirmPose { waiting } => {
                return self.confirm_pose(decision, &waiting, *by, now).map(|()| None);
            }
            AlignRequest::UndoPose { before } => {
                return self.undo_confirmed_pose(decision, &before, *by).map(|()| None);
            }
        }))
    }

    /// What is published, saved and told of the state that a decision makes.
    fn settle(&self, decision: &mut Decision<Self>, is_asked: bool) -> Result<(), Failure> {
        let (earlier, next) = (&self.in_force, &mut decision.next);
        let [before, table] = [earlier, &*next].map(|state| state.persisted.observed.table(state.config.apply));
        if table != before {
            decision.publish.push(AlignSample::Observed { table, is_asked });
        }
        if let Some((archive, inputs)) = next.archive() {
            if next.alignment.as_ref().is_none_or(|last| last.bytes().bytes() != archive.bytes()) {
                let archive = Arc::new(Checked::new(archive)?);
                next.pending.wanted_comparison += 1;
                next.alignment = Some(Arc::clone(&archive));
                let sample = NewSample { archive, frame_epoch: inputs.frame_epoch, inputs: inputs.hashes };
                decision.publish.push(AlignSample::Alignment(sample));
            }
            // The pose must survive this daemon; moves below the threshold are not written.
            if let Some(pose) = next.follower.pose().copied().filter(|pose| next.persisted.is_worth_saving(pose)) {
                let frame_epoch = next.frame_epoch();
                next.persisted_mut().set_pose(&pose, frame_epoch);
            }
            decision.history.extend(next.withdraw());
        }
        if next.persisted != earlier.persisted {
            decision.save.push(self.state.saving(&*next.persisted)?);
        }
        if let (None, Some(pose), false) = (earlier.follower.pose(), next.effective_pose(), is_asked) {
            decision.history.push(pose_event(None, "accepted", &pose));
        }
        Ok(())
    }
}

impl Decide for SlamAlign {
    type Input = AlignInput;
    type Request = AlignRequest;
    type Facts = AlignFacts;
    type InForce = InForce;
    type Outputs = AlignOutputs;

    fn take(&mut self, input: AlignInput) {
        match input {
            AlignInput::Site(site) => {
                let (hash, frame_epoch) = (site.content_hash(), site.bytes().header().frame_epoch);
                self.newest.site = Some(NewestSite { hash, frame_epoch, n_storeys: site.view().map_storeys.len() });
                self.samples.insert(SiteSample::Site(site));
            }
            AlignInput::ScheduleState(state) => {
                self.newest.schedule_state = Some([state.view().head.site_hash, state.content_hash()]);
                self.samples.insert(SiteSample::ScheduleState(state));
            }
            AlignInput::Grids(index) => {
                self.newest.index = Some([index.view().head.site_hash, index.bytes().header().inputs.robot]);
                self.samples.insert(SiteSample::Index(index));
            }
            AlignInput::SlamMap(map) => self.take_map(&map),
        }
    }

    fn attach(&mut self, bus: &Bus) -> Result<(), Failure> {
        // A job that runs keeps its samples, and with them their generation of the bus.
        (self.samples, self.generation) = (SiteSamples::default(), bus.generation());
        Ok(())
    }

    fn gather(&mut self) -> Result<(), Failure> {
        let Some(mut done) = self.worker.take()? else { return Ok(()) };
        let samples = std::mem::take(&mut done.job.samples);
        if done.job.generation == self.generation {
            // Newer samples have come meanwhile, or these are still the newest.
            self.samples.take_back(samples);
        }
        self.activity.set(if self.in_force.alignment.is_some() { Activity::Published } else { Activity::Idle });
        (self.is_busy, self.done) = (false, Some(done));
        Ok(())
    }

    fn decide(&self, occasion: Occasion<'_, AlignRequest>, now: &Now<'_, Self>) -> Result<Decision<Self>, Failure> {
        let mut decision = Decision::<Self>::of(InForce { used: Used::default(), ..self.in_force.clone() });
        decision.next.searches.are_published(now.outputs.alignment.published());
        match occasion {
            Occasion::Look => {
                if self.look(&mut decision, now)? {
                    self.settle(&mut decision, false)?;
                }
            }
            Occasion::Configuration(config) => {
                self.configure(&mut decision, config)?;
                self.settle(&mut decision, false)?;
            }
            Occasion::Request(request, asked) => {
                let answer = self.carry_out(&mut decision, request, asked, now)?;
                // What is saved or told changes something; the rest asks.
                if !(decision.save.is_empty() && decision.history.is_empty()) {
                    self.settle(&mut decision, true)?;
                }
                let published = |now: &Now<'_, Self>| AlignAnswer::Pose(now.outputs.alignment.published());
                decision = decision.answered(move |_, now| answer.unwrap_or_else(|| published(now)));
            }
        }
        decision.next.used.begins = self.next_job(&mut decision.next);
        let is_working = self.is_busy || decision.next.used.begins.is_some();
        let is_done = self.done.is_some() && !decision.next.used.outcome;
        decision.wake_in = (is_working || is_done).then_some(POLL_INTERVAL);
        Ok(decision)
    }

    fn become_in_force(&mut self, mut next: InForce) {
        let Used { map, outcome, begins } = std::mem::take(&mut next.used);
        self.newest_map = self.newest_map.take().filter(|_| !map);
        self.done = self.done.take().filter(|_| !outcome);
        let needed = self.in_force.map_setting.needed();
        self.in_force = next;
        if needed != self.in_force.map_setting.needed() {
            self.in_force.map_setting.remove_other_copies();
        }
        if let Some((inputs, task)) = begins {
            self.activity.set(Activity::Reading);
            self.is_busy = true;
            let samples = std::mem::take(&mut self.samples);
            self.worker.begin(Job { samples, inputs, generation: self.generation, task });
        }
    }

    fn standing(&self, _: &Now<'_, Self>) -> Standing {
        let InForce { job_errors, map_setting, map_error, .. } = &self.in_force;
        let failed = job_errors.iter().next().map(|(kind, why)| format!("{} failed: {why}", kind.name()));
        let warning = map_setting.warning().map(str::to_owned);
        let warnings = self.findings.iter().cloned().chain(warning).chain(self.in_force.why_not_effective());
        Standing { error: map_error.clone().or(failed), warning: joined(warnings) }
    }

    fn facts(&self, now: &Now<'_, Self>) -> AlignFacts {
        let output = &now.outputs.alignment;
        let alignment = output.last().map(|last| AlignmentSummary::of(output.epoch(), &last.view()));
        AlignFacts { alignment, setting: self.in_force.map_setting.in_force() }
    }
}
