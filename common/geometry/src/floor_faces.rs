//! Upward faces of a mesh between two heights, and the test of their slope.

use crate::mesh::{MeshView, unit_normal};
use crate::polygon::{Ring, ring_area_doubled};
use crate::slab::{Slab, clip_to_slab};

/// The upward triangles with a slope of at most `max_slope_rad`, counter-clockwise from above.
///
/// A mesh with negative volume is treated as inside out.
pub fn upward_triangles(mesh: MeshView<'_>, max_slope_rad: f64) -> impl Iterator<Item = [[i32; 3]; 3]> {
    let inside_out = mesh.volume_m3() < 0.0;
    let least_upward = libm::cos(max_slope_rad) - 1e-6;
    mesh.corners()
        .map(move |[a, b, c]| if inside_out { [a, c, b] } else { [a, b, c] })
        .filter(move |t| normal_z(t) >= least_upward)
}

/// Horizontal projections of the parts of [`upward_triangles`] between two heights.
///
/// Heights in tenths of a millimetre, both included. Rings are counter-clockwise and may overlap.
pub fn floor_faces(mesh: MeshView<'_>, lowest: i32, highest: i32, max_slope_rad: f64) -> Vec<Ring> {
    let Some((z_min, z_max)) = mesh.z_range() else { return Vec::new() };
    // The slab's faces lie half a unit inside its bounds: one unit more includes both heights.
    let band = Slab { lo: lowest - 1, hi: highest + 1 };
    if !band.meets(z_min, z_max) {
        return Vec::new();
    }
    let mut plan = Vec::new();
    let mut rings = Vec::new();
    for triangle in upward_triangles(mesh, max_slope_rad) {
        let z = triangle.map(|v| v[2]);
        if band.meets(z[0].min(z[1]).min(z[2]), z[0].max(z[1]).max(z[2])) {
            clip_to_slab(&triangle, band, &mut plan);
            if ring_area_doubled(&plan) > 0 {
                rings.push(plan.clone());
            }
        }
    }
    rings
}

/// Upward component of the unit normal; 0 for degenerate triangles.
fn normal_z(triangle: &[[i32; 3]; 3]) -> f64 {
    unit_normal(triangle).map_or(0.0, |normal| normal[2])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::section::tests::cuboid;

    #[test]
    fn only_the_top_of_a_slab_is_floor() {
        let (v, t) = cuboid([0, 0, -2_000], [10_000, 10_000, 0]);
        let mesh = MeshView { vertices: &v, triangles: &t, closed: true };
        assert_eq!(floor_faces(mesh, -500, 500, 0.1).len(), 2);
        assert_eq!(floor_faces(mesh, 0, 500, 0.1).len(), 2, "both heights count");
        assert!(floor_faces(mesh, -3_000, -1_000, 0.1).is_empty(), "a bottom is no floor");
    }

    #[test]
    fn steep_faces_are_no_floor_and_gentle_ones_are() {
        let ramp = |rise: i32| {
            let v = [[0, 0, 0], [10_000, 0, rise], [10_000, 10_000, rise]];
            floor_faces(MeshView { vertices: &v, triangles: &[[0, 1, 2]], closed: false }, -500, 10_000, 0.1).len()
        };
        assert_eq!((ramp(900), ramp(1_200)), (1, 0));
    }
}
