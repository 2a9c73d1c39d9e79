//! Names of robots, and what each robot of a site has of its own on the bus.

use crate::limits::MAX_ROBOT_NAME_BYTES;
use crate::names::{Daemon, TopicName};
use std::fmt;
use std::str::FromStr;

/// The name of a robot on a site with several: 1 to 32 bytes of `a` to `z`, `0` to `9` and `-`, so that it is a part of names of
/// topics, folders and units as it is. Ordered as text.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct RobotName {
    /// Behind the name zeros, which are less than all of its bytes.
    bytes: [u8; MAX_ROBOT_NAME_BYTES],
}

/// A text that is no name of a robot.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{text:?} is no name of a robot: 1 to {MAX_ROBOT_NAME_BYTES} characters of a-z, 0-9 and -")]
pub struct RobotNameError {
    /// As given.
    text: String,
}

impl RobotName {
    /// The name as text.
    pub fn as_str(&self) -> &str {
        let length = self.bytes.iter().position(|byte| *byte == 0).unwrap_or(self.bytes.len());
        std::str::from_utf8(&self.bytes[..length]).expect("names are made of ASCII alone")
    }
}

impl FromStr for RobotName {
    type Err = RobotNameError;

    fn from_str(text: &str) -> Result<Self, RobotNameError> {
        let is_plain = |byte: u8| matches!(byte, b'a'..=b'z' | b'0'..=b'9' | b'-');
        if text.is_empty() || text.len() > MAX_ROBOT_NAME_BYTES || !text.bytes().all(is_plain) {
            return Err(RobotNameError { text: text.chars().take(2 * MAX_ROBOT_NAME_BYTES).collect() });
        }
        let mut bytes = [0; MAX_ROBOT_NAME_BYTES];
        bytes[..text.len()].copy_from_slice(text.as_bytes());
        Ok(Self { bytes })
    }
}

impl fmt::Display for RobotName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

impl fmt::Debug for RobotName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(self.as_str(), f)
    }
}

/// Names of robots in a sentence: `lift, scan`.
pub fn names_of_robots(robots: &[RobotName]) -> String {
    robots.iter().map(RobotName::as_str).collect::<Vec<_>>().join(", ")
}

/// What is the site's, or that of each robot: a topic, a daemon, heartbeats.
pub(crate) trait Owned: Copy {
    /// True for what each robot has of its own.
    fn is_of_robot(self) -> bool;
}

impl Owned for TopicName {
    fn is_of_robot(self) -> bool {
        Self::is_of_robot(self)
    }
}

impl Owned for Daemon {
    fn is_of_robot(self) -> bool {
        Self::is_of_robot(self)
    }
}

/// A topic or daemon with the robot whose it is; without one it is the site's, or that of a robot without a name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct OfRobot<T> {
    pub(crate) robot: Option<RobotName>,
    pub(crate) what: T,
}

impl<T: Owned> OfRobot<T> {
    /// As a participant with this robot, or without one, means it.
    pub(crate) fn new(robot: Option<RobotName>, what: T) -> Self {
        Self { robot: robot.filter(|_| what.is_of_robot()), what }
    }
}

impl<T: fmt::Display> fmt::Display for OfRobot<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&below_robot(self.robot, &self.what.to_string()))
    }
}

impl OfRobot<TopicName> {
    /// Whose event service its samples are told by.
    pub(crate) fn producer(self) -> OfRobot<Daemon> {
        OfRobot { robot: self.robot, what: self.what.producer() }
    }
}

impl OfRobot<Daemon> {
    /// The name of the service of its commands.
    pub(crate) fn command(self) -> String {
        below_robot(self.robot, &format!("command/{}", self.what))
    }
}

/// The name of a service of a robot, or of the site.
pub(crate) fn below_robot(robot: Option<RobotName>, name: &str) -> String {
    robot.map_or_else(|| name.to_owned(), |robot| format!("robots/{robot}/{name}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_plain_and_short() {
        let longest = "a".repeat(MAX_ROBOT_NAME_BYTES);
        for name in ["a", "lift", "scan-2", "-", "007", &longest] {
            let parsed: RobotName = name.parse().unwrap();
            assert_eq!((parsed.as_str(), parsed.to_string().as_str()), (name, name));
        }
        for name in ["", "Lift", "lift 1", "lift_1", "a/b", "..", "é", "a\0", &(longest.clone() + "a")] {
            let refused = name.parse::<RobotName>().unwrap_err().to_string();
            assert!(refused.contains("a-z, 0-9 and -"), "{refused}");
        }
    }

    #[test]
    fn names_are_ordered_as_text() {
        let mut names: Vec<RobotName> = ["scan", "lift-2", "lift", "a"].map(|name| name.parse().unwrap()).into();
        names.sort();
        assert_eq!(names_of_robots(&names), "a, lift, lift-2, scan");
    }

    #[test]
    fn what_is_a_robots_lies_below_its_name_and_what_is_the_sites_does_not() {
        let lift = Some("lift".parse().unwrap());
        let topic = |robot, topic| OfRobot::new(robot, topic).to_string();
        assert_eq!(topic(lift, TopicName::Grids), "robots/lift/grids");
        assert_eq!(topic(None, TopicName::Grids), "grids");
        for site_wide in [TopicName::Site, TopicName::Candidate, TopicName::Tasks, TopicName::ScheduleState] {
            assert_eq!(OfRobot::new(lift, site_wide), OfRobot::new(None, site_wide));
        }
        let of_site: Vec<Daemon> = Daemon::ALL.into_iter().filter(|daemon| !daemon.is_of_robot()).collect();
        let expected = [
            Daemon::IfcIngest,
            Daemon::ScheduleEval,
            Daemon::Groundplan,
            Daemon::Web,
            Daemon::SiteFollow,
            Daemon::SiteServer,
            Daemon::Ask,
        ];
        assert_eq!(of_site, expected);
        assert_eq!(OfRobot::new(lift, Daemon::Rasterize).command(), "robots/lift/command/rasterize");
        assert_eq!(OfRobot::new(lift, Daemon::Web).command(), "command/groundplan-web");
    }
}
