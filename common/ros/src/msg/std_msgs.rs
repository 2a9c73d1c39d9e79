//! Header, text and colour.

use crate::interface::ros_message;
use crate::msg::builtin_interfaces::Time;
use serde::{Deserialize, Serialize};

/// When and in which frame.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Header {
    /// The instant of the content.
    pub stamp: Time,
    /// The frame of its coordinates.
    pub frame_id: std::string::String,
}
ros_message!(
    Header,
    std_msgs / msg / Header,
    "f49fb3ae2cf070f793645ff749683ac6b06203e41c891e17701b1cb597ce6a01",
    builtin_interfaces / msg / Time,
);

/// A text.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct String {
    /// The text.
    pub data: std::string::String,
}
ros_message!(String, std_msgs / msg / String, "df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18");

/// Red, green, blue and opacity from 0 to 1.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "the fields are those of a colour")]
pub struct ColorRGBA {
    pub r: f32,
    pub g: f32,
    pub b: f32,
    pub a: f32,
}
ros_message!(ColorRGBA, std_msgs / msg / ColorRGBA, "77a7a5b9ae477306097665106e0413ba74440245b1f3d0c6d6405fe5c7813fe8");
