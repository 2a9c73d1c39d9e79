//! Maps of a model in the frame of a robot, whose own map bends.

use crate::place_lattice::PlaceLattice;
use crate::spec::{GridSpec, GridSpecError};
use frames::{BentMotion, Map, Slam, TENTHS_PER_M};
use geometry::Bounds;

/// Samples per cell in both directions: enough to find the corners of rotated cells.
const SAMPLES_PER_SIDE: usize = 3;
/// Side of the squares within which a motion is taken for straight, in metres: bends reach over several.
const SQUARE_M: f64 = 0.5;
/// Distance of the places on the border of a map that its bounds are found by, in metres.
const BORDER_M: f64 = 1.0;

/// The grid of a map in the robot's frame, with the place of each of its cells in the model.
#[derive(Debug)]
pub struct MovedGrid {
    /// Where its cells lie, in the robot's frame.
    pub spec: GridSpec,
    in_model: PlaceLattice,
    /// By square of the lattice: true if its place is known.
    is_known: Vec<bool>,
}

impl MovedGrid {
    /// The grid around a map whose lower left corner and size are given in the model's frame, in metres. `is_known` tells of a place in the
    /// robot's map whether its place in the model is known.
    ///
    /// # Errors
    /// A resolution that is none, too many cells, a motion that folds the map.
    pub fn around(
        origin_m: [f64; 2],
        size_m: [f64; 2],
        resolution_m: f64,
        motion: &BentMotion<Map, Slam>,
        is_known: impl Fn([f64; 2]) -> bool,
    ) -> Result<Self, GridSpecError> {
        let border: Option<Vec<[f64; 2]>> = border(origin_m, size_m).map(|place| motion.apply_inverse(place)).collect();
        let border = border.ok_or(GridSpecError::Folded)?;
        let bound = |k: usize, pick: fn(f64, f64) -> f64| border.iter().map(|p| p[k]).reduce(pick).unwrap_or(0.0);
        let tenths = |metres: f64| (metres * f64::from(TENTHS_PER_M)) as i32;
        let min = [0, 1].map(|k| tenths(bound(k, f64::min)));
        let max = [0, 1].map(|k| tenths(bound(k, f64::max)));
        let spec = GridSpec::around(Bounds { min, max }, 0, resolution_m)?;
        let size_m = [spec.width, spec.height].map(|n| f64::from(n) * spec.resolution_m());
        let in_model = PlaceLattice::over(spec.origin_m(), size_m, SQUARE_M, |place| Some(motion.apply(place)));
        let is_known = in_model.middles_m().map(is_known).collect();
        Ok(Self { spec, in_model, is_known })
    }

    /// A layer of the map: each cell gets the strongest of several samples, so that no obstacle is lost. Row-major.
    ///
    /// `sample` gives the value at a place in the model, in metres. `strongest_first` are values in order of priority; without any of
    /// them a cell gets the value at its middle. Where the place is not known, `free` becomes `unknown`: what stands there is drawn
    /// where it is expected, and nothing is called free.
    pub fn resampled<T: Copy + PartialEq>(
        &self,
        strongest_first: &[T],
        free: T,
        unknown: T,
        sample: impl Fn([f64; 2]) -> T,
    ) -> Vec<T> {
        let look = |place: Option<[f64; 2]>, is_known: bool| {
            let value = place.map_or(unknown, &sample);
            if value == free && !is_known { unknown } else { value }
        };
        self.joined(look, |samples| strongest(strongest_first, samples))
    }

    /// A layer of the map: each cell gets what `join` makes of several samples. Row-major.
    ///
    /// `sample` gives the value at a place in the model, in metres, or where none is known, and is told whether it is known where
    /// that place is in the robot's map.
    pub fn joined<T>(&self, sample: impl Fn(Option<[f64; 2]>, bool) -> T, join: impl Fn(&[T]) -> T) -> Vec<T> {
        let ([x, y], side_m) = (self.spec.origin_m(), self.spec.resolution_m());
        let look = |[column, row]: [f64; 2]| {
            let place = [x + column * side_m, y + row * side_m];
            let is_known = self.in_model.square(place).is_some_and(|square| self.is_known[square]);
            sample(self.in_model.at(place), is_known)
        };
        resampled(self.spec.width as usize, self.spec.height as usize, look, join)
    }
}

/// Places around a rectangle, no farther from each other than [`BORDER_M`].
fn border([x, y]: [f64; 2], [wide_m, high_m]: [f64; 2]) -> impl Iterator<Item = [f64; 2]> {
    let steps = |length_m: f64| {
        let n = (length_m / BORDER_M).ceil().max(1.0) as usize;
        (0..=n).map(move |k| length_m * k as f64 / n as f64)
    };
    let along_x = steps(wide_m).flat_map(move |dx| [[x + dx, y], [x + dx, y + high_m]]);
    along_x.chain(steps(high_m).flat_map(move |dy| [[x, y + dy], [x + wide_m, y + dy]]))
}

