//! Sample points on exposed sides of elements.

use crate::sections::{LidarKind, Sections, metres};
use crate::thresholds::{BESIDE_M, DEEP_M, GAP_M, LAYER_M, REACH_M, SAME_SIDE_M, SAMPLE_M};
use geometry::Point;

/// A sample point on a side.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sample {
    /// Metres in `map`.
    pub(crate) at: [f64; 2],
    /// Unit normal out of the solid.
    pub(crate) normal: [f64; 2],
    /// Thickness of the solid behind it; 0 for a sheet.
    pub(crate) thick_m: f64,
}

/// Maximum relevant thickness of a solid.
const MAX_THICK_M: f64 = REACH_M + DEEP_M;

/// The samples of an element on exposed sides.
pub(crate) fn open_samples(sections: &Sections, cut: u32) -> Vec<Sample> {
    let own = &sections.cuts[cut as usize];
    let mut samples = Vec::new();
    for ring in own.section.area.rings() {
        let corners = ring.iter().chain(ring.first()).copied();
        along(corners.collect(), &mut samples);
    }
    for sample in &mut samples {
        let into = sample.normal.map(|c| -c);
        sample.thick_m = sections.thickness(sample.at, into, cut, MAX_THICK_M);
    }
    for [a, b] in &own.section.lines {
        // A sheet has two sides.
        along(vec![*a, *b], &mut samples);
        along(vec![*b, *a], &mut samples);
    }
    samples.retain(|s| is_open(sections, cut, s));
    samples
}

/// Samples along a line that has the solid on its left.
fn along(corners: Vec<Point>, samples: &mut Vec<Sample>) {
    let mut next_m = SAMPLE_M / 2.0;
    for pair in corners.windows(2) {
        let (a, b) = (metres(pair[0]), metres(pair[1]));
        let length_m = libm::hypot(b[0] - a[0], b[1] - a[1]);
        let direction = [0, 1].map(|k| (b[k] - a[k]) / length_m);
        while next_m < length_m {
            let at = [0, 1].map(|k| a[k] + direction[k] * next_m);
            samples.push(Sample { at, normal: [direction[1], -direction[0]], thick_m: 0.0 });
            next_m += SAMPLE_M;
        }
        next_m -= length_m;
    }
}

/// True if no other element stands before the sample or close beside it.
fn is_open(sections: &Sections, cut: u32, sample: &Sample) -> bool {
    let Sample { at, normal, .. } = *sample;
    let place = |out_m: f64, aside_m: f64| {
        [at[0] + normal[0] * out_m - normal[1] * aside_m, at[1] + normal[1] * out_m + normal[0] * aside_m]
    };
    let own = &sections.cuts[cut as usize];
    // An element that should not stand yet is not sampled where another one stands.
    if !own.stands && sections.is_others(at, SAME_SIDE_M * 2.0, cut) {
        return false;
    }
    // A layer on another element: without it the other's face is seen, and nearly in the same place.
    if sample.thick_m <= LAYER_M && sections.covered(place(-sample.thick_m - GAP_M / 6.0, 0.0), cut) {
        return false;
    }
    let steps = [0.01, GAP_M / 3.0, GAP_M * 2.0 / 3.0, GAP_M];
    if steps.iter().any(|out_m| sections.covered(place(*out_m, 0.0), cut)) {
        return false;
    }
    // Doors move and hide nothing.
    let asides = [BESIDE_M / 4.0, BESIDE_M / 2.0, BESIDE_M * 3.0 / 4.0, BESIDE_M];
    own.kind == LidarKind::Door
        || !asides.iter().any(|a| sections.covered(place(0.02, *a), cut) || sections.covered(place(0.02, -a), cut))
}
