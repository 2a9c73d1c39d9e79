//! `groundplan states`: which elements stand and which spaces may be entered.

use crate::args::{ScheduleInput, with_timeline};
use crate::cli::StatesArgs;
use crate::failure::Failure;
use crate::plan_date;
use export::{ScheduleFindings, ScheduleReport};
use frames::counted;
use messages::{Phase, PhaseHead, Site, SpaceState};
use schedule::{Period, Timeline};
use serde::Serialize;
use std::collections::{BTreeMap, HashSet};
use std::fmt::Write;

/// How many findings people see; all are in the JSON document.
const MAX_FINDINGS: usize = 8;

/// States at a date.
#[derive(Debug, Serialize)]
struct States<'s> {
    at: String,
    /// End of the period whose union these states are, exclusive; null for an instant.
    until: Option<String>,
    elements: BTreeMap<&'s str, &'static str>,
    spaces: BTreeMap<&'s str, Space>,
    /// Where the date has no time: what differs in the union over its day.
    #[serde(skip_serializing_if = "Option::is_none")]
    whole_day: Option<WholeDay<'s>>,
    report: Report<'s>,
}

/// What `convert` draws differently for a date without a time, which is a whole day there and midnight here.
#[derive(Debug, Serialize)]
struct WholeDay<'s> {
    until: String,
    elements: BTreeMap<&'s str, &'static str>,
    spaces: BTreeMap<&'s str, Space>,
}

#[derive(Debug, PartialEq, Serialize)]
struct Space {
    state: &'static str,
    why: Vec<String>,
}

#[derive(Debug, Serialize)]
struct Report<'s> {
    /// Last change at or before the date.
    valid_from: Option<String>,
    /// Next change after it.
    valid_until: Option<String>,
    /// Open spaces that will be blocked soon, and when.
    closing: BTreeMap<&'s str, String>,
    /// Number of elements by state.
    counts: BTreeMap<&'static str, usize>,
    #[serde(flatten)]
    schedule: ScheduleReport,
    findings: ScheduleFindings,
}

/// Tells the states at every date that is asked for.
///
/// # Errors
/// Bad arguments, models that cannot be read, dates that can be read in two ways.
pub fn states(arguments: &StatesArgs) -> Result<String, Failure> {
    let schedule = ScheduleInput::read(&arguments.schedule)?;
    let until = arguments.until.as_deref();
    if until.is_some() && arguments.date.len() > 1 {
        return Err(Failure::usage("--until ends one period: give one --date"));
    }
    let period = |text: &String| plan_date::instant_or_period(text, until, schedule.site_zone());
    let periods: Vec<(Period, Option<Period>)> = arguments.date.iter().map(period).collect::<Result<_, _>>()?;
    with_timeline(&arguments.model, &schedule, |site, timeline, _| {
        let all: Vec<String> =
            periods.iter().map(|asked| at(site, timeline, *asked, arguments.json)).collect::<Result<_, _>>()?;
        Ok(match all.as_slice() {
            [one] => one.clone(),
            several if arguments.json => format!("[{}]\n", several.join(",").replace('\n', "")),
            several => several.join("\n"),
        })
    })
}

fn at(
    site: &Site<'_>,
    timeline: &Timeline,
    (period, day): (Period, Option<Period>),
    json: bool,
) -> Result<String, Failure> {
    let phase = timeline.phase(period).finish();
    let phase = Phase::open(phase.bytes()).map_err(Failure::work)?;
    let of_day = day.map(|day| timeline.phase(day).finish());
    let of_day = of_day.as_ref().map(|phase| Phase::open(phase.bytes())).transpose().map_err(Failure::work)?;
    let whole_day = day.zip(of_day.as_ref()).map(|(day, of_day)| whole_day(site, &phase, day, of_day));
    if json { json_of(site, &phase, period, whole_day) } else { Ok(text_of(site, timeline, &phase, period, whole_day)) }
}

