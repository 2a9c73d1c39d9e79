//! Doors between the ends of their openings, with the types that Open-RMF knows.

use crate::names::unique;
use export::{ExportInput, rounded};
use frames::TENTHS_PER_M;
use messages::door_operations::{DoorFrame, Leaf, LeafMotion, mirrored, operation_of};
use messages::{DoorRecord, ElementState, NONE};
use std::collections::BTreeSet;

/// A door that hangs.
#[derive(Debug, Clone)]
pub(crate) struct Door {
    /// Of the site.
    pub(crate) door: u32,
    /// On which it stands.
    pub(crate) map_storey: u32,
    pub(crate) name: String,
    pub(crate) global_id: String,
    /// IfcDoorTypeOperationEnum as the model says it; empty if it says nothing.
    pub(crate) operation: String,
    /// Both ends of the opening of its moving leaves, in `map`: a single leaf hangs at the first, or slides towards it.
    pub(crate) ends_m: [[f64; 2]; 2],
    pub(crate) kind: DoorKind,
}

/// What its leaves do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum DoorKind {
    Hinged(Swing),
    /// With the width of the leaf at the first end as a part of that at the second.
    DoubleHinged(Swing, f64),
    Sliding,
    /// With the same.
    DoubleSliding(f64),
}

/// To which side leaves swing, seen from the first end to the second: `Forward` is to the left.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Swing {
    Forward,
    Backward,
    Both,
}

impl Door {
    /// True if a way between two places passes it, as `building_map_generator` has it: two lines that are nearly parallel or short
    /// do not cross.
    pub(crate) fn is_crossed_by(&self, [a, b]: [[f64; 2]; 2]) -> bool {
        let [c, d] = self.ends_m;
        let cross = |p: [f64; 2], q: [f64; 2]| p[0] * q[1] - p[1] * q[0];
        let from_to = |p: [f64; 2], q: [f64; 2]| [q[0] - p[0], q[1] - p[1]];
        let (way, opening, between) = (from_to(a, b), from_to(c, d), from_to(a, c));
        let area = cross(way, opening);
        let [on_way, on_opening] = [cross(between, opening) / area, cross(between, way) / area];
        area.abs() >= MIN_AREA_M2 && (0.0..=1.0).contains(&on_way) && (0.0..=1.0).contains(&on_opening)
    }
}

/// Least area of the parallelogram of two lines that cross.
const MIN_AREA_M2: f64 = 0.01;

/// All doors that hang in what stands, but the landing doors of lifts.
pub(crate) fn doors(input: &ExportInput<'_>, landing_doors: &BTreeSet<u32>) -> Vec<Door> {
    let site = input.site;
    let elements = site.doors.iter().map(|door| &site.elements[door.element as usize]);
    let names = unique(elements.map(|e| (site.text(e.name).to_owned(), site.text(e.global_id))));
    let hung = (0..)
        .zip(site.doors)
        .zip(names)
        .filter(|((index, door), _)| is_hung(input, door) && !landing_doors.contains(index));
    hung.map(|((index, record), name)| {
        let (ends_m, kind) = ends_and_kind(input, record);
        Door {
            door: index,
            map_storey: record.map_storey,
            name,
            global_id: site.text(site.elements[record.element as usize].global_id).to_owned(),
            operation: site.text(record.operation).to_owned(),
            ends_m,
            kind,
        }
    })
    .collect()
}

/// True if a door with a passage is finished, and so is the wall around it, if it has one.
pub(crate) fn is_hung(input: &ExportInput<'_>, door: &DoorRecord) -> bool {
    let is_built = |element: u32| input.schedule_state.effective(element as usize) == ElementState::Built;
    let host = input.site.openings.get(door.opening as usize).map_or(NONE, |opening| opening.host);
    door.passage.half[0] > 0.0 && is_built(door.element) && (host == NONE || is_built(host))
}

fn ends_and_kind(input: &ExportInput<'_>, door: &DoorRecord) -> ([[f64; 2]; 2], DoorKind) {
    let passage = door.passage.to_box();
    let frame = DoorFrame::of(door, &passage);
    let mut leaves = operation_of(input.site, door, "").map(|(_, leaves, _)| leaves).unwrap_or_default();
    if frame.turned {
        mirrored(&mut leaves);
        leaves.reverse();
    }
    leaves.retain(|leaf| leaf.motion != LeafMotion::Fixed);
    let jamb = |x: f64| frame.at(x, 0.0).map(|c| rounded(c / f64::from(TENTHS_PER_M)));
    let [left, right] = [jamb(0.0), jamb(2.0 * passage.half[0])];
    let (is_right, kind) = kind_of(&leaves);
    (if is_right { [right, left] } else { [left, right] }, kind)
}

