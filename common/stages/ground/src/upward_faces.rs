//! The faces of a body that carry somebody, and the undersides with which it rests on others.

use crate::plane::{Triangle, double_area};
use geometry::{MeshView, unit_normal, upward_triangles};
use messages::GroundClass;

/// Steepest slope of ground: 45 degrees, steeper than any vehicle or person on legs goes.
pub const MAX_SLOPE_RAD: f64 = std::f64::consts::FRAC_PI_4;

/// Steepest slope of a tread or deck: drained, not inclined.
const LEVEL_RAD: f64 = 0.05;

/// Slopes are computed from vertices that were rounded to tenths of a millimetre.
const SLOPE_TOLERANCE_RAD: f64 = 1e-3;

/// The faces of a mesh that carry somebody by its class, counter-clockwise from above, with their slopes.
pub fn upward_faces(mesh: MeshView<'_>, class: GroundClass) -> Vec<([[i32; 3]; 3], f32)> {
    let max_slope_rad = match class {
        GroundClass::StairTread | GroundClass::ScaffoldDeck => LEVEL_RAD,
        _ => MAX_SLOPE_RAD,
    };
    let is_sheet = class.is_outdoors() && mesh.is_sheet();
    let faces: Vec<Triangle> = if is_sheet {
        mesh.corners().map(turned_up).collect()
    } else {
        upward_triangles(mesh, max_slope_rad + SLOPE_TOLERANCE_RAD).collect()
    };
    let sloped = faces.into_iter().filter(|t| double_area(t) > 0).filter_map(|t| Some((t, slope_rad(&t)?)));
    let limit = (max_slope_rad + SLOPE_TOLERANCE_RAD) as f32;
    sloped.filter(|(_, slope_rad)| *slope_rad <= limit).map(|(t, slope)| (t, slope.min(max_slope_rad as f32))).collect()
}

/// The faces of a solid that look down, counter-clockwise from above. An open surface rests on nothing.
pub(crate) fn undersides(mesh: MeshView<'_>) -> Vec<Triangle> {
    if !mesh.closed {
        return Vec::new();
    }
    let inside_out = mesh.volume_m3() < 0.0;
    let looks_down = |t: &Triangle| (double_area(t) < 0) != inside_out && double_area(t) != 0;
    mesh.corners().filter(looks_down).map(turned_up).collect()
}

fn turned_up([a, b, c]: Triangle) -> Triangle {
    if double_area(&[a, b, c]) < 0 { [a, c, b] } else { [a, b, c] }
}

fn slope_rad(t: &Triangle) -> Option<f32> {
    Some(libm::acos(unit_normal(t)?[2].min(1.0)) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mesh<'a>(vertices: &'a [[i32; 3]], triangles: &'a [[u32; 3]], closed: bool) -> MeshView<'a> {
        MeshView { vertices, triangles, closed }
    }

    #[test]
    fn open_terrain_counts_whichever_way_it_is_turned_and_steep_faces_do_not() {
        let vertices = [[0, 0, 0], [10_000, 0, 0], [0, 10_000, 1_000], [10_000, 10_000, 60_000], [0, 0, 5_000]];
        let triangles = [[0, 2, 1], [1, 3, 2], [0, 1, 4]];
        let found = upward_faces(mesh(&vertices, &triangles, false), GroundClass::Terrain);
        assert_eq!(found.len(), 1);
        assert!(double_area(&found[0].0) > 0 && (f64::from(found[0].1) - libm::atan(0.1)).abs() < 1e-6);
        assert!(upward_faces(mesh(&vertices, &triangles, false), GroundClass::StairTread).is_empty());
    }

    #[test]
    fn of_a_solid_the_top_carries_and_the_underside_rests() {
        let corner = [[0, 0], [10_000, 0], [10_000, 10_000], [0, 10_000]];
        let vertices: Vec<[i32; 3]> = [0, 2_000].iter().flat_map(|&z| corner.map(|[x, y]| [x, y, z])).collect();
        let quads = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];
        let triangles: Vec<[u32; 3]> = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        for class in [GroundClass::Floor, GroundClass::Terrain] {
            let top = upward_faces(mesh(&vertices, &triangles, true), class);
            assert!(top.len() == 2 && top.iter().all(|(t, _)| t.iter().all(|v| v[2] == 2_000)));
        }
        let bottom = undersides(mesh(&vertices, &triangles, true));
        assert!(bottom.len() == 2 && bottom.iter().all(|t| double_area(t) > 0 && t[0][2] == 0));
        assert!(undersides(mesh(&vertices, &triangles, false)).is_empty());
        // The skin of a solid that is not closed has an inside, too.
        let skin = upward_faces(mesh(&vertices, &triangles[..11], false), GroundClass::Terrain);
        assert!(skin.iter().all(|(t, _)| t.iter().all(|v| v[2] == 2_000)), "{skin:?}");
    }
}
