//! Requests to groundplan-ask.

use crate::request::Request;
use bus::Daemon;
use serde::{Deserialize, Serialize};

/// Requests to groundplan-ask over the bus: there are none.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum AskRequest {}

impl Request for AskRequest {
    const DAEMON: Daemon = Daemon::Ask;
    type Answer = ();

    fn may_be_sent_twice(&self) -> bool {
        match *self {}
    }
}
