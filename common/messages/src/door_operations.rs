//! Door operation types (IfcDoorTypeOperationEnum) as leaves and their motions.

use crate::{DoorPanelRecord, DoorRecord, MovingLeaves, Site};
use geometry::OrientedBox;

/// A leaf: its part of the door's width and what it does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Leaf {
    /// Its start and end as shares of the width from the left.
    pub span: [f64; 2],
    /// What it does.
    pub motion: LeafMotion,
}

/// Motion of a leaf. Left, right and front are those of the door: x = 0, x = W, +y.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LeafMotion {
    /// Turns about an upright hinge on its left or right edge, to the front (1), to the back (-1), or both ways.
    Swing {
        /// True if it hangs on its left edge.
        left: bool,
        /// To the front (1) or the back (-1).
        towards: f64,
        /// True if it turns both ways.
        both: bool,
    },
    /// Slides along the wall: -1 to the left, 1 to the right.
    Slide {
        /// To the left (-1) or the right (1).
        to: f64,
    },
    /// Folds in the middle, hung on its left or right edge.
    Fold {
        /// True if it hangs on its left edge.
        left: bool,
    },
    /// Goes up.
    Rise,
    /// Wings around the middle.
    Turn,
    /// Stays.
    Fixed,
}

/// Source of an operation type.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OperationSource {
    /// OperationType of the door or its type.
    Model,
    /// PanelOperation and PanelPosition of its panels.
    Panels,
    /// The configuration: the model does not say.
    Assumed,
}

impl OperationSource {
    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Model => "model",
            Self::Panels => "panels",
            Self::Assumed => "assumed",
        }
    }
}

/// The leaves of an operation type, `share` being that of the left one of two; `None` if the schema has no such type, or leaves
/// open how it moves.
pub fn leaves(operation: &str, share: f64) -> Option<Vec<Leaf>> {
    let whole = |motion| Some(vec![Leaf { span: [0.0, 1.0], motion }]);
    let two =
        |left, right| Some(vec![Leaf { span: [0.0, share], motion: left }, Leaf { span: [share, 1.0], motion: right }]);
    let swing = |left, towards| LeafMotion::Swing { left, towards, both: false };
    let double = |left| LeafMotion::Swing { left, towards: 1.0, both: true };
    match operation {
        "SINGLE_SWING_LEFT" => whole(swing(true, 1.0)),
        "SINGLE_SWING_RIGHT" => whole(swing(false, 1.0)),
        "DOUBLE_SWING_LEFT" => whole(double(true)),
        "DOUBLE_SWING_RIGHT" => whole(double(false)),
        "DOUBLE_DOOR_SINGLE_SWING" | "DOUBLE_PANEL_SINGLE_SWING" => two(swing(true, 1.0), swing(false, 1.0)),
        "DOUBLE_DOOR_SINGLE_SWING_OPPOSITE_LEFT" | "DOUBLE_PANEL_SINGLE_SWING_OPPOSITE_LEFT" => {
            two(swing(true, -1.0), swing(false, 1.0))
        }
        "DOUBLE_DOOR_SINGLE_SWING_OPPOSITE_RIGHT" | "DOUBLE_PANEL_SINGLE_SWING_OPPOSITE_RIGHT" => {
            two(swing(true, 1.0), swing(false, -1.0))
        }
        "DOUBLE_DOOR_DOUBLE_SWING" | "DOUBLE_PANEL_DOUBLE_SWING" => two(double(true), double(false)),
        "SWING_FIXED_LEFT" => two(swing(true, 1.0), LeafMotion::Fixed),
        "SWING_FIXED_RIGHT" => two(LeafMotion::Fixed, swing(false, 1.0)),
        "SLIDING_TO_LEFT" => whole(LeafMotion::Slide { to: -1.0 }),
        "SLIDING_TO_RIGHT" => whole(LeafMotion::Slide { to: 1.0 }),
        "DOUBLE_DOOR_SLIDING" | "DOUBLE_PANEL_SLIDING" => {
            two(LeafMotion::Slide { to: -1.0 }, LeafMotion::Slide { to: 1.0 })
        }
        "FOLDING_TO_LEFT" => whole(LeafMotion::Fold { left: true }),
        "FOLDING_TO_RIGHT" => whole(LeafMotion::Fold { left: false }),
        "DOUBLE_DOOR_FOLDING" | "DOUBLE_PANEL_FOLDING" => {
            two(LeafMotion::Fold { left: true }, LeafMotion::Fold { left: false })
        }
        "REVOLVING" | "REVOLVING_VERTICAL" => whole(LeafMotion::Turn),
        "ROLLINGUP" | "LIFTING_VERTICAL_LEFT" | "LIFTING_VERTICAL_RIGHT" => whole(LeafMotion::Rise),
        "DOUBLE_DOOR_LIFTING_VERTICAL" | "DOUBLE_PANEL_LIFTING_VERTICAL" => two(LeafMotion::Rise, LeafMotion::Rise),
        _ => None,
    }
}

