//! Requests to slam-align.

use crate::config::PoseHint;
use crate::request::{Published, Request};
use bus::Daemon;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Requests to slam-align; the answer is the published alignment.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum AlignRequest {
    /// The robot's map is in this file, as its map server saved it.
    ReadSlamMap {
        /// Absolute path of the description.
        file: PathBuf,
    },
    /// Search the pose of the robot's map now.
    Align {
        /// Near this pose only.
        hint: Option<PoseHint>,
        /// On this map storey only.
        storey: Option<u32>,
    },
    /// The pending pose is right; or, with GlobalIds, these elements are absent although they are planned to be there.
    Confirm {
        /// Elements that the robot saw through; none for the pose.
        absent: Vec<String>,
    },
}

impl Request for AlignRequest {
    const DAEMON: Daemon = Daemon::SlamAlign;
    type Answer = Published;
}
