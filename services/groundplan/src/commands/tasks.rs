//! `groundplan tasks`: the tasks of a schedule with their dates, what they act on, and what is wrong with them.

use crate::args::{ModelArgs, ScheduleArgs, ScheduleInput, with_timeline};
use crate::date_argument;
use crate::failure::Failure;
use crate::run::{Outcome, Run};
use answers::tasks::list;
use schedule::find_task;

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
The JSON document has a schema: config/schemas/tasks.schema.json.

Examples:
  groundplan tasks house.ifc
  groundplan tasks house.ifc --task 'Partition walls' --date 2024-04-15T08:00:00
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
        with_timeline(&self.model, &schedule, |site, timeline, _| {
            let wanted = self.task.iter().map(|name| find_task(site, name));
            let wanted: Vec<usize> = wanted.collect::<Result<_, _>>().map_err(Failure::usage)?;
            let list = list(site, timeline, at_s, &wanted);
            if self.json {
                return Ok((serde_json::to_string_pretty(&list).map_err(Failure::work)? + "\n").into());
            }
            Ok(list.text(timeline, site.schedule.tasks.is_empty()).into())
        })
    }
}
