//! Sample points on exposed sides of elements.

use crate::sections::{LidarKind, Sections, metres};
use crate::thresholds::{BESIDE_M, DEEP_M, GAP_M, LAYER_M, LEAF_GAP_M, REACH_M, SAME_SIDE_M, SAMPLE_M};
use crate::wall_bodies::WallBodies;
use geometry::Point;
use std::collections::BTreeMap;

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

/// Samples on the outer sides of a body behind which one of its elements lies, with the thickness of the whole body.
pub(crate) fn body_samples(sections: &Sections, cut: u32, bodies: &WallBodies) -> Vec<Sample> {
    let mut samples = Vec::new();
    for member in bodies.members(cut) {
        let mut sides = Vec::new();
        for ring in sections.cuts[member as usize].section.area.rings() {
            along(ring.iter().chain(ring.first()).copied().collect(), &mut sides);
        }
        for mut sample in sides {
            let into = sample.normal.map(|c| -c);
            let Some(thick_m) = thickness_with(sections, cut, bodies, sample.at, into) else { continue };
            sample.thick_m = thick_m;
            if is_exposed(sections, member, &sample) {
                samples.push(sample);
            }
        }
    }
    samples
}

/// Thickness of a body behind a point of its border, if one of its elements is a part of it there.
fn thickness_with(sections: &Sections, cut: u32, bodies: &WallBodies, at: [f64; 2], into: [f64; 2]) -> Option<f64> {
    // From a hair before the border, so that the first element is entered, too.
    const BEFORE_M: f64 = 1e-3;
    let from = [0, 1].map(|k| at[k] - into[k] * BEFORE_M);
    let mut depths: BTreeMap<u32, Vec<f64>> = BTreeMap::new();
    for (of, depth_m) in sections.crossings(from, into, MAX_THICK_M + BEFORE_M) {
        if bodies.body(of) == bodies.body(cut) && 0.0 < depth_m && depth_m <= MAX_THICK_M + BEFORE_M {
            depths.entry(of).or_default().push(depth_m);
        }
    }
    let mut spans: Vec<(f64, f64, u32)> = Vec::new();
    for (of, mut depths) in depths {
        depths.sort_by(f64::total_cmp);
        depths.dedup();
        spans.extend(depths.chunks(2).map(|d| (d[0], d.get(1).copied().unwrap_or(MAX_THICK_M), of)));
    }
    spans.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut end_m, mut is_part) = (BEFORE_M, false);
    for (enters_m, leaves_m, of) in spans {
        if enters_m > end_m + LEAF_GAP_M {
            break;
        }
        end_m = leaves_m.max(end_m);
        is_part |= of == cut;
    }
    is_part.then_some(end_m - BEFORE_M)
}

/// True if the side is its own: no other element in, behind or before it.
fn is_open(sections: &Sections, cut: u32, sample: &Sample) -> bool {
    let Sample { at, normal, .. } = *sample;
    let place = |out_m: f64, aside_m: f64| {
        [at[0] + normal[0] * out_m - normal[1] * aside_m, at[1] + normal[1] * out_m + normal[0] * aside_m]
    };
    let own = &sections.cuts[cut as usize];
    // An element that should not stand yet is not sampled where another one stands.
    if !own.stands && sections.is_others(at, SAME_SIDE_M * 2.0, |other| other == cut) {
        return false;
    }
    // A layer on another element: without it the other's face is seen, and nearly in the same place.
    if sample.thick_m <= LAYER_M && sections.covered(place(-sample.thick_m - GAP_M / 6.0, 0.0), cut) {
        return false;
    }
    is_exposed(sections, cut, sample)
}

/// True if no other element stands before a side or close beside it.
fn is_exposed(sections: &Sections, cut: u32, sample: &Sample) -> bool {
    let Sample { at, normal, .. } = *sample;
    let place = |out_m: f64, aside_m: f64| {
        [at[0] + normal[0] * out_m - normal[1] * aside_m, at[1] + normal[1] * out_m + normal[0] * aside_m]
    };
    let steps = [0.01, GAP_M / 3.0, GAP_M * 2.0 / 3.0, GAP_M];
    if steps.iter().any(|out_m| sections.covered(place(*out_m, 0.0), cut)) {
        return false;
    }
    // Doors move and hide nothing.
    let asides = [BESIDE_M / 4.0, BESIDE_M / 2.0, BESIDE_M * 3.0 / 4.0, BESIDE_M];
    sections.cuts[cut as usize].kind == LidarKind::Door
        || !asides.iter().any(|a| sections.covered(place(0.02, *a), cut) || sections.covered(place(0.02, -a), cut))
}
