//! Walkable floor: level faces with headroom, sampled in plan.

use crate::floor_samples::{FloorTriangles, STEP, each_sample};
use frames::TENTHS_PER_M;
use geometry::{Bounds, MeshView};
use grid::GridSpec;

/// Required headroom above a floor.
pub(crate) const HEADROOM: i32 = 13 * TENTHS_PER_M / 10;

/// Bodies less than this above a face lie on it.
const ON_FACE: i32 = TENTHS_PER_M / 50;

/// A face that looks down this little below a floor still covers it.
const CONTACT: i32 = TENTHS_PER_M / 1_000;

/// Half the width in metres that a floor must have everywhere to count.
const HALF_WIDTH_M: f64 = 0.25;

/// Samples lie this far apart, or farther where that were too many.
const SPACING: i64 = 1_000;

/// Most places in plan, and most samples.
const MAX_SAMPLES: f64 = 4e6;

/// Floor at places in plan: several heights above each other.
#[derive(Debug)]
pub(crate) struct WalkableFloor {
    pub(crate) spec: GridSpec,
    /// Place in plan and height of each sample, sorted.
    pub(crate) samples: Vec<(u32, i32)>,
    /// First sample of each place, and the end of the last.
    first: Vec<u32>,
    /// True where nothing is in the way above a sample.
    pub(crate) open: Vec<bool>,
}

impl WalkableFloor {
    /// Samples these faces inside `bounds`; `None` if there is nothing to sample.
    pub(crate) fn new(faces: &FloorTriangles, bounds: Bounds) -> Option<Self> {
        let area: f64 = faces.iter().map(double_area).sum::<f64>() / 2.0;
        let side = |k: usize| i64::from(bounds.max[k]) - i64::from(bounds.min[k]);
        let mut cell = SPACING;
        let squares = |cell: i64| (side(0) / cell + 2) as f64 * (side(1) / cell + 2) as f64;
        while squares(cell) > MAX_SAMPLES || area / (cell as f64 * cell as f64) > MAX_SAMPLES {
            cell *= 2;
        }
        let spec = GridSpec {
            cell_tenths: i32::try_from(cell).ok()?,
            first_cell: bounds.min.map(|c| i64::from(c).div_euclid(cell) as i32),
            width: (side(0) / cell + 2) as u32,
            height: (side(1) / cell + 2) as u32,
        };
        let mut samples = Vec::new();
        faces.iter().for_each(|t| each_sample(&spec, t, |place, z| samples.push((place, z))));
        samples.sort_unstable();
        samples.dedup();
        let mut first = vec![0u32; spec.n_cells() + 1];
        samples.iter().for_each(|s| first[s.0 as usize + 1] += 1);
        for place in 0..spec.n_cells() {
            first[place + 1] += first[place];
        }
        let open = vec![true; samples.len()];
        (!samples.is_empty()).then_some(Self { spec, samples, first, open })
    }

    /// Area that a sample stands for, in square metres.
    pub(crate) fn sample_m2(&self) -> f64 {
        self.spec.resolution_m() * self.spec.resolution_m()
    }

    /// Closes the samples that this body lies on, or hangs above too low.
    pub(crate) fn close_below(&mut self, mesh: MeshView<'_>) {
        let inside_out = mesh.volume_m3() < 0.0;
        let Self { spec, samples, first, open } = self;
        for triangle in mesh.corners() {
            let double = double_area(&triangle);
            let looks_down = (double < 0.0) != inside_out;
            let turned = if double < 0.0 { [triangle[0], triangle[2], triangle[1]] } else { triangle };
            let above_face = if looks_down { -CONTACT } else { ON_FACE };
            each_sample(spec, &turned, |place, z| {
                let own = first[place as usize] as usize..first[place as usize + 1] as usize;
                for k in own {
                    let above = z - samples[k].1;
                    open[k] &= above < above_face || HEADROOM <= above;
                }
            });
        }
    }

