//! Evaluates site and rules into a timeline.

use crate::as_built::{ElementReports, as_built_reports};
use crate::clock::Calendars;
use crate::closures::{self, closures};
use crate::diagnostics::{Entity, ScheduleDiagnostics};
use crate::element_timeline::{ElementTimeline, element_timelines};
use crate::error::EvaluateError;
use crate::overrides::{ABSENT, Actual, Delay, ObservationConflict, Overrides, find_task, reported_date, task_names};
use crate::probability::{Network, Samples};
use crate::property_dates::{ScheduleProperties, schedule_properties};
use crate::rules::{Rules, RulesMode};
use crate::task_effects::{Effect, TaskEffects, task_effects};
use crate::tasks::{self, Floats, TaskDates, TaskTimes, Tasks, WorkStarts, WrittenTaskTimes};
use crate::timeline::{Steps, Timeline};
use diagnostics::{counted, nearest_names_hint};
use frames::written_date::WrittenDate;
use messages::{
    DateSource, DiagnosticCode, ElementScheduleRecord, NONE, ScheduleStateHead, Severity, Site, SpaceState,
};
use std::collections::BTreeMap;

/// Evaluates the schedule of a site with rules and overrides.
///
/// With reported progress the effective states differ from the planned ones; schedule states carry both.
///
/// # Errors
/// Dates that can be read in two ways, overrides of unknown tasks or elements; see [`EvaluateError`]. Problems of
/// single tasks, elements or dates are diagnostics of the timeline and do not stop the evaluation.
pub fn evaluate(site: &Site<'_>, rules: &Rules, overrides: &Overrides) -> Result<Timeline, EvaluateError> {
    let mut diagnostics = ScheduleDiagnostics::new(site);
    let properties = schedule_properties(site, rules, &mut diagnostics)?;
    let reports = Reports::of(site, rules, overrides, &mut diagnostics)?;
    let is_planned = !overrides.has_reports() && reports.elements.is_empty();
    let effective = evaluate_once(site, rules, overrides, (&properties, &reports), diagnostics)?;
    if is_planned {
        return Ok(effective);
    }
    Ok(effective.with_planned_states(planned(site, rules, &overrides.delays)?))
}

/// Evaluates the schedule of a site as it is planned: without progress, also that of an as-built model.
///
/// # Errors
/// As [`evaluate`].
pub fn planned(site: &Site<'_>, rules: &Rules, delays: &[Delay]) -> Result<Timeline, EvaluateError> {
    let overrides = Overrides { delays: delays.to_vec(), ..Overrides::default() };
    let mut diagnostics = ScheduleDiagnostics::new(site);
    let properties = schedule_properties(site, rules, &mut diagnostics)?;
    evaluate_once(site, rules, &overrides, (&properties, &Reports::default()), diagnostics)
}

fn evaluate_once<'s>(
    site: &'s Site<'s>,
    rules: &Rules,
    overrides: &Overrides,
    (properties, reports): (&ScheduleProperties, &Reports),
    mut diagnostics: ScheduleDiagnostics<'s>,
) -> Result<Timeline, EvaluateError> {
    let TaskSchedule { dates, floats } = match rules.mode {
        RulesMode::Standard => task_schedule(site, rules, overrides, reports, &mut diagnostics)?,
        RulesMode::Paper => {
            TaskSchedule { dates: vec![None; site.schedule.tasks.len()], floats: vec![None; site.schedule.tasks.len()] }
        }
    };
    let task_effects = task_effects(site, &dates, rules.inputs);
    let element_timelines = match rules.mode {
        RulesMode::Standard => {
            element_timelines(site, rules, &task_effects, properties, &reports.effects(&task_effects), &mut diagnostics)
        }
        RulesMode::Paper => paper_element_timelines(site, properties),
    };
    let closures = closures(site, rules, &task_effects, properties, &mut diagnostics);
    Ok(timeline(site, rules, TimelineParts { dates, floats, element_timelines, closures, diagnostics }))
}

/// Dates and floats of all tasks.
struct TaskSchedule {
    dates: Vec<Option<TaskDates>>,
    floats: Vec<Option<Floats>>,
}

