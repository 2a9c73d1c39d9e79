//! Evidence for an element from samples on its sides: in place, displaced, or seen through.

use crate::displacement::{Displacement, displacement};
use crate::distortion::{Distortion, DistortionField};
use crate::partial_absence::{AbsentPart, absent_parts};
use crate::probed_sample::ProbedSample;
use crate::sections::{LidarKind, Sections};
use crate::side_samples::{Sample, body_samples};
use crate::slam_view::{Probe, SlamView};
use crate::surface_pieces::{middle_of, square_of};
use crate::thresholds::*;
use crate::wall_bodies::WallBodies;
use messages::{Observation, UnseenReason};
use std::collections::BTreeMap;

/// The evidence for an element.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Evidence {
    pub(crate) observation: Observation,
    pub(crate) reason: UnseenReason,
    pub(crate) n_samples: u32,
    pub(crate) n_visible: u32,
    pub(crate) n_confirmed: u32,
    pub(crate) n_contradicted: u32,
    pub(crate) displacement: Displacement,
    pub(crate) distortion_m: [f64; 2],
    /// Mean offset of the SLAM map there from where its pose as a whole puts it.
    pub(crate) off_whole_m: [f64; 2],
    pub(crate) deviation_m: f64,
}

/// What an element is compared with.
pub(crate) struct Comparison<'a> {
    pub(crate) sections: &'a Sections,
    pub(crate) bodies: &'a WallBodies,
    pub(crate) slam: &'a SlamView<'a>,
    pub(crate) distortions: &'a DistortionField,
}

/// Sides of an element, and whose surfaces are its own.
struct Sides<'a> {
    cut: u32,
    samples: &'a [Sample],
    /// With those of all elements of its body.
    with_body: bool,
}

/// Collects the evidence for an element from all of its samples. Of an element that a lidar sees as one with others, the outer
/// sides of all of them tell whether it is absent or displaced.
pub(crate) fn evidence(comparison: &Comparison<'_>, cut: u32, samples: &[Sample]) -> (Evidence, Vec<AbsentPart>) {
    let alone = Sides { cut, samples, with_body: false };
    let found = evidence_of(comparison, &alone);
    if !comparison.bodies.is_shared(cut) {
        return (found, parts(comparison, &alone, found.observation));
    }
    let samples = body_samples(comparison.sections, cut, comparison.bodies);
    let whole = Sides { cut, samples: &samples, with_body: true };
    let of_whole = evidence_of(comparison, &whole);
    let is_whole = matches!(of_whole.observation, Observation::Absent | Observation::Displaced);
    (if is_whole { of_whole } else { found }, parts(comparison, &whole, of_whole.observation))
}

/// Stretches of what stands that are not there. Where the map shows the rest of the element is known, so that places are
/// compared with less margin than for the whole of it.
fn parts(comparison: &Comparison<'_>, sides: &Sides<'_>, observation: Observation) -> Vec<AbsentPart> {
    let Comparison { sections, slam, distortions, .. } = comparison;
    let own = &sections.cuts[sides.cut as usize];
    let stands = matches!(observation, Observation::Observed | Observation::Unseen);
    if !own.stands || own.kind != LidarKind::Solid || !stands {
        return Vec::new();
    }
    let mut local: BTreeMap<[i32; 2], Distortion> = BTreeMap::new();
    let mut worst_m = 0.0f64;
    let mut probed = Vec::with_capacity(sides.samples.len());
    for sample in sides.samples {
        let square = square_of(sample.at);
        let distortion = local.entry(square).or_insert_with(|| distortions.at(middle_of(square), None));
        let deviation_m = distortion.deviation_m(sample.normal);
        probed.push(probed_sample(comparison, sides, sample, distortion, slam.cell_m + WITHIN * deviation_m));
        worst_m = worst_m.max(deviation_m);
    }
    let tolerance_m = slam.cell_m + SAME_SIDE_M + WITHIN * worst_m;
    absent_parts(sections, sides.cut, sides.samples, &probed, tolerance_m, libm::hypot(slam.cell_m, worst_m))
}

