//! Facts of rasterize.

use crate::request::Published;
use crate::robot_file::Robot;
use crate::setting::SettingInForce;
use messages::{ContentHash, DoorCapability, RobotProfile};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Facts of rasterize.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct RasterizeFacts {
    /// The index of grids that is published.
    pub grids: Published,
    /// Its plan time, civil seconds since 1970; `None` if everything is built.
    pub plan_time_s: Option<i64>,
    /// Content hash of the site that it shows.
    pub site_hash: ContentHash,
    /// Epoch of that site's sample.
    pub site_epoch: u64,
    /// Epoch of the sample of the schedule state that it shows.
    pub state_epoch: u64,
    /// Content hash of the schedule state that it shows.
    pub state_hash: ContentHash,
    /// Its storeys.
    pub storeys: usize,
    /// Name of the robot.
    pub robot: String,
    /// Metres per cell.
    pub resolution_m: f64,
    /// Where robot and resolution come from.
    pub settings: Vec<SettingInForce>,
}

/// A robot, for people and programs.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct RobotSummary {
    /// Name of its profile.
    pub name: String,
    /// Height of the body, in metres.
    pub height_m: f64,
    /// Radius of the circle around the body, in metres.
    pub radius_m: f64,
    /// Highest step that it takes, in metres.
    pub step_height_m: f64,
    /// Outline in its frame, in metres; empty for the circle.
    pub footprint_m: Vec<[f64; 2]>,
    /// True if it climbs stairs.
    pub climbs_stairs: bool,
    /// Door operations that it manages.
    pub opens: Vec<String>,
}

impl RobotSummary {
    /// Of a robot.
    pub fn of(robot: &Robot) -> Self {
        let RobotProfile { height_m, radius_m, step_height_m, climbs_stairs, opens, .. } = robot.profile;
        let opened = DoorCapability::ALL.into_iter().filter(|operation| opens & *operation as u32 != 0);
        Self {
            name: robot.name.clone(),
            height_m,
            radius_m,
            step_height_m,
            footprint_m: robot.footprint_m.clone(),
            climbs_stairs: climbs_stairs == 1,
            opens: opened.map(|operation| operation.name().to_owned()).collect(),
        }
    }
}

impl fmt::Display for RobotSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, height_m, radius_m, step_height_m, climbs_stairs, opens, .. } = self;
        let outline = if self.footprint_m.is_empty() { "" } else { " with an outline" };
        let stairs = if *climbs_stairs { "climbs stairs" } else { "climbs no stairs" };
        let doors = if opens.is_empty() { "no doors".to_owned() } else { format!("{} doors", opens.join(", ")) };
        write!(
            f,
            "robot {name}: height {height_m} m, radius {radius_m} m{outline}, steps up to {step_height_m} m, {stairs}, opens {doors}"
        )
    }
}
