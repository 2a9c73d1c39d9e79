//! Configuration of ros-bridge: `[ros]` of a site.

use schemars::JsonSchema;
use serde::Deserialize;
use serde::de::Error;
use std::collections::{BTreeMap, BTreeSet};
use std::net::{Ipv4Addr, SocketAddr};
use std::ops::RangeInclusive;
use std::path::PathBuf;

/// What ros-bridge publishes in ROS 2, and takes from there.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RosConfig {
    /// True to run ros-bridge.
    pub enabled: bool,
    /// A file with the keys of this table; they are in one place, there or here.
    pub options: Option<PathBuf>,
    /// The ROS domain, 0 to 232; that of ROS_DOMAIN_ID if left out, else 0.
    #[schemars(range(min = 0, max = Self::MAX_DOMAIN))]
    pub domain_id: Option<u16>,
    /// Addresses of the network interfaces that are used; all interfaces if left out.
    pub interfaces: BTreeSet<Ipv4Addr>,
    /// Namespace of the node and of its topics.
    pub namespace: String,
    /// Frame of the maps: the model's map.
    pub frame: String,
    /// True to publish the grids in `slam_frame`, resampled by the alignment that is in effect; none without one.
    pub in_slam_frame: bool,
    /// Topic of the planning map; NAMESPACE/map if left out.
    pub map_topic: Option<String>,
    /// Index of the map storey that is published until another is set; that of the alignment if left out, else the lowest.
    pub storey: Option<u32>,
    /// True: a robot that comes to the end of a stair or ramp is on the storey there.
    pub follow_portals: bool,
    /// Topic of the robot's SLAM map; none is taken if left out.
    pub slam_map_topic: Option<String>,
    /// Frame of the SLAM map: the parent of `frame` in `/tf_static`.
    pub slam_frame: String,
    /// Frame of the robot, whose pose in `slam_frame` is taken from `/tf`.
    pub robot_frame: String,
    /// True to publish the robot's pose in the model's map on `/initialpose` whenever another alignment comes into effect.
    pub initial_pose: bool,
    /// What is published; all if left out.
    pub outputs: BTreeSet<RosOutput>,
    /// True to publish the limits of speed of the robot's profile on `speed_mask` and `speed_info`; without limits, none in any cell.
    pub speed_mask: bool,
    /// True to publish heights, slopes and traversability on `grid_map`: three numbers of 32 bits for each cell.
    pub grid_map: bool,
    /// True: while maps are stale the keep-out mask keeps the robot out of everything.
    pub keepout_when_stale: bool,
    /// True to let ROS 2 change the plan time, start searches and confirm.
    pub allow_control: bool,
    /// How requests and responses of services are told apart: as the middleware of the other nodes does it.
    pub service_mapping: RosServiceMapping,
    /// Simulated time that the plan time follows; none if left out.
    pub sim_time: Option<SimTimeConfig>,
    /// What Nav2 is told when maps change; nothing if left out.
    pub nav2: Option<Nav2Config>,
    /// The server for Foxglove; there is none if left out.
    pub foxglove: Option<FoxgloveConfig>,
    /// Other qualities of service, by topic as in `outputs`.
    pub qos: BTreeMap<RosOutput, QosConfig>,
}

impl Default for RosConfig {
    fn default() -> Self {
        Self {
            enabled: false,
            options: None,
            domain_id: None,
            interfaces: BTreeSet::new(),
            namespace: "/groundplan".to_owned(),
            frame: "site_map".to_owned(),
            in_slam_frame: false,
            map_topic: None,
            storey: None,
            follow_portals: true,
            slam_map_topic: None,
            slam_frame: "map".to_owned(),
            robot_frame: "base_link".to_owned(),
            initial_pose: false,
            outputs: RosOutput::ALL.into(),
            speed_mask: false,
            grid_map: false,
            keepout_when_stale: false,
            allow_control: false,
            service_mapping: RosServiceMapping::default(),
            sim_time: None,
            nav2: None,
            foxglove: None,
            qos: BTreeMap::new(),
        }
    }
}

impl RosConfig {
    /// The largest number of a domain whose ports exist.
    pub const MAX_DOMAIN: u16 = 232;

    /// A name in full: one that begins with a slash as it is, others in the namespace of the node.
    pub fn full_name(&self, name: &str) -> String {
        full_ros_name(&self.namespace, name)
    }

    /// This table, which names a file of options, with the text of that file.
    ///
    /// # Errors
    /// No TOML of these keys, or keys in both places.
    pub(crate) fn with_options(&self, text: &str) -> Result<Self, toml::de::Error> {
        let of_file: Self = toml::from_str(text)?;
        let (enabled, options) = (self.enabled, self.options.clone());
        if *self != (Self { enabled, options: options.clone(), ..Self::default() }) {
            return Err(toml::de::Error::custom("[ros] of the site names this file: all its keys belong here"));
        }
        if of_file.enabled || of_file.options.is_some() {
            return Err(toml::de::Error::custom("enabled and options belong into [ros] of the site"));
        }
        Ok(Self { enabled, options, ..of_file })
    }
}

/// What ros-bridge can publish.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum RosOutput {
    /// The planning map.
    Map,
    /// The map for localization.
    LocalizationMap,
    /// The keep-out mask, and what it means.
    KeepoutMask,
    /// Rooms, doors and drop-offs.
    Rooms,
    /// Waypoints.
    Waypoints,
    /// The route graph, and the path of its file.
    Route,
    /// What changed.
    Changed,
    /// Once a second whether the maps may be used.
    Heartbeat,
    /// How the processes of the site are.
    Diagnostics,
    /// How the model's map lies in the robot's.
    TfStatic,
}

