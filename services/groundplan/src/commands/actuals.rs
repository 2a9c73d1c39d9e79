//! `groundplan actuals`: reported progress for the running daemons.

use crate::args::SiteArgs;
use crate::failure::Failure;
use crate::run::{Outcome, Run};
use crate::wait::{ask, join, wait_for_schedule_state};
use daemon::facts::ProgressRows;
use daemon::{ActualsSource, FileText, MAX_TABLE_BYTES, ScheduleAnswer, ScheduleRequest};
use diagnostics::counted;
use std::path::PathBuf;

/// Arguments of `actuals`.
#[derive(Debug, Clone, clap::Args)]
#[command(
    after_help = "A table whose rows name an element or task that the model does not have, or whose dates cannot be read, changes \
nothing.\n\nExamples:\n  groundplan actuals progress.csv\n  groundplan actuals --clear\n  groundplan undo progress"
)]
pub struct Args {
    /// CSV table with the columns id, start, finish; it replaces what was reported before
    #[arg(value_name = "FILE.csv", required_unless_present = "clear")]
    file: Option<PathBuf>,

    /// Nothing was reported
    #[arg(long, conflicts_with = "file")]
    clear: bool,

    /// Go back to what was reported before: `groundplan undo progress`.
    #[arg(skip)]
    undo: bool,

    /// Print one JSON document on standard output and nothing else there
    #[arg(long)]
    json: bool,

    /// The site.
    #[command(flatten)]
    site: SiteArgs,
}

impl Args {
    /// Goes back to what was reported before.
    pub(crate) fn undo(json: bool, site: SiteArgs) -> Self {
        Self { file: None, clear: false, undo: true, json, site }
    }
}

impl Run for Args {
    /// Sets the progress that was reported, and prints what is in force.
    ///
    /// # Errors
    /// No daemons, a file that cannot be used; what was reported before stays.
    fn run(&self) -> Result<Outcome, Failure> {
        let read = |path| FileText::read_up_to("progress", path, MAX_TABLE_BYTES);
        let file = self.file.as_deref().map(read).transpose().map_err(Failure::work)?;
        let config = self.site.config_of_drawing()?;
        let (bus, mut waiter) = join(&config)?;
        let request = if self.undo {
            let seen = ask(&bus, &mut waiter, &ScheduleRequest::GetPlanTime)?;
            let table = seen.table.ok_or_else(|| Failure::work("no progress was reported that could be taken back"))?;
            ScheduleRequest::UndoActuals { table }
        } else {
            ScheduleRequest::SetActuals { file, source: ActualsSource::Reported, robot: None }
        };
        let answer = ask(&bus, &mut waiter, &request)?;
        if answer.state.epoch > 0 {
            wait_for_schedule_state(&mut waiter, &config, &answer.state, "the reported progress")?;
        }
        Ok(if self.json { Outcome::json(&answer)? } else { text(&answer).into() })
    }
}

/// The progress in force, as a line.
fn text(answer: &ScheduleAnswer) -> String {
    let ProgressRows { reported, observed } = answer.progress;
    let reported = counted(reported, "reported row");
    let observed = if observed > 0 { format!(", {}", counted(observed, "observed row")) } else { String::new() };
    let state = match answer.state.epoch {
        0 => "used when there is a site".to_owned(),
        epoch => format!("schedule state epoch {epoch}"),
    };
    format!("progress in force: {reported}{observed}; {state}\n")
}