/// The operation type of a door, its leaves, and who says so; a leaf that its panels call fixed is. `None` for a door that
/// stays shut.
pub fn operation_of(site: &Site<'_>, door: &DoorRecord, unknown: &str) -> Option<(String, Vec<Leaf>, OperationSource)> {
    let moving = site.moving_leaves(door)?;
    let (operation, leaves, source) = leaves_of_operation(site, door, unknown)?;
    Some((operation, beside_fixed(leaves, moving), source))
}

/// The leaves with what is fixed beside them; those of the whole door where nothing is.
fn beside_fixed(leaves: Vec<Leaf>, moving: MovingLeaves) -> Vec<Leaf> {
    let MovingLeaves { share, side } = moving;
    let mut moving: Vec<Leaf> = leaves.iter().copied().filter(|leaf| leaf.motion != LeafMotion::Fixed).collect();
    if share >= 1.0 || moving.is_empty() {
        return leaves;
    }
    if side != 0.0 && moving.len() == 2 && leaves.len() == 2 {
        moving.remove(usize::from(side < 0.0));
    }
    let [start, end] = [moving[0].span[0], moving[moving.len() - 1].span[1]];
    let from = (1.0 - share) * (1.0 + side) / 2.0;
    for leaf in &mut moving {
        leaf.span = leaf.span.map(|s| from + share * (s - start) / (end - start));
    }
    let fixed = |span: [f64; 2]| (span[1] - span[0] > 1e-9).then_some(Leaf { span, motion: LeafMotion::Fixed });
    let before = fixed([0.0, from]);
    before.into_iter().chain(moving).chain(fixed([from + share, 1.0])).collect()
}

fn leaves_of_operation(
    site: &Site<'_>,
    door: &DoorRecord,
    unknown: &str,
) -> Option<(String, Vec<Leaf>, OperationSource)> {
    let panels = site.door_panels(door);
    let share = share_of_left(site, panels);
    let said = site.text(door.operation).to_ascii_uppercase();
    if let Some(leaves) = leaves(&said, share) {
        return Some((said, leaves, OperationSource::Model));
    }
    if let Some(found) = of_panels(site, panels)
        && let Some(leaves) = leaves(found, share)
    {
        return Some((found.to_owned(), leaves, OperationSource::Panels));
    }
    leaves(unknown, share).map(|leaves| (unknown.to_owned(), leaves, OperationSource::Assumed))
}

/// Share of the left one of two leaves; a half unless the panels say otherwise.
fn share_of_left(site: &Site<'_>, panels: &[DoorPanelRecord]) -> f64 {
    let of = |position: &str| {
        panels.iter().find(|p| site.text(p.position) == position && 0.05 < p.share && p.share < 0.95).map(|p| p.share)
    };
    if panels.len() < 2 {
        return 0.5;
    }
    of("LEFT").or_else(|| of("RIGHT").map(|right| 1.0 - right)).unwrap_or(0.5)
}

/// The operation type that one or two panels make together.
fn of_panels(site: &Site<'_>, panels: &[DoorPanelRecord]) -> Option<&'static str> {
    let words = |p: &DoorPanelRecord| (site.text(p.operation), site.text(p.position));
    let one = |p| {
        Some(match words(p) {
            ("SWINGING", "LEFT") => "SINGLE_SWING_LEFT",
            ("SWINGING", "RIGHT") => "SINGLE_SWING_RIGHT",
            ("DOUBLE_ACTING", "LEFT") => "DOUBLE_SWING_LEFT",
            ("DOUBLE_ACTING", "RIGHT") => "DOUBLE_SWING_RIGHT",
            ("SLIDING", "LEFT") => "SLIDING_TO_LEFT",
            ("SLIDING", "RIGHT") => "SLIDING_TO_RIGHT",
            ("FOLDING", "LEFT") => "FOLDING_TO_LEFT",
            ("FOLDING", "RIGHT") => "FOLDING_TO_RIGHT",
            ("REVOLVING", _) => "REVOLVING",
            ("ROLLINGUP", _) => "ROLLINGUP",
            _ => return None,
        })
    };
    match panels {
        [p] => one(p),
        [a, b] => {
            let (left, right) = if words(a).1 == "RIGHT" { (b, a) } else { (a, b) };
            Some(match (words(left).0, words(right).0) {
                ("SWINGING", "SWINGING") => "DOUBLE_DOOR_SINGLE_SWING",
                ("DOUBLE_ACTING", "DOUBLE_ACTING") => "DOUBLE_DOOR_DOUBLE_SWING",
                ("SLIDING", "SLIDING") => "DOUBLE_DOOR_SLIDING",
                ("FOLDING", "FOLDING") => "DOUBLE_DOOR_FOLDING",
                ("SWINGING", "FIXEDPANEL") => "SWING_FIXED_LEFT",
                ("FIXEDPANEL", "SWINGING") => "SWING_FIXED_RIGHT",
                _ => return None,
            })
        }
        _ => None,
    }
}

/// An operation type with left and right exchanged: of a door that stands on its head.
pub fn mirrored(leaves: &mut [Leaf]) {
    for leaf in leaves.iter_mut() {
        leaf.span = [1.0 - leaf.span[1], 1.0 - leaf.span[0]];
        match &mut leaf.motion {
            LeafMotion::Swing { left, .. } | LeafMotion::Fold { left } => *left = !*left,
            LeafMotion::Slide { to } => *to = -*to,
            LeafMotion::Rise | LeafMotion::Turn | LeafMotion::Fixed => {}
        }
    }
}

/// The frame of a door in plan: x along its width, y to the front.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DoorFrame {
    /// The left jamb in the middle of the wall, tenths of a millimetre.
    pub origin: [f64; 2],
    /// Unit direction of x.
    pub along: [f64; 2],
    /// True if the frame of the model is upside down, so that left and right are exchanged.
    pub turned: bool,
    /// True if the model does not say which side is left or front.
    pub assumed: bool,
}