impl RosOutput {
    /// All of them.
    pub const ALL: [Self; 10] = [
        Self::Map,
        Self::LocalizationMap,
        Self::KeepoutMask,
        Self::Rooms,
        Self::Waypoints,
        Self::Route,
        Self::Changed,
        Self::Heartbeat,
        Self::Diagnostics,
        Self::TfStatic,
    ];
}

/// How a middleware tells requests and responses of services apart.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum RosServiceMapping {
    /// As rmw_fastrtps, the default of ROS 2: beside the message.
    #[default]
    FastDds,
    /// As rmw_cyclonedds: before the body of the message.
    CycloneDds,
}

/// Simulated time: the plan time follows `/clock`.
#[derive(Debug, Clone, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SimTimeConfig {
    /// The plan time when `/clock` says zero.
    pub plan_time_at_zero: String,
    /// Seconds of plan time for each of `/clock`; 1 if left out.
    #[serde(default = "one")]
    pub rate: f64,
}

fn one() -> f64 {
    1.0
}

/// What Nav2 is told when the maps of the robot's storey change: stop, forget, load, go on.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Nav2Config {
    /// How the robot is stopped before new maps are published.
    pub pause: Nav2Pause,
    /// The lifecycle manager that pauses and resumes.
    pub lifecycle_manager: String,
    /// The actions whose goals are cancelled.
    pub actions: Vec<String>,
    /// The costmaps that are cleared.
    pub costmaps: Vec<String>,
    /// The route server that gets the route graph; none if empty.
    pub route_server: String,
}

impl Default for Nav2Config {
    fn default() -> Self {
        let names = |names: &[&str]| names.iter().map(|&name| name.to_owned()).collect();
        Self {
            pause: Nav2Pause::default(),
            lifecycle_manager: "/lifecycle_manager_navigation".to_owned(),
            actions: names(&["/navigate_to_pose", "/navigate_through_poses", "/follow_waypoints"]),
            costmaps: names(&["/global_costmap", "/local_costmap"]),
            route_server: "/route_server".to_owned(),
        }
    }
}

/// How Nav2 is paused.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Nav2Pause {
    /// All goals are cancelled; the mission sends the next one when it hears of the change.
    #[default]
    Goals,
    /// The lifecycle manager pauses Nav2, and resumes it.
    Lifecycle,
}

/// The server for Foxglove in ros-bridge.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FoxgloveConfig {
    /// Address and TCP port at which it listens; port 0 for one that is free, which the log names.
    pub address: SocketAddr,
}

impl Default for FoxgloveConfig {
    fn default() -> Self {
        Self { address: SocketAddr::from((Ipv4Addr::LOCALHOST, 8765)) }
    }
}

/// Qualities of service of a topic; what is left out stays as it is.
#[derive(Debug, Clone, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct QosConfig {
    /// False for best effort.
    pub is_reliable: Option<bool>,
    /// True to keep the last message for those that join later.
    pub is_latched: Option<bool>,
    /// How many messages are kept.
    #[schemars(range(min = 1, max = 100))]
    pub depth: Option<u8>,
    /// A message is not delivered any more after this time.
    pub lifespan_s: Option<f64>,
    /// A message is promised at least this often.
    pub deadline_s: Option<f64>,
}

/// A name in full, of a node in a namespace.
pub fn full_ros_name(namespace: &str, name: &str) -> String {
    if name.starts_with('/') { name.to_owned() } else { format!("{}/{name}", namespace.trim_end_matches('/')) }
}

impl QosConfig {
    /// How many messages may be kept.
    pub const DEPTHS: RangeInclusive<u8> = 1..=100;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_in_the_namespace_unless_they_begin_with_a_slash() {
        assert_eq!(full_ros_name("/groundplan", "map"), "/groundplan/map");
        assert_eq!(full_ros_name("/", "map"), "/map");
        assert_eq!(full_ros_name("/groundplan", "/map"), "/map");
    }

    #[test]
    fn keys_are_in_the_site_or_in_the_file_that_it_names() {
        let site = RosConfig { enabled: true, options: Some("ros.toml".into()), ..RosConfig::default() };
        let both = site.with_options("frame = \"map\"\n").unwrap();
        assert_eq!((both.enabled, both.frame.as_str(), &both.options), (true, "map", &site.options));
        let twice = RosConfig { in_slam_frame: true, ..site.clone() };
        assert!(twice.with_options("").unwrap_err().to_string().contains("belong here"));
        assert!(site.with_options("enabled = true").unwrap_err().to_string().contains("of the site"));
        assert!(site.with_options("frames = 1").unwrap_err().to_string().contains("frames"));
    }

    #[test]
    fn a_table_without_keys_is_the_default_and_a_wrong_word_is_refused() {
        let read = |text: &str| toml::from_str::<RosConfig>(text);
        assert_eq!(read("").unwrap(), RosConfig::default());
        let config =
            read("outputs = [\"map\"]\n[nav2]\npause = \"lifecycle\"\n[qos.map]\nis_latched = false\n").unwrap();
        assert_eq!(config.outputs, [RosOutput::Map].into());
        assert_eq!(config.nav2.unwrap().pause, Nav2Pause::Lifecycle);
        assert_eq!(config.qos[&RosOutput::Map].is_latched, Some(false));
        for wrong in ["outputs = [\"maps\"]", "[nav2]\npauses = \"goals\"", "service_mapping = \"zenoh\""] {
            assert!(read(wrong).is_err(), "{wrong}");
        }
    }
}
