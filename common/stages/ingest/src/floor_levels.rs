//! Floor height of a storey, from upward faces sampled in plan.

use crate::floor_samples::{FloorTriangles, STEP, each_sample};
use frames::TENTHS_PER_M;
use geometry::{Bounds, MultiPolygon};
use grid::{GridSpec, Mask, overlapped_cells};

/// Floor faces this near to a storey's placement are its floor.
pub(crate) const REACH: i32 = TENTHS_PER_M / 2;

/// Most samples of a storey; large ones are sampled more coarsely.
const MAX_SAMPLES: i64 = 250_000;

/// No face at this sample.
const NO_FLOOR: i32 = i32::MIN;

/// Upward faces of all floor elements.
#[derive(Debug, Default)]
pub(crate) struct FloorFaces {
    /// Slabs, coverings, ramps, pavements.
    pub(crate) slabs: FloorTriangles,
    /// Footings.
    pub(crate) footings: FloorTriangles,
}

impl FloorFaces {
    pub(crate) fn all(&self) -> impl Iterator<Item = &[[i32; 3]; 3]> {
        self.slabs.iter().chain(&self.footings)
    }
}

/// The topmost floor near a height, in samples.
#[derive(Debug)]
pub(crate) struct FloorSampling {
    cell_m: f64,
    /// Height of the topmost face, or [`NO_FLOOR`].
    top: Vec<i32>,
    /// Samples that count: those in the spaces, or all.
    counted: Option<Mask>,
}

/// A level at which much floor lies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FloorLevel {
    pub(crate) z: i32,
    /// Area within a step of it, in square metres.
    pub(crate) area_m2: f64,
}

impl FloorSampling {
    /// Samples the faces within [`REACH`] of `z`, in the spaces where there are any.
    pub(crate) fn new(lists: &[&FloorTriangles], z: i32, spaces: &MultiPolygon) -> Option<Self> {
        let faces = || lists.iter().flat_map(|list| list.iter());
        let near = |t: &&[[i32; 3]; 3]| t.iter().any(|v| v[2] >= z - REACH) && t.iter().any(|v| v[2] <= z + REACH);
        let bounds = match spaces.bounds() {
            Some(bounds) => bounds,
            None => Bounds::of(faces().filter(near).flatten().map(|v| [v[0], v[1]]))?,
        };
        let spec = sample_spec(bounds)?;
        let mut sampling = Self { cell_m: spec.resolution_m(), top: vec![NO_FLOOR; spec.n_cells()], counted: None };
        for triangle in faces().filter(near) {
            sampling.add(&spec, triangle, [z - REACH, z + REACH]);
        }
        if !spaces.is_empty() {
            let mut mask = Mask::new(spec.width as usize, spec.height as usize);
            mask.set_runs(&overlapped_cells(spaces, &[], &spec));
            sampling.counted = Some(mask);
        }
        Some(sampling)
    }

    /// Share of the counted samples that have floor.
    pub(crate) fn share(&self) -> f64 {
        let (mut with, mut all) = (0u32, 0u32);
        for (index, &z) in self.top.iter().enumerate() {
            if self.counts(index) {
                all += 1;
                with += u32::from(z != NO_FLOOR);
            }
        }
        if all == 0 { 0.0 } else { f64::from(with) / f64::from(all) }
    }

    /// The height around which most floor lies within a step; of equal ones the nearest to `guess`.
    pub(crate) fn level(&self, guess: i32) -> Option<FloorLevel> {
        let mut heights: Vec<i32> =
            self.top.iter().enumerate().filter(|&(i, &z)| z != NO_FLOOR && self.counts(i)).map(|(_, &z)| z).collect();
        heights.sort_unstable();
        let z = dominant_height(&heights, guess)?;
        let within = heights.iter().filter(|h| (*h - z).abs() <= STEP).count();
        Some(FloorLevel { z, area_m2: within as f64 * self.cell_m * self.cell_m })
    }

    fn counts(&self, index: usize) -> bool {
        self.counted.as_ref().is_none_or(|mask| mask.cells[index])
    }

