//! `groundplan up`: starts and supervises the daemons of a site.

use crate::args::SiteArgs;
use crate::failure::Failure;
use crate::run::{Outcome, Run};
use crate::site_check::refuse_unusable;
use crate::supervise::{Running, SupervisedProcess, check_versions};
use bus::{Daemon, HEARTBEAT_PERIOD};
use daemon::{StatusBoard, StopSignal, claim_state};
use std::time::{Duration, Instant};

/// Interval at which the daemons are polled.
const POLL_INTERVAL: Duration = Duration::from_millis(100);

/// Arguments of `up`.
#[derive(Debug, Clone, clap::Args)]
pub struct Args {
    /// The site.
    #[command(flatten)]
    site: SiteArgs,
}

impl Run for Args {
    /// Starts the keeper and the daemons, and restarts those that die, until it is stopped.
    ///
    /// # Errors
    /// Executables that are missing or of another version, a configuration that cannot be used, a site that is up already.
    fn run(&self) -> Result<Outcome, Failure> {
        self.site.prepare()?;
        let config = self.site.own_config()?;
        let path = config.file.clone();
        refuse_unusable(&config)?;
        check_versions()?;
        claim_state(&config.state).map_err(Failure::usage)?;
        let mut stop = StopSignal::listen(false).map_err(Failure::work)?;
        let _running = Running::claim(&config.state)?;
        let board = StatusBoard::of(&config.bus.root);
        let mut last_look = Instant::now();
        let mut keeper = SupervisedProcess::of_command("keeper");
        let mut relay = SupervisedProcess::of_command("relay");
        let mut daemons = Daemon::SUPERVISED.map(|daemon| SupervisedProcess::new(daemon.name()));
        while !stop.is_raised_within(POLL_INTERVAL) {
            keeper.supervise(&path)?;
            let looks = last_look.elapsed() >= HEARTBEAT_PERIOD;
            for (process, daemon) in daemons.iter_mut().zip(Daemon::SUPERVISED) {
                process.supervise(&path)?;
                if looks {
                    process.kill_if_it_hangs(&board, daemon);
                }
            }
            if looks {
                last_look = Instant::now();
            }
            relay.supervise(&path)?;
        }
        // The keeper stops last, when the bus has no participants.
        relay.close();
        daemons.iter_mut().for_each(SupervisedProcess::close);
        relay.stop();
        daemons.iter_mut().for_each(SupervisedProcess::stop);
        keeper.close();
        keeper.stop();
        Ok(Outcome::silent())
    }
}
