//! The service type Trigger.

use crate::interface::ros_message;
use serde::{Deserialize, Serialize};

/// Request of `std_srvs/srv/Trigger`: nothing, in one byte.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct TriggerRequest {
    /// Zero: types of DDS have a member.
    pub structure_needs_at_least_one_member: u8,
}
ros_message!(
    TriggerRequest,
    std_srvs / srv / Trigger_Request,
    "d010825374ce8918e72bfd826c82603e60f45419e932ea976f807b74a863a199"
);

/// Response of `std_srvs/srv/Trigger`.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct TriggerResponse {
    /// True if it was done.
    pub success: bool,
    /// What was done, or why not.
    pub message: String,
}
ros_message!(
    TriggerResponse,
    std_srvs / srv / Trigger_Response,
    "2d946c21e2fc3f1e9ca6986a8191d85fcc70097a8bb7771a053564bc47009cdf"
);
