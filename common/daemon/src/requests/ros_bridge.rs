//! Requests of ros-bridge.

use crate::request::Request;
use bus::Daemon;
use serde::{Deserialize, Serialize};

/// It has none: what it does is told by its inputs.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum RosBridgeRequest {}

impl Request for RosBridgeRequest {
    const DAEMON: Daemon = Daemon::RosBridge;
    type Answer = ();
}