    /// The open samples at places up to `reach` columns and rows from a sample, other than at its own place.
    pub(crate) fn around(&self, sample: usize, reach: i64) -> impl Iterator<Item = usize> + '_ {
        let width = i64::from(self.spec.width);
        let place = i64::from(self.samples[sample].0);
        let (column, row) = (place % width, place / width);
        let rows = (row - reach).max(0)..(row + reach + 1).min(i64::from(self.spec.height));
        rows.flat_map(move |y| {
            let columns = (column - reach).max(0)..(column + reach + 1).min(width);
            columns.filter(move |x| (*x, y) != (column, row)).flat_map(move |x| self.at((y * width + x) as usize))
        })
    }

    /// The open samples at a place.
    pub(crate) fn at(&self, place: usize) -> impl Iterator<Item = usize> + '_ {
        (self.first[place] as usize..self.first[place + 1] as usize).filter(|&k| self.open[k])
    }

    /// The samples, of those that count, around which floor is as wide as a person at all sides; by sample.
    pub(crate) fn wide(&self, counts: &[bool]) -> Vec<bool> {
        let reach = self.width_reach();
        let side = 2 * reach + 1;
        let is_wide = |sample: usize| {
            let z = self.samples[sample].1;
            let mut places: Vec<u32> = self
                .around(sample, reach)
                .filter(|&k| counts[k] && (self.samples[k].1 - z).abs() <= STEP)
                .map(|k| self.samples[k].0)
                .collect();
            places.dedup();
            places.len() as i64 == side * side - 1
        };
        (0..self.samples.len()).map(|k| counts[k] && self.open[k] && is_wide(k)).collect()
    }

    /// Columns and rows that are half as wide as a person.
    pub(crate) fn width_reach(&self) -> i64 {
        (HALF_WIDTH_M / self.spec.resolution_m()).floor() as i64
    }
}

/// Twice the area of a triangle in plan, in square tenths of a millimetre; negative if it runs clockwise.
fn double_area(t: &[[i32; 3]; 3]) -> f64 {
    let d = |k: usize, i: usize| f64::from(t[k][i]) - f64::from(t[0][i]);
    d(1, 0) * d(2, 1) - d(2, 0) * d(1, 1)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use geometry::upward_triangles;

    /// A box from corner to corner, faces outward.
    pub(crate) fn cuboid([x0, y0, z0]: [i32; 3], [x1, y1, z1]: [i32; 3]) -> (Vec<[i32; 3]>, Vec<[u32; 3]>) {
        let v = [[x0, y0], [x1, y0], [x1, y1], [x0, y1]];
        let vertices = [z0, z1].into_iter().flat_map(|z| v.map(|[x, y]| [x, y, z])).collect();
        let quads = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];
        (vertices, quads.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect())
    }

    /// Open area of a floor of 4 x 4 m with this box on or above it.
    fn open_m2(min: [i32; 3], max: [i32; 3]) -> f64 {
        let (v, t) = cuboid([0, 0, -2_000], [40_000, 40_000, 0]);
        let floor = MeshView { vertices: &v, triangles: &t, closed: true };
        let faces: FloorTriangles = upward_triangles(floor, 0.01).collect();
        let mut walkable = WalkableFloor::new(&faces, Bounds { min: [0; 2], max: [40_000; 2] }).unwrap();
        walkable.close_below(floor);
        let (v, t) = cuboid(min, max);
        walkable.close_below(MeshView { vertices: &v, triangles: &t, closed: true });
        walkable.open.iter().filter(|o| **o).count() as f64 * walkable.sample_m2()
    }

    #[test]
    fn what_stands_on_a_floor_or_hangs_low_takes_it_away() {
        let (lo, hi) = ([0, 0], [20_000, 40_000]);
        let with = |bottom: i32, top: i32| open_m2([lo[0], lo[1], bottom], [hi[0], hi[1], top]);
        assert!((with(30_000, 32_000) - 16.0).abs() < 0.1, "a ceiling");
        assert!((with(0, 25_000) - 8.0).abs() < 0.5, "a block higher than a person");
        assert!((with(12_000, 14_000) - 8.0).abs() < 0.5, "a duct");
        assert!((with(0, 150) - 8.0).abs() < 0.5, "a screed");
        assert!((with(-2_000, 0) - 16.0).abs() < 0.1, "another slab that ends at the same height");
    }

    #[test]
    fn a_strip_narrower_than_a_person_is_not_wide() {
        let strip = |width: i32| {
            let faces =
                vec![[[0, 0, 0], [90_000, 0, 0], [90_000, width, 0]], [[0, 0, 0], [90_000, width, 0], [0, width, 0]]];
            let walkable = WalkableFloor::new(&faces, Bounds { min: [0; 2], max: [90_000, width] }).unwrap();
            walkable.wide(&vec![true; walkable.samples.len()]).iter().any(|w| *w)
        };
        assert!(strip(6_000) && !strip(4_000));
    }
}
