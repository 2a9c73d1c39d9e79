//! `groundplan relay`: lets other users than the bus's own look at the site, and send commands.

use crate::args::SiteArgs;
use crate::failure::Failure;
use crate::run::{Outcome, Run};
use bus::{Relay, RelayEvent, RelayOptions};
use daemon::{StatusBoard, StopSignal};
use std::time::Duration;
use tracing::{info, warn};

/// Interval at which the supervisor is told that the relay lives.
const TICK: Duration = Duration::from_secs(1);

/// Characters of a command that are logged.
const MAX_LOGGED: usize = 400;

/// Arguments of `relay`.
#[derive(Debug, Clone, clap::Args)]
pub struct Args {
    /// The site.
    #[command(flatten)]
    site: SiteArgs,

    /// Stop when standard input ends
    #[arg(long)]
    with_stdin: bool,
}

impl Run for Args {
    /// Serves the sockets until it is stopped.
    ///
    /// # Errors
    /// A bus of another user, sockets that cannot be opened.
    fn run(&self) -> Result<Outcome, Failure> {
        let config = self.site.own_config()?;
        let domain = config.domain().map_err(Failure::usage)?;
        let stop = StopSignal::listen(self.with_stdin).map_err(Failure::work)?;
        let board = StatusBoard::of(&config.bus.root);
        let group = |name: &str| Some(name.to_owned()).filter(|name| !name.is_empty());
        let options = RelayOptions {
            view_group: group(&config.relay.view_group),
            control_group: group(&config.relay.control_group),
            report: Box::new(move || board.to_bytes()),
        };
        let (mut relay, notes) = Relay::open(&domain, options).map_err(Failure::work)?;
        relay.stop_on(stop.descriptor().map_err(Failure::work)?);
        for note in notes {
            warn!(service = "relay", "{note}");
        }
        info!(service = "relay", folder = %relay.folder().display(), "serves other users");
        daemon::ready("serves other users");
        while !relay.serve(TICK, &mut log).map_err(Failure::work)? {
            daemon::alive("serves other users");
        }
        daemon::stopping();
        Ok(Outcome::silent())
    }
}

fn log(event: RelayEvent<'_>) {
    match event {
        RelayEvent::Command { uid, daemon, bytes } => {
            let command: String = String::from_utf8_lossy(bytes).chars().take(MAX_LOGGED).collect();
            info!(service = "relay", uid, daemon = daemon.name(), command, "a user sends a command");
        }
        RelayEvent::CutOff { uid, reason } => {
            warn!(service = "relay", uid, reason, "a client sends what is not the protocol, and is cut off");
        }
        RelayEvent::TurnedAway { uid, reason } => warn!(service = "relay", uid, reason, "a client is not served"),
        RelayEvent::SampleLost { topic, reason } => {
            warn!(service = "relay", %topic, reason, "a sample cannot be passed on");
        }
    }
}
