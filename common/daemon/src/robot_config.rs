//! Configuration of a robot: profile, waypoints and its own map, of one without a name and in the tables of `[[robots]]`.

use crate::failure::Failure;
use crate::known_places::{KnownPlaces, PointInRoom};
use crate::ros_config::RosConfig;
use bus::{MAX_ROBOTS, RobotName};
use schemars::JsonSchema;
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize};
use std::path::PathBuf;

/// Tables of a robot without a name, which no site with named robots has.
const UNNAMED: [&str; 4] = ["robot", "waypoints", "align", "ros"];

/// The robot.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RobotConfig {
    /// Robot profile, as for `groundplan convert --robot`.
    pub profile: Option<PathBuf>,
    /// Metres per cell.
    pub resolution_m: f64,
}

/// The waypoints.
#[derive(Debug, Clone, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct WaypointConfig {
    /// What is planned and how, as for `groundplan convert --waypoints`.
    pub options: Option<PathBuf>,
}

/// The robot's own map, and where it lies in the model's.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct AlignConfig {
    /// A map that the robot saved, for sites where it does not publish one.
    pub map: Option<PathBuf>,
    /// Index of the map storey that the robot is on; all are tried if left out.
    pub storey: Option<u32>,
    /// About where the robot's map lies.
    pub hint: Option<PoseHint>,
    /// Room in which the robot's map began (x and y are 0), by number, name or GlobalId.
    pub start_room: Option<String>,
    /// Points of the robot's map, each with the room that it lies in.
    pub at: Vec<PointInRoom>,
    /// Height of the floor under the robot in the model's map, in metres.
    pub elevation_m: Option<f64>,
    /// Stair, ramp or lift that the robot took last, by name or GlobalId.
    pub portal: Option<String>,
    /// Metres by which the pose may change, at the middle of the SLAM map, without confirmation.
    pub max_jump_m: f64,
    /// The same for its yaw, in degrees.
    pub max_jump_deg: f64,
    /// Largest standard deviation of the middle of the SLAM map, in metres, of a pose that may be used.
    pub max_uncertainty_m: f64,
    /// The same of its yaw, in degrees.
    pub max_uncertainty_deg: f64,
    /// True if what the robot sees before its time counts from then on: maps show it, planned states stay.
    pub apply: bool,
}

/// A guess of `map_from_slam`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PoseHint {
    /// Metres.
    pub x_m: f64,
    /// Metres.
    pub y_m: f64,
    /// Degrees.
    pub yaw_deg: f64,
    /// How far off the middle of the SLAM map may be, in metres.
    #[serde(default = "PoseHint::radius_m")]
    pub radius_m: f64,
    /// How far off the yaw may be, in degrees.
    #[serde(default = "PoseHint::radius_deg")]
    pub radius_deg: f64,
}

impl AlignConfig {
    /// Keys whose numbers cannot be used, with the reason.
    pub fn faults(&self) -> Vec<(&'static str, String)> {
        let distances = [
            ("align.max_jump_m", self.max_jump_m),
            ("align.max_jump_deg", self.max_jump_deg),
            ("align.max_uncertainty_m", self.max_uncertainty_m),
            ("align.max_uncertainty_deg", self.max_uncertainty_deg),
        ];
        let unusable = distances.into_iter().filter(|(_, value)| !(value.is_finite() && *value >= 0.0));
        let told = |(key, value)| (key, format!("{value} is no distance: it must be 0 or more"));
        let hint = self.hint.and_then(|hint| hint.check().err()).map(|why| ("align.hint", why.to_string()));
        unusable.map(told).chain(hint).collect()
    }

    /// Refuses numbers that cannot be used.
    ///
    /// # Errors
    /// The first of them.
    pub fn check(&self) -> Result<(), Failure> {
        let fault = self.faults().into_iter().next();
        fault.map_or(Ok(()), |(key, why)| Err(format!("{key}: {why}").into()))
    }
}

/// A hint whose numbers say no area.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("its numbers must be finite, and its radii more than 0")]
pub struct PoseHintError;

impl PoseHint {
    /// Refuses numbers that say no area.
    ///
    /// # Errors
    /// A number that is not finite, a radius that is not more than 0.
    pub fn check(&self) -> Result<(), PoseHintError> {
        let is_usable = [self.x_m, self.y_m, self.yaw_deg].iter().all(|value| value.is_finite())
            && [self.radius_m, self.radius_deg].iter().all(|radius| radius.is_finite() && *radius > 0.0);
        if is_usable { Ok(()) } else { Err(PoseHintError) }
    }

    fn radius_m() -> f64 {
        2.0
    }

    fn radius_deg() -> f64 {
        20.0
    }
}

/// A robot with a name: what `[robot]`, `[waypoints]`, `[align]` and `[ros]` say of one without.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NamedRobotConfig {
    /// Its name: 1 to 32 characters of a-z, 0-9 and -.
    #[serde(deserialize_with = "robot_name")]
    #[schemars(with = "String", regex(pattern = "^[a-z0-9-]{1,32}$"))]
    pub name: RobotName,
    /// Robot profile, as for `groundplan convert --robot`.
    #[serde(default)]
    pub profile: Option<PathBuf>,
    /// Metres per cell.
    #[serde(default = "default_resolution_m")]
    pub resolution_m: f64,
    /// Its waypoints.
    #[serde(default)]
    pub waypoints: WaypointConfig,
    /// Its own map.
    #[serde(default)]
    pub align: AlignConfig,
    /// ROS 2. Its namespace is the robot's name if left out.
    #[serde(default)]
    pub ros: RosConfig,
}

