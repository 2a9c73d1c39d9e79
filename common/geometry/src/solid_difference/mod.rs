//! Difference of solids: a closed mesh without what lies in others, as polygon differences in the planes of their faces.
//!
//! Each face of the difference lies in the plane of a face of one of the bodies, so every such plane is looked at once. What
//! bodies fill just below and just above a plane are sections of theirs, and the difference has a face where it is filled on
//! one side only. Polygons are overlaid on a lattice of a quarter of a hundredth of a millimetre; how bodies overlap, touch or
//! share planes makes no difference.
//!
//! The work is pairs of faces and corners of the bodies. There is no search for intersections in space, and nothing that is
//! computed exactly but the signs of overlays: what does not close up in the end is refused.

mod body;
mod face_plane;
mod face_regions;
mod outlined;
mod solid;

pub use solid::Solid;

use crate::vertex_welder::VertexWelder;
use body::{Body, snapped};
use face_regions::{WORK_MAX, face_planes, faces_on, work_on};
use outlined::{Outlined, WELD_M};
use solid::{Extent, NEAR_M};

/// The host without what lies in any cutter; without triangles where nothing is left.
///
/// Bodies may overlap and touch, and cutters reach out of the host. `None` if a body is not closed, if the work is more than a
/// few seconds, or if the result would not be closed.
pub fn difference_of_solids(host: &Solid, cutters: &[Solid]) -> Option<Solid> {
    let extent = Extent::of(&host.positions);
    let mut meeting = cutters.iter().filter(|cutter| Extent::of(&cutter.positions).meets(&extent)).peekable();
    if meeting.peek().is_none() {
        return Some(host.clone());
    }
    let mut bodies = vec![Body::of(host)?];
    for cutter in meeting {
        bodies.push(Body::of(&snapped(cutter, &bodies)?)?);
    }
    let volume_m3 = bodies[0].solid.volume_m3();
    let difference = outlined(&bodies)?.closed()?;
    (-NEAR_M <= difference.volume_m3() && difference.volume_m3() <= volume_m3 * (1.0 + 1e-6) + NEAR_M)
        .then_some(difference)
}

