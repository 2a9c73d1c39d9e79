//! Evaluates site and rules into a timeline.

use crate::clock::Calendars;
use crate::closures::{self, closures};
use crate::dates::WrittenDate;
use crate::edits::{ABSENT, Actual, Edits, find_task, reported_date, task_names};
use crate::error::EvaluateError;
use crate::findings::{Entity, Findings};
use crate::lives::{Life, lives};
use crate::rules::{Mode, Rules};
use crate::said::{AllSaid, all_said};
use crate::tasks::{self, Floats, TaskDates, TaskFacts, Tasks, TimeTexts};
use crate::timeline::{Steps, Timeline};
use crate::works::{Effect, Works, works};
use messages::{
    DateSource, DiagnosticCode, ElementScheduleRecord, NONE, ScheduleStateHead, Severity, Site, SpaceState,
    nearest_names_hint,
};
use std::collections::BTreeMap;

/// Works out everything that the site, the rules and the additions say about time.
///
/// Reported progress makes what counts differ from what was planned; the schedule states tell both.
///
/// # Errors
/// Dates that can be read in two ways, additions that name nothing; see [`EvaluateError`]. What is wrong with single
/// tasks, elements or dates is a finding of the timeline and does not stop the rest.
pub fn evaluate(site: &Site<'_>, rules: &Rules, edits: &Edits) -> Result<Timeline, EvaluateError> {
    let effective = worked_out(site, rules, edits)?;
    if !edits.has_reports() {
        return Ok(effective);
    }
    let planned = worked_out(site, rules, &Edits { delays: edits.delays.clone(), ..Edits::default() })?;
    Ok(effective.with_planned_states(planned))
}

fn worked_out(site: &Site<'_>, rules: &Rules, edits: &Edits) -> Result<Timeline, EvaluateError> {
    let mut findings = Findings::new(site);
    let said = all_said(site, rules, &mut findings)?;
    let reports = Reports::of(site, rules, edits)?;
    let Planned { dates, floats } = match rules.mode {
        Mode::Standard => planned(site, rules, edits, &reports, &mut findings)?,
        Mode::Paper => Planned { dates: vec![None; site.tasks.len()], floats: vec![None; site.tasks.len()] },
    };
    let works = works(site, &dates, rules.inputs);
    let lives = match rules.mode {
        Mode::Standard => lives(site, rules, &works, &said, &reports.effects(&works), &mut findings),
        Mode::Paper => paper_lives(site, &said),
    };
    let closures = closures(site, rules, &works, &said, &mut findings);
    Ok(timeline(site, rules, Parts { dates, floats, lives, closures, findings }))
}

/// Dates and floats of all tasks.
struct Planned {
    dates: Vec<Option<TaskDates>>,
    floats: Vec<Option<Floats>>,
}

fn planned(
    site: &Site<'_>,
    rules: &Rules,
    edits: &Edits,
    reports: &Reports,
    findings: &mut Findings<'_>,
) -> Result<Planned, EvaluateError> {
    let texts: Vec<TimeTexts<'_>> = site.tasks.iter().map(|t| TimeTexts::of(site, t)).collect();
    let mut span_s = tasks::written_span_s(site, rules, &texts);
    for at_s in reports.tasks.values().flatten().flatten().map(|d| d.start_s()) {
        let span = span_s.unwrap_or(at_s..at_s + 1);
        span_s = Some(span.start.min(at_s)..span.end.max(at_s + 1));
    }
    let calendars = Calendars::new(site, span_s, rules.duration_day, findings);
    let mut facts = tasks::facts(site, rules, &texts, &calendars, findings);
    reports.add_to(&mut facts);
    let mut children = vec![Vec::new(); site.tasks.len()];
    for (k, task) in (0..).zip(site.tasks).filter(|(_, t)| t.parent != NONE) {
        children[task.parent as usize].push(k);
    }
    let tasks = Tasks { site, rules, facts: &facts, calendars: &calendars, children: &children };
    let mut dates = tasks::resolve(&tasks, findings);
    if !edits.delays.is_empty() {
        let delay_s = delays(&tasks, &dates, edits, findings)?;
        dates = tasks::delay(&tasks, &dates, &delay_s);
    }
    let floats = tasks::floats(&tasks, &dates);
    Ok(Planned { dates, floats })
}

/// The delay of each task in seconds of its own clock.
fn delays(
    tasks: &Tasks<'_>,
    dates: &[Option<TaskDates>],
    edits: &Edits,
    findings: &mut Findings<'_>,
) -> Result<Vec<i64>, EvaluateError> {
    let mut delay_s = vec![0i64; dates.len()];
    for delay in &edits.delays {
        let task = find_task(tasks.site, &delay.task)?;
        let facts = &tasks.facts[task];
        let clock = tasks.calendars.clock(facts.clock);
        delay_s[task] = delay_s[task].saturating_add(delay.by.seconds(clock.day()));
        let why = match dates[task] {
            None => "it has no dates",
            Some(_) if facts.actual_start.is_some() || facts.actual_finish.is_some() => "it has actual dates",
            Some(_) => continue,
        };
        let message = format!("the task cannot be delayed: {why}");
        findings.add(
            Severity::Warning,
            DiagnosticCode::DelayWithoutEffect,
            Some(Entity::task(&tasks.site.tasks[task])),
            message,
        );
    }
    Ok(delay_s)
}

/// Reported progress, by what it is about: start and finish.
#[derive(Default)]
struct Reports {
    tasks: BTreeMap<usize, [Option<WrittenDate>; 2]>,
    /// `None` for an element that is not there.
    elements: BTreeMap<usize, Option<[Option<WrittenDate>; 2]>>,
}

