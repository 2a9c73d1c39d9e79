//! Stretches of a standing element that the robot saw through, along its axis.

use crate::probed_sample::ProbedSample;
use crate::sections::{Sections, metres};
use crate::side_samples::Sample;
use crate::thresholds::{
    MAX_PART_GAP_M, MIN_PART_M, MIN_SLENDERNESS, OPENING_M, PART_END_M, PART_THROUGH_SHARE, SAMPLE_M,
};

/// A stretch of an element that is not there.
#[derive(Debug, Clone, Copy)]
pub(crate) struct AbsentPart {
    /// From the end of the element with the smaller x, or the smaller y where it runs along y.
    pub(crate) from_m: f64,
    pub(crate) to_m: f64,
    /// The same two places on its middle line, in `map`.
    pub(crate) ends_m: [[f64; 2]; 2],
    /// Standard deviation of each end along the axis.
    pub(crate) deviation_m: f64,
}

/// Axis of an element, with its extent along it.
struct Axis {
    along: [f64; 2],
    /// Coordinate of the middle line across.
    across_m: f64,
    from_m: f64,
    to_m: f64,
}

/// What the samples at one place along the axis say.
#[derive(Clone, Copy, PartialEq)]
enum Place {
    Unknown,
    Through,
    Met,
}

/// Stretches that are seen through, of an element that is longer than wide. `tolerance_m` is that of its side, `end_m` the
/// standard deviation of places along it.
pub(crate) fn absent_parts(
    sections: &Sections,
    cut: u32,
    samples: &[Sample],
    probed: &[ProbedSample],
    tolerance_m: f64,
    end_m: f64,
) -> Vec<AbsentPart> {
    let Some(axis) = Axis::of(sections, cut, samples) else { return Vec::new() };
    let places = axis.places(sections, samples, probed, tolerance_m);
    let stretches = stretches(&places).into_iter();
    let is_part = |&(from, to): &(usize, usize)| to - from < places.len();
    stretches.filter(is_part).map(|(from, to)| axis.part(from, to, end_m)).collect()
}

impl Axis {
    fn of(sections: &Sections, cut: u32, samples: &[Sample]) -> Option<Self> {
        let normal = crate::displacement::main_axis(samples.iter().map(|s| s.normal))?;
        let [x, y] = [-normal[1], normal[0]];
        let along = if x > 1e-6 || (x.abs() <= 1e-6 && y > 0.0) { [x, y] } else { [-x, -y] };
        let points = || sections.cuts[cut as usize].section.area.rings().flatten().map(|p| metres(*p));
        let range = |axis: [f64; 2]| {
            let all = points().map(|p| p[0] * axis[0] + p[1] * axis[1]);
            all.fold([f64::INFINITY, f64::NEG_INFINITY], |[lo, hi], c| [lo.min(c), hi.max(c)])
        };
        let ([from_m, to_m], [near_m, far_m]) = (range(along), range([-along[1], along[0]]));
        let is_slender = to_m - from_m >= MIN_SLENDERNESS * (far_m - near_m);
        is_slender.then_some(Self { along, across_m: (near_m + far_m) / 2.0, from_m, to_m })
    }

    fn at(&self, along_m: f64) -> [f64; 2] {
        let [x, y] = self.along;
        [x * along_m - y * self.across_m, y * along_m + x * self.across_m]
    }

    /// One for each [`SAMPLE_M`] of the axis. At doors and windows nothing is known.
    fn places(&self, sections: &Sections, samples: &[Sample], probed: &[ProbedSample], tolerance_m: f64) -> Vec<Place> {
        let n = ((self.to_m - self.from_m) / SAMPLE_M).ceil() as usize;
        let mut places = vec![Place::Unknown; n];
        for (sample, probed) in samples.iter().zip(probed) {
            let along_m = sample.at[0] * self.along[0] + sample.at[1] * self.along[1];
            let aside = (sample.normal[0] * self.along[0] + sample.normal[1] * self.along[1]).abs();
            let index = ((along_m - self.from_m) / SAMPLE_M).max(0.0) as usize;
            if aside > 0.3 || index >= n {
                continue;
            }
            if probed.nearest(0.0).is_some_and(|d| d.abs() <= tolerance_m) {
                places[index] = Place::Met;
            } else if probed.through && places[index] == Place::Unknown {
                places[index] = Place::Through;
            }
        }
        let is_open = |k: usize| sections.is_opening(self.at(self.from_m + (k as f64 + 0.5) * SAMPLE_M), OPENING_M);
        (0..n).map(|k| if places[k] == Place::Through && is_open(k) { Place::Unknown } else { places[k] }).collect()
    }

    fn part(&self, from: usize, to: usize, end_m: f64) -> AbsentPart {
        let along_m = |k: usize| self.from_m + k as f64 * SAMPLE_M;
        let from_m = (along_m(from) - PART_END_M).max(self.from_m);
        let to_m = (along_m(to) + PART_END_M).min(self.to_m);
        AbsentPart {
            from_m: from_m - self.from_m,
            to_m: to_m - self.from_m,
            ends_m: [from_m, to_m].map(|m| self.at(m)),
            deviation_m: end_m,
        }
    }
}

/// Runs of places that are seen through, with small gaps; their first place and that after their last.
fn stretches(places: &[Place]) -> Vec<(usize, usize)> {
    let (gap, least) = ((MAX_PART_GAP_M / SAMPLE_M).round() as usize, (MIN_PART_M / SAMPLE_M).round() as usize);
    let mut found = Vec::new();
    let mut k = 0;
    while k < places.len() {
        if places[k] != Place::Through {
            k += 1;
            continue;
        }
        let (from, mut to, mut n) = (k, k + 1, 1);
        k += 1;
        while k < places.len() && places[k] != Place::Met && k <= to + gap {
            if places[k] == Place::Through {
                to = k + 1;
                n += 1;
            }
            k += 1;
        }
        if n >= least && n as f64 >= PART_THROUGH_SHARE * (to - from) as f64 {
            found.push((from, to));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(text: &str, expected: &[(usize, usize)]) {
        let place = |c: char| match c {
            'o' => Place::Through,
            '#' => Place::Met,
            _ => Place::Unknown,
        };
        assert_eq!(stretches(&text.chars().map(place).collect::<Vec<_>>()), expected, "{text}");
    }

    #[test]
    fn a_stretch_is_long_enough_and_has_small_gaps_and_nothing_met_within() {
        check("####oooooooooo####", &[(4, 14)]);
        check("####ooooooooo####", &[]);
        check("####ooooo..ooooo####", &[(4, 16)]);
        check("####ooooo......ooooo####", &[]);
        check("oooooo#ooooooooooooo..", &[(7, 20)]);
        check("", &[]);
    }
}
