//! Occupancy grids.

use crate::interface::ros_message;
use crate::msg::builtin_interfaces::Time;
use crate::msg::geometry_msgs::Pose;
use crate::msg::std_msgs::Header;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Size and place of a grid.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct MapMetaData {
    /// When the map was loaded.
    pub map_load_time: Time,
    /// Metres per cell.
    pub resolution: f32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// The lower left corner of the lower left cell.
    pub origin: Pose,
}
ros_message!(
    MapMetaData,
    nav_msgs / msg / MapMetaData,
    "2772d4b2000ef2b35dbaeb80fd3946c1369f817fb4f75677d916d27c17d763c8",
    builtin_interfaces / msg / Time,
    geometry_msgs / msg / Pose,
    geometry_msgs / msg / Point,
    geometry_msgs / msg / Quaternion,
);

/// A grid of cells: -1 unknown, 0 free to 100 occupied.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct OccupancyGrid {
    /// When and in which frame.
    pub header: Header,
    /// Size and place.
    pub info: MapMetaData,
    /// Row-major from the lower left cell.
    pub data: Int8Array,
}
ros_message!(
    OccupancyGrid,
    nav_msgs / msg / OccupancyGrid,
    "8d348150c12913a31ee0ec170fbf25089e4745d17035792a1ba94d6f0bc0cfc7",
    std_msgs / msg / Header,
    builtin_interfaces / msg / Time,
    nav_msgs / msg / MapMetaData,
    geometry_msgs / msg / Pose,
    geometry_msgs / msg / Point,
    geometry_msgs / msg / Quaternion,
);

/// `int8[]`, serialised and read as one run of bytes.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Int8Array(pub Vec<i8>);

impl Serialize for Int8Array {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_bytes(bytemuck::cast_slice(&self.0))
    }
}

impl<'de> Deserialize<'de> for Int8Array {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let bytes: Vec<u8> = serde_bytes::deserialize(deserializer)?;
        Ok(Self(bytes.into_iter().map(u8::cast_signed).collect()))
    }
}
