//! Points, poses and transforms.

use crate::interface::ros_message;
use crate::msg::std_msgs::Header;
use frames::Attitude;
use serde::{Deserialize, Serialize};

/// A point in metres.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "the fields are coordinates")]
pub struct Point {
    pub x: f64,
    pub y: f64,
    pub z: f64,
}
ros_message!(Point, geometry_msgs / msg / Point, "6963084842a9b04494d6b2941d11444708d892da2f4b09843b9c43f42a7f6881");

/// A direction, a shift or a size.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "the fields are coordinates")]
pub struct Vector3 {
    pub x: f64,
    pub y: f64,
    pub z: f64,
}
ros_message!(
    Vector3,
    geometry_msgs / msg / Vector3,
    "cc12fe83e4c02719f1ce8070bfd14aecd40f75a96696a67a2a1f37f7dbb0765d"
);

/// A rotation as a unit quaternion; no rotation unless another is given.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "the fields are coordinates")]
pub struct Quaternion {
    pub x: f64,
    pub y: f64,
    pub z: f64,
    pub w: f64,
}
ros_message!(
    Quaternion,
    geometry_msgs / msg / Quaternion,
    "8a765f66778c8ff7c8ab94afcc590a2ed5325a1d9a076ffff38fbce36f458684"
);

impl Default for Quaternion {
    fn default() -> Self {
        Self { x: 0.0, y: 0.0, z: 0.0, w: 1.0 }
    }
}

impl Quaternion {
    /// The rotation about Z.
    pub fn of_yaw_rad(yaw_rad: f64) -> Self {
        let (sin, cos) = libm::sincos(yaw_rad / 2.0);
        Self { z: sin, w: cos, ..Self::default() }
    }

    /// The orientation of a robot.
    pub fn of_attitude(attitude: &Attitude) -> Self {
        let [x, y, z, w] = attitude.quaternion();
        Self { x, y, z, w }
    }
}

/// Position and orientation.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// Where it is.
    pub position: Point,
    /// How it is turned.
    pub orientation: Quaternion,
}
ros_message!(
    Pose,
    geometry_msgs / msg / Pose,
    "d501954e9476cea2996984e812054b68026ae0bfae789d9a10b23daf35cc90fa",
    geometry_msgs / msg / Point,
    geometry_msgs / msg / Quaternion,
);

/// A pose in a frame at an instant.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct PoseStamped {
    /// When and in which frame.
    pub header: Header,
    /// The pose.
    pub pose: Pose,
}
ros_message!(
    PoseStamped,
    geometry_msgs / msg / PoseStamped,
    "10f3786d7d40fd2b54367835614bff85d4ad3b5dab62bf8bca0cc232d73b4cd8",
    std_msgs / msg / Header,
    builtin_interfaces / msg / Time,
    geometry_msgs / msg / Pose,
    geometry_msgs / msg / Point,
    geometry_msgs / msg / Quaternion,
);

/// A pose and how uncertain it is.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct PoseWithCovariance {
    /// The pose.
    pub pose: Pose,
    /// Covariance of x, y, z and the rotations about X, Y and Z, row by row: `float64[36]`.
    pub covariance: [[f64; 6]; 6],
}
ros_message!(
    PoseWithCovariance,
    geometry_msgs / msg / PoseWithCovariance,
    "9a7c0fd234b7f45c6098745ecccd773ca1085670e64107135397aee31c02e1bb",
    geometry_msgs / msg / Pose,
    geometry_msgs / msg / Point,
    geometry_msgs / msg / Quaternion,
);

/// A pose with its covariance in a frame at an instant.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct PoseWithCovarianceStamped {
    /// When and in which frame.
    pub header: Header,
    /// The pose.
    pub pose: PoseWithCovariance,
}
ros_message!(
    PoseWithCovarianceStamped,
    geometry_msgs / msg / PoseWithCovarianceStamped,
    "26432f9803e43727d3c8f668d1fdb3c630f548af631e2f4e31382371bfea3b6e",
    std_msgs / msg / Header,
    builtin_interfaces / msg / Time,
    geometry_msgs / msg / PoseWithCovariance,
    geometry_msgs / msg / Pose,
    geometry_msgs / msg / Point,
    geometry_msgs / msg / Quaternion,
);

/// A rigid motion: the rotation first, then the shift.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Transform {
    /// The shift.
    pub translation: Vector3,
    /// The rotation.
    pub rotation: Quaternion,
}
ros_message!(
    Transform,
    geometry_msgs / msg / Transform,
    "beb83fbe698636351461f6f35d1abb20010c43d55374d81bd041f1ba2581fddc",
    geometry_msgs / msg / Vector3,
    geometry_msgs / msg / Quaternion,
);

/// The motion from coordinates in `child_frame_id` to coordinates in the frame of the header.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct TransformStamped {
    /// When, and the parent frame.
    pub header: Header,
    /// The frame that lies in the parent.
    pub child_frame_id: String,
    /// How it lies there.
    pub transform: Transform,
}
ros_message!(
    TransformStamped,
    geometry_msgs / msg / TransformStamped,
    "0a241f87d04668d94099cbb5ba11691d5ad32c2f29682e4eb5653424bd275206",
    std_msgs / msg / Header,
    builtin_interfaces / msg / Time,
    geometry_msgs / msg / Transform,
    geometry_msgs / msg / Vector3,
    geometry_msgs / msg / Quaternion,
);
