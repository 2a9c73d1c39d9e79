//! The schedule-eval service: holds the plan time and publishes the schedule state.

use crate::evaluation::{Evaluated, EvaluationError, evaluated};
use crate::machine_time::{self, MachineTime};
use crate::plan_time_clock::{PlanTimeClock, ReachedPlanTime, Reading};
use crate::plan_time_setting::PlanTimeSetting;
use crate::schedule_files::ScheduleFiles;
use bus::{Bus, CheckedSample, topics};
use daemon::facts::{ProgressRows, ScheduleFacts};
use daemon::{
    ActualsSource, Asked, Caller, Configured, CurrentActivity, Done, Epochs, Event, Failure, FileText, History,
    HistoryEvent, HistoryKind, LatchedOutput, Published, ReportedProgress, ScheduleAnswer, ScheduleRequest, Service,
    Setting, SettingInForce, SettingKey, SettingSource, SiteConfig, Standing, StateFile, checked_rate, keep_observed,
    mend_progress, progress_in_force,
};
use frames::PlanTime;
use jiff::tz::TimeZone;
use messages::{Activity, Checked, DiagnosticCode, InputHashes, ScheduleStateHead};
use schedule::{Overrides, Rules, parse_actuals};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::time::Duration;
use tracing::{info, warn};

daemon::inputs! {
    /// What the schedule is read from.
    pub(crate) enum ScheduleInput { Site }
}

/// A plan time that moves is on disk with each change, and at least this often: the reading by which a clock that went ahead
/// while the machine was off is noticed.
const KEPT_EVERY_MS: i64 = 3_600_000;
/// What is due for longer could not be published.
const LATE_MS: i64 = 1_000;

/// Holds the plan time, which is restored from its state file after a restart.
///
/// While the plan time moves, the schedule state is that of the last change instant: it does not depend on how often it
/// is evaluated, and has its validity.
pub(crate) struct ScheduleService {
    rules: Rules,
    synchronised_while: Option<PathBuf>,
    /// Which boot of the machine this is.
    boot: Option<u64>,
    plan_time: PlanTimeSetting,
    rules_setting: Setting<Option<FileText>>,
    files: ScheduleFiles,
    /// The state folder, for the tables of progress.
    state: PathBuf,
    overrides: Overrides,
    epochs: Epochs,
    activity: CurrentActivity,
    /// Tasks of schedule files: on the bus before the states that follow them.
    tasks: LatchedOutput<topics::Tasks>,
    output: LatchedOutput<topics::ScheduleState>,
    /// The newest site; kept to evaluate it again when rules or progress change.
    site: Option<CheckedSample<topics::Site>>,
    /// The last schedule that could be evaluated: of an earlier site, if that of the newest cannot.
    evaluated: Option<Evaluated>,
    /// Why the schedule is not that of the newest site, rules and progress.
    error: Option<String>,
    history: History,
    /// Plan time of what was published last, or waits for room; `None` before that.
    published_at_s: Option<Option<i64>>,
    /// Plan time of what is on the bus; `None` before that.
    shown_at_s: Option<Option<i64>>,
    /// The rules that a site was last evaluated with: they stand in at a start where those in force cannot be used with the site.
    usable_rules: Option<KeptRules>,
    usable_rules_file: StateFile,
    /// What an operator should know of tables of progress that were damaged before this start.
    mended_progress: Option<String>,
}

/// Rules that a site was evaluated with.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct KeptRules {
    rules: Option<FileText>,
}

