//! States at a date for people.

use super::document::{WholeDay, counts};
use crate::named::{TaskRef, date_text};
use diagnostics::counted;
use messages::{DateSource, Diagnostic, ScheduleState, ScheduleStateHead, Severity, Site, TaskRecord};
use schedule::{Period, Timeline};
use std::collections::HashSet;
use std::fmt::Write;

/// Diagnostics in the text; all are in the JSON document.
const MAX_DIAGNOSTICS: usize = 8;

/// For people: counts, work in progress, blocked spaces with the names of the tasks, what is wrong.
pub fn text_of(
    site: &Site<'_>,
    timeline: &Timeline,
    schedule_state: &ScheduleState<'_>,
    period: Period,
    whole_day: Option<WholeDay<'_>>,
) -> String {
    let mut out = String::new();
    let time = |seconds: i64| messages::plan_time(seconds).map_or("-".to_owned(), |t| t.to_string());
    let until = period.until_s.map_or(String::new(), |s| format!(" until {}", date_text(s)));
    let _ = writeln!(
        out,
        "{}{until}  (last change {}, next {})",
        date_text(period.from_s),
        time(schedule_state.head.valid_from_s),
        time(schedule_state.head.valid_until_s)
    );
    if let Some(whole_day) = whole_day {
        out.push_str(&whole_day.text());
    }
    let counts: Vec<String> =
        counts(schedule_state).into_iter().map(|(state, n)| format!("{n} {}", state.replace('_', " "))).collect();
    let _ = writeln!(out, "elements: {}", counts.join(", "));
    let summaries: HashSet<usize> = site.schedule.tasks.iter().map(|t| t.parent as usize).collect();
    let end_s = period.until_s.unwrap_or(period.from_s.saturating_add(1));
    let running = (0..site.schedule.tasks.len()).filter(|k| {
        !summaries.contains(k) && timeline.task(*k).is_some_and(|d| d.start_s < end_s && period.from_s < d.finish_s)
    });
    for k in running {
        let dates = timeline.task(k).expect("running tasks have dates");
        let float = timeline.float(k).map_or(String::new(), |f| format!(", float {}", hours(f.total_s)));
        let _ = writeln!(out, "  at work: {} until {}{float}", TaskRef::of(site, k).label(), time(dates.finish_s));
    }
    let n_blocked = (0..site.spaces.len()).filter(|k| schedule_state.is_blocked(*k)).count();
    let _ = writeln!(out, "spaces: {} open, {n_blocked} blocked", site.spaces.len() - n_blocked);
    for (k, space) in site.spaces.iter().enumerate() {
        let name = format!("{} {}", site.text(space.name), site.text(space.long_name));
        if schedule_state.is_blocked(k) {
            let why: Vec<String> = schedule_state.why(k).map(|w| reason(site, w)).collect();
            let _ = writeln!(out, "  blocked: {:<24} {}", name.trim(), why.join("; "));
        } else if schedule_state.spaces[k].closes_at_s != ScheduleStateHead::NO_TIME {
            let _ = writeln!(out, "  closing: {:<24} at {}", name.trim(), time(schedule_state.spaces[k].closes_at_s));
        }
    }
    write_diagnostics(&mut out, timeline);
    let n_existing =
        (0..schedule_state.n_elements()).filter(|k| schedule_state.schedule_of(*k).source == DateSource::None).count();
    if n_existing > 0 {
        let _ = writeln!(out, "  {} without any date", counted(n_existing, "element"));
    }
    out
}

/// The first diagnostics of the schedule.
fn write_diagnostics(out: &mut String, timeline: &Timeline) {
    let diagnostics: Vec<&Diagnostic> = timeline.diagnostics().iter().filter(|f| f.severity > Severity::Info).collect();
    for diagnostic in diagnostics.iter().take(MAX_DIAGNOSTICS) {
        let who = [diagnostic.global_id(), diagnostic.name()].join(" ");
        let _ =
            writeln!(out, "  {}: {}{}", diagnostic.code.name(), who.trim(), separated(who.trim(), &diagnostic.message));
    }
    if diagnostics.len() > MAX_DIAGNOSTICS {
        let _ = writeln!(out, "  and {}: see --json", counted(diagnostics.len() - MAX_DIAGNOSTICS, "more finding"));
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
    let is_called = |t: &TaskRecord, id| site.schedule.text(t.global_id) == id;
    let task = why.strip_prefix("task:").and_then(|id| site.schedule.tasks.iter().position(|t| is_called(t, id)));
    task.map_or_else(|| why.replace('_', " "), |k| TaskRef::of(site, k).label())
}

fn hours(seconds: i64) -> String {
    format!("{:.1} h", seconds as f64 / 3600.0)
}
