//! `groundplan relay`: lets other users than the bus's own look at the site, and send commands.

use crate::failure::Failure;
use crate::run::{Outcome, Run};
use crate::site_service::ServiceArgs;
use bus::{Daemon, Relay, RelayEvent, RelayOptions, ReportKind, RobotName};
use daemon::{ProcessReport, SiteConfig, SiteHistory, SiteProcess, StatusBoard, StopSignal};
use std::time::Duration;
use tracing::{info, warn};

/// Interval at which the supervisor is told that the relay lives.
const TICK: Duration = Duration::from_secs(1);
const ACTIVITY: &str = "serves";

/// Characters of a command that are logged.
const MAX_LOGGED: usize = 400;

/// Arguments of `relay`.
#[derive(Debug, Clone, clap::Args)]
pub struct Args {
    /// The site, and when to stop.
    #[command(flatten)]
    service: ServiceArgs,
}

impl Run for Args {
    /// Serves the sockets until it is stopped.
    ///
    /// # Errors
    /// A bus of another user, sockets that cannot be opened.
    fn run(&self) -> Result<Outcome, Failure> {
        self.service.run("relay", serve)
    }
}

fn serve(config: &SiteConfig, stop: StopSignal) -> Result<(), Failure> {
    let domain = config.domain().map_err(Failure::usage)?;
    let (board, history) = (StatusBoard::of_own(config), SiteHistory::of(config));
    let robots = config.robot_names();
    let group = |name: &str| Some(name.to_owned()).filter(|name| !name.is_empty());
    let options = RelayOptions {
        view_group: group(&config.relay.view_group),
        control_group: group(&config.relay.control_group),
        report: Box::new(move |kind| match kind {
            ReportKind::Status => board.to_bytes(&robots),
            ReportKind::History => history.newest_lines(),
        }),
    };
    let (mut relay, notes) = Relay::open(&domain, options).map_err(Failure::work)?;
    relay.stop_on(stop.descriptor().map_err(Failure::work)?);
    for note in notes {
        warn!(service = "relay", "{note}");
    }
    info!(service = "relay", folder = %relay.folder().display(), "serves other users");
    let mut report = ProcessReport::of(&config.bus.root, SiteProcess::Relay);
    daemon::ready(ACTIVITY);
    let mut events = EventLog::default();
    loop {
        report.alive(ACTIVITY, relay.trouble());
        if relay.serve(TICK, &mut |event| events.log(event)).map_err(Failure::work)? {
            break;
        }
    }
    report.leave();
    Ok(())
}

/// Logs what users do. A command that a client sends again and again, to see how a search gets on, is logged once.
#[derive(Default)]
struct EventLog {
    last: Option<(u32, Daemon, Option<RobotName>, Vec<u8>)>,
}

impl EventLog {
    fn log(&mut self, event: RelayEvent<'_>) {
        match event {
            RelayEvent::Command { uid, daemon, robot, bytes } => {
                let sent = (uid, daemon, robot, bytes.to_vec());
                if self.last.as_ref() == Some(&sent) {
                    return;
                }
                self.last = Some(sent);
                let command: String = String::from_utf8_lossy(bytes).chars().take(MAX_LOGGED).collect();
                let robot = robot.map(|robot| robot.to_string());
                info!(service = "relay", uid, daemon = daemon.name(), robot, command, "a user sends a command");
            }
            RelayEvent::CutOff { uid, reason } => {
                warn!(service = "relay", uid, reason, "a client sends what is not the protocol, and is cut off");
            }
            RelayEvent::TurnedAway { uid, reason } => warn!(service = "relay", uid, reason, "a client is not served"),
            RelayEvent::NotAccepting { reason } => {
                warn!(service = "relay", reason, "no client can be accepted at the moment");
            }
            RelayEvent::CannotJoin { reason } => {
                warn!(service = "relay", reason, "the bus cannot be joined; it is tried again");
            }
            RelayEvent::SampleLost { topic, reason } => {
                warn!(service = "relay", topic, reason, "a sample cannot be passed on");
            }
        }
    }
}
