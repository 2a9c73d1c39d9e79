//! Diagnostics of programs and devices.

use crate::interface::ros_message;
use crate::msg::std_msgs::Header;
use serde::{Deserialize, Serialize};

/// A named value.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct KeyValue {
    /// Its name.
    pub key: String,
    /// The value as text.
    pub value: String,
}
ros_message!(
    KeyValue,
    diagnostic_msgs / msg / KeyValue,
    "d68081eaa540288c5440753baecef0c4e16e81a5f78ad68902ded5100413bb42"
);

/// How a part of a robot is.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct DiagnosticStatus {
    /// [`Self::OK`] to [`Self::STALE`].
    pub level: u8,
    /// The part.
    pub name: String,
    /// How it is, in words.
    pub message: String,
    /// The device.
    pub hardware_id: String,
    /// Values beside.
    pub values: Vec<KeyValue>,
}
ros_message!(
    DiagnosticStatus,
    diagnostic_msgs / msg / DiagnosticStatus,
    "b0e3e692ea2d54a8af2f4ef1930e81556a2db55216b771f8a7d2724ed47bf0e4",
    diagnostic_msgs / msg / KeyValue,
);

#[expect(missing_docs, reason = "the constants are those of the interface definition")]
impl DiagnosticStatus {
    pub const OK: u8 = 0;
    pub const WARN: u8 = 1;
    pub const ERROR: u8 = 2;
    pub const STALE: u8 = 3;
}

/// How several parts are.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct DiagnosticArray {
    /// When.
    pub header: Header,
    /// The parts.
    pub status: Vec<DiagnosticStatus>,
}
ros_message!(
    DiagnosticArray,
    diagnostic_msgs / msg / DiagnosticArray,
    "5a8a36efb05fb25070fa0fb3810290c0e6cd4862b54a8fb975a1ee8dc55a333e",
    std_msgs / msg / Header,
    builtin_interfaces / msg / Time,
    diagnostic_msgs / msg / DiagnosticStatus,
    diagnostic_msgs / msg / KeyValue,
);
