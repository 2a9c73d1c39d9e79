//! Ramp faces of a body: upward faces that are neither level nor too steep.

use crate::floor_faces::upward_triangles;
use crate::mesh::{MeshView, unit_normal};

/// Minimum slope; flatter faces are level or drained floor.
const MIN_SLOPE_RAD: f64 = 0.02;

/// Tolerance of slopes, because vertices are rounded to tenths of a millimetre.
const TOLERANCE_RAD: f64 = 1e-3;

/// Minimum sloped area of a ramp.
const MIN_AREA_M2: f64 = 0.5;

/// Minimum share of a ramp's upward area that is sloped.
const MIN_SLOPED_SHARE: f64 = 0.5;

/// The sloped faces of a body that is a ramp by its shape: most of its upward area is inclined by at most `max_slope_rad`.
/// Empty for other bodies.
pub fn ramp_faces<'a>(meshes: impl Iterator<Item = MeshView<'a>> + Clone, max_slope_rad: f64) -> Vec<[[i32; 3]; 3]> {
    let upward = meshes.flat_map(|mesh| upward_triangles(mesh, std::f64::consts::FRAC_PI_4));
    let (mut sloped, mut sloped_m2, mut all_m2) = (Vec::new(), 0.0, 0.0);
    for triangle in upward {
        let Some(normal) = unit_normal(&triangle) else { continue };
        let area_m2 = plan_area_m2(&triangle);
        all_m2 += area_m2;
        let slope_rad = libm::acos(normal[2].min(1.0));
        if MIN_SLOPE_RAD < slope_rad && slope_rad <= max_slope_rad + TOLERANCE_RAD {
            sloped_m2 += area_m2;
            sloped.push(triangle);
        }
    }
    let is_ramp = sloped_m2 >= MIN_AREA_M2 && sloped_m2 >= MIN_SLOPED_SHARE * all_m2;
    if is_ramp { sloped } else { Vec::new() }
}

fn plan_area_m2(t: &[[i32; 3]; 3]) -> f64 {
    let d = |k: usize, i: usize| f64::from(t[k][i]) - f64::from(t[0][i]);
    (d(1, 0) * d(2, 1) - d(2, 0) * d(1, 1)) / 2.0 / 1e8
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sheet of four by two metres that rises by so much, looking upward.
    fn sheet(rise: i32) -> usize {
        let vertices = [[0, 0, 0], [40_000, 0, rise], [40_000, 20_000, rise], [0, 20_000, 0]];
        let mesh = MeshView { vertices: &vertices, triangles: &[[0, 1, 2], [0, 2, 3]], closed: false };
        ramp_faces(std::iter::once(mesh), 0.1).len()
    }

    #[test]
    fn a_ramp_is_neither_level_nor_steep() {
        assert_eq!([0, 700, 1_000, 4_000, 4_100, 20_000].map(sheet), [0, 0, 2, 2, 0, 0]);
    }

    #[test]
    fn a_body_that_is_mostly_level_is_no_ramp() {
        let faces = |level: i32| {
            let vertices = [
                [0, 0, 0],
                [20_000, 0, 1_500],
                [20_000, 20_000, 1_500],
                [0, 20_000, 0],
                [20_000 + level, 0, 1_500],
                [20_000 + level, 20_000, 1_500],
            ];
            let triangles = [[0, 1, 2], [0, 2, 3], [1, 4, 5], [1, 5, 2]];
            ramp_faces(std::iter::once(MeshView { vertices: &vertices, triangles: &triangles, closed: false }), 0.1)
                .len()
        };
        assert_eq!([10_000, 30_000].map(faces), [2, 0]);
    }
}
