//! Requests to ros-bridge.

use crate::request::Request;
use bus::Daemon;
use serde::{Deserialize, Serialize};

/// Requests to ros-bridge.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum RosBridgeRequest {
    /// The robot is on this map storey: all outputs change to it.
    SetStorey {
        /// Its index; that of configuration or alignment if left out.
        storey: Option<u32>,
    },
}

impl Request for RosBridgeRequest {
    const DAEMON: Daemon = Daemon::RosBridge;
    type Answer = ();

    fn may_be_sent_twice(&self) -> bool {
        true
    }
}
