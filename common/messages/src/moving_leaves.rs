//! The part of a door that moves, where its operation type or its panels say that a leaf of it is fixed.

use crate::{DoorRecord, Site};
use geometry::OrientedBox;

/// Share of a door that moves beside a fixed leaf of unknown width.
const ASSUMED_SHARE: f64 = 0.5;

/// A door's own x axis runs along its passage where the cosine between them is at least this.
const ALIGNED: f64 = 0.5;

/// Words of operation types by which a leaf moves.
const MOTIONS: [&str; 6] = ["SWING", "SLID", "FOLD", "REVOLV", "ROLL", "LIFT"];

/// What is known of a panel of a door (IfcDoorPanelProperties).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeafPanel<'a> {
    /// PanelOperation.
    pub operation: &'a str,
    /// PanelPosition.
    pub position: &'a str,
    /// PanelWidth: its share of the door's width.
    pub share: Option<f64>,
}

/// The leaves of a door that move, as a part of its width.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MovingLeaves {
    /// Their share of the width: 1 without a fixed leaf.
    pub share: f64,
    /// Where they hang in the door's frame: at the left jamb (-1), at the right one (1), or in the middle, where the model does
    /// not say (0).
    pub side: f64,
}

impl LeafPanel<'_> {
    fn is_fixed(&self) -> bool {
        self.operation.contains("FIXED")
    }
}

impl MovingLeaves {
    /// The leaves of a door of this operation type with these panels; `None` if all of them are fixed.
    pub fn of(operation: &str, panels: &[LeafPanel<'_>]) -> Option<Self> {
        let operation = operation.to_ascii_uppercase();
        let moves = MOTIONS.iter().any(|motion| operation.contains(motion));
        let (fixed, moving): (Vec<_>, Vec<_>) = panels.iter().partition(|panel| panel.is_fixed());
        if !moves && !fixed.is_empty() && moving.is_empty() {
            return None;
        }
        if fixed.is_empty() && !operation.contains("FIXED") {
            return Some(Self { share: 1.0, side: 0.0 });
        }
        let sum = |panels: &[&LeafPanel<'_>]| {
            let known: Option<f64> = panels.iter().map(|p| p.share).sum();
            known.filter(|_| !panels.is_empty())
        };
        let share = sum(&moving).or_else(|| sum(&fixed).map(|fixed| 1.0 - fixed));
        let share = share.filter(|share| 0.0 < *share && *share < 1.0).unwrap_or(ASSUMED_SHARE);
        let position = |panels: &[&LeafPanel<'_>]| match panels {
            [panel] if panel.position == "LEFT" => Some(-1.0),
            [panel] if panel.position == "RIGHT" => Some(1.0),
            _ => None,
        };
        let of_operation = match (operation.contains("LEFT"), operation.contains("RIGHT")) {
            (true, false) => -1.0,
            (false, true) => 1.0,
            _ => 0.0,
        };
        let side = position(&moving).or_else(|| position(&fixed).map(|side: f64| -side)).unwrap_or(of_operation);
        Some(Self { share, side })
    }

    /// The part of the passage of a whole door in which its moving leaves hang; `along` is the direction of the door's own x
    /// axis in plan, zero where it is not known.
    pub fn part_of(self, whole: &OrientedBox, along: [f64; 2]) -> OrientedBox {
        let part = [whole.half[0] * self.share, whole.half[1]];
        OrientedBox { centre: whole.at(self.offset(whole, along, whole.half[0]), 0.0), half: part, axis: whole.axis }
    }

    /// The passage of the whole door around that part.
    pub fn whole_of(self, part: &OrientedBox, along: [f64; 2]) -> OrientedBox {
        let half = part.half[0] / self.share;
        OrientedBox {
            centre: part.at(-self.offset(part, along, half), 0.0),
            half: [half, part.half[1]],
            axis: part.axis,
        }
    }

    /// Offset of the part from the middle of a door of this half width, along the axis of a passage.
    fn offset(self, passage: &OrientedBox, along: [f64; 2], half: f64) -> f64 {
        let turn = along[0] * passage.axis[0] + along[1] * passage.axis[1];
        let turn = if turn.abs() < ALIGNED { 0.0 } else { turn.signum() };
        self.side * turn * half * (1.0 - self.share)
    }
}

impl Site<'_> {
    /// The leaves of a door that move; `None` if all of them are fixed.
    pub fn moving_leaves(&self, door: &DoorRecord) -> Option<MovingLeaves> {
        let panels: Vec<LeafPanel<'_>> = self
            .door_panels(door)
            .iter()
            .map(|panel| LeafPanel {
                operation: self.text(panel.operation),
                position: self.text(panel.position),
                share: (panel.share > 0.0).then_some(panel.share),
            })
            .collect();
        MovingLeaves::of(self.text(door.operation), &panels)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn panel(operation: &'static str, position: &'static str, share: Option<f64>) -> LeafPanel<'static> {
        LeafPanel { operation, position, share }
    }

