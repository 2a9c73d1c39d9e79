//! Decisions of schedule-eval: the plan time, the schedule state that is published, the verdict on a candidate.

use crate::evaluation::{Evaluated, EvaluationError, evaluated};
use crate::in_force::{InForce, KeptRules};
use crate::outputs::{ScheduleOutputs, ScheduleSample};
use crate::plan_time_setting::PlanTimeSetting;
use crate::schedule_files::ScheduleFiles;
use bus::{Bus, CheckedSample, RobotName, names_of_robots, topics};
use daemon::facts::ScheduleFacts;
use daemon::{
    ActualsSource, Asked, Caller, Committed, Configured, CurrentActivity, Decide, Decision, Epochs, Failure, FileText,
    HistoryEvent, HistoryKind, NewSample, Now, ObservedPair, ObservedTables, Occasion, ReportedProgress,
    ScheduleAnswer, ScheduleRequest, ScheduleVerdict, Setting, SettingKey, SiteConfig, Standing, StateFile,
    checked_rate, joined, mend_progress, progress_in_force, saving_observed, state_files,
};
use daemon::{PlanTimeClock, ReachedPlanTime};
use frames::PlanTime;
use messages::{Activity, Checked, ContentHash, DiagnosticCode, InputHashes, ScheduleStateHead};
use schedule::{ABSENT, Actual, ObservationConflict, Overrides, Rules, parse_actuals};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use tracing::{info, warn};

daemon::inputs! {
    /// What the schedule is read from.
    pub enum ScheduleInput { Site, Candidate }
}

/// A plan time that moves is on disk with each change, and at least this often: the reading by which a clock that went ahead
/// while the machine was off is noticed.
const KEPT_EVERY_MS: i64 = 3_600_000;

/// Holds the plan time.
///
/// While the plan time moves, the schedule state is that of the last change instant: it does not depend on how often it
/// is evaluated, and has its validity. A plan time is on disk before it is published, because a map must never go back in time when
/// a process dies.
pub struct ScheduleEval {
    in_force: InForce,
    /// The newest site; kept to evaluate it again when rules or progress change.
    site: Option<CheckedSample<topics::Site>>,
    /// The last revision of the site that was to be judged, and is not in force.
    candidate: Option<CheckedSample<topics::Candidate>>,
    activity: CurrentActivity,
    /// The state folder, for the tables of progress.
    state: PathBuf,
    usable_rules_file: StateFile,
    /// Robots with names, each of which has a table of observed progress.
    robots: Vec<RobotName>,
    /// What an operator should know of tables of progress that were damaged before this start.
    mended_progress: Option<String>,
}

impl ScheduleEval {
    /// The daemon on this machine, from the configuration and what survived.
    ///
    /// # Errors
    /// Rules, schedule files, a plan time or state that cannot be used.
    pub fn start(config: &SiteConfig, activity: CurrentActivity) -> Result<Committed<Self>, Failure> {
        let rules_setting = Setting::open(&config.state, SettingKey::Rules, rules_configured(config))?;
        let rules = parse_rules(rules_setting.value().as_ref())?;
        let plan_time = PlanTimeSetting::open(config, rules.site_zone.as_ref())?;
        let usable_rules_file = StateFile::at(&config.state, state_files::EVALUATED_RULES)?;
        let mended_progress = mend_progress(config)?;
        let overrides = Overrides::in_force(progress_in_force(config, parse_actuals)?);
        let robots = config.observers();
        let observed_tables = ObservedTables::load(&config.site_state, &robots)?;
        let overrides = Overrides { conflicts: conflicts(&observed_tables), ..overrides };
        let [table, _] = tables_of_state(&config.state)?;
        let in_force = InForce {
            files: ScheduleFiles::open(config, &rules)?,
            rules: Arc::new(rules),
            rules_setting,
            synchronised_while: config.clock.synchronised_while.clone(),
            plan_time,
            overrides: Arc::new(overrides),
            observed_tables: Arc::new(observed_tables),
            table: table.map(|table| table.id),
            evaluated: None,
            verdict: None,
            tried_site: None,
            error: None,
            shown_at_s: None,
            usable_rules: usable_rules_file.load_unless_damaged()?,
        };
        in_force.check_zone()?;
        let edits = in_force.edits(in_force.rules_setting.was_edited(), in_force.plan_time.was_edited());
        let (state, epochs) = (config.state.clone(), Epochs::at(&config.state, state_files::SCHEDULE_EPOCHS)?);
        let shared = activity.clone();
        let service = Self {
            in_force,
            robots,
            site: None,
            candidate: None,
            activity: shared,
            state,
            usable_rules_file,
            mended_progress,
        };
        let outputs = ScheduleOutputs::default();
        Ok(Committed::new(service, outputs, epochs, &config.state, activity).recording(edits))
    }