impl ScheduleService {
    /// From the configuration and what survived.
    ///
    /// # Errors
    /// Rules, schedule files, a plan time or state that cannot be used.
    pub(crate) fn new(config: &SiteConfig, activity: CurrentActivity) -> Result<Self, Failure> {
        let rules_setting = Setting::open(&config.state, SettingKey::Rules, rules_configured(config), || Ok(None))?;
        let rules = parse_rules(rules_setting.value().as_ref())?;
        let boot = machine_time::boot();
        let plan_time = PlanTimeSetting::open(config, rules.site_zone.as_ref(), MachineTime::now(boot))?;
        check_zone(&rules, plan_time.clock())?;
        let usable_rules_file = StateFile::at(&config.state, "evaluated-rules.json")?;
        let mended_progress = mend_progress(&config.state)?;
        let [actuals, observed] = progress_in_force(&config.state, parse_actuals)?;
        let files = ScheduleFiles::open(config, &rules)?;
        let service = Self {
            rules,
            files,
            synchronised_while: config.clock.synchronised_while.clone(),
            boot,
            plan_time,
            rules_setting,
            overrides: Overrides { actuals, observed, is_of_earlier_revision: true, ..Overrides::default() },
            state: config.state.clone(),
            epochs: Epochs::at(&config.state, "schedule-eval-epochs.json")?,
            activity,
            tasks: LatchedOutput::new(topics::Tasks),
            output: LatchedOutput::new(topics::ScheduleState),
            site: None,
            evaluated: None,
            error: None,
            history: History::at(&config.state),
            published_at_s: None,
            shown_at_s: None,
            usable_rules: usable_rules_file.load_unless_damaged()?,
            usable_rules_file,
            mended_progress,
        };
        service.record_edits(service.rules_setting.was_edited(), service.plan_time.was_edited());
        Ok(service)
    }

    /// What was edited in `site.toml`.
    fn record_edits(&self, has_other_rules: bool, has_other_plan_time: bool) {
        if has_other_rules {
            self.record(HistoryKind::Rules, None, format!("rules of {}", self.rules_words()));
        }
        if has_other_plan_time {
            self.record(HistoryKind::Date, None, format!("plan time {} of site.toml", self.plan_time.in_force().value));
        }
    }

    /// The settings in force; without schedule files there is no setting of them.
    fn settings(&self) -> Vec<SettingInForce> {
        let rules = self.rules_setting.in_force(|_| self.rules_words());
        let files = self.files.names().map(|names| SettingInForce {
            since: self.files.since(),
            ..SettingInForce::now(SettingKey::ScheduleFiles, names, SettingSource::SiteToml, None)
        });
        [rules, self.plan_time.in_force()].into_iter().chain(files).collect()
    }

    /// The zone in which the machine's clock is read.
    fn zone(&self) -> TimeZone {
        self.rules.site_zone.clone().unwrap_or(TimeZone::UTC)
    }

    fn read_clock(&self) -> (Reading, MachineTime) {
        let now = MachineTime::now(self.boot);
        let synchronised = self.synchronised_while.as_deref().is_none_or(Path::exists);
        (self.plan_time.clock().read(now, &self.zone(), synchronised), now)
    }

    /// Sets a mode: on disk before it is published, because a map must never go back in time when a process dies.
    fn set_clock(&mut self, clock: PlanTimeClock, by: Caller) -> Result<Done, Failure> {
        self.check_timeline()?;
        let earlier = self.plan_time.set(clock, by.uid)?;
        self.publish().or_else(|why| {
            self.published_at_s = None;
            self.plan_time.go_back(earlier)?;
            Err(why)
        })
    }

    /// Refuses to move the plan time along the schedule of a site that is no longer the newest.
    fn check_timeline(&self) -> Result<(), Failure> {
        let (Some(site), Some(evaluated)) = (&self.site, &self.evaluated) else { return Ok(()) };
        match &self.error {
            Some(why) if evaluated.site_hash != site.content_hash() => {
                Err(format!("the plan time stands until the newest site has a schedule: {why}").into())
            }
            _ => Ok(()),
        }
    }

    fn follow_wall_clock(&mut self, by: Caller) -> Result<Done, Failure> {
        if self.rules.site_zone.is_none() {
            return Err("to follow the clock, set site_zone in the schedule rules".into());
        }
        self.set_clock(PlanTimeClock::Wall { reached: ReachedPlanTime::default() }, by)
    }

    fn simulate(&mut self, rate: f64, from_s: Option<i64>, by: Caller) -> Result<Done, Failure> {
        let rate = checked_rate(rate)?;
        let (reading, now) = self.read_clock();
        let from_s = from_s.or(reading.plan_time_s).ok_or("there is no plan time to start from: say which")?;
        let since_ms = now.wall_ms;
        self.set_clock(PlanTimeClock::Simulated { from_s, rate, since_ms, reached: ReachedPlanTime::default() }, by)
    }

