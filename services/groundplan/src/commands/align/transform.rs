//! The static transform of an alignment, as a file for robots.

use super::pose_file::PoseFile;
use messages::PoseRecord;

/// Every transform that this program wrote begins so.
const FIRST_WORDS: &str = "# ros2 run tf2_ros static_transform_publisher";

/// The transform of a pose as a file.
pub(super) const TRANSFORM: PoseFile = PoseFile { what: "transform", first_words: FIRST_WORDS };

/// A static transform as ROS writes one: where the model's frame lies in the robot's.
pub(super) fn text(pose: &PoseRecord) -> String {
    let [x_m, y_m, yaw_rad] = pose.map_from_slam().inverse().x_y_yaw();
    let (sin, cos) = libm::sincos(yaw_rad / 2.0);
    format!(
        "{FIRST_WORDS} --x {x_m} --y {y_m} --yaw {yaw_rad} --frame-id map \\\n\
         #   --child-frame-id site_map\n\
         header:\n  frame_id: map\nchild_frame_id: site_map\n\
         transform:\n  translation: {{x: {x_m}, y: {y_m}, z: 0.0}}\n  rotation: {{x: 0.0, y: 0.0, z: {sin}, w: {cos}}}\n"
    )
}
