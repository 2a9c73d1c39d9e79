//! Requests to groundplan-web.

use crate::request::Request;
use bus::Daemon;
use serde::{Deserialize, Serialize};

/// Requests to groundplan-web: there are none.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum WebRequest {}

impl Request for WebRequest {
    const DAEMON: Daemon = Daemon::Web;
    type Answer = ();

    fn may_be_sent_twice(&self) -> bool {
        match *self {}
    }
}