    fn next_change(&mut self, by: Caller) -> Result<Done, Failure> {
        self.check_timeline()?;
        let evaluated = self.evaluated.as_ref().ok_or("there is no site yet")?;
        let now_s = self.read_clock().0.plan_time_s.unwrap_or(i64::MIN);
        let next = evaluated.timeline.instants_s().iter().find(|s| **s > now_s).copied();
        let at_s = next.ok_or("no later change in the schedule")?;
        self.set_clock(PlanTimeClock::Fixed { at_s }, by)
    }

    /// Progress that was reported, or observed; a file that cannot be used changes nothing.
    fn set_actuals(&mut self, file: Option<&FileText>, source: ActualsSource) -> Result<Done, Failure> {
        let bytes = file.map_or(NO_PROGRESS, |file| file.text.as_bytes());
        let path = file.map_or(Path::new(""), |file| &file.path);
        let named = |e: &(dyn std::error::Error + 'static)| format!("{}: {}", path.display(), daemon::chain(e));
        let actuals = parse_actuals(bytes).map_err(|e| named(&e))?;
        let mut overrides = self.overrides.clone();
        match (source, file) {
            (ActualsSource::Reported, Some(_)) if actuals.is_empty() => {
                let file = path.display();
                return Err(
                    format!("{file} has no rows: `groundplan actuals --clear` takes reported progress back").into()
                );
            }
            // A new table is about the model as it is.
            (ActualsSource::Reported, _) => (overrides.actuals, overrides.is_of_earlier_revision) = (actuals, false),
            (ActualsSource::Observed, _) => overrides.observed = actuals,
        }
        let evaluated = self.evaluate(&overrides)?.transpose().map_err(|e| named(&e))?;
        overrides.is_of_earlier_revision = true;
        match source {
            ActualsSource::Reported => {
                let tables = ReportedProgress::at(&self.state);
                tables.add(bytes).map_err(|e| format!("the table cannot be written: {e}"))?;
                self.take_progress(overrides, evaluated)
                    .or_else(|why| tables.take_back().map_err(Into::into).and(Err(why)))
            }
            ActualsSource::Observed => {
                keep_observed(&self.state, bytes).map_err(|e| format!("the table cannot be written: {e}"))?;
                self.take_progress(overrides, evaluated)
            }
        }
    }

    /// Goes back to the progress that was reported before the last table.
    fn undo_actuals(&mut self) -> Result<Done, Failure> {
        let tables = ReportedProgress::at(&self.state);
        let [last, before] = tables.tables()?;
        let last = ReportedProgress::read(&last.ok_or("no progress was reported that could be taken back")?)?;
        let mut overrides = self.overrides.clone();
        overrides.actuals = match before {
            Some(before) => {
                let bytes = ReportedProgress::read(&before)?;
                // Earlier versions wrote no columns where nothing was reported.
                if bytes.is_empty() { Vec::new() } else { parse_actuals(&bytes)? }
            }
            None => Vec::new(),
        };
        let evaluated = self.evaluate(&overrides)?.transpose()?;
        tables.take_back()?;
        self.take_progress(overrides, evaluated).or_else(|why| tables.add(&last).map_err(Into::into).and(Err(why)))
    }

    /// Publishes the schedule with other progress, which is on disk; what fails leaves the schedule as it was.
    fn take_progress(&mut self, overrides: Overrides, evaluated: Option<Evaluated>) -> Result<Done, Failure> {
        let overrides = std::mem::replace(&mut self.overrides, overrides);
        let evaluated = std::mem::replace(&mut self.evaluated, evaluated);
        match self.publish() {
            Ok(done) => {
                self.error = None;
                Ok(done)
            }
            Err(why) => {
                (self.overrides, self.evaluated, self.published_at_s) = (overrides, evaluated, None);
                Err(why)
            }
        }
    }

    fn progress_rows(&self) -> ProgressRows {
        ProgressRows { reported: self.overrides.actuals.len(), observed: self.overrides.observed.len() }
    }

    fn rules_words(&self) -> String {
        FileText::words(self.rules_setting.value().as_ref(), "the default rules")
    }

    fn record(&self, kind: HistoryKind, by: Option<Caller>, summary: String) {
        if let Err(why) = self.history.record(HistoryEvent { kind, by, summary }) {
            warn!(service = "schedule-eval", error = daemon::chain(&why), "the history cannot be written");
        }
    }

    /// Takes other rules: a site whose schedule could not be used may have one now. Rules that the site has no schedule with
    /// count for the next site; until then the schedule stays.
    fn configure(&mut self, config: &SiteConfig) -> Result<Done, Failure> {
        let edited = self.rules_setting.edited(rules_configured(config))?;
        let rules = parse_rules(edited.value().as_ref())?;
        check_zone(&rules, self.plan_time.clock())?;
        self.files.configure(config, &rules)?;
        let has_other_plan_time = self.plan_time.edit(config, rules.site_zone.as_ref())?;
        let has_other_rules = edited != self.rules_setting.as_kept();
        if has_other_rules {
            self.rules_setting.keep(edited)?;
        }
        self.record_edits(has_other_rules, has_other_plan_time);
        self.rules = rules;
        self.synchronised_while.clone_from(&config.clock.synchronised_while);
        self.evaluate_site()
    }

    /// The schedule of the newest site with other overrides; `None` if there is no site yet.
    fn evaluate(&self, overrides: &Overrides) -> Result<Option<Result<Evaluated, EvaluationError>>, Failure> {
        match &self.site {
            Some(site) => Ok(Some(evaluated(site, &self.rules, self.files.plans(), overrides))),
            // The bus was created anew, and the site is on its way.
            None if self.evaluated.is_some() => Err("the site is not there at the moment: try again".into()),
            None => Ok(None),
        }
    }

    fn handle_site(&mut self, site: CheckedSample<topics::Site>) -> Result<Done, Failure> {
        let is_evaluated = self.evaluated.as_ref().is_some_and(|e| e.site_hash == site.content_hash());
        self.site = Some(site);
        if is_evaluated && self.error.is_none() { self.tick() } else { self.evaluate_site() }
    }

    /// Evaluates the newest site with the newest rules. If that cannot be, the last schedule stays, and the error stands until
    /// site, rules or progress are others.
    fn evaluate_site(&mut self) -> Result<Done, Failure> {
        let Some(site) = &self.site else {
            // The bus was created anew, and the site is on its way.
            self.error = self.evaluated.as_ref().map(|_| "the site is not there at the moment".to_owned());
            return Ok(self.done());
        };
        self.activity.set(Activity::Reading);
        match evaluated(site, &self.rules, self.files.plans(), &self.overrides) {
            Ok(evaluated) => {
                let (tasks, changes) = (evaluated.n_tasks, evaluated.timeline.instants_s().len());
                info!(service = "schedule-eval", tasks, changes, "schedule evaluated");
                (self.evaluated, self.error) = (Some(evaluated), None);
                self.keep_usable_rules()?;
                self.publish()
            }
            Err(why) => {
                self.error = Some(format!("the schedule cannot be used: {}", daemon::chain(&why)));
                self.activity.set(if self.output.last().is_some() { Activity::Published } else { Activity::Idle });
                if self.evaluated.is_none() {
                    self.evaluate_with_usable_rules()?;
                }
                self.tick()
            }
        }
    }

    /// The rules in force are some that a site was evaluated with.
    fn keep_usable_rules(&mut self) -> Result<(), Failure> {
        let kept = KeptRules { rules: self.rules_setting.value().clone() };
        if self.usable_rules.as_ref() != Some(&kept) {
            self.usable_rules_file.save(&kept)?;
            self.usable_rules = Some(kept);
        }
        Ok(())
    }

    /// After a start there is no schedule that could stay: that of the rules before stands in.
    fn evaluate_with_usable_rules(&mut self) -> Result<(), Failure> {
        let (Some(site), Some(KeptRules { rules })) = (&self.site, &self.usable_rules) else { return Ok(()) };
        let rules = parse_rules(rules.as_ref())?;
        if let Ok(evaluated) = evaluated(site, &rules, self.files.plans(), &self.overrides) {
            warn!(service = "schedule-eval", "the schedule is evaluated with the rules before");
            self.evaluated = Some(evaluated);
        }
        Ok(())
    }

    /// The schedule state at the plan time, if there is a site.
    fn publish(&mut self) -> Result<Done, Failure> {
        let (reading, now) = self.read_clock();
        let at_s = self.effective_plan_time_s(reading);
        if self.evaluated.is_some() {
            self.keep_clock(reading, now)?;
        }
        self.publish_tasks()?;
        let Some(evaluated) = &self.evaluated else { return Ok(self.done()) };
        self.activity.set(Activity::Writing);
        let schedule_state = Checked::new(evaluated.timeline.schedule_state_at(at_s).finish())?;
        let (n_bytes, frame_epoch) = (schedule_state.bytes().bytes().len(), evaluated.frame_epoch);
        let inputs = InputHashes { site: evaluated.site_hash, ..InputHashes::default() };
        self.published_at_s = Some(at_s);
        self.output.publish(&mut self.epochs, schedule_state, frame_epoch, inputs)?;
        self.shown_at_s = Some(at_s);
        info!(service = "schedule-eval", epoch = self.output.epoch(), bytes = n_bytes, "schedule state published");
        self.activity.set(Activity::Published);
        Ok(self.done())
    }

    /// The tasks of schedule files, if they are others than those on the bus.
    fn publish_tasks(&mut self) -> Result<(), Failure> {
        let Some(evaluated) = &self.evaluated else { return Ok(()) };
        let Some(tasks) = &evaluated.tasks else { return Ok(()) };
        if self.tasks.is_last(tasks) {
            return self.tasks.retry(&mut self.epochs);
        }
        let inputs = InputHashes { site: evaluated.site_hash, ..InputHashes::default() };
        self.tasks.publish(&mut self.epochs, Checked::new(tasks.clone())?, evaluated.frame_epoch, inputs)
    }

    /// Saves how far a plan time that moves got.
    fn keep_clock(&mut self, reading: Reading, machine: MachineTime) -> Result<(), Failure> {
        if self.plan_time.clock().is_moving() && reading.distrust.is_none() {
            let clock =
                self.plan_time.clock().with_reached(ReachedPlanTime { plan_time_s: reading.plan_time_s, machine });
            self.plan_time.move_on(clock)?;
        }
        Ok(())
    }

    /// The plan time of the schedule state to be shown: while it moves, the last instant at which anything changed.
    fn effective_plan_time_s(&self, reading: Reading) -> Option<i64> {
        let now_s = reading.plan_time_s?;
        let evaluated = self.evaluated.as_ref().filter(|_| self.plan_time.clock().is_moving());
        let update_instants_s = evaluated.map_or(&[][..], |e| &e.update_instants_s);
        let n_past = update_instants_s.partition_point(|s| *s <= now_s);
        // Before the first change all instants are alike: the second before it stands for them.
        let before_all = update_instants_s.first().map_or(now_s, |first| first - 1);
        Some(n_past.checked_sub(1).map_or(before_all, |k| update_instants_s[k]))
    }

    /// What the history says of a request that was carried out; `None` for one that changes nothing.
    fn summary(&self, request: ScheduleRequest, plan_time_s: Option<i64>) -> Option<(HistoryKind, String)> {
        Some(match request {
            ScheduleRequest::GetPlanTime => return None,
            ScheduleRequest::SetActuals { file, source } => {
                let source = match source {
                    ActualsSource::Reported => "reported",
                    ActualsSource::Observed => "observed",
                };
                let from = file.map_or("none".to_owned(), |file| file.path.display().to_string());
                (HistoryKind::Progress, format!("{source} progress: {from}"))
            }
            ScheduleRequest::UndoActuals => {
                let n = self.overrides.actuals.len();
                (HistoryKind::Progress, format!("reported progress taken back to the table before, of {n} rows"))
            }
            ScheduleRequest::SetPlanTime { .. }
            | ScheduleRequest::NextChange
            | ScheduleRequest::FollowWallClock
            | ScheduleRequest::Simulate { .. } => {
                let at = plan_time_s.and_then(PlanTime::from_civil_seconds);
                let at = at.map(|at| format!("{at}, ")).unwrap_or_default();
                (HistoryKind::Date, format!("plan time {at}{}", self.plan_time.clock().name()))
            }
        })
    }

    /// Evaluates the schedule anew if its files have changed, and publishes if the plan time has passed a change.
    fn look_and_tick(&mut self) -> Result<Done, Failure> {
        if !self.files.look(&self.rules)? {
            return self.tick();
        }
        let names = self.files.names().unwrap_or_default();
        self.record(HistoryKind::Rules, None, format!("schedule of {names}, which changed"));
        self.evaluate_site()
    }

    /// Publishes if the plan time has passed a change.
    fn tick(&mut self) -> Result<Done, Failure> {
        let (reading, now) = self.read_clock();
        let at_s = self.effective_plan_time_s(reading);
        let kept_ms =
            self.plan_time.clock().reached().filter(|kept| kept.plan_time_s.is_some()).map(|kept| kept.machine.wall_ms);
        if kept_ms.is_some_and(|kept_ms| now.wall_ms.saturating_sub(kept_ms) >= KEPT_EVERY_MS) {
            self.keep_clock(reading, now)?;
        }
        match self.published_at_s {
            Some(published_s) if published_s == at_s && (self.tasks.is_pending() || self.output.is_pending()) => {
                self.tasks.retry(&mut self.epochs)?;
                self.output.retry(&mut self.epochs)?;
                self.shown_at_s = Some(at_s);
                self.activity.set(Activity::Published);
                Ok(self.done())
            }
            Some(published_s) if published_s == at_s => Ok(Done { published: Published::default(), ..self.done() }),
            None if self.evaluated.is_none() => Ok(Done::default()),
            _ => self.publish(),
        }
    }

    /// The current state, and when the next change is due. What is late is tried again with each tick.
    fn done(&self) -> Done {
        let wait_ms = self.next_update().map(|(wait_ms, _)| wait_ms).filter(|wait_ms| *wait_ms > -LATE_MS);
        let wake_in = wait_ms.and_then(|wait_ms| u64::try_from(wait_ms.max(1)).ok()).map(Duration::from_millis);
        Done { answer: (), published: self.output.published(), wake_in }
    }

    /// The schedule state that follows the one on the bus: in how many milliseconds it is due, and when by the machine's clock,
    /// milliseconds since 1970 in UTC. `None` if the plan time stands.
    fn next_update(&self) -> Option<(i64, i64)> {
        let (reading, now) = self.read_clock();
        let evaluated = self.evaluated.as_ref().filter(|_| reading.distrust.is_none())?;
        let shown_s = self.shown_at_s.unwrap_or(reading.plan_time_s)?;
        let n_past = evaluated.update_instants_s.partition_point(|s| *s <= shown_s);
        let next_s = evaluated.update_instants_s.get(n_past)?;
        let wait_ms = self.plan_time.clock().until_ms(*next_s, now.wall_ms, &self.zone())?;
        Some((wait_ms, now.wall_ms.saturating_add(wait_ms)))
    }
}

/// Refuses rules that do not say in which zone a clock is to be followed.
fn check_zone(rules: &Rules, clock: &PlanTimeClock) -> Result<(), Failure> {
    match (clock, &rules.site_zone) {
        (PlanTimeClock::Wall { .. }, None) => Err("the plan time follows the clock: the rules need site_zone".into()),
        _ => Ok(()),
    }
}

/// A table without rows.
const NO_PROGRESS: &[u8] = b"id,start,finish\n";

/// What `schedule.rules` of `site.toml` says.
fn rules_configured(config: &SiteConfig) -> Configured<Option<FileText>> {
    FileText::configured("rules", config.schedule.rules.as_deref(), Rules::parse)
}

fn parse_rules(file: Option<&FileText>) -> Result<Rules, Failure> {
    file.map_or_else(|| Ok(Rules::default()), |file| Ok(file.parse("rules", Rules::parse)?))
}

impl Service for ScheduleService {
    type Input = ScheduleInput;
    type Request = ScheduleRequest;
    type Facts = ScheduleFacts;

