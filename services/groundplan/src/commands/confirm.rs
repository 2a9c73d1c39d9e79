//! `groundplan confirm`: confirms the pending pose or absent elements.

use crate::alignment_request::{alignment_after, outcome_of};
use crate::args::SiteArgs;
use crate::failure::Failure;
use crate::run::{Outcome, Run};
use daemon::AlignRequest;

/// Arguments of `confirm`.
#[derive(Debug, Clone, clap::Args)]
pub struct Args {
    /// These elements are absent although they are planned to be there: maps leave them out until they are observed
    /// [default: the pending pose]
    #[arg(value_name = "GLOBALID")]
    absent: Vec<String>,

    /// Print one JSON document on standard output and nothing else there
    #[arg(long)]
    json: bool,

    /// The site.
    #[command(flatten)]
    site: SiteArgs,
}

impl Run for Args {
    /// Confirms the pending pose, or that elements are absent.
    ///
    /// # Errors
    /// No daemons, no pending pose, elements that the robot has not seen through.
    fn run(&self) -> Result<Outcome, Failure> {
        let sample = alignment_after(&self.site, &AlignRequest::Confirm { absent: self.absent.clone() })?;
        Ok(Outcome { exit_code: 0, ..outcome_of(&sample, self.json) })
    }
}