fn evidence_of(comparison: &Comparison<'_>, sides: &Sides<'_>) -> Evidence {
    let mut local: BTreeMap<[i32; 2], Distortion> = BTreeMap::new();
    let body = comparison.bodies.body(sides.cut);
    let distortions = comparison.distortions;
    let by_others = |s: &Sample| {
        let square = square_of(s.at);
        *local.entry(square).or_insert_with(|| distortions.at(middle_of(square), Some(body)))
    };
    let corrected = evidence_with(comparison, sides, by_others);
    let displacement = &corrected.displacement;
    let away_m = libm::hypot(displacement.by_m[0], displacement.by_m[1]);
    // The element is displaced only if that holds without the distortion, too; otherwise its neighbours are displaced.
    let beside_m = displacement.along([0, 1].map(|k| displacement.by_m[k] + corrected.distortion_m[k])) / away_m;
    if displacement.is_displaced && beside_m < MIN_DISPLACED_M {
        return evidence_with(comparison, sides, |s| distortions.none(s.at));
    }
    corrected
}

fn evidence_with(
    comparison: &Comparison<'_>,
    sides: &Sides<'_>,
    mut distortion_at: impl FnMut(&Sample) -> Distortion,
) -> Evidence {
    let (Comparison { sections, slam, .. }, Sides { cut, samples, .. }) = (comparison, sides);
    let own = &sections.cuts[*cut as usize];
    let mut probed_samples = Vec::with_capacity(samples.len());
    let (mut distortion_m, mut off_whole_m, mut worst_m) = ([0.0; 2], [0.0; 2], 0.0f64);
    let add = |sum: [f64; 2], by_m: [f64; 2]| [0, 1].map(|k| sum[k] + by_m[k] / samples.len() as f64);
    for sample in *samples {
        let distortion = distortion_at(sample);
        let tolerance_m = slam.cell_m + SAME_SIDE_M + WITHIN * distortion.deviation_m(sample.normal);
        probed_samples.push(probed_sample(comparison, sides, sample, &distortion, tolerance_m));
        distortion_m = add(distortion_m, distortion.by_m.into());
        off_whole_m = add(off_whole_m, slam.off_whole_m(sample.at, distortion.by_m.into()));
        worst_m = worst_m.max(distortion.deviation_m(sample.normal));
    }
    let displacement = displacement(&probed_samples, MIN_DISPLACED_M.max(UNCERTAIN * libm::hypot(worst_m, BUILT_M)));
    let mut out = Evidence {
        observation: Observation::Unseen,
        reason: UnseenReason::Inconclusive,
        n_samples: samples.len() as u32,
        n_visible: 0,
        n_confirmed: 0,
        n_contradicted: 0,
        displacement,
        distortion_m,
        off_whole_m,
        deviation_m: worst_m,
    };
    let tolerance_m = slam.cell_m + SAME_SIDE_M + WITHIN * worst_m;
    probed_samples.iter().for_each(|probed_sample| out.count(probed_sample, tolerance_m));
    if displacement.is_displaced && !out.is_left() {
        // What is not displaced as a whole stands where its surfaces are within the tolerance.
        out.displacement.is_displaced = false;
        [out.n_visible, out.n_confirmed, out.n_contradicted] = [0; 3];
        probed_samples.iter().for_each(|probed_sample| out.count(probed_sample, tolerance_m));
    }
    out.observation = out.observation(own.stands, own.kind);
    out.reason = out.unseen_reason(sections, *cut);
    out
}

/// Probes the SLAM map at one sample.
fn probed_sample(
    comparison: &Comparison<'_>,
    sides: &Sides<'_>,
    sample: &Sample,
    distortion: &Distortion,
    tolerance_m: f64,
) -> ProbedSample {
    let Comparison { sections, bodies, slam, .. } = comparison;
    let is_ours = |cut: u32| {
        if sides.with_body { bodies.body(cut) == bodies.body(sides.cut) } else { cut == sides.cut }
    };
    let Sample { at, normal, thick_m } = *sample;
    let seen_at = [0, 1].map(|k| at[k] + distortion.by_m[k]);
    let probe_result = slam.probe(&Probe { at: seen_at, normal, thick_m, tolerance_m });
    let place = |d: f64| [0, 1].map(|k| at[k] + normal[k] * d);
    // The surface belongs to another element if it lies nearer to that.
    let is_own = |d: &f64| d.abs() <= OWN_M || !sections.is_others(place(*d), OTHERS_M.min(d.abs() * NEARER), is_ours);
    // Through all of the solid up to the face of what stands behind it.
    let reaches_other = |depth_m: f64| {
        depth_m >= (SAME_SIDE_M + WITHIN * distortion.deviation_m(normal)).max(thick_m - slam.cell_m)
            && depth_m <= thick_m + BESIDE_M
            && sections.is_others(place(-depth_m), OTHERS_M, is_ours)
    };
    let through = probe_result.through || thick_m > slam.cell_m && probe_result.free_m.is_some_and(reaches_other);
    ProbedSample { normal, offsets_m: probe_result.offsets_m.into_iter().filter(is_own).collect(), through }
}