    fn attach(&mut self, bus: &Bus) -> Result<(), Failure> {
        // The sample belongs to a generation of the bus that is gone; it comes again.
        self.site = None;
        self.tasks.attach(bus, &mut self.epochs)?;
        self.output.attach(bus, &mut self.epochs)
    }

    fn handle(&mut self, event: Event<ScheduleInput>) -> Result<Done, Failure> {
        match event {
            Event::Input(ScheduleInput::Site(site)) => self.handle_site(site),
            Event::Configuration(config) => self.configure(&config),
            Event::Attached => self.tick(),
            Event::Tick => self.look_and_tick(),
        }
    }

    fn answer(&mut self, request: ScheduleRequest, asked: &Asked) -> Result<Done<ScheduleAnswer>, Failure> {
        let changed = request.clone();
        let done = match request {
            ScheduleRequest::SetPlanTime { at_s } => self.set_clock(PlanTimeClock::Fixed { at_s }, asked.by)?,
            ScheduleRequest::NextChange => self.next_change(asked.by)?,
            ScheduleRequest::FollowWallClock => self.follow_wall_clock(asked.by)?,
            ScheduleRequest::Simulate { rate, from_s } => self.simulate(rate, from_s, asked.by)?,
            ScheduleRequest::GetPlanTime => self.done(),
            ScheduleRequest::SetActuals { file, source } => self.set_actuals(file.as_ref(), source)?,
            ScheduleRequest::UndoActuals => self.undo_actuals()?,
        };
        let plan_time_s = self.read_clock().0.plan_time_s;
        if let Some((kind, summary)) = self.summary(changed, plan_time_s) {
            self.record(kind, Some(asked.by), summary);
        }
        let (clock, progress) = (self.plan_time.clock().name(), self.progress_rows());
        let answer = ScheduleAnswer { state: done.published, plan_time_s, clock, progress };
        Ok(done.answered(answer))
    }

