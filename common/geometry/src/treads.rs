//! Level faces of a stair (treads and landings), from low to high.

use crate::floor_faces::upward_triangles;
use crate::mesh::MeshView;
use crate::overlay::{FillRule, union};
use crate::polygon::{MultiPolygon, Ring};
use frames::TENTHS_PER_M;

/// Maximum slope of a level face; treads may be slightly sloped for drainage.
const LEVEL_RAD: f64 = 0.05;

/// Faces within this height of one another are one level, such as a finish on its structure.
const MAX_LEVEL_OFFSET: i32 = 6 * TENTHS_PER_M / 100;

/// Minimum area of a tread; smaller faces are rims of stringers or ends of rails.
const MIN_AREA_M2: f64 = 0.02;

/// A connected level face.
#[derive(Debug, Clone, PartialEq)]
pub struct Tread {
    /// Its height in tenths of a millimetre.
    pub z: i32,
    /// Its plan: one polygon.
    pub plan: MultiPolygon,
    /// Area centroid of the plan in tenths of a millimetre.
    pub centre: [f64; 2],
}

/// The upward level faces of a stair, from low to high.
pub fn treads<'a>(parts: impl IntoIterator<Item = MeshView<'a>>) -> Vec<Tread> {
    let mut faces: Vec<(i32, Ring)> = Vec::new();
    for triangle in parts.into_iter().flat_map(|mesh| upward_triangles(mesh, LEVEL_RAD).collect::<Vec<_>>()) {
        let z = triangle.map(|v| v[2]);
        faces.push((z[0].max(z[1]).max(z[2]), triangle.map(|v| [v[0], v[1]]).to_vec()));
    }
    faces.sort_unstable();
    let mut treads = Vec::new();
    let mut rest = faces.as_slice();
    while let Some((lowest, _)) = rest.first() {
        let n = rest.partition_point(|(z, _)| z - lowest <= MAX_LEVEL_OFFSET);
        let (level, above) = rest.split_at(n);
        rest = above;
        let Some((z, _)) = level.last() else { break };
        let rings: Vec<Ring> = level.iter().map(|(_, ring)| ring.clone()).collect();
        for polygon in union(&rings, FillRule::NonZero).0 {
            let plan = MultiPolygon(vec![polygon]);
            if let Some(centre) = plan.centroid().filter(|_| plan.area_m2() >= MIN_AREA_M2) {
                treads.push(Tread { z: *z, plan, centre });
            }
        }
    }
    treads
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::section::tests::cuboid;

    type Solid = (Vec<[i32; 3]>, Vec<[u32; 3]>);

    /// Boxes of steps of 0.28 m going and 1 m width, one above the other.
    fn steps(heights: &[i32]) -> Vec<Solid> {
        let step =
            |(k, z): (usize, &i32)| cuboid([k as i32 * 2_800, 0, z - 500], [k as i32 * 2_800 + 2_800, 10_000, *z]);
        heights.iter().enumerate().map(step).collect()
    }

    fn levels(heights: &[i32]) -> Vec<i32> {
        let boxes = steps(heights);
        let views = boxes.iter().map(|(vertices, triangles)| MeshView { vertices, triangles, closed: true });
        treads(views).iter().map(|t| t.z).collect()
    }

    #[test]
    fn every_step_is_a_tread_at_its_top() {
        assert_eq!(levels(&[1_750, 3_500, 5_250]), [1_750, 3_500, 5_250]);
    }

    #[test]
    fn a_finish_on_a_step_is_no_step_of_its_own() {
        let (structure, finish) =
            (cuboid([0, 0, 0], [2_800, 10_000, 1_500]), cuboid([0, 0, 1_500], [2_800, 10_000, 1_750]));
        let views = [&structure, &finish].map(|(v, t)| MeshView { vertices: v, triangles: t, closed: true });
        let found = treads(views);
        assert_eq!(found.iter().map(|t| t.z).collect::<Vec<_>>(), [1_750]);
        assert_eq!(found[0].centre, [1_400.0, 5_000.0]);
    }

    #[test]
    fn rims_and_slopes_are_no_treads() {
        let rim = cuboid([0, 0, 0], [300, 3_000, 1_750]);
        let slope = [[0, 0, 0], [10_000, 0, 2_000], [10_000, 10_000, 2_000]];
        let rim = MeshView { vertices: &rim.0, triangles: &rim.1, closed: true };
        assert!(treads([rim, MeshView { vertices: &slope, triangles: &[[0, 1, 2]], closed: false }]).is_empty());
    }
}