/// Resamples a map: each cell gets what `join` makes of several samples, by rows from below, of which that in its middle is the middle one.
///
/// `sample` gives the value at a point of the new map, in cells from its lower left corner; the result is row-major.
fn resampled<T>(width: usize, height: usize, sample: impl Fn([f64; 2]) -> T, join: impl Fn(&[T]) -> T) -> Vec<T> {
    let offsets: Vec<[f64; 2]> = (0..SAMPLES_PER_SIDE * SAMPLES_PER_SIDE)
        .map(|k| [k % SAMPLES_PER_SIDE, k / SAMPLES_PER_SIDE].map(|step| (step as f64 + 0.5) / SAMPLES_PER_SIDE as f64))
        .collect();
    let cell = |index: usize| {
        let corner = [(index % width) as f64, (index / width) as f64];
        let at = |offset: &[f64; 2]| sample([corner[0] + offset[0], corner[1] + offset[1]]);
        join(&offsets.iter().map(at).collect::<Vec<T>>())
    };
    (0..width * height).map(cell).collect()
}

/// The first of these values that a sample has; without any of them the sample in the middle.
fn strongest<T: Copy + PartialEq>(strongest_first: &[T], samples: &[T]) -> T {
    let strongest = strongest_first.iter().find(|value| samples.contains(value));
    strongest.copied().unwrap_or(samples[samples.len() / 2])
}

#[cfg(test)]
mod tests {
    use super::*;
    use frames::Rigid2;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_wall_of_a_cell_stays_whole_however_it_is_turned(yaw in 0.0..6.3f64, across in 0.0..1.0f64) {
            // A wall along a line through the middle of 41 x 41 cells, one cell thick.
            let (sin, cos) = (libm::sin(yaw), libm::cos(yaw));
            let far = |[x, y]: [f64; 2]| (x - 20.5) * cos + (y - 20.5) * sin;
            let look = |p: [f64; 2]| if (far(p) - across).abs() < 0.5 { 0 } else { 254 };
            let turned = resampled(41, 41, look, |samples| strongest(&[0, 205], samples));
            // There is no path from one side to the other, not even diagonally.
            let side = |k: usize| far([(k % 41) as f64 + 0.5, (k / 41) as f64 + 0.5]) > across;
            for k in 0..41 * 41 {
                for (dx, dy) in [(1i32, 0i32), (0, 1), (1, 1), (-1, 1)] {
                    let (x, y) = ((k % 41) as i32 + dx, (k / 41) as i32 + dy);
                    if (0..41).contains(&x) && (0..41).contains(&y) {
                        let other = (y * 41 + x) as usize;
                        prop_assert!(side(k) == side(other) || turned[k] == 0 || turned[other] == 0);
                    }
                }
            }
        }
    }

    /// The moved grid of a map of 20 m by 4 m that is bent by up to half a metre, of which the right half is not known.
    fn bent() -> MovedGrid {
        let motion = |k: i32| {
            let x_m = f64::from(k) * 2.0;
            ([x_m, 2.0], Rigid2::<Map, Slam>::new([0.0, 0.05 * x_m], 0.0), 0.1)
        };
        let motion = BentMotion::of((0..=10).map(motion)).unwrap();
        MovedGrid::around([0.0; 2], [20.0, 4.0], 0.05, &motion, |[x, _]| x < 10.0).unwrap()
    }

    #[test]
    fn a_wall_is_drawn_where_the_bend_puts_it_and_free_is_only_what_is_known() {
        let grid = bent();
        let cells = grid.resampled(&[100, -1], 0, -1, |[x, y]| match y {
            _ if !(0.0..20.0).contains(&x) || !(0.0..4.0).contains(&y) => -1,
            y if (2.0..2.05).contains(&y) => 100,
            _ => 0_i8,
        });
        let [x0, y0] = grid.spec.origin_m();
        let wide = grid.spec.width as usize;
        let at = |x: f64, y: f64| cells[((y - y0) / 0.05) as usize * wide + ((x - x0) / 0.05) as usize];
        for x in [1.03, 5.03, 9.03, 13.03, 19.03] {
            let wall_m = 2.025 - 0.05 * x;
            assert!([-0.05, 0.0, 0.05].map(|off| at(x, wall_m + off)).contains(&100), "the wall at {x}");
            assert_eq!(at(x, wall_m + 0.5), if x < 10.0 { 0 } else { -1 }, "the floor at {x}");
        }
    }

    #[test]
    fn a_motion_that_folds_the_map_is_refused() {
        // Two halves that lie on each other, turned against each other.
        let [a, b] = [0.0, 2.0].map(|yaw_rad| Rigid2::<Map, Slam>::new([0.0; 2], yaw_rad));
        let motion = BentMotion::of([([-3.0, 0.0], a, 0.1), ([3.0, 0.0], b, 0.1)]).unwrap();
        let found = MovedGrid::around([-4.0, -4.0], [8.0, 8.0], 0.05, &motion, |_| true);
        assert_eq!(found.err(), Some(GridSpecError::Folded));
    }

    #[test]
    fn the_strongest_value_wins_and_without_one_the_middle() {
        let look = |[x, y]: [f64; 2]| {
            if x < 0.3 && y < 0.3 {
                205
            } else if x > 0.7 {
                1
            } else {
                254
            }
        };
        assert_eq!(resampled(1, 1, look, |samples| strongest(&[0, 205], samples)), [205]);
        assert_eq!(resampled(1, 1, look, |samples| strongest(&[0], samples)), [254]);
    }
}
