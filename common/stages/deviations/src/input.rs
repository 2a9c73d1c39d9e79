//! Inputs of the comparison: site, schedule state and an aligned SLAM map.

use frames::{Map, PoseCovariance, Rigid2, Slam};
use messages::{RobotProfile, ScheduleState, Site};
use occupancy::OccupancyMap;

/// Inputs of the comparison.
#[derive(Debug, Clone, Copy)]
pub struct DeviationInput<'a> {
    /// Geometry and attributes.
    pub site: &'a Site<'a>,
    /// States at the plan time, of this site.
    pub schedule_state: &'a ScheduleState<'a>,
    /// The height of its lidar counts.
    pub robot: &'a RobotProfile,
    /// Map storey of the site.
    pub map_storey: usize,
    /// The SLAM map.
    pub slam: &'a OccupancyMap,
    /// Hash of that map, for the record.
    pub slam_map_hash: u64,
    /// Its pose in the map of the model.
    pub map_from_slam: Rigid2<Map, Slam>,
    /// A place in the SLAM map, in metres.
    pub about_m: [f64; 2],
    /// Of where that place lies in the model's map and of yaw.
    pub covariance: PoseCovariance,
}
