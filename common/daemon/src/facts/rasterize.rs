//! Facts of rasterize.

use crate::request::Published;
use serde::{Deserialize, Serialize};

/// Facts of rasterize.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct RasterizeFacts {
    /// The index of grids that is published.
    pub grids: Published,
    /// Its plan time, civil seconds since 1970; `None` if everything is built.
    pub plan_time_s: Option<i64>,
    /// Its storeys.
    pub storeys: usize,
    /// Name of the robot.
    pub robot: String,
    /// Metres per cell.
    pub resolution_m: f64,
}