/// What differs in the union over a day from its midnight.
fn whole_day<'s>(site: &'s Site<'_>, midnight: &Phase<'_>, day: Period, of_day: &Phase<'_>) -> WholeDay<'s> {
    let elements = (0..site.elements.len()).filter(|k| of_day.effective(*k) != midnight.effective(*k));
    let spaces = (0..site.spaces.len()).map(|k| (k, space_of(of_day, k)));
    let spaces = spaces.filter(|(k, space)| *space != space_of(midnight, *k));
    WholeDay {
        until: day.until_s.map(plan_date::text).unwrap_or_default(),
        elements: elements.map(|k| (site.text(site.elements[k].global_id), of_day.effective(k).name())).collect(),
        spaces: spaces.map(|(k, space)| (site.text(site.spaces[k].global_id), space)).collect(),
    }
}

fn json_of<'s>(
    site: &'s Site<'_>,
    phase: &Phase<'_>,
    period: Period,
    whole_day: Option<WholeDay<'s>>,
) -> Result<String, Failure> {
    let elements = site.elements.iter().enumerate();
    let spaces = site.spaces.iter().enumerate();
    let closing = spaces.clone().filter(|(k, _)| phase.spaces[*k].closes_at_s != PhaseHead::NO_TIME);
    let time = |seconds: i64| messages::plan_time(seconds).map(|t| t.to_string());
    let states = States {
        at: plan_date::text(period.from_s),
        until: period.until_s.map(plan_date::text),
        whole_day,
        elements: elements.map(|(k, e)| (site.text(e.global_id), phase.effective(k).name())).collect(),
        spaces: spaces.map(|(k, s)| (site.text(s.global_id), space_of(phase, k))).collect(),
        report: Report {
            valid_from: time(phase.head.valid_from_s),
            valid_until: time(phase.head.valid_until_s),
            closing: closing
                .map(|(k, s)| (site.text(s.global_id), plan_date::text(phase.spaces[k].closes_at_s)))
                .collect(),
            counts: counts(phase),
            schedule: ScheduleReport::of(site, phase),
            findings: ScheduleFindings::of(site, phase),
        },
    };
    Ok(serde_json::to_string(&states).map_err(Failure::work)? + "\n")
}

fn space_of(phase: &Phase<'_>, space: usize) -> Space {
    let state = if phase.is_blocked(space) { SpaceState::Blocked } else { SpaceState::Open };
    Space { state: state.name(), why: phase.why(space).map(str::to_owned).collect() }
}