fn task_schedule<'s>(
    site: &'s Site<'s>,
    rules: &Rules,
    overrides: &Overrides,
    reports: &Reports,
    diagnostics: &mut ScheduleDiagnostics<'s>,
) -> Result<TaskSchedule, EvaluateError> {
    with_tasks(site, rules, reports, diagnostics, |tasks, diagnostics| {
        let mut dates = tasks::resolve(tasks, diagnostics);
        if !overrides.delays.is_empty() {
            let delay_s = delays(tasks, &dates, overrides, diagnostics)?;
            dates = tasks::delay(tasks, &dates, &delay_s);
        }
        tasks::report_constraints(tasks, &dates, diagnostics);
        let floats = tasks::floats(tasks, &dates);
        Ok(TaskSchedule { dates, floats })
    })
}

/// Draws the dates of all tasks many times, around those of the timeline; [`crate::probability`] tells how.
pub(crate) fn samples(
    site: &Site<'_>,
    rules: &Rules,
    overrides: &Overrides,
    timeline: &Timeline,
) -> Result<Samples, EvaluateError> {
    // What is wrong with the schedule is among the diagnostics of the timeline.
    let mut diagnostics = ScheduleDiagnostics::new(site);
    let reports = Reports::of(site, rules, overrides, &mut diagnostics)?;
    with_tasks(site, rules, &reports, &mut diagnostics, |tasks, diagnostics| {
        let starts = WorkStarts::of(site, tasks, diagnostics);
        let delay_s = delays(tasks, &timeline.tasks, overrides, diagnostics)?;
        let network = Network::of(tasks, &timeline.tasks, &delay_s, &starts, &rules.uncertainty);
        Ok(Samples::draw(&network, timeline.tasks.len(), rules.uncertainty.runs))
    })
}

/// Reads calendars and times of all tasks, with reported progress, and works with them.
fn with_tasks<'s, T>(
    site: &'s Site<'s>,
    rules: &Rules,
    reports: &Reports,
    diagnostics: &mut ScheduleDiagnostics<'s>,
    work: impl FnOnce(&Tasks<'_>, &mut ScheduleDiagnostics<'s>) -> Result<T, EvaluateError>,
) -> Result<T, EvaluateError> {
    let written: Vec<_> = (0..site.schedule.tasks.len()).map(|k| WrittenTaskTimes::of(site, k)).collect();
    let mut span_s = tasks::written_span_s(site, rules, &written);
    for at_s in reports.tasks.values().flatten().flatten().map(|d| d.start_s()) {
        let span = span_s.unwrap_or(at_s..at_s + 1);
        span_s = Some(span.start.min(at_s)..span.end.max(at_s + 1));
    }
    let calendars = Calendars::new(site, span_s, rules.duration_day, diagnostics);
    let mut task_times = tasks::task_times(site, rules, &written, &calendars, diagnostics);
    reports.add_to(&mut task_times);
    let mut children = vec![Vec::new(); site.schedule.tasks.len()];
    for (k, task) in (0..).zip(site.schedule.tasks).filter(|(_, t)| t.parent != NONE) {
        children[task.parent as usize].push(k);
    }
    let tasks = Tasks {
        site,
        rules,
        task_times: &task_times,
        limits: &tasks::limits(site, rules, diagnostics),
        calendars: &calendars,
        children: &children,
    };
    work(&tasks, diagnostics)
}

/// The delay of each task in seconds of its own clock.
fn delays(
    tasks: &Tasks<'_>,
    dates: &[Option<TaskDates>],
    overrides: &Overrides,
    diagnostics: &mut ScheduleDiagnostics<'_>,
) -> Result<Vec<i64>, EvaluateError> {
    let mut delay_s = vec![0i64; dates.len()];
    for delay in &overrides.delays {
        let task = find_task(tasks.site, &delay.task)?;
        let task_times = &tasks.task_times[task];
        let clock = tasks.clock(task);
        delay_s[task] = delay_s[task].saturating_add(delay.by.seconds(clock.day()));
        let why = match dates[task] {
            None => "it has no dates",
            Some(_) if task_times.actual_start.is_some() || task_times.actual_finish.is_some() => "it has actual dates",
            Some(_) => continue,
        };
        let message = format!("the task cannot be delayed: {why}");
        diagnostics.add(
            Severity::Warning,
            DiagnosticCode::DelayWithoutEffect,
            Some(Entity::task(&tasks.site.schedule.tasks[task])),
            message,
        );
    }
    Ok(delay_s)
}