    fn site_hash(&self) -> Option<ContentHash> {
        self.site.as_ref().map(Checked::content_hash)
    }

    /// The schedule of the newest site with other overrides; `None` if there is no site yet.
    fn evaluate(&self, overrides: &Overrides) -> Result<Option<Result<Evaluated, EvaluationError>>, Failure> {
        match &self.site {
            Some(site) => Ok(Some(evaluated(site, &self.in_force.rules, self.in_force.files.plans(), overrides))),
            // The bus was created anew, and the site is on its way.
            None if self.in_force.evaluated.is_some() => Err("the site is not there at the moment: try again".into()),
            None => Ok(None),
        }
    }

    /// Evaluates the newest site with the rules, files and progress of the decision. If that cannot be, the last schedule stays, and
    /// the error stands until one of them is another.
    fn evaluate_site(&self, decision: &mut Decision<Self>) -> Result<(), Failure> {
        let next = &mut decision.next;
        next.verdict = None;
        let Some(site) = &self.site else {
            // The bus was created anew, and the site is on its way.
            next.tried_site = None;
            next.error = next.evaluated.as_ref().map(|_| "the site is not there at the moment".to_owned());
            return Ok(());
        };
        self.activity.set(Activity::Reading);
        next.tried_site = Some(site.content_hash());
        match evaluated(site, &next.rules, next.files.plans(), &next.overrides) {
            Ok(evaluated) => {
                let (tasks, changes) = (evaluated.n_tasks, evaluated.timeline.instants_s().len());
                info!(service = "schedule-eval", tasks, changes, "schedule evaluated");
                (next.evaluated, next.error, next.shown_at_s) = (Some(Arc::new(evaluated)), None, None);
                let kept = KeptRules { rules: next.rules_setting.value().clone() };
                if next.usable_rules.as_ref() != Some(&kept) {
                    decision.save.push(self.usable_rules_file.saving(&kept)?);
                    next.usable_rules = Some(kept);
                }
            }
            Err(why) => {
                next.error = Some(format!("the schedule cannot be used: {}", daemon::chain(&why)));
                self.activity.set(if next.shown_at_s.is_some() { Activity::Published } else { Activity::Idle });
                if next.evaluated.is_none() {
                    Self::evaluate_with_usable_rules(next, site)?;
                }
            }
        }
        Ok(())
    }

    /// Judges a candidate for a site by the rules, files and progress of the decision.
    fn judge(&self, next: &mut InForce) {
        let is_judged = |hash| next.verdict.as_ref().is_some_and(|verdict| verdict.site_hash == hash);
        let Some(candidate) = self.candidate.as_ref().filter(|candidate| !is_judged(candidate.content_hash())) else {
            return;
        };
        let found = evaluated(candidate, &next.rules, next.files.plans(), &next.overrides);
        let refused = found.err().map(|why| daemon::chain(&why));
        next.verdict = Some(ScheduleVerdict { site_hash: candidate.content_hash(), refused });
    }