fn counts(phase: &Phase<'_>) -> BTreeMap<&'static str, usize> {
    let mut counts = BTreeMap::new();
    for k in 0..phase.n_elements() {
        *counts.entry(phase.effective(k).name()).or_default() += 1;
    }
    counts
}

/// For people: counts, work in progress, blocked spaces with the names of the tasks, what is wrong.
fn text_of(
    site: &Site<'_>,
    timeline: &Timeline,
    phase: &Phase<'_>,
    period: Period,
    whole_day: Option<WholeDay<'_>>,
) -> String {
    let mut out = String::new();
    let time = |seconds: i64| messages::plan_time(seconds).map_or("-".to_owned(), |t| t.to_string());
    let until = period.until_s.map_or(String::new(), |s| format!(" until {}", plan_date::text(s)));
    let _ = writeln!(
        out,
        "{}{until}  (last change {}, next {})",
        plan_date::text(period.from_s),
        time(phase.head.valid_from_s),
        time(phase.head.valid_until_s)
    );
    if let Some(whole_day) = whole_day {
        out.push_str(&whole_day.text());
    }
    let counts: Vec<String> =
        counts(phase).into_iter().map(|(state, n)| format!("{n} {}", state.replace('_', " "))).collect();
    let _ = writeln!(out, "elements: {}", counts.join(", "));
    let summaries: HashSet<usize> = site.tasks.iter().map(|t| t.parent as usize).collect();
    let end_s = period.until_s.unwrap_or(period.from_s.saturating_add(1));
    let running = (0..site.tasks.len()).filter(|k| {
        !summaries.contains(k) && timeline.task(*k).is_some_and(|d| d.start_s < end_s && period.from_s < d.finish_s)
    });
    for k in running {
        let dates = timeline.task(k).expect("running tasks have dates");
        let float = timeline.float(k).map_or(String::new(), |f| format!(", float {}", hours(f.total_s)));
        let _ = writeln!(out, "  at work: {} until {}{float}", task_name(site, k), time(dates.finish_s));
    }
    let n_blocked = (0..site.spaces.len()).filter(|k| phase.is_blocked(*k)).count();
    let _ = writeln!(out, "spaces: {} open, {n_blocked} blocked", site.spaces.len() - n_blocked);
    for (k, space) in site.spaces.iter().enumerate() {
        let name = format!("{} {}", site.text(space.name), site.text(space.long_name));
        if phase.is_blocked(k) {
            let why: Vec<String> = phase.why(k).map(|w| reason(site, w)).collect();
            let _ = writeln!(out, "  blocked: {:<24} {}", name.trim(), why.join("; "));
        } else if phase.spaces[k].closes_at_s != PhaseHead::NO_TIME {
            let _ = writeln!(out, "  closing: {:<24} at {}", name.trim(), time(phase.spaces[k].closes_at_s));
        }
    }
    write_findings(&mut out, timeline);
    let n_existing = (0..phase.n_elements()).filter(|k| phase.schedule_of(*k).source == 0).count();
    if n_existing > 0 {
        let _ = writeln!(out, "  {} without any date", counted(n_existing, "element"));
    }
    out
}

/// What is wrong with the schedule: the first findings.
fn write_findings(out: &mut String, timeline: &Timeline) {
    let findings: Vec<&schedule::Finding> =
        timeline.findings().iter().filter(|f| f.severity > schedule::Severity::Info).collect();
    for finding in findings.iter().take(MAX_FINDINGS) {
        let who = [finding.global_id.as_str(), finding.name.as_str()].join(" ");
        let _ = writeln!(out, "  {}: {}{}", finding.code, who.trim(), separated(who.trim(), &finding.message));
    }
    if findings.len() > MAX_FINDINGS {
        let _ = writeln!(out, "  and {}: see --json", counted(findings.len() - MAX_FINDINGS, "more finding"));
    }
}

impl WholeDay<'_> {
    /// For people: a line.
    fn text(&self) -> String {
        let differences = match (self.elements.len(), self.spaces.len()) {
            (0, 0) => "nothing is different".to_owned(),
            (n_elements, n_spaces) => {
                format!("{} and {} are different", counted(n_elements, "element"), counted(n_spaces, "space"))
            }
        };
        format!("  this is midnight; in the whole day until {}, which convert draws, {differences}\n", self.until)
    }
}

fn separated(who: &str, message: &str) -> String {
    if who.is_empty() { message.to_owned() } else { format!(": {message}") }
}

/// A reason with the name of the task.
fn reason(site: &Site<'_>, why: &str) -> String {
    let task = why.strip_prefix("task:").and_then(|id| site.tasks.iter().position(|t| site.text(t.global_id) == id));
    task.map_or_else(|| why.replace('_', " "), |k| task_name(site, k))
}

/// Identification and name of a task.
pub(crate) fn task_name(site: &Site<'_>, task: usize) -> String {
    let record = &site.tasks[task];
    let name = format!("{} {}", site.text(record.identification), site.text(record.name));
    if name.trim().is_empty() { site.text(record.global_id).to_owned() } else { name.trim().to_owned() }
}

fn hours(seconds: i64) -> String {
    format!("{:.1} h", seconds as f64 / 3600.0)
}
