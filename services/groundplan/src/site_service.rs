//! The frame of commands that are a process of a site until they are stopped: `up`, `keeper`, `relay`.

use crate::failure::Failure;
use crate::run::Outcome;
use daemon::{Log, SiteConfig};
use tracing::error;

/// Runs such a process. Its log is that of the site from here on, also for the reason why it cannot go on.
///
/// # Errors
/// A log that cannot be had.
pub(crate) fn run_logged(
    config: &SiteConfig,
    service: &'static str,
    work: impl FnOnce() -> Result<(), Failure>,
) -> Result<Outcome, Failure> {
    Log::start(&config.log).map_err(Failure::usage)?;
    let exit_code = match work() {
        Ok(()) => 0,
        Err(failure) => {
            error!(service, error = format!("{failure:#}"), "cannot go on");
            failure.code()
        }
    };
    Ok(Outcome { text: String::new(), exit_code })
}
