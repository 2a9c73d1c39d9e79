//! Carries places from the model into a SLAM map that is bent.

use crate::distortion::DistortionField;
use crate::input::DeviationInput;
use crate::sampled_storey::SampledStorey;
use crate::thresholds::CORRECTED_SHARE;
use frames::{Map, PoseCovariance, Rigid2, Slam, wrapped};

/// The motion from the model's map into the SLAM map: the rigid pose, and the local distortion where surfaces show it.
///
/// The pose itself stays as it was found.
pub struct LocalTransform {
    slam_from_map: Rigid2<Slam, Map>,
    field: DistortionField,
}

/// A place and a heading in the SLAM map.
#[derive(Debug, Clone, Copy)]
pub struct SlamPlace {
    /// In metres.
    pub at_m: [f64; 2],
    /// Heading, turned by the rigid pose alone.
    pub yaw_rad: f64,
    /// Of both, in the axes of the SLAM map: errors of the pose and of the local distortion together.
    pub covariance: PoseCovariance,
    /// False if too few surfaces around show the distortion: then this is the rigid pose, with all of the drift that the map
    /// may have in its covariance.
    pub is_corrected: bool,
}

impl LocalTransform {
    /// From the surfaces of elements that are planned to stand.
    ///
    /// # Panics
    /// If the site has no such map storey, or the schedule state is of another site.
    pub fn of(input: &DeviationInput<'_>) -> Self {
        Self { slam_from_map: input.map_from_slam.inverse(), field: SampledStorey::of(input).distortion_field(input) }
    }

    /// Where a place of the model's map lies in the SLAM map.
    pub fn slam_place(&self, in_map_m: [f64; 2], yaw_in_map_rad: f64) -> SlamPlace {
        let (rigid, local) = (self.field.none(in_map_m), self.field.at(in_map_m, None));
        let is_corrected = local.worst_m() <= CORRECTED_SHARE * rigid.worst_m();
        let distortion = if is_corrected { local } else { rigid };
        let at_m = [0, 1].map(|k| in_map_m[k] + distortion.by_m[k]);
        let [[xx, xy], [_, yy]] = distortion.covariance.into();
        let covariance =
            PoseCovariance::from_rows([[xx, xy, 0.0], [xy, yy, 0.0], [0.0, 0.0, self.field.turn_variance()]]);
        SlamPlace {
            at_m: self.slam_from_map.apply(at_m),
            yaw_rad: wrapped(yaw_in_map_rad + self.slam_from_map.yaw_rad()),
            covariance: covariance.turned(&self.slam_from_map),
            is_corrected,
        }
    }
}
