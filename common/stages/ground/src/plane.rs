//! Triangles in plan: their areas, and the places that they cover.

/// Corners of a triangle in `map`, tenths of a millimetre, counter-clockwise from above.
pub(crate) type Triangle = [[i32; 3]; 3];

/// Twice the signed area in plan.
pub(crate) fn double_area(t: &Triangle) -> i64 {
    let d = |k: usize, i: usize| i64::from(t[k][i]) - i64::from(t[0][i]);
    d(1, 0) * d(2, 1) - d(2, 0) * d(1, 1)
}

/// True if a triangle covers a place in plan, its border included.
pub(crate) fn covers(t: &Triangle, [x, y]: [f64; 2]) -> bool {
    (0..3).all(|k| {
        let (a, b) = (t[k], t[(k + 1) % 3]);
        let [ax, ay, bx, by] = [a[0], a[1], b[0], b[1]].map(f64::from);
        (bx - ax) * (y - ay) - (by - ay) * (x - ax) >= 0.0
    })
}
