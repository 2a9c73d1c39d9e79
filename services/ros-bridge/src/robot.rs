//! The robot as `/tf` shows it.

use crate::graph::RosGraph;
use crate::robot_pose::TransformTree;
use daemon::facts::Pose;
use daemon::{Failure, RosConfig};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

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

    /// Its pose in the SLAM map now; `None` if nobody tells it.
    pub(crate) fn pose(&self) -> Option<Pose> {
        let transforms = self.transforms.lock().unwrap_or_else(PoisonError::into_inner);
        transforms.pose(&self.slam_frame, &self.robot_frame, Instant::now())
    }
}
