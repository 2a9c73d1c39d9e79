//! Samples of floor faces in plan.

use frames::TENTHS_PER_M;
use grid::GridSpec;

/// Heights this near are one floor: the default robot's step.
pub(crate) const STEP: i32 = TENTHS_PER_M / 20;

/// Upward triangles in `map`.
pub(crate) type FloorTriangles = Vec<[[i32; 3]; 3]>;

/// Height of a triangle that runs counter-clockwise at every place whose middle it covers.
pub(crate) fn each_sample(spec: &GridSpec, t: &[[i32; 3]; 3], mut found: impl FnMut(u32, i32)) {
    let size = f64::from(spec.cell_tenths);
    let p = t.map(|v| [0, 1].map(|k| f64::from(v[k]) / size - f64::from(spec.first_cell[k]) - 0.5));
    let double = (p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) - (p[2][0] - p[0][0]) * (p[1][1] - p[0][1]);
    if double <= 0.0 {
        return;
    }
    let whole = |lo: f64, hi: f64, n: u32| {
        let (lo, hi) = (lo.ceil().max(0.0), hi.floor().min(f64::from(n) - 1.0));
        if lo <= hi { lo as u32..hi as u32 + 1 } else { 0..0 }
    };
    let least = |k: usize| p.iter().map(|q| q[k]).fold(f64::INFINITY, f64::min);
    let greatest = |k: usize| p.iter().map(|q| q[k]).fold(f64::NEG_INFINITY, f64::max);
    let edges = [[1, 2], [2, 0], [0, 1]];
    let is_level = t.iter().all(|corner| corner[2] == t[0][2]);
    for row in whole(least(1), greatest(1), spec.height) {
        let y = f64::from(row);
        // Where the row crosses the edges, a cell farther than rounding can be wrong.
        let (mut lo, mut hi) = (least(0), greatest(0));
        for [a, b] in edges {
            let dy = p[b][1] - p[a][1];
            let x = p[a][0] + (p[b][0] - p[a][0]) * (y - p[a][1]) / dy;
            if dy > 0.0 {
                hi = hi.min(x + 1.0);
            } else if dy < 0.0 {
                lo = lo.max(x - 1.0);
            }
        }
        let doubled = |column: u32| {
            let x = f64::from(column);
            edges.map(|[a, b]| (p[b][0] - p[a][0]) * (y - p[a][1]) - (x - p[a][0]) * (p[b][1] - p[a][1]))
        };
        let is_outside = |column: u32| doubled(column).iter().any(|area| *area < 0.0);
        let mut columns = whole(lo, hi, spec.width);
        // What is between two columns inside is inside.
        while !columns.is_empty() && is_outside(columns.start) {
            columns.start += 1;
        }
        while !columns.is_empty() && is_outside(columns.end - 1) {
            columns.end -= 1;
        }
        for column in columns {
            let z = if is_level {
                t[0][2]
            } else {
                let doubled = doubled(column);
                (0..3).map(|k| doubled[k] / double * f64::from(t[k][2])).sum::<f64>().round() as i32
            };
            found(row * spec.width + column, z);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Tries every cell.
    fn slow(spec: &GridSpec, t: &[[i32; 3]; 3]) -> Vec<u32> {
        let middle = |cell: i32, first: i32| (i64::from(cell) + i64::from(first)) * i64::from(spec.cell_tenths) * 2;
        let half = i64::from(spec.cell_tenths);
        let covers = |column: i32, row: i32| {
            let q = [middle(column, spec.first_cell[0]) + half, middle(row, spec.first_cell[1]) + half];
            let p = t.map(|v| [i64::from(v[0]) * 2, i64::from(v[1]) * 2]);
            let turn =
                |a: [i64; 2], b: [i64; 2], c: [i64; 2]| (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
            let turns = [turn(p[1], p[2], q), turn(p[2], p[0], q), turn(p[0], p[1], q)];
            turn(p[0], p[1], p[2]) > 0 && turns.iter().all(|turn| *turn > 0)
        };
        let columns = |row: u32| (0..spec.width).filter(move |&column| covers(column as i32, row as i32));
        (0..spec.height).flat_map(|row| columns(row).map(move |column| row * spec.width + column)).collect()
    }

    proptest! {
        #[test]
        fn cells_are_those_whose_middles_a_triangle_covers(
            corners in prop::array::uniform3(prop::array::uniform3(-9_000i32..19_000)),
            is_thin in any::<bool>(),
        ) {
            let spec = GridSpec { first_cell: [-7, -9], width: 25, height: 31, cell_tenths: 500 };
            let mut t = corners;
            if is_thin {
                t[2] = [0, 1, 2].map(|k| t[0][k] + (t[1][k] - t[0][k]) / 2 + 3);
            }
            let mut found = Vec::new();
            each_sample(&spec, &t, |cell, z| {
                let heights = t.map(|v| v[2]);
                assert!((heights.iter().min() <= Some(&z)) && Some(&z) <= heights.iter().max());
                found.push(cell);
            });
            // Middles on an edge may be either.
            let inside = slow(&spec, &t);
            prop_assert!(inside.iter().all(|cell| found.contains(cell)), "{:?} {:?}", inside, found);
            prop_assert!(found.len() <= inside.len() + 60);
        }
    }
}