/// True if the model has neither an element nor a task of this name.
fn is_gone(site: &Site<'_>, elements: &BTreeMap<&str, usize>, id: &str) -> bool {
    !elements.contains_key(id) && matches!(find_task(site, id), Err(EvaluateError::NoSuchTask { .. }))
}

/// Reported start and finish by task and by element.
#[derive(Default)]
struct Reports {
    tasks: BTreeMap<usize, [Option<WrittenDate>; 2]>,
    /// `None` for an element that is absent.
    elements: ElementReports,
}

/// What tables of progress say of a site: start and finish in civil seconds.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ReportedDates {
    /// By task.
    pub tasks: BTreeMap<usize, [Option<i64>; 2]>,
    /// By element; `None` for one that is absent.
    pub elements: BTreeMap<usize, Option<[Option<i64>; 2]>>,
}

impl ReportedDates {
    /// What the overrides say, and the model where it is an as-built one; reports rank before observations, and both before the model.
    ///
    /// # Errors
    /// Rows that cannot be used.
    pub fn of(site: &Site<'_>, rules: &Rules, overrides: &Overrides) -> Result<Self, EvaluateError> {
        let Reports { tasks, elements } = Reports::of(site, rules, overrides, &mut ScheduleDiagnostics::new(site))?;
        let dates = |[start, finish]: [Option<WrittenDate>; 2]| {
            [start.map(WrittenDate::start_s), finish.map(WrittenDate::finish_s)]
        };
        Ok(Self {
            tasks: tasks.into_iter().map(|(task, written)| (task, dates(written))).collect(),
            elements: elements.into_iter().map(|(element, written)| (element, written.map(dates))).collect(),
        })
    }
}

impl Reports {
    fn of(
        site: &Site<'_>,
        rules: &Rules,
        overrides: &Overrides,
        diagnostics: &mut ScheduleDiagnostics<'_>,
    ) -> Result<Self, EvaluateError> {
        let mut reports = Self { elements: as_built_reports(site, rules, diagnostics), tasks: BTreeMap::new() };
        if !overrides.has_reports() {
            return Ok(reports);
        }
        let elements: BTreeMap<&str, usize> =
            site.elements.iter().enumerate().map(|(k, e)| (site.text(e.global_id), k)).collect();
        let observed = overrides.observed.iter().filter(|o| elements.contains_key(o.id.as_str()));
        for ObservationConflict { id, counts, other, is_absent } in &overrides.conflicts {
            let Some(element) = elements.get(id.as_str()).map(|&k| &site.elements[k]) else { continue };
            let (now, before) = if *is_absent { ("is absent", "was seen") } else { ("was seen", "is absent") };
            let message = format!("the element {now} by robot {counts}, which counts, and {before} by robot {other}");
            let entity = Entity::of(element.global_id, element.name, element.step_id, element.source);
            diagnostics.add(Severity::Warning, DiagnosticCode::ObservationConflict, Some(entity), message);
        }
        let mut gone = Vec::new();
        for actual @ Actual { id, start, finish, line } in observed.chain(&overrides.actuals) {
            let wrong = |why: &str| EvaluateError::Reported { line: *line, id: id.clone(), why: why.to_owned() };
            if overrides.is_of_earlier_revision && is_gone(site, &elements, id) {
                gone.push(id.as_str());
                continue;
            }
            if start == ABSENT {
                let element = elements.get(id.as_str()).ok_or_else(|| {
                    let nearest = nearest_names_hint(id, elements.keys().copied());
                    wrong(&format!("no element of the model is called that{nearest}"))
                })?;
                if !finish.is_empty() {
                    return Err(wrong("what is absent has no finish"));
                }
                reports.elements.insert(*element, None);
                continue;
            }
            let (begun, ended) = (reported_date(start, actual, rules)?, reported_date(finish, actual, rules)?);
            match (begun, ended) {
                (None, None) => return Err(wrong("it has neither start nor finish")),
                (Some(begun), Some(ended)) if ended.finish_s() < begun.start_s() => {
                    return Err(wrong("it finishes before it starts"));
                }
                _ => {}
            }
            if let Some(&element) = elements.get(id.as_str()) {
                reports.elements.insert(element, Some([begun, ended]));
            } else {
                let task = find_task(site, id).map_err(|error| match error {
                    EvaluateError::NoSuchTask { .. } => {
                        let names = elements.keys().copied().chain(task_names(site));
                        let nearest = nearest_names_hint(id, names);
                        wrong(&format!("no element or task of the model is called that{nearest}"))
                    }
                    error => wrong(&error.to_string()),
                })?;
                reports.tasks.insert(task, [begun, ended]);
            }
        }
        if let Some(first) = gone.first() {
            let rows = counted(gone.len(), "row");
            let message =
                format!("reported progress: {rows} for what the model no longer has, such as {first:?}; not used");
            diagnostics.add(Severity::Warning, DiagnosticCode::ReportedProgressGone, None, message);
        }
        Ok(reports)
    }

