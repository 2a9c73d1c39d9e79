//! Grids whose cells have several fields, as Foxglove draws them.
//!
//! The types are those of `foxglove_msgs` 3.0, which recordings and the server for Foxglove carry with them; later versions add fields.

use crate::interface::ros_message;
use crate::msg::builtin_interfaces::Time;
use crate::msg::geometry_msgs::Pose;
use serde::{Deserialize, Serialize};

/// Two lengths.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "the fields are those of a vector")]
pub struct Vector2 {
    pub x: f64,
    pub y: f64,
}
ros_message!(
    Vector2,
    foxglove_msgs / msg / Vector2,
    "79e1a1b0db092d52b0de4251d5aa394a99d7bf4bcb479e70331eb1ba0b07796b"
);

/// A field that each cell has.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct PackedElementField {
    /// Its name.
    pub name: String,
    /// Bytes of a cell before it.
    pub offset: u32,
    /// Kind of its number: [`Self::FLOAT32`] and others.
    pub r#type: u8,
}
ros_message!(
    PackedElementField,
    foxglove_msgs / msg / PackedElementField,
    "465d110563897e22946a468848a8c48e55eaa77fa207c4eec9c025a6609610b0"
);

impl PackedElementField {
    /// A number of 32 bits with a point, the lowest byte first.
    pub const FLOAT32: u8 = 7;
}

/// A grid in the plane of its pose.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Grid {
    /// The instant of the content.
    pub timestamp: Time,
    /// The frame of its coordinates.
    pub frame_id: String,
    /// The lower left corner of the lower left cell.
    pub pose: Pose,
    /// Cells in a row.
    pub column_count: u32,
    /// Metres of a cell along x and y.
    pub cell_size: Vector2,
    /// Bytes from a row to the next.
    pub row_stride: u32,
    /// Bytes from a cell to the next.
    pub cell_stride: u32,
    /// What each cell has.
    pub fields: Vec<PackedElementField>,
    /// The cells, row-major from the lower left.
    #[serde(with = "serde_bytes")]
    pub data: Vec<u8>,
}
ros_message!(
    Grid,
    foxglove_msgs / msg / Grid,
    "b0c6070e6d466742a149b77eda9ef066c31128f29858419125455d0943b0f867",
    builtin_interfaces / msg / Time,
    geometry_msgs / msg / Pose,
    geometry_msgs / msg / Point,
    geometry_msgs / msg / Quaternion,
    foxglove_msgs / msg / Vector2,
    foxglove_msgs / msg / PackedElementField,
);
