//! The frame of commands that are a process of a site until they are stopped: `up`, `keeper`, `relay`.

use crate::args::SiteArgs;
use crate::failure::Failure;
use crate::run::Outcome;
use daemon::{Log, SiteConfig, StopSignal};
use tracing::error;

/// Arguments of such a process that `up` starts.
#[derive(Debug, Clone, clap::Args)]
pub(crate) struct ServiceArgs {
    /// The site.
    #[command(flatten)]
    site: SiteArgs,

    /// Stop when standard input ends
    #[arg(long)]
    with_stdin: bool,
}

impl ServiceArgs {
    /// Runs it until it is stopped.
    ///
    /// # Errors
    /// A configuration that cannot be used, a log that cannot be had.
    pub(crate) fn run(
        &self,
        service: &'static str,
        work: impl FnOnce(&SiteConfig, StopSignal) -> Result<(), Failure>,
    ) -> Result<Outcome, Failure> {
        let config = self.site.own_config()?;
        run_logged(&config, service, || {
            let stop = StopSignal::listen(self.with_stdin).map_err(Failure::work)?;
            work(&config, stop)
        })
    }
}

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