    /// After a start there is no schedule that could stay: that of the rules before stands in.
    fn evaluate_with_usable_rules(next: &mut InForce, site: &CheckedSample<topics::Site>) -> Result<(), Failure> {
        let Some(KeptRules { rules }) = &next.usable_rules else { return Ok(()) };
        let rules = parse_rules(rules.as_ref())?;
        if let Ok(evaluated) = evaluated(site, &rules, next.files.plans(), &next.overrides) {
            warn!(service = "schedule-eval", "the schedule is evaluated with the rules before");
            next.evaluated = Some(Arc::new(evaluated));
        }
        Ok(())
    }

    /// The schedule state at the plan time of the decision, if another one is published.
    fn show(&self, decision: &mut Decision<Self>, now: &Now<'_, Self>) -> Result<(), Failure> {
        let next = &mut decision.next;
        let reading = next.read_clock(now.machine);
        let at_s = next.effective_plan_time_s(reading);
        let Some(evaluated) = next.evaluated.clone() else { return Ok(()) };
        let kept_ms = next.plan_time.clock().reached().filter(|kept| kept.plan_time_s.is_some());
        let is_long_ago = |kept_ms: i64| now.machine.wall_ms.saturating_sub(kept_ms) >= KEPT_EVERY_MS;
        let is_shown = next.shown_at_s == Some(at_s);
        if !is_shown || kept_ms.is_some_and(|kept| is_long_ago(kept.machine.wall_ms)) {
            decision.save.extend(next.keep_clock(reading, now.machine)?);
        }
        if is_shown {
            return Ok(());
        }
        let (frame_epoch, site) = (evaluated.frame_epoch, evaluated.site_hash);
        let inputs = InputHashes { site, ..InputHashes::default() };
        if let Some(tasks) = evaluated.tasks.as_ref().filter(|tasks| !now.outputs.tasks.is_last(tasks)) {
            let archive = Arc::new(Checked::new(tasks.clone())?);
            decision.publish.push(ScheduleSample::Tasks(NewSample { archive, frame_epoch, inputs }));
        }
        let archive = Arc::new(Checked::new(evaluated.timeline.schedule_state_at(at_s).finish())?);
        decision.publish.push(ScheduleSample::State(NewSample { archive, frame_epoch, inputs }));
        next.shown_at_s = Some(at_s);
        Ok(())
    }

    /// Looks at files, inputs and the clock.
    fn look(&self, decision: &mut Decision<Self>, now: &Now<'_, Self>) -> Result<(), Failure> {
        let next = &mut decision.next;
        let has_other_files = next.files.look(&next.rules, now.machine)?;
        let is_other_site = self.site.is_some() && self.site_hash() != next.tried_site;
        if let Some(save) = has_other_files {
            let names = next.files.names().unwrap_or_default();
            decision.save.push(save);
            decision.history.push(HistoryEvent::new(
                HistoryKind::Rules,
                None,
                format!("schedule of {names}, which changed"),
            ));
            self.evaluate_site(decision)?;
        } else if is_other_site {
            self.evaluate_site(decision)?;
        }
        self.judge(&mut decision.next);
        self.show(decision, now)
    }

    /// Takes other rules: a site whose schedule could not be used may have one now. Rules that the site has no schedule with
    /// count for the next site; until then the schedule stays.
    fn configure(
        &self,
        decision: &mut Decision<Self>,
        config: &SiteConfig,
        now: &Now<'_, Self>,
    ) -> Result<(), Failure> {
        let next = &mut decision.next;
        let edited = next.rules_setting.edited(rules_configured(config))?;
        let has_other_rules = edited != next.rules_setting.as_kept();
        next.rules = Arc::new(parse_rules(edited.value().as_ref())?);
        next.check_zone()?;
        decision.save.extend(next.files.configure(config, &next.rules)?);
        let (has_other_plan_time, save) = next.plan_time.edit(config, next.rules.site_zone.as_ref())?;
        decision.save.extend(save);
        decision.save.extend(next.rules_setting.keep(edited)?);
        decision.history.extend(next.edits(has_other_rules, has_other_plan_time));
        next.synchronised_while.clone_from(&config.clock.synchronised_while);
        self.evaluate_site(decision)?;
        self.show(decision, now)
    }

