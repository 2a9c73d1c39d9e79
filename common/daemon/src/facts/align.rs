//! Facts of slam-align.

use crate::setting::SettingInForce;
use messages::{Alignment, NONE, PoseValidity};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Facts of slam-align.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct AlignFacts {
    /// The alignment that is published; `None` while there is no map of the robot.
    pub alignment: Option<AlignmentSummary>,
    /// Where the map of a file comes from; `None` while there is none.
    pub setting: Option<SettingInForce>,
}

/// A turn and a shift in the plane.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Pose {
    /// Metres.
    pub x_m: f64,
    /// Metres.
    pub y_m: f64,
    /// Radians.
    pub yaw_rad: f64,
}

impl Pose {
    /// From metres, metres and radians.
    pub fn of([x_m, y_m, yaw_rad]: [f64; 3]) -> Self {
        Self { x_m, y_m, yaw_rad }
    }
}

/// An alignment in a line.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct AlignmentSummary {
    /// Epoch of its sample.
    pub epoch: u64,
    /// Verdict on the newest search.
    pub verdict: String,
    /// What the pose is worth: `effective`, `waits_for_confirm`, `held` or `refused`. Only an effective one may be used.
    pub validity: String,
    /// What the pose rests on: `found`, `tracked`, `held` or `none`.
    pub state: String,
    /// Index of the map storey.
    pub storey: Option<u32>,
    /// The pose; `None` for none.
    pub map_from_slam: Option<Pose>,
    /// True if another pose waits for `groundplan confirm`.
    pub is_waiting: bool,
}

impl AlignmentSummary {
    /// Of an alignment and the epoch of its sample.
    pub fn of(epoch: u64, alignment: &Alignment<'_>) -> Self {
        let pose = alignment.pose();
        Self {
            epoch,
            verdict: alignment.verdict().name().to_owned(),
            validity: alignment.validity().name().to_owned(),
            state: alignment.state().name().to_owned(),
            storey: pose.map(|pose| pose.map_storey).filter(|storey| *storey != NONE),
            map_from_slam: pose.map(|pose| Pose::of(pose.map_from_slam)),
            is_waiting: alignment.waiting().is_some(),
        }
    }

    /// True if the pose may be used.
    pub fn is_effective(&self) -> bool {
        self.validity == PoseValidity::Effective.name()
    }
}

impl std::fmt::Display for AlignmentSummary {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { epoch, verdict, .. } = self;
        let validity = self.validity.replace('_', " ");
        match (self.storey, self.map_from_slam) {
            (Some(storey), Some(Pose { x_m, y_m, yaw_rad })) => {
                let degrees = yaw_rad.to_degrees();
                write!(
                    f,
                    "SLAM map on storey {storey} at x {x_m:.2} m, y {y_m:.2} m, yaw {degrees:.2} degrees, {validity}, epoch {epoch}"
                )
            }
            _ => write!(f, "SLAM map {verdict}, no pose, epoch {epoch}"),
        }?;
        f.write_str(if self.is_waiting { ", another pose waits" } else { "" })
    }
}
