//! `groundplan monitor`: the running daemons in the terminal.

use crate::args::SiteOfRobotArgs;
use crate::failure::Failure;
use crate::monitor;
use crate::run::{Outcome, Run};
use std::time::{Duration, Instant};

/// Arguments of `monitor`.
#[derive(Debug, Clone, clap::Args)]
pub struct Args {
    /// The site.
    #[command(flatten)]
    site: SiteOfRobotArgs,

    /// Print everything that is shown as one JSON document a line, on every change
    #[arg(long)]
    json: bool,

    /// Stop after this time
    #[arg(long = "for", value_name = "SECONDS")]
    seconds: Option<f64>,
}

impl Run for Args {
    /// Shows the running site until the user quits; with `--json` prints a line for each change.
    ///
    /// # Errors
    /// No terminal, a bus that refuses.
    fn run(&self) -> Result<Outcome, Failure> {
        let config = self.site.config()?;
        let ends = self.seconds.map(|seconds| Instant::now() + Duration::from_secs_f64(seconds.clamp(0.0, 1e9)));
        monitor::show_until(&config, ends, self.json)?;
        Ok(Outcome::silent())
    }
}