    /// Sets a mode of the plan time.
    fn set_clock(
        &self,
        decision: &mut Decision<Self>,
        clock: PlanTimeClock,
        by: Caller,
        now: &Now<'_, Self>,
    ) -> Result<(), Failure> {
        let next = &mut decision.next;
        next.check_timeline(self.site_hash())?;
        decision.save.extend(next.plan_time.set(clock, by.uid)?);
        // Who sets a plan time gets its schedule state, also if it is the one that is shown.
        next.shown_at_s = None;
        self.show(decision, now)
    }

    fn next_change(&self, after_s: Option<i64>) -> Result<PlanTimeClock, Failure> {
        self.in_force.check_timeline(self.site_hash())?;
        let evaluated = self.in_force.evaluated.as_ref().ok_or("there is no site yet")?;
        let next =
            evaluated.timeline.instants_s().iter().find(|s| after_s.is_none_or(|after_s| **s > after_s)).copied();
        Ok(PlanTimeClock::Fixed { at_s: next.ok_or("no later change in the schedule")? })
    }

    fn wall_clock(&self) -> Result<PlanTimeClock, Failure> {
        if self.in_force.rules.site_zone.is_none() {
            return Err("to follow the clock, set site_zone in the schedule rules".into());
        }
        Ok(PlanTimeClock::Wall { reached: ReachedPlanTime::default() })
    }

    fn simulated(&self, rate: f64, from_s: Option<i64>, now: &Now<'_, Self>) -> Result<PlanTimeClock, Failure> {
        let rate = checked_rate(rate)?;
        let from_s = from_s.or(self.in_force.read_clock(now.machine).plan_time_s);
        let from_s = from_s.ok_or("there is no plan time to start from: say which")?;
        let since_ms = now.machine.wall_ms;
        Ok(PlanTimeClock::Simulated { from_s, rate, since_ms, reached: ReachedPlanTime::default() })
    }

