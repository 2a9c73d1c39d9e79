//! `deviations.json`, as far as it is written back.

use serde::Deserialize;
use std::collections::BTreeMap;

/// What a robot saw of a storey.
#[derive(Debug, Clone, Deserialize)]
pub(super) struct ComparedStorey {
    pub(super) plan_time: Option<String>,
    pub(super) storey: u32,
    pub(super) lidar_z_m: f64,
    pub(super) slam_map_hash: String,
    /// By GlobalId.
    pub(super) elements: BTreeMap<String, ComparedElement>,
    pub(super) obstacles: Vec<ComparedObstacle>,
}

/// What it saw of an element.
#[derive(Debug, Clone, Deserialize)]
pub(super) struct ComparedElement {
    pub(super) observation: String,
    #[serde(rename = "judgement")]
    pub(super) verdict: String,
    pub(super) displacement_m: Option<[f64; 2]>,
    pub(super) deviation_m: f64,
    pub(super) absent_parts: Vec<AbsentStretch>,
}

/// A stretch of an element that is absent.
#[derive(Debug, Clone, Deserialize)]
pub(super) struct AbsentStretch {
    #[serde(rename = "judgement")]
    pub(super) verdict: String,
    pub(super) from_m: f64,
    pub(super) to_m: f64,
}

/// What is no element of the model.
#[derive(Debug, Clone, Deserialize)]
pub(super) struct ComparedObstacle {
    pub(super) area_m2: f64,
    pub(super) polygon_m: Vec<Vec<[f64; 2]>>,
}
