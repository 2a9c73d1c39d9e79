//! Carries places from the model into a SLAM map that is bent.

use crate::distortion::DistortionField;
use crate::input::DeviationInput;
use crate::sampled_storey::SampledStorey;
use crate::thresholds::CORRECTED_SHARE;
use frames::{BentMotion, Map, PoseCovariance, Slam, wrapped};
use messages::SlamFrame;
use std::borrow::Cow;

/// The motion from the model's map into the SLAM map: the frame of that map, and the local distortion where surfaces show it.
///
/// The frame itself stays as it was found.
pub struct LocalTransform<'a> {
    frame: &'a SlamFrame,
    motion: Cow<'a, BentMotion<Map, Slam>>,
    field: DistortionField,
}

/// A place and a heading in the SLAM map.
#[derive(Debug, Clone, Copy)]
pub struct SlamPlace {
    /// In metres.
    pub at_m: [f64; 2],
    /// Heading, turned by the frame alone.
    pub yaw_rad: f64,
    /// Of both, in the axes of the SLAM map: errors of the pose and of the local distortion together.
    pub covariance: PoseCovariance,
    /// False if too few surfaces around show the distortion: then this is by the frame, with all of the drift that the map may have
    /// there in its covariance.
    pub is_corrected: bool,
}

impl<'a> LocalTransform<'a> {
    /// From the surfaces of elements that are planned to stand.
    ///
    /// # Panics
    /// If the site has no such map storey, or the schedule state is of another site.
    pub fn of(input: &DeviationInput<'a>) -> Self {
        Self {
            frame: input.slam_frame,
            motion: input.motion(),
            field: SampledStorey::of(input).distortion_field(input),
        }
    }

    /// Where a place of the model's map lies in the SLAM map; `None` where that map folds, so that the place lies nowhere in it.
    pub fn slam_place(&self, in_map_m: [f64; 2], yaw_in_map_rad: f64) -> Option<SlamPlace> {
        let (unseen, local) = (self.field.none(in_map_m), self.field.at(in_map_m, None));
        let is_corrected = local.worst_m() <= CORRECTED_SHARE * unseen.worst_m();
        let distortion = if is_corrected { local } else { unseen };
        let at_m = self.motion.apply_inverse([0, 1].map(|k| in_map_m[k] + distortion.by_m[k]))?;
        let [[xx, xy], [_, yy]] = distortion.covariance.into();
        let by_surfaces =
            PoseCovariance::from_rows([[xx, xy, 0.0], [xy, yy, 0.0], [0.0, 0.0, self.field.turn_variance()]]);
        let by_frame = self.frame.covariance_at(at_m);
        // Where no surfaces tell more, a place is known no better than its part of the map.
        let covariance =
            if is_corrected || by_surfaces.worst_m() > by_frame.worst_m() { by_surfaces } else { by_frame };
        let map_from_slam = self.motion.around(at_m);
        let slam_from_map = map_from_slam.inverse();
        Some(SlamPlace {
            at_m,
            yaw_rad: wrapped(yaw_in_map_rad + slam_from_map.yaw_rad()),
            covariance: covariance.turned(&slam_from_map),
            is_corrected,
        })
    }
}