impl DoorFrame {
    /// The point in `map` at a place in the frame, tenths of a millimetre.
    pub fn at(&self, x: f64, y: f64) -> [f64; 2] {
        let across = [-self.along[1], self.along[0]];
        [0, 1].map(|k| self.origin[k] + x * self.along[k] + y * across[k])
    }

    /// Left is where the model's frame begins; without one the direction of the passage counts.
    pub fn of(door: &DoorRecord, passage: &OrientedBox) -> Self {
        let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
        let towards = door.hanging.towards;
        // x is to the right of who looks to the front.
        let right = [towards[1], -towards[0]];
        let is_along = dot(right, passage.axis).abs() > 0.7;
        let along = match (is_along, dot(right, passage.axis) < 0.0) {
            (true, true) => passage.axis.map(|c| -c),
            _ => passage.axis,
        };
        Self {
            origin: [0, 1].map(|k| passage.centre[k] - along[k] * passage.half[0]),
            along,
            turned: is_along && dot(door.hanging.along, right) < 0.0,
            assumed: !is_along,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_operation_type_of_the_schema_that_says_how_it_moves_has_leaves() {
        for (operation, n_leaves) in [
            ("SINGLE_SWING_LEFT", 1),
            ("DOUBLE_DOOR_SINGLE_SWING", 2),
            ("DOUBLE_DOOR_SINGLE_SWING_OPPOSITE_LEFT", 2),
            ("DOUBLE_SWING_RIGHT", 1),
            ("SWING_FIXED_LEFT", 2),
            ("DOUBLE_DOOR_SLIDING", 2),
            ("FOLDING_TO_RIGHT", 1),
            ("REVOLVING", 1),
            ("ROLLINGUP", 1),
            ("DOUBLE_DOOR_LIFTING_VERTICAL", 2),
        ] {
            let found = leaves(operation, 0.4).unwrap();
            assert_eq!(found.len(), n_leaves, "{operation}");
            assert_eq!((found[0].span[0], found[n_leaves - 1].span[1]), (0.0, 1.0));
        }
        for operation in ["", "NOTDEFINED", "USERDEFINED", "LIFTING_HORIZONTAL", "opens left"] {
            assert!(leaves(operation, 0.5).is_none(), "{operation}");
        }
    }

    #[test]
    fn a_fixed_leaf_stays_beside_those_that_move() {
        let found = |operation: &str, share: f64, side: f64| {
            let leaves = beside_fixed(leaves(operation, 0.5).unwrap(), MovingLeaves { share, side });
            let rounded = |s: f64| (s * 1e9).round() / 1e9;
            leaves.iter().map(|l| (l.span.map(rounded), l.motion == LeafMotion::Fixed)).collect::<Vec<_>>()
        };
        let (left, right) = (-1.0, 1.0);
        assert_eq!(found("SWING_FIXED_LEFT", 0.6, left), [([0.0, 0.6], false), ([0.6, 1.0], true)]);
        assert_eq!(found("SWING_FIXED_RIGHT", 0.6, right), [([0.0, 0.4], true), ([0.4, 1.0], false)]);
        assert_eq!(found("SINGLE_SWING_LEFT", 0.7, left), [([0.0, 0.7], false), ([0.7, 1.0], true)]);
        assert_eq!(found("DOUBLE_DOOR_SLIDING", 0.5, right), [([0.0, 0.5], true), ([0.5, 1.0], false)]);
        let middle = [([0.0, 0.25], true), ([0.25, 0.5], false), ([0.5, 0.75], false), ([0.75, 1.0], true)];
        assert_eq!(found("DOUBLE_DOOR_SLIDING", 0.5, 0.0), middle);
        assert_eq!(found("DOUBLE_DOOR_SLIDING", 1.0, 0.0), [([0.0, 0.5], false), ([0.5, 1.0], false)]);
    }

    #[test]
    fn what_stands_on_its_head_is_hung_on_the_other_side() {
        let mut found = leaves("SWING_FIXED_LEFT", 0.7).unwrap();
        mirrored(&mut found);
        found.reverse();
        let mut expected = leaves("SWING_FIXED_RIGHT", 0.3).unwrap();
        expected.iter_mut().for_each(|l| l.span = l.span.map(|s| (s * 1e9).round() / 1e9));
        found.iter_mut().for_each(|l| l.span = l.span.map(|s| (s * 1e9).round() / 1e9));
        assert_eq!(found, expected);
    }
}
