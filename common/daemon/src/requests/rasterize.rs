//! Requests to rasterize.

use crate::facts::RobotSummary;
use crate::file_text::FileText;
use crate::request::{Published, Request};
use crate::setting::SettingInForce;
use bus::Daemon;
use serde::{Deserialize, Serialize};

/// Requests to rasterize.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum RasterizeRequest {
    /// The robot of this profile.
    SetRobot {
        /// Its content, which the client has read.
        profile: FileText,
    },
}

/// Answer of rasterize: what is in force.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RasterizeAnswer {
    /// The index of grids that it published.
    pub grids: Published,
    /// The robot.
    pub robot: RobotSummary,
    /// Metres per cell.
    pub resolution_m: f64,
    /// Where the robot comes from.
    pub setting: SettingInForce,
}

impl Request for RasterizeRequest {
    const DAEMON: Daemon = Daemon::Rasterize;
    type Answer = RasterizeAnswer;

    fn may_be_sent_twice(&self) -> bool {
        true
    }
}