    fn add(&mut self, spec: &GridSpec, t: &[[i32; 3]; 3], window: [i32; 2]) {
        each_sample(spec, t, |place, z| {
            let top = &mut self.top[place as usize];
            if window[0] <= z && z <= window[1] && *top < z {
                *top = z;
            }
        });
    }
}

/// A grid of samples 0.1 m apart, or coarser where that were too many.
pub(crate) fn sample_spec(bounds: Bounds) -> Option<GridSpec> {
    let side = |k: usize| i64::from(bounds.max[k]) - i64::from(bounds.min[k]);
    let mut cell = 1_000i64;
    while (side(0) / cell + 2) * (side(1) / cell + 2) > MAX_SAMPLES {
        cell *= 2;
    }
    let spec = |cell: i64| GridSpec {
        cell_tenths: cell as i32,
        first_cell: bounds.min.map(|c| i64::from(c).div_euclid(cell) as i32),
        width: (side(0) / cell + 2) as u32,
        height: (side(1) / cell + 2) as u32,
    };
    (cell < i64::from(i32::MAX)).then(|| spec(cell))
}

/// The most frequent of sorted heights within the window of two steps that holds most of them.
pub(crate) fn dominant_height(sorted: &[i32], guess: i32) -> Option<i32> {
    let mut best: Option<(usize, i32, &[i32])> = None;
    let mut end = 0;
    for (start, &low) in sorted.iter().enumerate() {
        if start > 0 && sorted[start - 1] == low {
            continue;
        }
        while end < sorted.len() && sorted[end] - low <= 2 * STEP {
            end += 1;
        }
        let far = (i64::from(low) - i64::from(guess)).abs() as i32;
        if best.is_none_or(|b| end - start > b.0 || end - start == b.0 && far < b.1) {
            best = Some((end - start, far, &sorted[start..end]));
        }
    }
    let (_, _, window) = best?;
    let runs = window.chunk_by(|a, b| a == b).map(|same| (same.len(), same[0]));
    // Of equally frequent heights the lowest: a sloped floor has many.
    let (count, mode) = runs.fold((0, 0), |best, run| if run.0 > best.0 { run } else { best });
    let sloped = count * 5 < window.len();
    Some(if sloped { window[window.len() / 2] } else { mode })
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{FillRule, union};

    fn square(x: i32, side: i32, z: i32) -> FloorTriangles {
        vec![[[x, 0, z], [x + side, 0, z], [x + side, side, z]], [[x, 0, z], [x + side, side, z], [x, side, z]]]
    }

    #[test]
    fn the_covering_on_a_slab_is_the_level() {
        let mut faces = square(0, 100_000, -1_000);
        faces.extend(square(0, 90_000, 0));
        let sampling = FloorSampling::new(&[&faces], 0, &MultiPolygon::default()).unwrap();
        let level = sampling.level(0).unwrap();
        assert_eq!(level.z, 0);
        assert!((level.area_m2 - 81.0).abs() < 2.0, "{}", level.area_m2);
    }

    #[test]
    fn only_what_lies_in_spaces_counts() {
        let mut faces = square(0, 100_000, 0);
        faces.extend(square(200_000, 50_000, 2_000));
        let space = union(&[vec![[200_000, 0], [250_000, 0], [250_000, 50_000], [200_000, 50_000]]], FillRule::NonZero);
        let sampling = FloorSampling::new(&[&faces], 0, &space).unwrap();
        assert_eq!(sampling.level(0).unwrap().z, 2_000);
        assert!(sampling.share() > 0.95);
    }

    #[test]
    fn a_bathroom_three_centimetres_higher_does_not_lift_the_floor() {
        let heights: Vec<i32> = [vec![0; 90], vec![300; 30]].concat();
        assert_eq!(dominant_height(&heights, 0), Some(0));
    }

    #[test]
    fn equal_levels_go_to_the_one_nearer_to_the_placement() {
        assert_eq!(dominant_height(&[0, 0, 4_000, 4_000], 3_900), Some(4_000));
        assert_eq!(dominant_height(&[], 0), None);
    }
}
