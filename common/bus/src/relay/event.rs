//! Events of a relay, for its log.

use crate::names::Daemon;
use crate::robot_name::RobotName;

/// What happens at a relay, for its log.
#[derive(Debug)]
pub enum RelayEvent<'a> {
    /// A user sends a command.
    Command {
        /// Who, as the system says.
        uid: u32,
        /// To which daemon.
        daemon: Daemon,
        /// Of which robot, if it is one of a robot with a name.
        robot: Option<RobotName>,
        /// The command.
        bytes: &'a [u8],
    },
    /// A client sent something that is not the protocol, and is cut off.
    CutOff {
        /// Whose.
        uid: u32,
        /// What it sent.
        reason: String,
    },
    /// A client is not served.
    TurnedAway {
        /// Whose.
        uid: u32,
        /// Why.
        reason: String,
    },
    /// No client can be accepted at the moment; those that ask go on waiting.
    NotAccepting {
        /// Why.
        reason: String,
    },
    /// There is a bus, and the relay cannot join it: clients are told why, and it is tried again.
    CannotJoin {
        /// Why.
        reason: String,
    },
    /// A sample cannot be passed on; clients keep the one before it. One that cannot be copied is tried again.
    SampleLost {
        /// Of which topic, with the robot whose it is.
        topic: String,
        /// Why.
        reason: String,
    },
}
