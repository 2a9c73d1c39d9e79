//! Evidence for an element from samples on its sides: in place, displaced, or seen through.

use crate::bend::{Bend, Bends, square};
use crate::displaced::{Shift, shift};
use crate::probed_sample::Look;
use crate::sections::{Kind, Sections};
use crate::sides::Sample;
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
    pub(crate) shift: Shift,
    pub(crate) bend_m: [f64; 2],
    pub(crate) deviation_m: f64,
}

/// Looks at an element from all of its samples.
pub(crate) fn evidence(sections: &Sections, cut: u32, samples: &[Sample], slam: &SlamView, bends: &Bends) -> Evidence {
    let mut local: BTreeMap<[i32; 2], Bend> = BTreeMap::new();
    let by_others = |s: &Sample| *local.entry(square(s.at)).or_insert_with(|| bends.at(s.at, Some(cut)));
    let bent = seen_with(sections, cut, samples, slam, by_others);
    let shift = &bent.shift;
    let away_m = libm::hypot(shift.by_m[0], shift.by_m[1]);
    // Beside its place as the pose alone has it, too; otherwise it is the others that were built elsewhere.
    let beside_m = shift.along([0, 1].map(|k| shift.by_m[k] + bent.bend_m[k])) / away_m;
    if shift.is_displaced && beside_m < LEAST_DISPLACED_M {
        return seen_with(sections, cut, samples, slam, |_| bends.none());
    }
    bent
}

fn seen_with(
    sections: &Sections,
    cut: u32,
    samples: &[Sample],
    slam: &SlamView,
    mut bend_at: impl FnMut(&Sample) -> Bend,
) -> Evidence {
    let own = &sections.cuts[cut as usize];
    let (mut looks, mut bend_m, mut worst_m) = (Vec::with_capacity(samples.len()), [0.0; 2], 0.0f64);
    for sample in samples {
        let bend = bend_at(sample);
        looks.push(look(sections, cut, sample, slam, &bend));
        bend_m = [0, 1].map(|k| bend_m[k] + bend.by_m[k] / samples.len() as f64);
        worst_m = worst_m.max(bend.deviation_m(sample.normal));
    }
    let shift = shift(&looks, LEAST_DISPLACED_M + UNCERTAIN * worst_m);
    let mut out = Evidence {
        observation: Observation::Unseen,
        reason: UnseenReason::Inconclusive,
        n_samples: samples.len() as u32,
        n_visible: 0,
        n_confirmed: 0,
        n_contradicted: 0,
        shift,
        bend_m,
        deviation_m: worst_m,
    };
    let tolerance_m = slam.cell_m + SAME_SIDE_M + worst_m;
    looks.iter().for_each(|look| out.count(look, tolerance_m));
    out.observation = out.seen_as(own.stands, own.kind);
    out.reason = out.why(sections, cut);
    out
}

/// Looks at one sample.
fn look(sections: &Sections, cut: u32, sample: &Sample, slam: &SlamView, bend: &Bend) -> Look {
    let Sample { at, normal, thick_m } = *sample;
    let tolerance_m = slam.cell_m + SAME_SIDE_M + bend.deviation_m(normal);
    let seen_at = [0, 1].map(|k| at[k] + bend.by_m[k]);
    let met = slam.probe(&Probe { at: seen_at, normal, thick_m, tolerance_m });
    let place = |d: f64| [0, 1].map(|k| at[k] + normal[k] * d);
    // Another element's, if it lies nearer to that.
    let is_own = |d: &f64| d.abs() <= OWN_M || !sections.is_others(place(*d), OTHERS_M.min(d.abs() * NEARER), cut);
    // Through all of the solid up to the face of what stands behind it.
    let reaches_other = |depth_m: f64| {
        depth_m >= (SAME_SIDE_M + bend.deviation_m(normal)).max(thick_m - slam.cell_m)
            && depth_m <= thick_m + BESIDE_M
            && sections.is_others(place(-depth_m), OTHERS_M, cut)
    };
    let through = met.through || thick_m > slam.cell_m && met.free_m.is_some_and(reaches_other);
    Look { normal, offsets_m: met.offsets_m.into_iter().filter(is_own).collect(), through }
}

impl Evidence {
    fn count(&mut self, look: &Look, tolerance_m: f64) {
        let out_m = self.shift.along(look.normal);
        let nearest = look.nearest(0.0);
        let in_place = nearest.is_some_and(|d| d.abs() <= tolerance_m);
        let behind = nearest.is_some_and(|d| d < -tolerance_m);
        let is_moved = self.shift.is_displaced
            && out_m.abs() > SUPPORT_M
            && look.nearest(out_m).is_some_and(|d| (d - out_m).abs() <= SUPPORT_M);
        self.n_confirmed += u32::from(in_place && !is_moved);
        self.n_contradicted += u32::from(!in_place && (look.through || (behind && is_moved)));
        self.n_visible += u32::from(in_place || is_moved || look.through);
    }

    fn seen_as(&self, stands: bool, kind: Kind) -> Observation {
        let [confirmed, contradicted, all] = [self.n_confirmed, self.n_contradicted, self.n_samples].map(f64::from);
        let judged = confirmed + contradicted;
        let is_lasting = kind != Kind::Door;
        if !is_judged(kind) {
            return Observation::Unseen;
        }
        let is_left = confirmed <= MOST_IN_PLACE * f64::from(self.n_visible) || self.is_slight();
        if self.shift.is_displaced && stands && is_lasting && is_left {
            return Observation::Displaced;
        }
        let is_absent = self.n_contradicted as usize >= LEAST_ABSENT
            && contradicted >= ABSENT_SHARE * judged
            && contradicted >= ABSENT_OF_ALL * all;
        if is_absent && is_lasting {
            return Observation::Absent;
        }
        let n_confirmed = self.n_confirmed as usize;
        let is_observed = if stands {
            n_confirmed >= LEAST_OBSERVED
                && confirmed >= OBSERVED_SHARE * judged
                && (n_confirmed >= SURELY_OBSERVED || confirmed >= OBSERVED_OF_ALL * all)
        } else {
            !self.shift.is_displaced
                && n_confirmed >= LEAST_EARLY
                && confirmed >= EARLY_SHARE * judged
                && confirmed >= EARLY_OF_ALL * all
        };
        if is_observed { Observation::Observed } else { Observation::Unseen }
    }

    /// True if it is displaced by so little that surfaces count as in its place all the same.
    fn is_slight(&self) -> bool {
        libm::hypot(self.shift.by_m[0], self.shift.by_m[1]) <= 2.0 * SAME_SIDE_M
    }

    /// Why nothing can be said, if nothing can.
    fn why(&self, sections: &Sections, cut: u32) -> UnseenReason {
        let own = &sections.cuts[cut as usize];
        match own.kind {
            _ if self.observation != Observation::Unseen => UnseenReason::Seen,
            Kind::Glass => UnseenReason::Glass,
            Kind::StandIn => UnseenReason::StandIn,
            _ if own.section.is_empty() => UnseenReason::NoSection,
            _ if self.n_samples == 0 => UnseenReason::Covered,
            Kind::Door => UnseenReason::Door,
            _ if self.n_visible == 0 => UnseenReason::NotSeen,
            _ => UnseenReason::Inconclusive,
        }
    }
}

/// True if a lidar shows elements of this kind at all.
pub(crate) fn is_judged(kind: Kind) -> bool {
    !matches!(kind, Kind::Glass | Kind::StandIn)
}
