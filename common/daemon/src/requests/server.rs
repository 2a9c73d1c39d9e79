//! Requests to site-server and site-follow.

use crate::file_text::FileText;
use crate::request::Request;
use bus::Daemon;
use serde::{Deserialize, Serialize};

/// Requests to site-server: there are none.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum ServeRequest {}

/// Requests to site-follow. What it shows is decided by the server of the site.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum FollowRequest {
    /// Progress that the robot observed, a table as for [`crate::ScheduleRequest::SetActuals`]: it is kept, and told to the server.
    SetObserved {
        /// The table.
        table: FileText,
    },
}

impl Request for ServeRequest {
    const DAEMON: Daemon = Daemon::SiteServer;
    type Answer = ();

    fn may_be_sent_twice(&self) -> bool {
        match *self {}
    }
}

impl Request for FollowRequest {
    const DAEMON: Daemon = Daemon::SiteFollow;
    type Answer = ();

    fn may_be_sent_twice(&self) -> bool {
        match self {
            Self::SetObserved { .. } => true,
        }
    }
}
