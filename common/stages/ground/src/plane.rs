//! Heights of the planes of triangles, and areas in plan.

/// Corners of a triangle in `map`, tenths of a millimetre, counter-clockwise from above.
pub(crate) type Triangle = [[i32; 3]; 3];

/// The plane of a triangle that has an area in plan: heights in tenths of a millimetre.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Plane {
    origin: [f64; 3],
    gradient: [f64; 2],
}

impl Plane {
    pub(crate) fn of(triangle: &Triangle) -> Self {
        let origin = triangle[0].map(f64::from);
        let side = |k: usize| [0, 1, 2].map(|i| f64::from(triangle[k][i]) - origin[i]);
        let ([ux, uy, uz], [vx, vy, vz]) = (side(1), side(2));
        let area = ux * vy - uy * vx;
        Self { origin, gradient: [(uz * vy - uy * vz) / area, (ux * vz - uz * vx) / area] }
    }

    pub(crate) fn z(&self, [x, y]: [f64; 2]) -> f64 {
        self.origin[2] + self.gradient[0] * (x - self.origin[0]) + self.gradient[1] * (y - self.origin[1])
    }
}

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
