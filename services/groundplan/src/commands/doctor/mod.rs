//! `groundplan doctor`: what this machine lacks.

mod check;
mod machine;
mod site;

use crate::args::SiteArgs;
use crate::failure::Failure;
use crate::run::{Outcome, Run};
use check::{Check, CheckResult, failure};
use machine::of_machine;
use site::of_site;

/// Arguments of `doctor`.
#[derive(Debug, Clone, clap::Args)]
pub struct Args {
    /// The site.
    #[command(flatten)]
    site: SiteArgs,

    /// Print one JSON document on standard output and nothing else there
    #[arg(long)]
    json: bool,
}

impl Run for Args {
    /// Checks this machine and the site's configuration; all is well if nothing fails.
    ///
    /// # Errors
    /// JSON that cannot be written.
    fn run(&self) -> Result<Outcome, Failure> {
        let mut checks = of_machine();
        match self.site.config() {
            Ok(config) => checks.extend(of_site(&config)),
            Err(why) => checks.push(failure("configuration", format!("{why:#}"))),
        }
        let is_well = checks.iter().all(|check| check.verdict != CheckResult::Failure);
        if self.json {
            let text = serde_json::to_string(&checks).map_err(Failure::work)? + "\n";
            return Ok(Outcome::judged(text, is_well));
        }
        let line = |check: &Check| {
            let word = match check.verdict {
                CheckResult::Ok => "ok",
                CheckResult::Warning => "warning",
                CheckResult::Failure => "FAILS",
            };
            format!("{word:<8} {:<16} {}\n", check.what, check.found)
        };
        Ok(Outcome::judged(checks.iter().map(line).collect(), is_well))
    }
}
