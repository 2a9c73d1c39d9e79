//! Names of topics and frames.

use messages::Site;

/// The namespace of all topics but `/tf_static`.
pub const NAMESPACE: &str = "/groundplan";
/// Transforms that do not change.
pub const TF_STATIC: &str = "/tf_static";

/// Topics of a map storey, in full.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StoreyTopics {
    /// The planning map: `nav_msgs/OccupancyGrid`.
    pub map: String,
    /// The localization map: `nav_msgs/OccupancyGrid`.
    pub localization_map: String,
    /// The keep-out mask: `nav_msgs/OccupancyGrid`.
    pub keepout_mask: String,
    /// What the mask means: `nav2_msgs/CostmapFilterInfo`.
    pub keepout_info: String,
    /// The mask of limits of speed, where it is wanted: `nav_msgs/OccupancyGrid`.
    pub speed_mask: String,
    /// What that mask means: `nav2_msgs/CostmapFilterInfo`.
    pub speed_info: String,
    /// Heights, slopes and traversability, where they are wanted: `grid_map_msgs/GridMap`.
    pub grid_map: String,
    /// The same for Foxglove: `foxglove_msgs/Grid`.
    pub elevation: String,
    /// Rooms, doors and drop-offs: `visualization_msgs/MarkerArray`.
    pub rooms: String,
    /// Waypoints: `visualization_msgs/MarkerArray`.
    pub waypoints: String,
    /// The route graph: `visualization_msgs/MarkerArray`.
    pub route: String,
}

impl StoreyTopics {
    /// The topics below a namespace, e.g. `/groundplan` or `/groundplan/storey_00_ground_floor`.
    pub fn below(namespace: &str) -> Self {
        let topic = |name: &str| format!("{namespace}/{name}");
        Self {
            map: topic("map"),
            localization_map: topic("localization_map"),
            keepout_mask: topic("keepout_mask"),
            keepout_info: topic("keepout_info"),
            speed_mask: topic("speed_mask"),
            speed_info: topic("speed_info"),
            grid_map: topic("grid_map"),
            elevation: topic("elevation"),
            rooms: topic("rooms"),
            waypoints: topic("waypoints"),
            route: topic("route"),
        }
    }
}

/// Name of a map storey as a part of a topic and as a frame, e.g. `storey_00_ground_floor`: what its folder in an output is
/// called, in the letters that names of ROS may have.
///
/// # Panics
/// If the site has no such map storey.
pub fn storey_name(site: &Site<'_>, map_storey: u32) -> String {
    let folder = export::storey_folder(site, map_storey, &site.map_storeys[map_storey as usize]);
    let name = folder.rsplit('/').next().unwrap_or_default();
    format!("storey_{}", name.replace('-', "_"))
}
