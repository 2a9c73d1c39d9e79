//! Contacts between elements and spaces that have no IfcRelSpaceBoundary.

use crate::classify::is_a;
use crate::diagnostics::add_diagnostic;
use crate::merge::Merged;
use crate::meshes::points_in_map;
use crate::site_frame::SiteFrame;
use frames::TENTHS_PER_M;
use ifc::{Diagnostic, DiagnosticCode, Named, Severity};
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

/// Contacts that a site may have: elements that all lie in one place with all spaces multiply.
const CONTACTS_MAX: usize = 4_000_000;

/// Boxes that are compared one by one.
const LEAF: usize = 8;

/// An upright box in `map`, tenths of a millimetre: lower and upper corner.
type Box3 = [[i32; 3]; 2];

/// Adds space and element of every contact, sorted: for spaces without any IfcRelSpaceBoundary.
///
/// Bodies are approximated by their boxes: contacts may be too many but not too few, and work blocks rather too many rooms.
/// A door or window uses the opening that it fills.
pub(crate) fn add_contacts(builder: &mut SiteBuilder, merged: &Merged, frame: SiteFrame) {
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
    let Some(tree) = BoxTree::of(boxed.collect()) else { return };
    for space in (0..model.spaces.len()).filter(|k| !model.spaces[*k].has_boundaries) {
        let record = &builder.spaces[space];
        let vertices = builder.meshes(record.first_part, record.n_parts).flat_map(|m| m.vertices.iter().copied());
        let Some(room) = box_around(vertices) else { continue };
        let touching = tree.touching(&room);
        if builder.contacts.len() + touching.len() > CONTACTS_MAX {
            add_diagnostic(builder, merged.space_source[space], &too_many(&model.spaces[space].id));
            return;
        }
        let contact = |element| BoundaryRecord { space: space as u32, element };
        builder.contacts.extend(touching.into_iter().map(contact));
    }
}

fn too_many(space: &Named) -> Diagnostic {
    Diagnostic {
        severity: Severity::Error,
        code: DiagnosticCode::SpaceContactsTooMany,
        entity: Some(space.clone()),
        source: None,
        message: format!(
            "elements touch spaces in more than {CONTACTS_MAX} places; those of this and later spaces are left out"
        ),
    }
}

/// Boxes of elements in halves of halves, each with the box around it.
struct BoxTree {
    around: Box3,
    content: Content,
}

enum Content {
    /// Numbers of elements with their boxes.
    Boxes(Vec<(u32, Box3)>),
    Halves(Box<[BoxTree; 2]>),
}

impl BoxTree {
    /// `None` without boxes. The halves lie beside each other along the longest side of the box around them.
    fn of(mut boxes: Vec<(u32, Box3)>) -> Option<Self> {
        let around = boxes.iter().map(|(_, element)| *element).reduce(|a, b| grown(grown(a, b[0]), b[1]))?;
        if boxes.len() <= LEAF {
            return Some(Self { around, content: Content::Boxes(boxes) });
        }
        let extent = |axis: &usize| i64::from(around[1][*axis]) - i64::from(around[0][*axis]);
        let axis = (0..3).max_by_key(extent).unwrap_or_default();
        let middle = boxes.len() / 2;
        // Twice the centre; the number makes the order total.
        let place = |(k, b): &(u32, Box3)| (i64::from(b[0][axis]) + i64::from(b[1][axis]), *k);
        boxes.select_nth_unstable_by_key(middle, place);
        let rest = boxes.split_off(middle);
        Some(Self { around, content: Content::Halves(Box::new([Self::of(boxes)?, Self::of(rest)?])) })
    }

    /// Elements that touch the room, sorted.
    fn touching(&self, room: &Box3) -> Vec<u32> {
        let mut found = Vec::new();
        self.collect(room, &mut found);
        found.sort_unstable();
        found
    }

    fn collect(&self, room: &Box3, found: &mut Vec<u32>) {
        // What touches no box around an element does not touch the element.
        if !touch(room, &self.around) {
            return;
        }
        match &self.content {
            Content::Boxes(boxes) => {
                found.extend(boxes.iter().filter(|(_, element)| touch(room, element)).map(|(k, _)| *k));
            }
            Content::Halves(halves) => halves.iter().for_each(|half| half.collect(room, found)),
        }
    }
}

fn box_around(mut points: impl Iterator<Item = [i32; 3]>) -> Option<Box3> {
    let first = points.next()?;
    Some(points.fold([first, first], grown))
}

/// The box around a box and a point.
fn grown([lo, hi]: Box3, p: [i32; 3]) -> Box3 {
    [[0, 1, 2].map(|k| lo[k].min(p[k])), [0, 1, 2].map(|k| hi[k].max(p[k]))]
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

    /// Boxes within 18 m, each side short or up to 6 m long.
    fn boxes(n_max: usize) -> impl Strategy<Value = Vec<Box3>> {
        let bar = prop::array::uniform3((-60_000i32..60_000, prop_oneof![1i32..3_000, 1i32..60_000]));
        prop::collection::vec(
            bar.prop_map(|sides| [sides.map(|(lo, _)| lo), sides.map(|(lo, size)| lo + size)]),
            0..n_max,
        )
    }

    proptest! {
        #[test]
        fn the_tree_finds_what_comparing_all_boxes_finds(elements in boxes(200), rooms in boxes(8)) {
            let numbered: Vec<(u32, Box3)> = (0..).zip(elements).collect();
            let tree = BoxTree::of(numbered.clone());
            prop_assert_eq!(tree.is_none(), numbered.is_empty());
            for room in rooms {
                let all: Vec<u32> = numbered.iter().filter(|(_, b)| touch(&room, b)).map(|(k, _)| *k).collect();
                prop_assert_eq!(tree.as_ref().map(|tree| tree.touching(&room)).unwrap_or_default(), all);
            }
        }

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
