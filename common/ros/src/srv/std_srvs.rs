//! Services without arguments.

pub use crate::msg::std_srvs::{TriggerRequest, TriggerResponse};

use super::ros_service;

ros_service! {
    /// Asks for something to be done.
    Trigger: std_srvs, TriggerRequest => TriggerResponse
}
