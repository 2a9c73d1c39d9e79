//! Inputs of the comparison: site, schedule state and an aligned SLAM map.

use crate::thresholds::BENT_M;
use frames::{BentMotion, Map, PoseCovariance, Slam};
use messages::{ContentHash, RobotProfile, ScheduleState, Site, SlamFrame};
use occupancy::OccupancyMap;
use std::borrow::Cow;

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
    pub slam_map_hash: ContentHash,
    /// Where that map lies in the map of the model, from place to place. Of parts of it of which that is not known well enough nothing
    /// is said.
    pub slam_frame: &'a SlamFrame,
    /// A place in the SLAM map, in metres.
    pub about_m: [f64; 2],
    /// Of where that place lies in the model's map and of yaw.
    pub covariance: PoseCovariance,
}

impl<'a> DeviationInput<'a> {
    /// True if the SLAM map bends by more than what is found as drift beside one pose.
    pub(crate) fn is_bent(&self) -> bool {
        self.slam_frame.largest_bend_m() > BENT_M
    }

    /// From the SLAM map into the model's: as its frame bends, or by one pose if that is enough.
    pub(crate) fn motion(&self) -> Cow<'a, BentMotion<Map, Slam>> {
        match self.is_bent() {
            true => Cow::Borrowed(&self.slam_frame.motion),
            false => Cow::Owned(BentMotion::rigid(self.slam_frame.map_from_slam())),
        }
    }
}