    /// Takes progress that was reported, or observed; a file that cannot be used changes nothing.
    fn set_actuals(
        &self,
        decision: &mut Decision<Self>,
        file: Option<&FileText>,
        source: ActualsSource,
        robot: Option<&str>,
        now: &Now<'_, Self>,
    ) -> Result<(), Failure> {
        let bytes = file.map_or(NO_PROGRESS, |file| file.text.as_bytes());
        let path = file.map_or(Path::new(""), |file| &file.path);
        let named = |e: &(dyn std::error::Error + 'static)| format!("{}: {}", path.display(), daemon::chain(e));
        let actuals = parse_actuals(bytes).map_err(|e| named(&e))?;
        let mut overrides = Overrides::clone(&self.in_force.overrides);
        match (source, file) {
            (ActualsSource::Reported, Some(_)) if actuals.is_empty() => {
                let file = path.display();
                return Err(
                    format!("{file} has no rows: `groundplan actuals --clear` takes reported progress back").into()
                );
            }
            // A new table is about the model as it is.
            (ActualsSource::Reported, _) => (overrides.actuals, overrides.is_of_earlier_revision) = (actuals, false),
            (ActualsSource::Observed, _) if self.robots.is_empty() && robot.is_none() => overrides.observed = actuals,
            (ActualsSource::Observed, _) => {
                let tables = self.observed_tables_with(robot, &actuals)?;
                overrides.observed = parse_actuals(&tables.in_force())?;
                overrides.conflicts = conflicts(&tables);
                decision.next.observed_tables = Arc::new(tables);
            }
        }
        let evaluated = self.evaluate(&overrides)?.transpose().map_err(|e| named(&e))?;
        let table = bytes.to_vec();
        match source {
            ActualsSource::Reported => {
                let (id, saves) = ReportedProgress::at(&self.state).adding(table)?;
                decision.next.table = Some(id);
                decision.save.extend(saves);
            }
            ActualsSource::Observed if self.robots.is_empty() => {
                decision.save.push(saving_observed(&self.state, table));
            }
            ActualsSource::Observed => decision.save.push(decision.next.observed_tables.saving(&self.state)?),
        }
        self.take_progress(decision, overrides, evaluated, now)
    }

    /// The tables of all robots, with another one of a robot.
    fn observed_tables_with(&self, robot: Option<&str>, actuals: &[Actual]) -> Result<ObservedTables, Failure> {
        let known = || match self.robots.as_slice() {
            [] => "its only robot has no name".to_owned(),
            robots => format!("it has {}", names_of_robots(robots)),
        };
        let robot = self.robots.iter().find(|known| robot == Some(known.as_str())).ok_or_else(|| match robot {
            Some(robot) => format!("the site has no robot {robot:?}: {}", known()),
            None => format!("observed progress is of one robot of the site, and none is named: {}", known()),
        })?;
        let rows = actuals.iter().map(|row| [&row.id, &row.start, &row.finish].map(Clone::clone));
        Ok(self.in_force.observed_tables.with(*robot, rows))
    }

    /// Goes back to the progress that was reported before a table; true if there was anything to go back from.
    fn undo_actuals(&self, decision: &mut Decision<Self>, seen: &str, now: &Now<'_, Self>) -> Result<bool, Failure> {
        match &self.in_force.table {
            Some(table) if table == seen => {}
            Some(table) if *table.as_str() > *seen => {
                return Err("other progress was reported since: look at what is in force, and undo that".into());
            }
            // It was taken back before.
            _ => return Ok(false),
        }
        let [_, before] = tables_of_state(&self.state)?;
        let mut overrides = Overrides::clone(&self.in_force.overrides);
        overrides.actuals = before.as_ref().map_or(Ok(Vec::new()), |before| parse_actuals(&before.content))?;
        let evaluated = self.evaluate(&overrides)?.transpose()?;
        decision.next.table = before.map(|before| before.id);
        decision.save.extend(ReportedProgress::at(&self.state).taking_back()?);
        self.take_progress(decision, overrides, evaluated, now)?;
        Ok(true)
    }

    /// Publishes the schedule with other progress.
    fn take_progress(
        &self,
        decision: &mut Decision<Self>,
        overrides: Overrides,
        evaluated: Option<Evaluated>,
        now: &Now<'_, Self>,
    ) -> Result<(), Failure> {
        let next = &mut decision.next;
        next.overrides = Arc::new(Overrides { is_of_earlier_revision: true, ..overrides });
        (next.evaluated, next.tried_site) = (evaluated.map(Arc::new), self.site_hash());
        (next.error, next.shown_at_s, next.verdict) = (None, None, None);
        self.show(decision, now)
    }

    /// Carries a request out; `decision` says what follows.
    fn carry_out(
        &self,
        decision: &mut Decision<Self>,
        request: ScheduleRequest,
        by: Caller,
        now: &Now<'_, Self>,
    ) -> Result<(), Failure> {
        let changed = request.clone();
        match request {
            ScheduleRequest::SetPlanTime { at_s } => {
                self.set_clock(decision, PlanTimeClock::Fixed { at_s }, by, now)?;
            }
            ScheduleRequest::NextChange { after_s } => self.set_clock(decision, self.next_change(after_s)?, by, now)?,
            ScheduleRequest::FollowWallClock => self.set_clock(decision, self.wall_clock()?, by, now)?,
            ScheduleRequest::Simulate { rate, from_s } => {
                self.set_clock(decision, self.simulated(rate, from_s, now)?, by, now)?;
            }
            ScheduleRequest::GetPlanTime | ScheduleRequest::GetVerdict => return Ok(()),
            ScheduleRequest::SetActuals { file, source, robot } => {
                self.set_actuals(decision, file.as_ref(), source, robot.as_deref(), now)?;
            }
            ScheduleRequest::UndoActuals { table } => {
                if !self.undo_actuals(decision, &table, now)? {
                    return Ok(());
                }
            }
        }
        let plan_time_s = decision.next.read_clock(now.machine).plan_time_s;
        let told = summary(&decision.next, changed, plan_time_s);
        decision.history.extend(told.map(|(kind, summary)| HistoryEvent::new(kind, Some(by), summary)));
        Ok(())
    }
}

/// Elements of which robots observed the contrary of each other.
fn conflicts(tables: &ObservedTables) -> Vec<ObservationConflict> {
    let pairs = tables.pairs().into_iter().map(|ObservedPair { id, newer, older }| {
        let [(counts, is_absent), (other, was_absent)] =
            [newer, older].map(|(robot, row)| (robot.to_owned(), row.start == ABSENT));
        (is_absent != was_absent).then(|| ObservationConflict { id: id.to_owned(), counts, other, is_absent })
    });
    pairs.flatten().collect()
}

/// What the history says of a request that is carried out; `None` for one that changes nothing.
fn summary(next: &InForce, request: ScheduleRequest, plan_time_s: Option<i64>) -> Option<(HistoryKind, String)> {
    Some(match request {
        ScheduleRequest::GetPlanTime | ScheduleRequest::GetVerdict => return None,
        ScheduleRequest::SetActuals { file, source, robot } => {
            let source = match source {
                ActualsSource::Reported => "reported",
                ActualsSource::Observed => "observed",
            };
            let from = file.map_or("none".to_owned(), |file| file.path.display().to_string());
            let of_robot = robot.map_or_else(String::new, |robot| format!(" of robot {robot}"));
            (HistoryKind::Progress, format!("{source} progress{of_robot}: {from}"))
        }
        ScheduleRequest::UndoActuals { .. } => {
            let n = next.overrides.actuals.len();
            (HistoryKind::Progress, format!("reported progress taken back to the table before, of {n} rows"))
        }
        ScheduleRequest::SetPlanTime { .. }
        | ScheduleRequest::NextChange { .. }
        | ScheduleRequest::FollowWallClock
        | ScheduleRequest::Simulate { .. } => {
            let at = plan_time_s.and_then(PlanTime::from_civil_seconds);
            let at = at.map(|at| format!("{at}, ")).unwrap_or_default();
            (HistoryKind::Date, format!("plan time {at}{}", next.plan_time.clock().name()))
        }
    })
}

/// A table of reported progress, with what tells it from others.
struct ReportedTable {
    id: String,
    content: Vec<u8>,
}

/// The table in force and the one before it.
fn tables_of_state(state: &Path) -> io::Result<[Option<ReportedTable>; 2]> {
    let [last, before] = ReportedProgress::at(state).tables()?;
    let read = |path: PathBuf| {
        let content = ReportedProgress::read(&path)?;
        Ok::<_, io::Error>(ReportedTable { id: ReportedProgress::id_of(&path, &content), content })
    };
    Ok([last.map(read).transpose()?, before.map(read).transpose()?])
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

impl Decide for ScheduleEval {
    type Input = ScheduleInput;
    type Request = ScheduleRequest;
    type Facts = ScheduleFacts;
    type InForce = InForce;
    type Outputs = ScheduleOutputs;

    fn take(&mut self, input: ScheduleInput) {
        match input {
            ScheduleInput::Site(site) => {
                self.candidate.take_if(|candidate| candidate.content_hash() == site.content_hash());
                self.site = Some(site);
            }
            ScheduleInput::Candidate(candidate) => self.candidate = Some(candidate),
        }
    }

    fn attach(&mut self, _: &Bus) -> Result<(), Failure> {
        (self.site, self.candidate) = (None, None);
        Ok(())
    }

    fn decide(&self, occasion: Occasion<'_, ScheduleRequest>, now: &Now<'_, Self>) -> Result<Decision<Self>, Failure> {
        let mut decision = Decision::of(self.in_force.clone());
        let asks_for_verdict = matches!(occasion, Occasion::Request(ScheduleRequest::GetVerdict, _));
        let is_asked = matches!(occasion, Occasion::Request(..));
        match occasion {
            Occasion::Look => self.look(&mut decision, now)?,
            Occasion::Configuration(config) => self.configure(&mut decision, config, now)?,
            Occasion::Request(request, Asked { by, .. }) => self.carry_out(&mut decision, request, *by, now)?,
        }
        decision.wake_in = decision.next.wake_in(now.machine);
        let answer = move |rules: &Self, now: &Now<'_, Self>| {
            let verdict = rules.in_force.verdict.clone().filter(|_| asks_for_verdict);
            ScheduleAnswer { verdict, ..rules.answer(now) }
        };
        Ok(if is_asked { decision.answered(answer) } else { decision })
    }

    fn become_in_force(&mut self, next: InForce) {
        self.in_force = next;
    }

    fn standing(&self, now: &Now<'_, Self>) -> Standing {
        let InForce { evaluated, rules_setting, files, plan_time, error, .. } = &self.in_force;
        let warning = self.in_force.read_clock(now.machine).distrust.map(|distrust| distrust.to_string());
        let diagnostics = || evaluated.iter().flat_map(|evaluated| evaluated.timeline.diagnostics());
        let gone = diagnostics().find(|diagnostic| diagnostic.code == DiagnosticCode::ReportedProgressGone);
        let gone = gone.map(|diagnostic| diagnostic.message.clone());
        let conflict = diagnostics().find(|diagnostic| diagnostic.code == DiagnosticCode::ObservationConflict);
        let conflict = conflict.map(|diagnostic| {
            let id = diagnostic.entity.as_ref().map_or("", |entity| entity.global_id.as_str());
            format!("{id}: {}", diagnostic.message)
        });
        let of_state = [rules_setting.warning(), files.warning(), plan_time.warning()];
        let [of_rules, of_files, of_plan_time] = of_state.map(|w| w.map(str::to_owned));
        let warnings = [warning, of_rules, of_files, of_plan_time, self.mended_progress.clone(), gone, conflict];
        Standing { error: error.clone(), warning: joined(warnings.into_iter().flatten()) }
    }

    fn facts(&self, now: &Now<'_, Self>) -> ScheduleFacts {
        let InForce { plan_time, rules, shown_at_s, .. } = &self.in_force;
        let output = &now.outputs.state;
        let valid_until_s = output.last().map(|state| state.view().head.valid_until_s);
        let reading = self.in_force.read_clock(now.machine);
        ScheduleFacts {
            state: output.published(),
            site_hash: output.inputs().site,
            state_plan_time_s: shown_at_s.flatten(),
            due_plan_time_s: self.in_force.effective_plan_time_s(reading),
            plan_time_s: reading.plan_time_s,
            clock: plan_time.clock().name(),
            is_wall_clock: matches!(plan_time.clock(), PlanTimeClock::Wall { .. }),
            valid_until_s: valid_until_s.filter(|until_s| *until_s != ScheduleStateHead::NO_TIME),
            next_update_ms: self.in_force.next_update(now.machine).map(|(_, at_ms)| at_ms),
            clock_distrust: reading.distrust.map(|distrust| distrust.to_string()),
            progress: self.in_force.progress_rows(),
            site_zone: rules.site_zone.as_ref().and_then(|zone| zone.iana_name().map(str::to_owned)),
            settings: self.in_force.settings(),
        }
    }
}

impl ScheduleEval {
    /// What a client is told once its request is carried out.
    fn answer(&self, now: &Now<'_, Self>) -> ScheduleAnswer {
        let plan_time_s = self.in_force.read_clock(now.machine).plan_time_s;
        let (clock, progress) = (self.in_force.plan_time.clock().name(), self.in_force.progress_rows());
        ScheduleAnswer {
            state: now.outputs.state.published(),
            plan_time_s,
            clock,
            progress,
            table: self.in_force.table.clone(),
            verdict: None,
        }
    }
}
