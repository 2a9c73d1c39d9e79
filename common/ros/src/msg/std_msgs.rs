//! Header, text, colour, and arrays of several dimensions.

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

/// One dimension of an array.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct MultiArrayDimension {
    /// Its name.
    pub label: std::string::String,
    /// Items along it.
    pub size: u32,
    /// Values in one step of the dimension before it; of the first one all that there are.
    pub stride: u32,
}
ros_message!(
    MultiArrayDimension,
    std_msgs / msg / MultiArrayDimension,
    "5e773a60a4c7fc8a54985f307c7837aa2994252a126c301957a24e31282c9cbe"
);

/// How the values of an array lie.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct MultiArrayLayout {
    /// The dimensions, the slowest first.
    pub dim: Vec<MultiArrayDimension>,
    /// Values before the first one.
    pub data_offset: u32,
}
ros_message!(
    MultiArrayLayout,
    std_msgs / msg / MultiArrayLayout,
    "4c66e6f78e740ac103a94cf63259f968e48c617e7699e829b63c21a5cb50dac6",
    std_msgs / msg / MultiArrayDimension,
);

/// An array of numbers.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Float32MultiArray {
    /// How they lie.
    pub layout: MultiArrayLayout,
    /// The numbers.
    pub data: Vec<f32>,
}
ros_message!(
    Float32MultiArray,
    std_msgs / msg / Float32MultiArray,
    "0599f6f85b4bfca379873a0b4375a0aca022156bd2d7021275d116ed1fa8bfe0",
    std_msgs / msg / MultiArrayLayout,
    std_msgs / msg / MultiArrayDimension,
);
