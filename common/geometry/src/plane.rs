//! The plane of a face that can be seen from above: its height anywhere in plan.

/// Heights over the plan, in tenths of a millimetre.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane {
    origin: [f64; 3],
    gradient: [f64; 2],
}

/// Planes with gradients and heights that differ by less have one key, heights in tenths of a millimetre.
const GRADIENT_UNIT: f64 = 1e-4;
const HEIGHT_UNIT: f64 = 5.0;

impl Plane {
    /// The plane of a triangle that has an area in plan.
    pub fn of(triangle: &[[i32; 3]; 3]) -> Self {
        let origin = triangle[0].map(f64::from);
        let side = |k: usize| [0, 1, 2].map(|i| f64::from(triangle[k][i]) - origin[i]);
        let ([ux, uy, uz], [vx, vy, vz]) = (side(1), side(2));
        let area = ux * vy - uy * vx;
        Self { origin, gradient: [(uz * vy - uy * vz) / area, (ux * vz - uz * vx) / area] }
    }

    /// The level plane at a height.
    pub fn level(z: i32) -> Self {
        Self { origin: [0.0, 0.0, f64::from(z)], gradient: [0.0; 2] }
    }

    /// Height at a place in plan.
    pub fn z(&self, [x, y]: [f64; 2]) -> f64 {
        self.origin[2] + self.gradient[0] * (x - self.origin[0]) + self.gradient[1] * (y - self.origin[1])
    }

    /// Rise per length towards x and y.
    pub fn gradient(&self) -> [f64; 2] {
        self.gradient
    }

    /// The same for planes whose gradients differ by less than 1e-4 and whose heights at a place by less than half a millimetre, but for
    /// rounding: faces of one plane are found by it.
    pub fn key(&self, place: [f64; 2]) -> [i64; 3] {
        let [gx, gy] = self.gradient.map(|g| (g / GRADIENT_UNIT).round() as i64);
        [gx, gy, (self.z(place) / HEIGHT_UNIT).round() as i64]
    }

    /// The angle from the horizontal.
    pub fn slope_rad(&self) -> f64 {
        libm::atan(libm::hypot(self.gradient[0], self.gradient[1]))
    }

    /// Vertices with their heights above the plane instead of in `map`. A solid stays one: upright lines do.
    pub fn heights_above(&self, vertices: &[[i32; 3]]) -> Vec<[i32; 3]> {
        let above = |v: &[i32; 3]| (f64::from(v[2]) - self.z([v[0], v[1]].map(f64::from))).round() as i32;
        vertices.iter().map(|v| [v[0], v[1], above(v)]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heights_are_those_of_the_face_and_above_it_those_of_a_level_floor() {
        let triangle = [[0, 0, 100], [10_000, 0, 1_100], [0, 10_000, 100]];
        let plane = Plane::of(&triangle);
        assert!((plane.z([5_000.0, 7_000.0]) - 600.0).abs() < 1e-9);
        assert!((plane.slope_rad() - libm::atan(0.1)).abs() < 1e-12);
        assert_eq!(plane.heights_above(&triangle), triangle.map(|v| [v[0], v[1], 0]));
        assert_eq!(plane.heights_above(&[[10_000, 0, 13_100]]), [[10_000, 0, 12_000]]);
    }
}
