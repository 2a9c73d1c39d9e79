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
    let range = |k: usize, n: u32| {
        let lo = p.iter().map(|q| q[k]).fold(f64::INFINITY, f64::min).ceil().max(0.0);
        let hi = p.iter().map(|q| q[k]).fold(f64::NEG_INFINITY, f64::max).floor().min(f64::from(n) - 1.0);
        if lo <= hi { lo as u32..hi as u32 + 1 } else { 0..0 }
    };
    for row in range(1, spec.height) {
        for column in range(0, spec.width) {
            let q = [f64::from(column), f64::from(row)];
            let weight = |a: usize, b: usize| {
                ((p[b][0] - p[a][0]) * (q[1] - p[a][1]) - (q[0] - p[a][0]) * (p[b][1] - p[a][1])) / double
            };
            let w = [weight(1, 2), weight(2, 0), weight(0, 1)];
            if w.iter().all(|w| *w >= 0.0) {
                let z = (0..3).map(|k| w[k] * f64::from(t[k][2])).sum::<f64>().round() as i32;
                found(row * spec.width + column, z);
            }
        }
    }
}