    /// Sets actual dates of tasks; a date that is not reported stays.
    fn add_to(&self, task_times: &mut [TaskTimes]) {
        for (&task, [start, finish]) in &self.tasks {
            let task_times = &mut task_times[task];
            task_times.actual_start = start.or(task_times.actual_start);
            task_times.actual_finish = finish.or(task_times.actual_finish);
            task_times.has_time = true;
            task_times.is_faulty &= start.is_none() || finish.is_none();
        }
    }

    /// Effects of reported progress on elements; a missing start or duration is the planned one.
    fn effects(&self, task_effects: &TaskEffects) -> BTreeMap<usize, Effect> {
        let source = DateSource::Reported;
        let effect = |(&element, report): (&usize, &Option<[Option<WrittenDate>; 2]>)| {
            let Some([start, finish]) = report else {
                let never_s = i64::MAX;
                return (element, Effect { start_s: never_s, finish_s: never_s, removes: false, task: NONE, source });
            };
            let planned: Vec<&Effect> = task_effects.elements[element].iter().filter(|e| !e.removes).collect();
            let planned_start_s = planned.iter().map(|e| e.start_s).min();
            let planned_finish_s = planned.iter().map(|e| e.finish_s).max();
            let length_s = planned_start_s.zip(planned_finish_s).map(|(s, f)| f - s);
            let (start_s, finish_s) = match (start.map(|d| d.start_s()), finish.map(|d| d.finish_s())) {
                (Some(start_s), Some(finish_s)) => (start_s, finish_s),
                // Without a planned duration the finish is not known.
                (Some(start_s), None) => (start_s, length_s.map_or(i64::MAX, |l| start_s.saturating_add(l))),
                (None, finish_s) => {
                    let finish_s = finish_s.unwrap_or(i64::MAX);
                    (planned_start_s.filter(|s| *s <= finish_s).unwrap_or(finish_s), finish_s)
                }
            };
            (element, Effect { start_s, finish_s, removes: false, task: NONE, source })
        };
        self.elements.iter().map(effect).collect()
    }
}

/// The rule of the published prototype: a wall or door exists from the day after its date on, everything else is left
/// out.
fn paper_element_timelines(site: &Site<'_>, properties: &ScheduleProperties) -> Vec<ElementTimeline> {
    let element_timeline =
        |(element, properties): (&messages::ElementRecord, &crate::property_dates::ObjectProperties)| {
            let drawn = ["IfcWall", "IfcDoor"].iter().any(|entity| site.is_a(element, entity));
            let date = properties.actual.or(properties.planned).filter(|_| drawn);
            let start_s = date.map_or(i64::MAX, WrittenDate::end_of_day_s);
            let source = if date.is_some() { DateSource::PropertyPlanned } else { DateSource::None };
            let effect = Effect { start_s, finish_s: start_s, removes: false, task: NONE, source };
            ElementTimeline { effects: vec![effect], source: Some(source) }
        };
    site.elements.iter().zip(&properties.elements).map(element_timeline).collect()
}

