//! The robot as `/tf` shows it.

use crate::graph::RosGraph;
use crate::robot_pose::TransformTree;
use daemon::facts::Pose;
use daemon::{Failure, RosConfig};
use messages::PoseRecord;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Follows the robot's pose in its own map.
pub(crate) struct Robot {
    transforms: Arc<Mutex<TransformTree>>,
    slam_frame: String,
    robot_frame: String,
}

impl Robot {
    /// Takes transforms from now on.
    ///
    /// # Errors
    /// Topics that cannot be opened.
    pub(crate) fn follow(graph: &mut RosGraph, config: &RosConfig) -> Result<Self, Failure> {
        let transforms = Arc::new(Mutex::new(TransformTree::default()));
        let taken = Arc::clone(&transforms);
        graph.take_transforms(move |message| {
            taken.lock().unwrap_or_else(PoisonError::into_inner).take(message, Instant::now());
        })?;
        Ok(Self { transforms, slam_frame: config.slam_frame.clone(), robot_frame: config.robot_frame.clone() })
    }

    /// Its pose in the model's map, by the pose of its own map.
    pub(crate) fn pose_in_map(&self, of_slam_map: &PoseRecord) -> Option<Pose> {
        let (map_from_slam, robot) = (of_slam_map.map_from_slam(), self.pose()?);
        let [x_m, y_m] = map_from_slam.apply([robot.x_m, robot.y_m]);
        Some(Pose { x_m, y_m, yaw_rad: frames::wrapped(robot.yaw_rad + map_from_slam.yaw_rad()) })
    }

    /// Its pose in the SLAM map now; `None` if nobody tells it.
    pub(crate) fn pose(&self) -> Option<Pose> {
        let transforms = self.transforms.lock().unwrap_or_else(PoisonError::into_inner);
        transforms.pose(&self.slam_frame, &self.robot_frame, Instant::now())
    }

    /// How long ago the transform of the robot's own frame came.
    pub(crate) fn seen_ago(&self) -> Option<Duration> {
        let transforms = self.transforms.lock().unwrap_or_else(PoisonError::into_inner);
        transforms.age(&self.robot_frame, Instant::now())
    }
}
