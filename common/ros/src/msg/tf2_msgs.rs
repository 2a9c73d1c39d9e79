//! Transforms between frames.

use crate::interface::ros_message;
use crate::msg::geometry_msgs::TransformStamped;
use serde::{Deserialize, Serialize};

/// Several transforms: the type of `/tf` and `/tf_static`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct TFMessage {
    /// The transforms.
    pub transforms: Vec<TransformStamped>,
}
ros_message!(
    TFMessage,
    tf2_msgs / msg / TFMessage,
    "e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087",
    geometry_msgs / msg / TransformStamped,
    std_msgs / msg / Header,
    builtin_interfaces / msg / Time,
    geometry_msgs / msg / Transform,
    geometry_msgs / msg / Vector3,
    geometry_msgs / msg / Quaternion,
);
