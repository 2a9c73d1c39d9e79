//! Masks of Nav2's costmap filters.

use crate::interface::ros_message;
use crate::msg::std_msgs::Header;
use serde::{Deserialize, Serialize};

/// What a mask means to a costmap filter: the value of a cell is `base + multiplier * data`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct CostmapFilterInfo {
    /// When and in which frame.
    pub header: Header,
    /// Kind of the mask: [`Self::KEEPOUT`], [`Self::SPEED_ABSOLUTE`] and others.
    pub r#type: u8,
    /// Topic of the mask.
    pub filter_mask_topic: String,
    /// Value of a cell whose data is 0.
    pub base: f32,
    /// How much the value grows with the data.
    pub multiplier: f32,
}
ros_message!(
    CostmapFilterInfo,
    nav2_msgs / msg / CostmapFilterInfo,
    "61ce391bf7690f76a331c01c9d5ce8ca71e6c99273b9fb75e48380f05c6dfdc8",
    std_msgs / msg / Header,
    builtin_interfaces / msg / Time,
);

impl CostmapFilterInfo {
    /// Keep-out zones and preferred lanes.
    pub const KEEPOUT: u8 = 0;
    /// Limits of speed in metres per second.
    pub const SPEED_ABSOLUTE: u8 = 2;
}
