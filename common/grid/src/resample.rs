//! Resampling of a map into a rotated frame.

use crate::spec::{GridSpec, GridSpecError};
use frames::TENTHS_PER_M;
use geometry::Bounds;

/// Samples per cell in both directions: enough to find the corners of rotated cells.
const SAMPLES_PER_SIDE: usize = 3;

/// The grid around a map that was moved: `origin_m` and `size_m` are those of the map in its own frame, `moved` brings a point
/// from there into the new frame. Metres.
///
/// # Errors
/// A resolution that is none, or too many cells.
pub fn spec_around_moved(
    origin_m: [f64; 2],
    size_m: [f64; 2],
    resolution_m: f64,
    moved: impl Fn([f64; 2]) -> [f64; 2],
) -> Result<GridSpec, GridSpecError> {
    let [x, y] = origin_m;
    let corners = [[0.0, 0.0], [size_m[0], 0.0], [0.0, size_m[1]], size_m].map(|[dx, dy]| moved([x + dx, y + dy]));
    let bound = |k: usize, pick: fn(f64, f64) -> f64| corners.iter().map(|c| c[k]).reduce(pick).unwrap_or(0.0);
    let tenths = |metres: f64| (metres * f64::from(TENTHS_PER_M)) as i32;
    let min = [0, 1].map(|k| tenths(bound(k, f64::min)));
    let max = [0, 1].map(|k| tenths(bound(k, f64::max)));
    GridSpec::around(Bounds { min, max }, 0, resolution_m)
}

/// Resamples a map: each cell gets the strongest of several samples, so that no obstacle is lost.
///
/// `sample` gives the value at a point of the new map, in cells from its lower left corner; the result is row-major.
/// `strongest_first` are values in order of priority; without any of them a cell gets the value at its middle.
pub fn resampled<T: Copy + PartialEq>(
    width: usize,
    height: usize,
    strongest_first: &[T],
    sample: impl Fn([f64; 2]) -> T,
) -> Vec<T> {
    let offsets: Vec<[f64; 2]> = (0..SAMPLES_PER_SIDE * SAMPLES_PER_SIDE)
        .map(|k| [k % SAMPLES_PER_SIDE, k / SAMPLES_PER_SIDE].map(|step| (step as f64 + 0.5) / SAMPLES_PER_SIDE as f64))
        .collect();
    let cell = |index: usize| {
        let corner = [(index % width) as f64, (index / width) as f64];
        let at = |offset: &[f64; 2]| sample([corner[0] + offset[0], corner[1] + offset[1]]);
        let samples: Vec<T> = offsets.iter().map(at).collect();
        let strongest = strongest_first.iter().find(|value| samples.contains(value));
        strongest.copied().unwrap_or(samples[SAMPLES_PER_SIDE * SAMPLES_PER_SIDE / 2])
    };
    (0..width * height).map(cell).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_wall_of_a_cell_stays_whole_however_it_is_turned(yaw in 0.0..6.3f64, across in 0.0..1.0f64) {
            // A wall along a line through the middle of 41 x 41 cells, one cell thick.
            let (sin, cos) = (libm::sin(yaw), libm::cos(yaw));
            let far = |[x, y]: [f64; 2]| (x - 20.5) * cos + (y - 20.5) * sin;
            let look = |p: [f64; 2]| if (far(p) - across).abs() < 0.5 { 0 } else { 254 };
            let turned = resampled(41, 41, &[0, 205], look);
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
        assert_eq!(resampled(1, 1, &[0, 205], look), [205]);
        assert_eq!(resampled(1, 1, &[0], look), [254]);
    }
}
