//! Compressed images.

use crate::interface::ros_message;
use crate::msg::std_msgs::Header;
use serde::{Deserialize, Serialize};

/// An image in a file format.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct CompressedImage {
    /// When and in which frame.
    pub header: Header,
    /// `jpeg`, `png` ..
    pub format: String,
    /// The file.
    #[serde(with = "serde_bytes")]
    pub data: Vec<u8>,
}
ros_message!(
    CompressedImage,
    sensor_msgs / msg / CompressedImage,
    "15640771531571185e2efc8a100baf923961a4d15d5569652e6cb6691e8e371a",
    std_msgs / msg / Header,
    builtin_interfaces / msg / Time,
);
