//! A storey of the model and the SLAM map beside each other, with the surfaces found at the sides of elements.

use crate::distortion::DistortionField;
use crate::input::DeviationInput;
use crate::sections::{LidarKind, Sections};
use crate::side_samples::{Sample, open_samples};
use crate::slam_view::{Probe, SlamView};
use crate::surface_pieces::SurfaceOffset;
use crate::thresholds::{BENT_DRIFT_M, SAME_SIDE_M};
use crate::wall_bodies::WallBodies;
use rayon::prelude::*;

/// Margin around a storey within which the SLAM map is looked at: probes reach less far.
const AROUND_M: f64 = 3.0;

/// The storey and the SLAM map beside each other.
pub(crate) struct SampledStorey<'a> {
    pub(crate) slam: SlamView<'a>,
    pub(crate) sections: Sections,
    pub(crate) bodies: WallBodies,
    /// By cut.
    pub(crate) samples: Vec<Vec<Sample>>,
}

impl<'a> SampledStorey<'a> {
    /// Samples on all sides, before anything is compared.
    pub(crate) fn of(input: &DeviationInput<'a>) -> Self {
        let [x0, y0, x1, y1] = input.site.map_storeys[input.map_storey].bounds_tenths.map(frames::metres);
        let bounds_m = [[x0 - AROUND_M, y0 - AROUND_M], [x1 + AROUND_M, y1 + AROUND_M]];
        let slam = SlamView::of(input, bounds_m);
        let sections = Sections::of(input.site, input.schedule_state, input.robot, input.map_storey);
        let bodies = WallBodies::of(&sections);
        let cuts = 0..sections.cuts.len() as u32;
        let samples = cuts.into_par_iter().map(|cut| open_samples(&sections, cut)).collect();
        Self { slam, sections, bodies, samples }
    }

    /// The distortion that the surfaces show.
    pub(crate) fn distortion_field(&self, input: &DeviationInput<'_>) -> DistortionField {
        let about_m = input.motion().apply(input.about_m);
        let least_drift_m = if input.is_bent() { BENT_DRIFT_M } else { 0.0 };
        DistortionField::new(self.surface_offsets().into_iter(), about_m, &input.covariance, least_drift_m)
    }

    /// Surface offsets at the sides of elements that are planned to stand.
    fn surface_offsets(&self) -> Vec<SurfaceOffset> {
        let Self { slam, sections, bodies, samples } = self;
        let of_cut = |cut: u32| -> Vec<SurfaceOffset> {
            let own = &sections.cuts[cut as usize];
            if !own.stands || own.kind != LidarKind::Solid {
                return Vec::new();
            }
            let surface = |s: &Sample| {
                let Sample { at, normal, thick_m } = *s;
                let probe_result = slam.probe(&Probe { at, normal, thick_m, tolerance_m: SAME_SIDE_M });
                let nearest = probe_result.offsets_m.into_iter().min_by(|a, b| a.abs().total_cmp(&b.abs()))?;
                Some(SurfaceOffset { at, normal, offset_m: nearest, body: bodies.body(cut) })
            };
            samples[cut as usize].iter().filter_map(surface).collect()
        };
        (0..samples.len() as u32).into_par_iter().flat_map_iter(of_cut).collect()
    }
}
