//! Contacts between elements and spaces that have no IfcRelSpaceBoundary.

use crate::classify::is_a;
use crate::merge::Merged;
use crate::meshes::points_in_map;
use crate::site_frame::SiteFrame;
use frames::TENTHS_PER_M;
use messages::{BoundaryRecord, SiteBuilder};

/// Elements that can bound a space.
const BOUNDING: [&str; 16] = [
    "IfcWall",
    "IfcSlab",
    "IfcRoof",
    "IfcCovering",
    "IfcDoor",
    "IfcWindow",
    "IfcCurtainWall",
    "IfcColumn",
    "IfcBeam",
    "IfcMember",
    "IfcPlate",
    "IfcRailing",
    "IfcStair",
    "IfcStairFlight",
    "IfcRamp",
    "IfcRampFlight",
];

/// Maximum gap of bodies in contact: plaster and joints are often not modelled.
const GAP: i64 = TENTHS_PER_M as i64 / 20;

/// Minimum contact: 0.01 m², in squares of a tenth of a millimetre.
const MIN_CONTACT: i64 = TENTHS_PER_M as i64 * TENTHS_PER_M as i64 / 100;

/// An upright box in `map`, tenths of a millimetre: lower and upper corner.
type Box3 = [[i32; 3]; 2];

/// Space and element of every contact, sorted: for spaces without any IfcRelSpaceBoundary.
///
/// Bodies are approximated by their boxes: contacts may be too many but not too few, and work blocks rather too many rooms.
/// A door or window uses the opening that it fills.
pub(crate) fn contacts(builder: &SiteBuilder, merged: &Merged, frame: SiteFrame) -> Vec<BoundaryRecord> {
    let model = &merged.model;
    let bounding = model.elements.iter().enumerate().filter(|(_, e)| BOUNDING.iter().any(|entity| is_a(e, entity)));
    let boxed = bounding.filter_map(|(k, element)| {
        let opening = element
            .fills
            .and_then(|o| box_around(points_in_map(&model.openings[o].geometry, &frame.map_from_world).into_iter()));
        let record = &builder.elements[k];
        let own = (record.n_parts > 0).then_some([record.min_tenths, record.max_tenths]);
        Some((k as u32, opening.or(own)?))
    });
    let boxed: Vec<(u32, Box3)> = boxed.collect();
    let mut contacts = Vec::new();
    for (k, space) in builder.spaces.iter().enumerate().filter(|(k, _)| !model.spaces[*k].has_boundaries) {
        let vertices = builder.meshes(space.first_part, space.n_parts).flat_map(|m| m.vertices.iter().copied());
        let Some(room) = box_around(vertices) else { continue };
        let touching = boxed.iter().filter(|(_, element)| touch(&room, element));
        contacts.extend(touching.map(|(element, _)| BoundaryRecord { space: k as u32, element: *element }));
    }
    contacts
}

fn box_around(mut points: impl Iterator<Item = [i32; 3]>) -> Option<Box3> {
    let first = points.next()?;
    let grow = |[lo, hi]: Box3, p: [i32; 3]| {
        [0, 1].map(|end| [0, 1, 2].map(|k| if end == 0 { lo[k].min(p[k]) } else { hi[k].max(p[k]) }))
    };
    Some(points.fold([first, first], grow))
}

/// True if no gap exceeds the maximum and the two longest sides of the shared box give the minimum contact.
fn touch(a: &Box3, b: &Box3) -> bool {
    let mut shared = [0, 1, 2].map(|k| i64::from(a[1][k].min(b[1][k])) - i64::from(a[0][k].max(b[0][k])));
    shared.sort_unstable();
    let [least, middle, most] = shared;
    -GAP <= least && 0 < middle && MIN_CONTACT <= middle * most
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A room of 4 m x 3 m x 2.5 m at the origin.
    const ROOM: Box3 = [[0, 0, 0], [40_000, 30_000, 25_000]];

    #[test]
    fn what_bounds_a_room_touches_it_and_its_neighbours_do_not() {
        for (element, expected, what) in [
            ([[-2_000, 0, 0], [0, 30_000, 25_000]], true, "a wall beside"),
            ([[-2_400, 0, 0], [-400, 30_000, 25_000]], true, "a wall behind 4 cm of plaster"),
            ([[-2_600, 0, 0], [-600, 30_000, 25_000]], false, "a wall 6 cm off"),
            ([[-5_000, -5_000, -2_000], [60_000, 60_000, 0]], true, "the slab below"),
            ([[10_000, 10_000, 25_300], [12_000, 20_000, 28_000]], true, "a beam 3 cm above"),
            ([[10_000, 10_000, 0], [12_000, 12_000, 25_000]], true, "a column inside"),
            ([[-2_000, -2_000, 0], [0, 0, 25_000]], false, "a pier at the corner"),
            ([[-2_000, 0, 0], [0, 300, 300]], false, "9 cm²"),
        ] {
            assert_eq!(touch(&ROOM, &element), expected, "{what}");
        }
    }

    proptest! {
        #[test]
        fn contact_is_mutual_and_grows_with_the_element(
            lo in prop::array::uniform3(-60_000i32..60_000),
            size in prop::array::uniform3(1i32..40_000),
            more in 0i32..20_000,
        ) {
            let element = [lo, [0, 1, 2].map(|k| lo[k] + size[k])];
            let larger = [lo.map(|v| v - more), element[1].map(|v| v + more)];
            prop_assert_eq!(touch(&ROOM, &element), touch(&element, &ROOM));
            prop_assert!(!touch(&ROOM, &element) || touch(&ROOM, &larger));
        }
    }
}