impl Reports {
    fn of(site: &Site<'_>, rules: &Rules, edits: &Edits) -> Result<Self, EvaluateError> {
        let mut reports = Self::default();
        if !edits.has_reports() {
            return Ok(reports);
        }
        let elements: BTreeMap<&str, usize> =
            site.elements.iter().enumerate().map(|(k, e)| (site.text(e.global_id), k)).collect();
        let observed = edits.observed.iter().filter(|o| elements.contains_key(o.id.as_str()));
        for actual @ Actual { id, start, finish, line } in observed.chain(&edits.actuals) {
            let wrong = |why: &str| EvaluateError::Reported { line: *line, id: id.clone(), why: why.to_owned() };
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
        Ok(reports)
    }

    /// Actual dates of tasks; what a report leaves out stays as it was.
    fn add_to(&self, facts: &mut [TaskFacts]) {
        for (&task, [start, finish]) in &self.tasks {
            let facts = &mut facts[task];
            facts.actual_start = start.or(facts.actual_start);
            facts.actual_finish = finish.or(facts.actual_finish);
            facts.has_time = true;
            facts.is_faulty &= start.is_none() || finish.is_none();
        }
    }

    /// Effects of reported progress on elements; a missing start or duration is the planned one.
    fn effects(&self, works: &Works) -> BTreeMap<usize, Effect> {
        let source = DateSource::Reported;
        let effect = |(&element, report): (&usize, &Option<[Option<WrittenDate>; 2]>)| {
            let Some([start, finish]) = report else {
                let never_s = i64::MAX;
                return (element, Effect { start_s: never_s, finish_s: never_s, removes: false, task: NONE, source });
            };
            let planned: Vec<&Effect> = works.elements[element].iter().filter(|e| !e.removes).collect();
            let plan_start_s = planned.iter().map(|e| e.start_s).min();
            let plan_finish_s = planned.iter().map(|e| e.finish_s).max();
            let length_s = plan_start_s.zip(plan_finish_s).map(|(s, f)| f - s);
            let (start_s, finish_s) = match (start.map(|d| d.start_s()), finish.map(|d| d.finish_s())) {
                (Some(start_s), Some(finish_s)) => (start_s, finish_s),
                // Without a planned length nobody knows when it ends.
                (Some(start_s), None) => (start_s, length_s.map_or(i64::MAX, |l| start_s.saturating_add(l))),
                (None, finish_s) => {
                    let finish_s = finish_s.unwrap_or(i64::MAX);
                    (plan_start_s.filter(|s| *s <= finish_s).unwrap_or(finish_s), finish_s)
                }
            };
            (element, Effect { start_s, finish_s, removes: false, task: NONE, source })
        };
        self.elements.iter().map(effect).collect()
    }
}

/// The published prototype's rule: a wall or door is drawn from the day behind its date on, everything else is dropped.
fn paper_lives(site: &Site<'_>, said: &AllSaid) -> Vec<Life> {
    let life = |(element, said): (&messages::ElementRecord, &crate::said::Said)| {
        let drawn = ["IfcWall", "IfcDoor"].iter().any(|entity| site.is_a(element, entity));
        let date = said.actual.or(said.planned).filter(|_| drawn);
        let start_s = date.map_or(i64::MAX, WrittenDate::end_of_day_s);
        let source = if date.is_some() { DateSource::PropertyPlanned } else { DateSource::None };
        let effect = Effect { start_s, finish_s: start_s, removes: false, task: NONE, source };
        Life { effects: vec![effect], source: Some(source) }
    };
    site.elements.iter().zip(&said.elements).map(life).collect()
}

/// What a timeline is made of.
struct Parts<'a> {
    dates: Vec<Option<TaskDates>>,
    floats: Vec<Option<Floats>>,
    lives: Vec<Life>,
    closures: Vec<Vec<closures::Closure>>,
    findings: Findings<'a>,
}

fn timeline(site: &Site<'_>, rules: &Rules, parts: Parts<'_>) -> Timeline {
    let (mut elements, mut spaces) = (Steps::default(), Steps::default());
    for life in &parts.lives {
        let (first, steps) = life.steps(rules.undated);
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
        schedule: parts.lives.iter().map(|life| schedule_of(life, &parts.floats)).collect(),
        effects: parts.lives.into_iter().map(|life| life.effects).collect(),
        elements,
        planned_states: None,
        spaces,
        closures: parts.closures,
        task_ids: site.tasks.iter().map(|t| site.text(t.global_id).to_owned()).collect(),
        closing_reasons: rules.closed_spaces.iter().map(|c| c.reason.clone()).collect(),
        instants_s,
        tasks: parts.dates,
        floats: parts.floats,
        findings: parts.findings.finish(),
        closing_lead_s: rules.closing_lead_s,
        is_paper: rules.mode == Mode::Paper,
    }
}

/// When an element is first built, and when it is removed after that.
fn schedule_of(life: &Life, floats: &[Option<Floats>]) -> ElementScheduleRecord {
    let episodes = life.episodes();
    let built = episodes.iter().find(|e| !e.removes);
    let removed = episodes.iter().find(|e| e.removes);
    let known = |s: i64| if s == i64::MAX || s == i64::MIN { ScheduleStateHead::NO_TIME } else { s };
    // A property says when something is finished, not when it was begun.
    let is_finish_only = matches!(life.source, Some(DateSource::PropertyActual | DateSource::PropertyPlanned));
    let last = |removes: bool| {
        life.effects.iter().filter(|e| e.removes == removes && e.task != NONE).max_by_key(|e| e.finish_s)
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
        source: life.source.unwrap_or(DateSource::None).into(),
        task: task.unwrap_or(NONE),
    }
}
