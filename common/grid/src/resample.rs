//! Resampling of a map into a rotated frame.

/// Places that are looked at in a cell, in both directions: corners of cells that were turned are then not overlooked.
const LOOKS: usize = 3;

/// What is at many places of a cell becomes one value, so that nothing that stops a robot is lost.
///
/// `look` gives what is at a point of the new map, in its cells from the lower left corner of its lower left cell; the result is
/// row-major from there. `first_wins` are values from the one that beats all others on; without any of them a cell has what is at
/// its middle.
pub fn resampled(width: usize, height: usize, first_wins: &[u8], look: impl Fn([f64; 2]) -> u8) -> Vec<u8> {
    let offsets: Vec<[f64; 2]> =
        (0..LOOKS * LOOKS).map(|k| [k % LOOKS, k / LOOKS].map(|step| (step as f64 + 0.5) / LOOKS as f64)).collect();
    let cell = |index: usize| {
        let corner = [(index % width) as f64, (index / width) as f64];
        let seen = |offset: &[f64; 2]| look([corner[0] + offset[0], corner[1] + offset[1]]);
        let looks: Vec<u8> = offsets.iter().map(seen).collect();
        let strongest = first_wins.iter().find(|wins| looks.contains(wins));
        strongest.copied().unwrap_or(looks[LOOKS * LOOKS / 2])
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
            // Nobody gets from one side to the other, diagonally either.
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