/// The difference of the first body and all others, as outlines.
fn outlined(bodies: &[Body]) -> Option<Outlined> {
    let mut welder = VertexWelder::new(WELD_M);
    // Corners of the bodies stay where they are.
    let mut ids_of_host = Vec::new();
    for (k, body) in bodies.iter().enumerate() {
        let ids: Vec<u32> = body.solid.positions.iter().map(|p| welder.add(*p)).collect();
        if k == 0 {
            ids_of_host = ids;
        }
    }
    let (planes, untouched) = face_planes(bodies)?;
    let work = planes.iter().map(|plane| work_on(plane, bodies)).sum::<u64>();
    (work <= WORK_MAX).then_some(())?;
    let whole = untouched.into_iter().map(|t| t.map(|k| ids_of_host[k as usize])).collect();
    let mut difference = Outlined { planes, welder, outlines: Vec::new(), split: Vec::new(), whole };
    for k in 0..difference.planes.len() {
        for (region, looks_along) in faces_on(&difference.planes[k], bodies)? {
            difference.add(k, &region, looks_along);
        }
    }
    Some(difference)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Point3, Vector3};
    use proptest::prelude::*;

    type Corners = ([f64; 3], [f64; 3]);

    /// A box, its faces outward.
    fn cuboid((low, high): &Corners) -> Solid {
        let corner = |k: usize| [0, 1, 2].map(|axis| if k >> axis & 1 == 0 { low[axis] } else { high[axis] });
        let faces: [[u32; 4]; 6] = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        Solid {
            positions: (0..8).map(|k| corner(k).into()).collect(),
            triangles: faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
        }
    }

    /// Turned about the z axis and tilted, as single precision holds it.
    fn turned(solid: &Solid, angle: f64) -> Solid {
        let (sin, cos) = libm::sincos(angle);
        let turn = |p: &Point3<f64>| {
            let p = Vector3::new(cos * p.x - sin * p.y, sin * p.x + cos * p.y, p.z);
            let p = [p.x, cos * p.y - sin * p.z, sin * p.y + cos * p.z];
            Point3::from(p.map(|c| f64::from(c as f32)))
        };
        Solid { positions: solid.positions.iter().map(turn).collect(), triangles: solid.triangles.clone() }
    }

    const WALL: Corners = ([0.0; 3], [5.0, 0.3, 3.0]);

    /// The volume that is left of a wall of 5 x 0.3 x 3 m, however all of it is turned.
    fn check(cutters: &[Corners], expected_m3: f64) {
        for angle in [0.0, 0.4, 1.9] {
            let cutters: Vec<Solid> = cutters.iter().map(|cutter| turned(&cuboid(cutter), angle)).collect();
            let left = difference_of_solids(&turned(&cuboid(&WALL), angle), &cutters).unwrap();
            assert!(left.is_closed());
            assert!((left.volume_m3() - expected_m3).abs() < 1e-5, "{} instead of {expected_m3}", left.volume_m3());
        }
    }

    #[test]
    fn openings_are_cut_however_they_overlap_touch_and_share_planes_with_the_wall() {
        let flush = |x: [f64; 2], z: [f64; 2]| ([x[0], 0.0, z[0]], [x[1], 0.3, z[1]]);
        let through = |x: [f64; 2], z: [f64; 2]| ([x[0], -1.0, z[0]], [x[1], 1.0, z[1]]);
        check(&[through([1.0, 2.0], [0.5, 1.0])], 4.5 - 0.15);
        check(&[flush([1.0, 2.0], [0.5, 1.0]), flush([1.0, 2.0], [1.5, 2.0])], 4.5 - 0.3);
        check(&[flush([1.0, 2.0], [0.0, 2.0]), through([1.5, 2.5], [0.0, 2.0])], 4.5 - 0.9);
        check(&[flush([1.0, 2.0], [0.0, 2.0]), flush([2.0, 3.0], [0.0, 3.0])], 4.5 - 0.6 - 0.9);
        check(&[through([-1.0, 9.0], [1.0, 2.0])], 3.0);
        check(&[([1.0, 0.1, 1.0], [2.0, 0.2, 2.0])], 4.5 - 0.1);
        check(&[([1.0, 0.0, 1.0], [2.0, 0.1, 2.0]), ([1.0, 0.2, 1.0], [2.0, 0.3, 2.0])], 4.5 - 0.2);
        check(&[flush([0.0, 5.0], [0.0, 3.0])], 0.0);
    }

    #[test]
    fn skins_thinner_than_what_an_archive_holds_are_cut_and_thicker_ones_stay() {
        check(&[([1.0, 0.00005, 1.0], [2.0, 0.3, 2.0])], 4.5 - 0.3);
        check(&[([1.0, 0.002, 1.0], [2.0, 0.3, 2.0])], 4.5 - 0.298);
    }

    #[test]
    fn what_no_cutter_meets_is_as_it_was() {
        let wall = cuboid(&WALL);
        let left = difference_of_solids(&wall, &[cuboid(&([9.0; 3], [10.0; 3]))]).unwrap();
        assert_eq!((left.positions, left.triangles), (wall.positions, wall.triangles));
    }

    #[test]
    fn a_body_with_a_gap_is_refused_and_one_with_corners_on_edges_is_cut() {
        let mut open = cuboid(&WALL);
        open.triangles.pop();
        let opening = cuboid(&([1.0, -1.0, 1.0], [2.0, 1.0, 2.0]));
        assert!(difference_of_solids(&open, std::slice::from_ref(&opening)).is_none());
        assert!(difference_of_solids(&cuboid(&WALL), &[open]).is_none());
        // The edge at the foot has a corner in its middle in one of its two faces.
        let mut split = cuboid(&WALL);
        let middle = split.positions.len() as u32;
        split.positions.push(Point3::new(2.5, 0.0, 0.0));
        let place = split.triangles.iter().position(|t| t.contains(&0) && t.contains(&1)).unwrap();
        let [a, b, c] = split.triangles.remove(place);
        let [p, q, r] = if [a, b] == [0, 1] || [a, b] == [1, 0] {
            [a, b, c]
        } else if [b, c] == [0, 1] || [b, c] == [1, 0] {
            [b, c, a]
        } else {
            [c, a, b]
        };
        split.triangles.extend([[p, middle, r], [middle, q, r]]);
        assert!(!split.is_closed());
        let left = difference_of_solids(&split, &[opening]).unwrap();
        assert!((left.volume_m3() - (4.5 - 0.3)).abs() < 1e-9);
    }

    proptest! {
        #[test]
        fn a_point_is_left_if_it_is_in_the_wall_and_in_no_cutter(
            cutters in prop::collection::vec((0..20i32, -2..4i32, 0..12i32, 1..9i32, 1..5i32, 1..9i32), 1..7),
        ) {
            // Corners on a lattice of 0.25 x 0.1 x 0.25 m, so that they meet in all ways.
            let corners = |&(x, y, z, w, d, h): &(i32, i32, i32, i32, i32, i32)| -> Corners {
                let at = |x: i32, y: i32, z: i32| [0.25 * f64::from(x), 0.1 * f64::from(y), 0.25 * f64::from(z)];
                (at(x, y, z), at(x + w, y + d, z + h))
            };
            let cutters: Vec<Corners> = cutters.iter().map(corners).collect();
            let mut expected_m3 = 0.0;
            for k in 0..20 * 3 * 12 {
                let p = [0.25 * (f64::from(k % 20) + 0.5), 0.1 * (f64::from(k / 20 % 3) + 0.5), 0.25 * (f64::from(k / 60) + 0.5)];
                let is_in = |(low, high): &Corners| (0..3).all(|axis| low[axis] < p[axis] && p[axis] < high[axis]);
                expected_m3 += if cutters.iter().any(is_in) { 0.0 } else { 0.25 * 0.1 * 0.25 };
            }
            let solids: Vec<Solid> = cutters.iter().map(cuboid).collect();
            let left = difference_of_solids(&cuboid(&WALL), &solids);
            // Blocks that touch along an edge alone have four faces there, which is closed as well.
            let left = left.unwrap();
            prop_assert!((left.volume_m3() - expected_m3).abs() < 5e-5, "{} instead of {expected_m3}", left.volume_m3());
        }
    }
}
