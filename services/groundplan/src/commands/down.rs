//! `groundplan down`: stops the daemons of a site.

use crate::args::SiteArgs;
use crate::failure::Failure;
use crate::run::{Outcome, Run};
use crate::supervise::{DOWN_TIMEOUT, running};
use rustix::process::{Signal, kill_process};
use std::time::{Duration, Instant};

/// Interval at which the processes are polled.
const POLL_INTERVAL: Duration = Duration::from_millis(100);

/// Arguments of `down`.
#[derive(Debug, Clone, clap::Args)]
pub struct Args {
    /// The site.
    #[command(flatten)]
    site: SiteArgs,
}

impl Run for Args {
    /// Stops the daemons of a site; returns when they are gone.
    ///
    /// # Errors
    /// A site that is not up, or does not go down.
    fn run(&self) -> Result<Outcome, Failure> {
        let config = self.site.config()?;
        let pid = running(&config.state).ok_or_else(|| Failure::work("the site is not up"))?;
        kill_process(pid, Signal::TERM).map_err(Failure::work)?;
        let deadline = Instant::now() + DOWN_TIMEOUT;
        while running(&config.state).is_some() {
            if Instant::now() >= deadline {
                return Err(Failure::work(format!("process {} does not leave", pid.as_raw_nonzero())));
            }
            std::thread::sleep(POLL_INTERVAL);
        }
        Ok(Outcome::silent())
    }
}
