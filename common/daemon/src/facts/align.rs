//! Facts of slam-align.

use crate::setting::SettingInForce;
use messages::{Alignment, LocalPoses, NONE, PoseValidity};
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
    /// What the pose is worth: `effective`, `waits_for_confirm`, `held`, `refused` or `uncertain`. Only an effective one may be used.
    pub validity: String,
    /// What the pose rests on: `found`, `tracked`, `held` or `none`.
    pub state: String,
    /// Index of the map storey.
    pub storey: Option<u32>,
    /// The pose; `None` for none.
    pub map_from_slam: Option<Pose>,
    /// True if another pose waits for `groundplan confirm`.
    pub is_waiting: bool,
    /// For which part of the SLAM map the pose holds; absent while that is not known.
    #[serde(default)]
    pub holds: Option<PoseHolds>,
}

/// For which part of a SLAM map a pose holds: maps bend.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PoseHolds {
    /// Share of the map's walls for which it holds.
    pub share_of_walls: f64,
    /// Share of its floor.
    pub share_of_floor: f64,
    /// Of the parts of which the place is known: how far the pose puts one from it, at most, in metres.
    pub largest_known_off_m: f64,
    /// Share of the floor of which is not known how far off the pose is.
    pub unknown_share_of_floor: f64,
}

impl PoseHolds {
    /// As local poses say; `None` without any.
    pub fn of(local_poses: Option<LocalPoses<'_>>) -> Option<Self> {
        let head = local_poses?.head;
        Some(Self {
            share_of_walls: head.walls_share,
            share_of_floor: head.area_share,
            largest_known_off_m: head.largest_off_m,
            unknown_share_of_floor: head.unknown_share,
        })
    }
}

impl std::fmt::Display for PoseHolds {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [walls, floor, unknown] =
            [self.share_of_walls, self.share_of_floor, self.unknown_share_of_floor].map(|share| 100.0 * share);
        let off_m = self.largest_known_off_m;
        write!(
            f,
            "it holds for {walls:.0} % of the map's walls and {floor:.0} % of its floor, is known to be off by up to {off_m:.2} m, and not \
             known for {unknown:.0} % of the floor"
        )
    }
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
            holds: PoseHolds::of(alignment.local_poses),
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
        f.write_str(if self.is_waiting { ", another pose waits" } else { "" })?;
        self.holds.map_or(Ok(()), |holds| write!(f, "; {holds}"))
    }
}