impl Evidence {
    fn count(&mut self, probed_sample: &ProbedSample, tolerance_m: f64) {
        let out_m = self.displacement.along(probed_sample.normal);
        let nearest = probed_sample.nearest(0.0);
        let in_place = nearest.is_some_and(|d| d.abs() <= tolerance_m);
        let behind = nearest.is_some_and(|d| d < -tolerance_m);
        let is_moved = self.displacement.is_displaced
            && out_m.abs() > SUPPORT_M
            && probed_sample.nearest(out_m).is_some_and(|d| (d - out_m).abs() <= SUPPORT_M);
        self.n_confirmed += u32::from(in_place && !is_moved);
        self.n_contradicted += u32::from(!in_place && (probed_sample.through || (behind && is_moved)));
        self.n_visible += u32::from(in_place || is_moved || probed_sample.through);
    }

    fn observation(&self, stands: bool, kind: LidarKind) -> Observation {
        let [confirmed, contradicted, all] = [self.n_confirmed, self.n_contradicted, self.n_samples].map(f64::from);
        let judged = confirmed + contradicted;
        let is_lasting = kind != LidarKind::Door;
        if !is_observable(kind) {
            return Observation::Unseen;
        }
        if self.displacement.is_displaced && stands && is_lasting {
            return Observation::Displaced;
        }
        let is_absent = self.n_contradicted as usize >= MIN_ABSENT
            && contradicted >= ABSENT_SHARE * judged
            && contradicted >= ABSENT_OF_ALL * all;
        if is_absent && is_lasting {
            return Observation::Absent;
        }
        let n_confirmed = self.n_confirmed as usize;
        let is_observed = if stands {
            n_confirmed >= MIN_OBSERVED
                && confirmed >= OBSERVED_SHARE * judged
                && (n_confirmed >= SURELY_OBSERVED || confirmed >= OBSERVED_OF_ALL * all)
        } else {
            !self.displacement.is_displaced
                && n_confirmed >= MIN_EARLY
                && confirmed >= EARLY_SHARE * judged
                && confirmed >= EARLY_OF_ALL * all
        };
        if is_observed { Observation::Observed } else { Observation::Unseen }
    }

    /// True if enough of the element was seen, and little of it in its place.
    fn is_left(&self) -> bool {
        let [confirmed, visible, all] = [self.n_confirmed, self.n_visible, self.n_samples].map(f64::from);
        let [x, y] = self.displacement.by_m;
        confirmed <= MAX_IN_PLACE * visible
            && visible >= DISPLACED_OF_ALL * all
            && (self.n_visible >= MIN_SLIGHT || libm::hypot(x, y) >= SLIGHT_M)
    }

    /// Reason of an unseen element.
    fn unseen_reason(&self, sections: &Sections, cut: u32) -> UnseenReason {
        let own = &sections.cuts[cut as usize];
        match own.kind {
            _ if self.observation != Observation::Unseen => UnseenReason::Seen,
            LidarKind::Glass => UnseenReason::Glass,
            LidarKind::StandIn => UnseenReason::StandIn,
            _ if own.section.is_empty() => UnseenReason::NoSection,
            _ if self.n_samples == 0 => UnseenReason::Covered,
            LidarKind::Door => UnseenReason::Door,
            _ if self.n_visible == 0 => UnseenReason::NotSeen,
            _ => UnseenReason::Inconclusive,
        }
    }
}

/// True if a lidar shows elements of this kind.
pub(crate) fn is_observable(kind: LidarKind) -> bool {
    !matches!(kind, LidarKind::Glass | LidarKind::StandIn)
}
