//! Requests to ifc-ingest.

use crate::request::{Published, Request};
use bus::Daemon;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Requests to ifc-ingest; the answer is the published site.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum IngestRequest {
    /// Read these files as the site; without any, read those again that are loaded.
    Load {
        /// Absolute paths.
        models: Vec<PathBuf>,
    },
}

impl Request for IngestRequest {
    const DAEMON: Daemon = Daemon::IfcIngest;
    type Answer = Published;
}
