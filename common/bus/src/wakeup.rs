//! Wake-up events: one event service per daemon and one for each status stream.

use crate::names::Daemon;
use crate::robot_name::{OfRobot, RobotName, below_robot};

/// The event services of a domain.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum EventService {
    /// Events of a daemon: samples that it published, late joiners, commands to it, replies of it.
    Of(OfRobot<Daemon>),
    /// The status stream of the site, or of a robot.
    Status(Option<RobotName>),
}

impl EventService {
    /// The name of its service.
    pub(crate) fn text(self) -> String {
        match self {
            Self::Of(OfRobot { robot, what }) => below_robot(robot, &format!("event/{what}")),
            Self::Status(robot) => below_robot(robot, "event/status"),
        }
    }
}

/// Wake-up events, with the numbers that iceoryx2 transfers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub(crate) enum Wakeup {
    /// The daemon published a sample; of the status stream: a daemon sent a heartbeat.
    Data = 0,
    /// A subscriber joined and needs the last samples.
    LateJoiner = 1,
    /// A participant with a notifier of this service died.
    Dead = 2,
    /// A command for the daemon.
    Command = 3,
    /// A reply of the daemon.
    Reply = 4,
}

/// Events received since the last call, as a set.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Wakeups(pub(crate) u8);

impl Wakeups {
    pub(crate) fn add(&mut self, number: usize) {
        self.0 |= 1u8.checked_shl(number as u32).unwrap_or(0);
    }

    pub(crate) fn any(self, wakeups: &[Wakeup]) -> bool {
        wakeups.iter().any(|&r| self.0 & (1 << r as u8) != 0)
    }
}
