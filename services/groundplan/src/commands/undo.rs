//! `groundplan undo`: takes reported progress or a confirmation back.

use super::{actuals, confirm};
use crate::args::SiteOfRobotArgs;
use crate::failure::Failure;
use crate::run::{Outcome, Run};

/// The word for reported progress.
const PROGRESS: &str = "progress";

/// Arguments of `undo`.
#[derive(Debug, Clone, clap::Args)]
#[command(
    after_help = "`groundplan confirm --list` lists what was confirmed, `groundplan log` what was done.\n\nExamples:\n  groundplan undo \
progress\n  groundplan undo pose\n  groundplan undo 0T8xbPmeHQFhEy1wPGGLbq"
)]
pub struct Args {
    /// `progress`: back to the table before the last one, also before --clear; `pose`: back to the pose before the one that was
    /// confirmed; or GlobalIds of elements that were confirmed to be absent. May be repeated
    #[arg(value_name = "progress|pose|GLOBALID", required = true)]
    what: Vec<String>,

    /// Print one JSON document on standard output and nothing else there
    #[arg(long)]
    json: bool,

    /// The site.
    #[command(flatten)]
    site: SiteOfRobotArgs,
}

impl Run for Args {
    /// Takes it back; returns when the maps are as before.
    ///
    /// # Errors
    /// No daemons, nothing that can be taken back.
    fn run(&self) -> Result<Outcome, Failure> {
        let (what, json, site) = (self.what.clone(), self.json, self.site.clone());
        match what.as_slice() {
            [only] if only == PROGRESS => actuals::Args::undo(json, site.site().clone()).run(),
            several if several.iter().any(|what| what == PROGRESS) => {
                Err(Failure::usage("take progress and confirmations back one after the other"))
            }
            _ => confirm::Args::undo(what, json, site).run(),
        }
    }
}