pub(crate) fn robot_name<'de, D: Deserializer<'de>>(deserializer: D) -> Result<RobotName, D::Error> {
    String::deserialize(deserializer)?.parse().map_err(D::Error::custom)
}

pub(crate) fn robot_names<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<RobotName>, D::Error> {
    let names = Vec::<String>::deserialize(deserializer)?;
    names.iter().map(|name| name.parse().map_err(D::Error::custom)).collect()
}

pub(crate) fn optional_robot_name<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<RobotName>, D::Error> {
    robot_name(deserializer).map(Some)
}

fn default_resolution_m() -> f64 {
    RobotConfig::default().resolution_m
}

impl Default for RobotConfig {
    fn default() -> Self {
        Self { profile: None, resolution_m: 0.05 }
    }
}

impl Default for AlignConfig {
    fn default() -> Self {
        Self {
            map: None,
            storey: None,
            hint: None,
            start_room: None,
            at: Vec::new(),
            elevation_m: None,
            portal: None,
            max_jump_m: 0.10,
            max_jump_deg: 1.0,
            max_uncertainty_m: 0.10,
            max_uncertainty_deg: 1.0,
            apply: false,
        }
    }
}

impl AlignConfig {
    /// What is known of where the robot is.
    pub fn known_places(&self) -> KnownPlaces {
        let start = self.start_room.clone().map(PointInRoom::start);
        KnownPlaces {
            rooms: start.into_iter().chain(self.at.iter().cloned()).collect(),
            elevation_m: self.elevation_m,
            portal: self.portal.clone(),
        }
    }
}

impl NamedRobotConfig {
    /// Paths of the table, which count from the folder of the file.
    pub(crate) fn paths(&mut self) -> impl Iterator<Item = &mut PathBuf> {
        [&mut self.profile, &mut self.waypoints.options, &mut self.align.map, &mut self.ros.options]
            .into_iter()
            .flatten()
    }
}

/// Checks the robots of a parsed configuration against its text.
///
/// # Errors
/// Tables of a robot without a name beside those with names, a name that is there twice, too many robots.
pub(crate) fn check_robots(robots: &[NamedRobotConfig], text: &str) -> Result<(), toml::de::Error> {
    if robots.is_empty() {
        return Ok(());
    }
    let table: toml::Table = toml::from_str(text)?;
    let both: Vec<String> =
        UNNAMED.into_iter().filter(|key| table.contains_key(*key)).map(|key| format!("[{key}]")).collect();
    if !both.is_empty() {
        return Err(Error::custom(format!(
            "{} and [[robots]] exclude each other: what a robot has belongs into its table of [[robots]]",
            both.join(", ")
        )));
    }
    if robots.len() > MAX_ROBOTS {
        return Err(Error::custom(format!("[[robots]]: {} robots, and a site can have {MAX_ROBOTS}", robots.len())));
    }
    let twice = robots.iter().enumerate().find(|(at, robot)| robots[..*at].iter().any(|r| r.name == robot.name));
    match twice {
        Some((_, robot)) => Err(Error::custom(format!("[[robots]]: two robots have the name `{}`", robot.name))),
        None => Ok(()),
    }
}

/// Gives each robot a namespace in ROS 2, and checks that no two bridges meet: nodes of one name in one domain, or one address.
///
/// # Errors
/// Two robots with one namespace, or with one address for Foxglove.
pub(crate) fn separate_bridges(robots: &mut [NamedRobotConfig]) -> Result<(), toml::de::Error> {
    let default = RosConfig::default().namespace;
    for robot in &mut *robots {
        if robot.ros.namespace == default {
            robot.ros.namespace = namespace_of(robot.name);
        }
    }
    for (at, robot) in robots.iter().enumerate() {
        for other in &robots[..at] {
            let (a, b) = (&robot.ros, &other.ros);
            if a.domain_id == b.domain_id && a.namespace == b.namespace {
                let (a, b, namespace) = (robot.name, other.name, &b.namespace);
                return Err(Error::custom(format!(
                    "[[robots]]: ros.namespace of `{b}` and `{a}` is {namespace}: each robot needs its own in a domain"
                )));
            }
            let addresses = [a, b].map(|ros| ros.foxglove.as_ref().map(|foxglove| foxglove.address));
            if let [Some(address), Some(same)] = addresses
                && address == same
            {
                let (a, b) = (robot.name, other.name);
                return Err(Error::custom(format!(
                    "[[robots]]: ros.foxglove.address of `{b}` and `{a}` is {address}: each robot needs its own"
                )));
            }
        }
    }
    Ok(())
}

/// Names in ROS 2 have no `-`, and begin with no digit.
fn namespace_of(name: RobotName) -> String {
    let plain = name.as_str().replace('-', "_");
    if plain.starts_with(|first: char| first.is_ascii_digit()) {
        format!("/robot_{plain}")
    } else {
        format!("/{plain}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn namespaces_are_names_of_ros() {
        let namespace = |name: &str| namespace_of(name.parse().unwrap());
        assert_eq!(["lift-2", "7"].map(namespace), ["/lift_2", "/robot_7"]);
    }
}
