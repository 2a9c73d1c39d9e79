//! Requests to rasterize.

use crate::request::{Published, Request};
use bus::Daemon;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Requests to rasterize; the answer is the published index of grids.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum RasterizeRequest {
    /// The robot profile in this file.
    SetRobot {
        /// Absolute path.
        profile: PathBuf,
    },
}

impl Request for RasterizeRequest {
    const DAEMON: Daemon = Daemon::Rasterize;
    type Answer = Published;
}
