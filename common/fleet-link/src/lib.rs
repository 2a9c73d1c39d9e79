//! The link between the server of a site and its robots, beside the store: that an index is new, who is there, what robots tell.
//!
//! Maps never go this way: a lost or late word costs a robot nothing but the time until it looks at the store by itself. The server
//! is the router; robots are its clients, and hear nothing of each other. This crate alone names zenoh.
//!
//! | key | from | what |
//! |---|---|---|
//! | `groundplan/SITE/index` | server | the epoch of the newest index, in decimal digits |
//! | `groundplan/SITE/server` | server | liveliness: it is there |
//! | `groundplan/SITE/robots/ROBOT/here` | robot | liveliness: it is there |
//! | `groundplan/SITE/robots/ROBOT/KIND` | robot | a query with a message; the reply is the answer of the server, see [`MessageKind`] |
//!
//! # Guarantees
//!
//! - A robot that the server knows by its password or by the common name of its certificate speaks under its own name and no other,
//!   and hears the two keys of the server and answers to itself: the access control of the router has these rules and denies the rest.
//! - Without passwords and certificates the server listens on its own machine alone, where any name may be taken.
//! - A message has at most [`MessageKind::max_bytes`]; of one robot at most [`MAX_WAITING`] wait for the server, of all robots
//!   at most 64 MiB; the rest is refused.
//! - A link that broke is made again by itself, on both sides; what was told meanwhile is for the robot to tell again.

mod config;
mod error;
mod robot;
mod secret;
mod server;

pub use config::{Identity, RobotSettings, ServerSettings};
pub use error::LinkError;
pub use robot::RobotLink;
pub use server::{MAX_WAITING, Message, ServerLink};

/// Largest message, and largest answer.
pub const MAX_MESSAGE_BYTES: usize = 8 << 20;

/// Largest report.
const MAX_REPORT_BYTES: usize = 256 << 10;

/// What a robot tells.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum MessageKind {
    /// How it is, and what it shows.
    Report,
    /// The table of progress that it observed.
    Progress,
    /// What it observed of elements.
    Observations,
}

impl MessageKind {
    /// All kinds.
    pub const ALL: [Self; 3] = [Self::Report, Self::Progress, Self::Observations];

    /// Its name in keys.
    pub fn name(self) -> &'static str {
        match self {
            Self::Report => "report",
            Self::Progress => "progress",
            Self::Observations => "observations",
        }
    }

    /// Largest message of this kind.
    pub fn max_bytes(self) -> usize {
        match self {
            Self::Report => MAX_REPORT_BYTES,
            Self::Progress | Self::Observations => MAX_MESSAGE_BYTES,
        }
    }

    fn of_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }
}

/// Keys of a site.
mod keys {
    pub(crate) fn index(site: &str) -> String {
        format!("groundplan/{site}/index")
    }

    pub(crate) fn server(site: &str) -> String {
        format!("groundplan/{site}/server")
    }

    /// Of a robot, or of all with `*`.
    pub(crate) fn here(site: &str, robot: &str) -> String {
        format!("groundplan/{site}/robots/{robot}/here")
    }

    /// What a robot tells, or all do with `*`.
    pub(crate) fn told(site: &str, robot: &str, kind: &str) -> String {
        format!("groundplan/{site}/robots/{robot}/{kind}")
    }

    /// The robot and the last part of a key of a robot.
    pub(crate) fn parts(key: &str) -> Option<(&str, &str)> {
        let mut parts = key.rsplit('/');
        let last = parts.next()?;
        Some((parts.next()?, last))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_of_a_robot_names_it_and_the_kind() {
        for kind in MessageKind::ALL {
            let key = keys::told("tower", "scout-1", kind.name());
            assert_eq!(keys::parts(&key), Some(("scout-1", kind.name())));
            assert_eq!(MessageKind::of_name(kind.name()), Some(kind));
        }
        assert_eq!(keys::parts(&keys::here("tower", "a")), Some(("a", "here")));
    }
}
