//! Simulated time.

use crate::interface::ros_message;
use crate::msg::builtin_interfaces::Time;
use serde::{Deserialize, Serialize};

/// The simulated time: the type of `/clock`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Clock {
    /// The time.
    pub clock: Time,
}
ros_message!(
    Clock,
    rosgraph_msgs / msg / Clock,
    "692f7a66e93a3c83e71765d033b60349ba68023a8c689a79e48078bcb5c58564",
    builtin_interfaces / msg / Time,
);
