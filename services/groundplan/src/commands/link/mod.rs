//! `groundplan link`: which elements a planner's schedule works on, and what of both fits nothing.

mod document;
mod proposals;
mod text;

use crate::args::{ModelArgs, ScheduleArgs, ScheduleInput, with_timeline};
use crate::failure::Failure;
use crate::output_file::OutputFile;
use crate::run::{Outcome, Run};
use document::LinkReport;
use proposals::ProposalReport;
use std::path::PathBuf;

/// Arguments of `link`.
#[derive(Debug, Clone, clap::Args)]
#[command(after_help = AFTER_HELP)]
pub struct Args {
    /// Write the links of all elements and spaces as a table, to be completed in a spreadsheet and given to --link: columns
    /// global_id, task (code or id), effect (builds, removes, works_in, uses); others are for people
    #[arg(long, value_name = "OUT.csv")]
    csv: Option<PathBuf>,

    /// Propose rules instead: [[link]] for values of elements and tasks that are equal, best first, with counts as comments; to be
    /// pasted into a file for --schedule. Rules in force do not count, and nothing is applied
    #[arg(long, conflicts_with_all = ["csv", "link"])]
    propose: bool,

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
Links come from --link, then from [[link]] of the rules in their order: the first that names an element counts.
Near misses are values of elements that differ from a task's in spaces, signs and leading zeros only.
Tasks contradict each other if one removes an element that another builds later or at the same time, or if one task has two effects.
--propose compares every value of elements (name, class, storey, room, zone, group, classification,
properties) with every value of tasks (code, work breakdown, name, id, fields). Texts that may be
equal by chance are not proposed: a shared number counts by how few of the numbers around it tasks
have, so that numbers of rows count for nothing. What is near and not equal is told.
The JSON document has a schema: config/schemas/link.schema.json, of
--propose config/schemas/link-proposals.schema.json.

Examples:
  groundplan link house.ifc --schedule-file plan.xer
  groundplan link house.ifc --schedule-file plan.xml --schedule rules.toml --csv links.csv
  groundplan link house.ifc --schedule-file plan.xlsx --propose
  groundplan link house.ifc --schedule-file plan.xml --link links.csv --json | jq '.unlinked_tasks'

Exit codes: 0 done, 1 failed, 2 bad usage or configuration.";

impl Run for Args {
    /// Links, and tells how well the schedule and the models fit together.
    ///
    /// # Errors
    /// No schedule file, files that cannot be read, a table onto a file that was read or that cannot be written.
    fn run(&self) -> Result<Outcome, Failure> {
        if !self.schedule.has_files() {
            return Err(Failure::usage("--schedule-file is needed: the schedule whose tasks are to be linked"));
        }
        let inputs: Vec<PathBuf> =
            self.model.paths().iter().cloned().chain(self.schedule.inputs().map(PathBuf::from)).collect();
        let csv = self.csv.as_deref().map(|path| OutputFile::of("--csv", path, &inputs)).transpose()?;
        let schedule = ScheduleInput::read(&self.schedule)?;
        with_timeline(&self.model, &schedule, |site, timeline, _| {
            if self.propose {
                let report = ProposalReport::of(site, &schedule);
                return if self.json { Outcome::json(&report) } else { Ok(report.text().into()) };
            }
            let links = schedule.links(site)?;
            if let Some(csv) = &csv {
                csv.write(::tasks::link_table(site, schedule.plans(), &links).as_bytes())?;
            }
            let report = LinkReport::of(site, timeline, &schedule, &links);
            if self.json { Outcome::json(&report) } else { Ok(report.text().into()) }
        })
    }
}
