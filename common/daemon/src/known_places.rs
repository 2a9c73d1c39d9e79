//! Places of a robot that operators name: rooms of points of its map, the height of its floor, the portal it took last.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Places by which poses of a SLAM map are excluded.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct KnownPlaces {
    /// Points of the SLAM map, each with its room.
    pub rooms: Vec<PointInRoom>,
    /// Height of the floor under the robot in the model's map, in metres.
    pub elevation_m: Option<f64>,
    /// Stair, ramp or lift that the robot took last, by name or GlobalId.
    pub portal: Option<String>,
}

/// A point of the SLAM map that lies in a room.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PointInRoom {
    /// Metres, in the frame of the SLAM map.
    pub x_m: f64,
    /// Metres.
    pub y_m: f64,
    /// Number, name or GlobalId of the room.
    pub room: String,
}

impl PointInRoom {
    /// The room in which the SLAM map began.
    pub fn start(room: impl Into<String>) -> Self {
        Self { x_m: 0.0, y_m: 0.0, room: room.into() }
    }
}

impl KnownPlaces {
    /// True if nothing is known.
    pub fn is_empty(&self) -> bool {
        self == &Self::default()
    }

    /// The points, with the names of their rooms.
    pub fn points_in_rooms(&self) -> impl Iterator<Item = ([f64; 2], &str)> {
        self.rooms.iter().map(|point| ([point.x_m, point.y_m], point.room.as_str()))
    }
}