    #[test]
    fn a_fixed_leaf_takes_its_share_on_its_side() {
        let swinging = |position, share| panel("SWINGING", position, share);
        let fixed = |position, share| panel("FIXEDPANEL", position, share);
        for (operation, panels, expected) in [
            ("SINGLE_SWING_LEFT", vec![swinging("LEFT", Some(0.8))], Some((1.0, 0.0))),
            ("SWING_FIXED_LEFT", vec![], Some((0.5, -1.0))),
            ("SWING_FIXED_RIGHT", vec![swinging("", Some(0.6)), fixed("", None)], Some((0.6, 1.0))),
            ("", vec![swinging("", None), fixed("LEFT", Some(0.25))], Some((0.75, 1.0))),
            ("SINGLE_SWING_RIGHT", vec![swinging("LEFT", Some(0.7)), fixed("RIGHT", Some(0.3))], Some((0.7, -1.0))),
            ("", vec![fixed("LEFT", None)], None),
            ("NOTDEFINED", vec![fixed("LEFT", Some(0.5)), fixed("RIGHT", Some(0.5))], None),
            ("SWING_FIXED_LEFT", vec![fixed("RIGHT", Some(0.4))], Some((0.6, -1.0))),
        ] {
            let found = MovingLeaves::of(operation, &panels).map(|leaves| (leaves.share, leaves.side));
            assert_eq!(found, expected, "{operation} {panels:?}");
        }
    }

    #[test]
    fn the_moving_part_lies_on_the_side_of_the_doors_own_frame() {
        let whole = OrientedBox { centre: [0.0; 2], axis: [1.0, 0.0], half: [10_000.0, 1_000.0] };
        let leaves = MovingLeaves { share: 0.5, side: -1.0 };
        let centre = |along: [f64; 2]| leaves.part_of(&whole, along).centre;
        assert_eq!(
            [[1.0, 0.0], [-1.0, 0.0], [0.0, 0.0]].map(centre),
            [[-5_000.0, 0.0], [5_000.0, 0.0], [0.0, 0.0]],
            "without a frame the middle"
        );
    }

    proptest! {
        #[test]
        fn the_whole_follows_from_the_part(
            share in 0.1..1.0f64,
            side in prop::sample::select(vec![-1.0, 0.0, 1.0]),
            turn in -10.0..10.0f64,
            is_against in any::<bool>(),
        ) {
            let axis = [1.0 - turn * turn, 2.0 * turn].map(|c| c / (1.0 + turn * turn));
            let whole = OrientedBox { centre: [30_000.0, -2_000.0], axis, half: [9_000.0, 1_200.0] };
            let along = if is_against { axis.map(|c| -c) } else { axis };
            let leaves = MovingLeaves { share, side };
            let found = leaves.whole_of(&leaves.part_of(&whole, along), along);
            let off = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).abs().max((a[1] - b[1]).abs());
            prop_assert!(off(found.centre, whole.centre) < 1e-6 && off(found.half, whole.half) < 1e-6, "{found:?}");
        }
    }
}
