//! `groundplan tasks`: the tasks of a schedule with their dates, what they act on, and what is wrong with them.

mod calendar;
mod table;

use crate::args::{ModelArgs, ScheduleArgs, ScheduleInput, with_timeline};
use crate::date_argument;
use crate::failure::Failure;
use crate::output_file::OutputFile;
use crate::run::{Outcome, Run};
use answers::tasks::{list, rows};
use messages::Site;
use schedule::{Timeline, find_task};
use std::path::PathBuf;

/// Arguments of `tasks`.
#[derive(Debug, Clone, clap::Args)]
#[command(after_help = AFTER_HELP)]
pub struct Args {
    /// Only this task, by GlobalId, identification or name; may be repeated
    #[arg(long, value_name = "TASK")]
    task: Vec<String>,

    /// Status of the tasks at this date: 2024-04-15 (its midnight) or 2024-04-15T08:30:00
    #[arg(long, value_name = "DATE")]
    date: Option<String>,

    /// Only tasks that are at work from this date on: 2024-04-15 (its midnight) or 2024-04-15T08:30:00
    #[arg(long, value_name = "DATE")]
    from: Option<String>,

    /// Only tasks that are at work before this date; one without a time is the end of its day
    #[arg(long, value_name = "DATE")]
    to: Option<String>,

    /// Only tasks that are at work in so many weeks from --from on
    #[arg(long, value_name = "N", requires = "from", conflicts_with = "to", value_parser = clap::value_parser!(u16).range(1..=520))]
    weeks: Option<u16>,

    /// Write the tasks as a table: dates, progress, storeys, rooms and doors that they close, elements. It is a schedule file, too:
    /// --schedule-file reads it again, and links by its column GlobalId
    #[arg(long, value_name = "OUT.csv")]
    csv: Option<PathBuf>,

    /// Write the tasks as events of a calendar (iCalendar), without summaries; in UTC where the rules have a site_zone, else in the
    /// local time of whoever opens it
    #[arg(long, value_name = "OUT.ics")]
    ics: Option<PathBuf>,

    /// Rules and additions.
    #[command(flatten)]
    schedule: ScheduleArgs,

    /// The site.
    #[command(flatten)]
    model: ModelArgs,

    /// Print one JSON document on standard output and nothing else there
    #[arg(long)]
    json: bool,
}

const AFTER_HELP: &str = "\
Dates are local to the site: written, rolled up from nested tasks, or computed from sequence,
durations and calendars. A task acts on elements that it constructs or removes, and on spaces that
are closed while it is at work. The file may link elements on which it has no effect, because it has
no dates, is of another kind, or another source goes before it.
A table and a calendar have the same tasks: those of --task and of the window. An event keeps its
identity as long as its task keeps its code or GlobalId, so that a calendar that is read again
changes in place. Ways that a task may close are the rooms in which it works, their doors, and the
doors that it builds or removes.
The JSON document has a schema: config/schemas/tasks.schema.json.

Examples:
  groundplan tasks house.ifc
  groundplan tasks house.ifc --task 'Partition walls' --date 2024-04-15T08:00:00
  groundplan tasks house.ifc --from 2024-04-15 --weeks 3 --csv next.csv --ics next.ics
  groundplan tasks house.ifc --json | jq -r '.tasks[] | [.start, .name] | @tsv'

Exit codes: 0 done, 1 failed, 2 bad usage or configuration.";

impl Run for Args {
    /// Lists the tasks.
    ///
    /// # Errors
    /// Bad arguments, models that cannot be read, dates that can be read in two ways, a task that does not exist.
    fn run(&self) -> Result<Outcome, Failure> {
        let schedule = ScheduleInput::read(&self.schedule)?;
        let instant_s = |text| date_argument::instant_s(text, schedule.site_zone());
        let at_s = self.date.as_deref().map(instant_s).transpose()?;
        let window = self.window(&schedule)?;
        let inputs: Vec<PathBuf> =
            self.model.paths().iter().cloned().chain(self.schedule.inputs().map(PathBuf::from)).collect();
        let [csv, ics] = [("--csv", &self.csv), ("--ics", &self.ics)]
            .map(|(option, path)| path.as_deref().map(|path| OutputFile::of(option, path, &inputs)).transpose());
        let (csv, ics) = (csv?, ics?);
        with_timeline(&self.model, &schedule, |site, timeline, _| {
            let wanted = self.task.iter().map(|name| find_task(site, name));
            let named: Vec<usize> = wanted.collect::<Result<_, _>>().map_err(Failure::usage)?;
            let wanted = chosen(site, timeline, &named, window);
            if csv.is_some() || ics.is_some() {
                let rows = rows(site, timeline, at_s, wanted.as_deref());
                if let Some(csv) = &csv {
                    csv.write(table::table(&rows).as_bytes())?;
                }
                if let Some(ics) = &ics {
                    let stamp_s = at_s.or(window.and_then(|[from_s, _]| from_s));
                    ics.write(calendar::calendar(&rows, stamp_s, schedule.site_zone()).as_bytes())?;
                }
            }
            let list = list(site, timeline, at_s, wanted.as_deref());
            if self.json {
                return Ok((serde_json::to_string_pretty(&list).map_err(Failure::work)? + "\n").into());
            }
            Ok(list.text(timeline, site.schedule.tasks.is_empty()).into())
        })
    }
}

/// Start and end of a window, each of which may be open.
type Window = [Option<i64>; 2];

impl Args {
    /// The window, if one is asked for.
    ///
    /// # Errors
    /// A text that is no date, an end that is not after the start.
    fn window(&self, schedule: &ScheduleInput) -> Result<Option<Window>, Failure> {
        let zone = schedule.site_zone();
        let from_s = self.from.as_deref().map(|text| date_argument::instant_s(text, zone)).transpose()?;
        let to_s = match (&self.to, self.weeks.zip(from_s)) {
            (Some(text), _) => Some(date_argument::finish_s(text, zone)?),
            (None, weeks) => weeks.map(|(weeks, from_s)| from_s + i64::from(weeks) * WEEK_S),
        };
        if let (Some(from), Some(to)) = (from_s, to_s)
            && to <= from
        {
            let [from, to] = [&self.from, &self.to].map(|text| text.as_deref().unwrap_or_default());
            return Err(Failure::usage(format!("--to {to} is not after --from {from}")));
        }
        Ok((from_s.is_some() || to_s.is_some()).then_some([from_s, to_s]))
    }
}

const WEEK_S: i64 = 7 * 86_400;

/// The tasks that are named and at work in the window; `None` for all.
fn chosen(site: &Site<'_>, timeline: &Timeline, named: &[usize], window: Option<Window>) -> Option<Vec<usize>> {
    let is_named = |task: &usize| named.is_empty() || named.contains(task);
    let is_in_window = |task: &usize| {
        let Some([from_s, to_s]) = window else { return true };
        timeline.task(*task).is_some_and(|dates| {
            // A milestone takes no time.
            let ends_later = |from_s: i64| dates.finish_s > from_s || dates.start_s >= from_s;
            from_s.is_none_or(ends_later) && to_s.is_none_or(|to_s| dates.start_s < to_s)
        })
    };
    let all = 0..site.schedule.tasks.len();
    (window.is_some() || !named.is_empty()).then(|| all.filter(|task| is_named(task) && is_in_window(task)).collect())
}