    fn standing(&self) -> Standing {
        let warning = self.read_clock().0.distrust.map(|distrust| distrust.to_string());
        let diagnostics = self.evaluated.iter().flat_map(|evaluated| evaluated.timeline.diagnostics());
        let mut gone = diagnostics.filter(|diagnostic| diagnostic.code == DiagnosticCode::ReportedProgressGone);
        let gone = gone.next().map(|diagnostic| diagnostic.message.clone());
        let of_state = [self.rules_setting.warning(), self.files.warning(), self.plan_time.warning()];
        let [of_rules, of_files, of_plan_time] = of_state.map(|w| w.map(str::to_owned));
        let warnings = [warning, of_rules, of_files, of_plan_time, self.mended_progress.clone(), gone];
        let warnings: Vec<String> = warnings.into_iter().flatten().collect();
        Standing { error: self.error.clone(), warning: (!warnings.is_empty()).then(|| warnings.join("; ")) }
    }

    fn facts(&self) -> ScheduleFacts {
        let valid_until_s = self.output.last().map(|state| state.view().head.valid_until_s);
        let reading = self.read_clock().0;
        ScheduleFacts {
            state: self.output.published(),
            site_hash: self.output.inputs().site,
            state_plan_time_s: self.shown_at_s.flatten(),
            due_plan_time_s: self.effective_plan_time_s(reading),
            plan_time_s: reading.plan_time_s,
            clock: self.plan_time.clock().name(),
            valid_until_s: valid_until_s.filter(|until_s| *until_s != ScheduleStateHead::NO_TIME),
            next_update_ms: self.next_update().map(|(_, at_ms)| at_ms),
            clock_distrust: reading.distrust.map(|distrust| distrust.to_string()),
            progress: self.progress_rows(),
            site_zone: self.rules.site_zone.as_ref().and_then(|zone| zone.iana_name().map(str::to_owned)),
            settings: self.settings(),
        }
    }
}