/// The kind of a door, and whether its first end is its right one. Open-RMF has no type for leaves that fold, turn or rise; these, and
/// those of which the model says nothing, are hinged as a door is of which nobody has said anything.
fn kind_of(leaves: &[Leaf]) -> (bool, DoorKind) {
    let swing = |towards: f64, both: bool| match (both, towards > 0.0) {
        (true, _) => Swing::Both,
        (false, true) => Swing::Forward,
        (false, false) => Swing::Backward,
    };
    let width = |leaf: &Leaf| leaf.span[1] - leaf.span[0];
    match leaves {
        [Leaf { motion: LeafMotion::Swing { left: true, towards, both }, .. }] => {
            (false, DoorKind::Hinged(swing(*towards, *both)))
        }
        [Leaf { motion: LeafMotion::Swing { left: false, towards, both }, .. }] => {
            (true, DoorKind::Hinged(swing(-towards, *both)))
        }
        [a @ Leaf { motion: LeafMotion::Swing { towards, both, .. }, .. }, b] => {
            (false, DoorKind::DoubleHinged(swing(*towards, *both), width(a) / width(b)))
        }
        [Leaf { motion: LeafMotion::Slide { to }, .. }] => (*to > 0.0, DoorKind::Sliding),
        [a @ Leaf { motion: LeafMotion::Slide { .. }, .. }, b] => (false, DoorKind::DoubleSliding(width(a) / width(b))),
        _ => (false, DoorKind::Hinged(Swing::Forward)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::door_operations::leaves;

    #[test]
    fn operation_types_have_their_kind_and_hang_at_the_first_end() {
        for (operation, expected) in [
            ("SINGLE_SWING_LEFT", (false, DoorKind::Hinged(Swing::Forward))),
            ("SINGLE_SWING_RIGHT", (true, DoorKind::Hinged(Swing::Backward))),
            ("DOUBLE_SWING_RIGHT", (true, DoorKind::Hinged(Swing::Both))),
            ("DOUBLE_DOOR_SINGLE_SWING", (false, DoorKind::DoubleHinged(Swing::Forward, 1.0))),
            ("DOUBLE_DOOR_SINGLE_SWING_OPPOSITE_LEFT", (false, DoorKind::DoubleHinged(Swing::Backward, 1.0))),
            ("SLIDING_TO_LEFT", (false, DoorKind::Sliding)),
            ("SLIDING_TO_RIGHT", (true, DoorKind::Sliding)),
            ("DOUBLE_DOOR_SLIDING", (false, DoorKind::DoubleSliding(1.0))),
            ("REVOLVING", (false, DoorKind::Hinged(Swing::Forward))),
        ] {
            assert_eq!(kind_of(&leaves(operation, 0.5).unwrap_or_default()), expected, "{operation}");
        }
        assert_eq!(kind_of(&[]), (false, DoorKind::Hinged(Swing::Forward)));
        let unequal = leaves("DOUBLE_DOOR_SLIDING", 0.25).unwrap_or_default();
        assert_eq!(kind_of(&unequal).1, DoorKind::DoubleSliding(0.25 / 0.75));
    }

    #[test]
    fn a_way_crosses_a_door_that_it_touches_and_none_beside_it() {
        let door = Door {
            door: 0,
            map_storey: 0,
            name: String::new(),
            global_id: String::new(),
            operation: String::new(),
            ends_m: [[0.0, 0.0], [1.0, 0.0]],
            kind: DoorKind::Sliding,
        };
        assert!(door.is_crossed_by([[0.5, -1.0], [0.5, 1.0]]) && door.is_crossed_by([[0.5, 0.0], [0.7, 1.0]]));
        assert!(!door.is_crossed_by([[1.5, -1.0], [1.5, 1.0]]) && !door.is_crossed_by([[0.5, 0.1], [0.5, 1.0]]));
        assert!(!door.is_crossed_by([[0.1, 0.0], [0.9, 0.0]]), "along it");
    }
}
