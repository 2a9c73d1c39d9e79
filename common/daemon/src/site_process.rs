//! The processes of a site that report on its status board.

use crate::config::SiteConfig;
use bus::{Daemon, RobotName};
use std::fmt;

/// A process of a site.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum SiteProcess {
    /// A participant of the bus, of the site or of a robot without a name.
    Daemon(Daemon),
    /// The daemon of a robot with a name.
    OfRobot(RobotName, Daemon),
    /// Creates the bus and removes resources of dead participants.
    Keeper,
    /// Serves users other than the bus's own.
    Relay,
}

impl SiteProcess {
    /// All that `groundplan up` starts and starts again for a site, in the order of the start.
    pub fn supervised(config: &SiteConfig) -> impl Iterator<Item = Self> + use<> {
        let (of_robots, of_site): (Vec<Daemon>, Vec<Daemon>) =
            daemons_of_maps(config).iter().copied().partition(|daemon| daemon.is_of_robot());
        let server = config.serve.as_ref().map(|_| Daemon::SiteServer);
        let of_site: Vec<Self> = of_site.into_iter().chain(server).map(Self::Daemon).collect();
        let of_robots = config.of_each_robot().into_iter().flat_map(move |robot| {
            let bridge = robot.ros.enabled.then_some(Daemon::RosBridge);
            let daemons: Vec<Self> =
                of_robots.iter().copied().chain(bridge).map(|daemon| Self::of(robot.robot_name, daemon)).collect();
            daemons
        });
        let web = config.web.enabled.then_some(Self::Daemon(Daemon::Web));
        let ask = config.ask.enabled.then_some(Self::Daemon(Daemon::Ask));
        let shown = web.into_iter().chain(ask);
        std::iter::once(Self::Keeper).chain(of_site).chain(of_robots).chain(shown).chain(std::iter::once(Self::Relay))
    }

    /// A daemon as a robot has it.
    pub fn of(robot: Option<RobotName>, daemon: Daemon) -> Self {
        match robot {
            Some(robot) if daemon.is_of_robot() => Self::OfRobot(robot, daemon),
            _ => Self::Daemon(daemon),
        }
    }

    /// The robot with a name whose it is.
    pub fn robot(self) -> Option<RobotName> {
        match self {
            Self::OfRobot(robot, _) => Some(robot),
            Self::Daemon(_) | Self::Keeper | Self::Relay => None,
        }
    }

    /// The participant of the bus that it is.
    pub fn daemon(self) -> Option<Daemon> {
        match self {
            Self::Daemon(daemon) | Self::OfRobot(_, daemon) => Some(daemon),
            Self::Keeper | Self::Relay => None,
        }
    }
}

/// The daemons without which there are no maps, and what works with them: those that draw, or those that follow a server.
fn daemons_of_maps(config: &SiteConfig) -> &'static [Daemon] {
    if config.follow.is_some() { &Daemon::FOLLOWING } else { &Daemon::SUPERVISED }
}

impl From<Daemon> for SiteProcess {
    fn from(daemon: Daemon) -> Self {
        Self::Daemon(daemon)
    }
}

impl fmt::Display for SiteProcess {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Daemon(daemon) => f.write_str(daemon.name()),
            Self::OfRobot(robot, daemon) => write!(f, "{daemon}@{robot}"),
            Self::Keeper => f.write_str("keeper"),
            Self::Relay => f.write_str("relay"),
        }
    }
}