/// Parts of a timeline.
struct TimelineParts<'a> {
    dates: Vec<Option<TaskDates>>,
    floats: Vec<Option<Floats>>,
    element_timelines: Vec<ElementTimeline>,
    closures: Vec<Vec<closures::Closure>>,
    diagnostics: ScheduleDiagnostics<'a>,
}

fn timeline(site: &Site<'_>, rules: &Rules, parts: TimelineParts<'_>) -> Timeline {
    let (mut elements, mut spaces) = (Steps::default(), Steps::default());
    for element_timeline in &parts.element_timelines {
        let (first, steps) = element_timeline.steps(rules.undated);
        elements.push(first, steps.into_iter().filter(|s| s.0 < i64::MAX));
    }
    for closures in &parts.closures {
        let state = |blocked: bool| if blocked { SpaceState::Blocked } else { SpaceState::Open };
        spaces.push(SpaceState::Open, closures::steps(closures).into_iter().map(|(time_s, b)| (time_s, state(b))));
    }
    let mut instants_s: Vec<i64> = elements.changes().map(|c| c.0).chain(spaces.changes().map(|c| c.0)).collect();
    instants_s.sort_unstable();
    instants_s.dedup();
    Timeline {
        site_hash: site.content_hash(),
        tasks_hash: site.schedule.tasks_hash,
        schedule: parts
            .element_timelines
            .iter()
            .map(|element_timeline| schedule_of(element_timeline, &parts.floats))
            .collect(),
        effects: parts.element_timelines.into_iter().map(|element_timeline| element_timeline.effects).collect(),
        elements,
        planned_states: None,
        spaces,
        closures: parts.closures,
        task_ids: site.schedule.tasks.iter().map(|t| site.schedule.text(t.global_id).to_owned()).collect(),
        closing_reasons: rules.closed_spaces.iter().map(|c| c.reason.clone()).collect(),
        instants_s,
        tasks: parts.dates,
        floats: parts.floats,
        diagnostics: parts.diagnostics.finish(),
        closing_lead_s: rules.closing_lead_s,
        is_paper: rules.mode == RulesMode::Paper,
    }
}

/// When an element is first built, and when it is removed after that.
fn schedule_of(element_timeline: &ElementTimeline, floats: &[Option<Floats>]) -> ElementScheduleRecord {
    let episodes = element_timeline.episodes();
    let built = episodes.iter().find(|e| !e.removes);
    let removed = episodes.iter().find(|e| e.removes);
    let known = |s: i64| if s == i64::MAX || s == i64::MIN { ScheduleStateHead::NO_TIME } else { s };
    // A property says when something is finished, not when it was begun.
    let is_finish_only =
        matches!(element_timeline.source, Some(DateSource::PropertyActual | DateSource::PropertyPlanned));
    let last = |removes: bool| {
        element_timeline.effects.iter().filter(|e| e.removes == removes && e.task != NONE).max_by_key(|e| e.finish_s)
    };
    let task = last(false).or(last(true)).map(|e| e.task);
    let float = task.and_then(|t| floats[t as usize]);
    ElementScheduleRecord {
        start_s: built.filter(|_| !is_finish_only).map_or(ScheduleStateHead::NO_TIME, |e| known(e.start_s)),
        finish_s: built.map_or(ScheduleStateHead::NO_TIME, |e| known(e.finish_s)),
        removal_start_s: removed.map_or(ScheduleStateHead::NO_TIME, |e| known(e.start_s)),
        removal_finish_s: removed.map_or(ScheduleStateHead::NO_TIME, |e| known(e.finish_s)),
        total_float_s: float.map_or(ScheduleStateHead::NO_TIME, |f| f.total_s),
        free_float_s: float.map_or(ScheduleStateHead::NO_TIME, |f| f.free_s),
        source: element_timeline.source.unwrap_or(DateSource::None).into(),
        task: task.unwrap_or(NONE),
    }
}
