//! Evidence for an element from samples on its sides: in place, displaced, or seen through.

use crate::displacement::{Displacement, displacement};
use crate::distortion::{Distortion, DistortionField, square};
use crate::probed_sample::ProbedSample;
use crate::sections::{LidarKind, Sections};
use crate::side_samples::Sample;
use crate::slam_view::{Probe, SlamView};
use crate::thresholds::*;
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
    pub(crate) deviation_m: f64,
}

/// Collects the evidence for an element from all of its samples.
pub(crate) fn evidence(
    sections: &Sections,
    cut: u32,
    samples: &[Sample],
    slam: &SlamView,
    distortions: &DistortionField,
) -> Evidence {
    let mut local: BTreeMap<[i32; 2], Distortion> = BTreeMap::new();
    let by_others = |s: &Sample| *local.entry(square(s.at)).or_insert_with(|| distortions.at(s.at, Some(cut)));
    let corrected = evidence_with(sections, cut, samples, slam, by_others);
    let displacement = &corrected.displacement;
    let away_m = libm::hypot(displacement.by_m[0], displacement.by_m[1]);
    // The element is displaced only if that holds without the distortion, too; otherwise its neighbours are displaced.
    let beside_m = displacement.along([0, 1].map(|k| displacement.by_m[k] + corrected.distortion_m[k])) / away_m;
    if displacement.is_displaced && beside_m < MIN_DISPLACED_M {
        return evidence_with(sections, cut, samples, slam, |_| distortions.none());
    }
    corrected
}

fn evidence_with(
    sections: &Sections,
    cut: u32,
    samples: &[Sample],
    slam: &SlamView,
    mut distortion_at: impl FnMut(&Sample) -> Distortion,
) -> Evidence {
    let own = &sections.cuts[cut as usize];
    let (mut probed_samples, mut distortion_m, mut worst_m) = (Vec::with_capacity(samples.len()), [0.0; 2], 0.0f64);
    for sample in samples {
        let distortion = distortion_at(sample);
        probed_samples.push(probed_sample(sections, cut, sample, slam, &distortion));
        distortion_m = [0, 1].map(|k| distortion_m[k] + distortion.by_m[k] / samples.len() as f64);
        worst_m = worst_m.max(distortion.deviation_m(sample.normal));
    }
    let displacement = displacement(&probed_samples, MIN_DISPLACED_M + UNCERTAIN * worst_m);
    let mut out = Evidence {
        observation: Observation::Unseen,
        reason: UnseenReason::Inconclusive,
        n_samples: samples.len() as u32,
        n_visible: 0,
        n_confirmed: 0,
        n_contradicted: 0,
        displacement,
        distortion_m,
        deviation_m: worst_m,
    };
    let tolerance_m = slam.cell_m + SAME_SIDE_M + worst_m;
    probed_samples.iter().for_each(|probed_sample| out.count(probed_sample, tolerance_m));
    out.observation = out.observation(own.stands, own.kind);
    out.reason = out.unseen_reason(sections, cut);
    out
}

/// Probes the SLAM map at one sample.
fn probed_sample(
    sections: &Sections,
    cut: u32,
    sample: &Sample,
    slam: &SlamView,
    distortion: &Distortion,
) -> ProbedSample {
    let Sample { at, normal, thick_m } = *sample;
    let tolerance_m = slam.cell_m + SAME_SIDE_M + distortion.deviation_m(normal);
    let seen_at = [0, 1].map(|k| at[k] + distortion.by_m[k]);
    let probe_result = slam.probe(&Probe { at: seen_at, normal, thick_m, tolerance_m });
    let place = |d: f64| [0, 1].map(|k| at[k] + normal[k] * d);
    // The surface belongs to another element if it lies nearer to that.
    let is_own = |d: &f64| d.abs() <= OWN_M || !sections.is_others(place(*d), OTHERS_M.min(d.abs() * NEARER), cut);
    // Through all of the solid up to the face of what stands behind it.
    let reaches_other = |depth_m: f64| {
        depth_m >= (SAME_SIDE_M + distortion.deviation_m(normal)).max(thick_m - slam.cell_m)
            && depth_m <= thick_m + BESIDE_M
            && sections.is_others(place(-depth_m), OTHERS_M, cut)
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
        let is_left = confirmed <= MAX_IN_PLACE * f64::from(self.n_visible) || self.is_slight();
        if self.displacement.is_displaced && stands && is_lasting && is_left {
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

    /// True if the displacement is so small that surfaces also count as in place.
    fn is_slight(&self) -> bool {
        libm::hypot(self.displacement.by_m[0], self.displacement.by_m[1]) <= 2.0 * SAME_SIDE_M
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
