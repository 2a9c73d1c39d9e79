//! The links of a door: boards on joints, in the door's frame.
//!
//! The frame: x along the width from the left jamb, y to the front from the middle of the wall, z from the floor.

use crate::joint_limits::Prism;
use messages::door_operations::{Leaf, LeafMotion};
use std::f64::consts::{FRAC_PI_2, PI};

/// A leaf slides this far off the wall.
const OFF_WALL_M: f64 = 0.01;

/// Gap above a leaf.
const TOP_GAP_M: f64 = 0.01;

/// Readers of SDF want limits of every joint: a revolving door turns twice each way.
const TURNS: f64 = 4.0 * PI;

/// Share of its width that a sliding leaf travels.
const TRAVEL: f64 = 0.95;

/// A box that is level, in the frame of its link.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Board {
    pub(crate) centre_m: [f64; 3],
    pub(crate) size_m: [f64; 3],
}

/// A joint by its kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum JointKind {
    /// Turns about the axis.
    Revolute,
    /// Shifts along the axis.
    Prismatic,
    /// Stays.
    Fixed,
}

impl JointKind {
    /// Its name in SDF and URDF.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Revolute => "revolute",
            Self::Prismatic => "prismatic",
            Self::Fixed => "fixed",
        }
    }
}

/// A link and the joint that moves it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Link {
    /// `leaf`, or `leaf_1`, `leaf_2` from left to right.
    pub(crate) name: String,
    /// Place of the link among the door's on which it hangs; `None` for the frame.
    pub(crate) parent: Option<usize>,
    /// Its origin in the door's frame, where the joint is.
    pub(crate) at_m: [f64; 3],
    pub(crate) boards: Vec<Board>,
    pub(crate) kind: JointKind,
    pub(crate) axis: [f64; 3],
    /// Values of the joint, 0 being closed.
    pub(crate) limits: [f64; 2],
    /// True if the true motion is another one.
    pub(crate) approximate: bool,
}

/// Sizes of an opening and its leaves; lengths in metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Opening {
    pub(crate) width_m: f64,
    /// Lower and upper end of the leaves above the door's origin.
    pub(crate) z_m: [f64; 2],
    /// Thickness of the wall.
    pub(crate) depth_m: f64,
    /// Thickness of the leaves.
    pub(crate) leaf_m: f64,
    /// Free width at each side of the leaves: lining and gap.
    pub(crate) side_m: f64,
}

impl Opening {
    fn top_m(&self) -> f64 {
        self.z_m[1] - TOP_GAP_M
    }
}

/// The links of a leaf. `front` is 1 or -1: the side of the wall on which it slides. `headroom_m` is free above the opening.
pub(crate) fn links_of(leaf: &Leaf, opening: &Opening, front: f64, headroom_m: f64) -> Vec<Link> {
    let inner = opening.width_m - 2.0 * opening.side_m;
    // Leaves that meet leave half a gap each.
    let gap = |share: f64| if 0.0 < share && share < 1.0 { 0.004 } else { 0.0 };
    let [x0, x1] = leaf.span.map(|share| opening.side_m + inner * share);
    let [x0, x1] = [x0 + gap(leaf.span[0]), x1 - gap(leaf.span[1])];
    match leaf.motion {
        LeafMotion::Swing { left, towards, both } => vec![swing(opening, [x0, x1], left, towards, both)],
        LeafMotion::Fold { left } => fold(opening, [x0, x1], left),
        LeafMotion::Slide { to } => vec![slide(opening, leaf.span, to, front)],
        LeafMotion::Rise => rise(opening, leaf.span, front, headroom_m),
        LeafMotion::Turn => vec![turn(opening)],
        LeafMotion::Fixed => {
            let board = board(opening, [x0, x1], 0.0, opening.leaf_m);
            vec![Link { kind: JointKind::Fixed, ..link([0.0; 3], vec![board]) }]
        }
    }
}

fn link(at_m: [f64; 3], boards: Vec<Board>) -> Link {
    Link {
        name: String::new(),
        parent: None,
        at_m,
        boards: boards.into_iter().map(|b| b.seen_from(at_m)).collect(),
        kind: JointKind::Revolute,
        axis: [0.0, 0.0, 1.0],
        limits: [0.0; 2],
        approximate: false,
    }
}

impl Board {
    fn seen_from(self, at_m: [f64; 3]) -> Self {
        Self { centre_m: [0, 1, 2].map(|k| self.centre_m[k] - at_m[k]), ..self }
    }
}

/// The board of a leaf between two places along the width, in the door's frame.
fn board(opening: &Opening, [x0, x1]: [f64; 2], y: f64, thickness: f64) -> Board {
    let (low, high) = (opening.z_m[0], opening.top_m());
    Board { centre_m: [(x0 + x1) / 2.0, y, (low + high) / 2.0], size_m: [x1 - x0, thickness, high - low] }
}

/// The hinge is on the face to which the leaf swings, as hinges are: then no corner passes behind it, and the gap can be narrow.
fn swing(opening: &Opening, [x0, x1]: [f64; 2], left: bool, towards: f64, both: bool) -> Link {
    // A leaf that swings both ways turns about its middle, and needs room for half its thickness.
    let extra = if both { opening.leaf_m / 2.0 } else { 0.0 };
    let [x0, x1] = if left { [x0 + extra, x1] } else { [x0, x1 - extra] };
    let hinge = [if left { x0 } else { x1 }, if both { 0.0 } else { towards * opening.leaf_m / 2.0 }, 0.0];
    let sense = if left { towards } else { -towards };
    let lower = if both { -FRAC_PI_2 } else { 0.0 };
    Link {
        axis: [0.0, 0.0, sense],
        limits: [lower, FRAC_PI_2],
        ..link(hinge, vec![board(opening, [x0, x1], 0.0, opening.leaf_m)])
    }
}

/// Two halves: the first swings to the front, the second folds back onto it.
fn fold(opening: &Opening, [x0, x1]: [f64; 2], left: bool) -> Vec<Link> {
    let (thickness, middle) = (opening.leaf_m, (x0 + x1) / 2.0);
    let (near, far) = if left { ([x0, middle], [middle, x1]) } else { ([middle, x1], [x0, middle]) };
    let first = swing(opening, near, left, 1.0, false);
    let axis = first.axis;
    let hinge = [middle, -thickness / 2.0, 0.0];
    let second =
        Link { parent: Some(0), axis, limits: [-PI, 0.0], ..link(hinge, vec![board(opening, far, 0.0, thickness)]) };
    vec![first, second]
}

/// The part of the whole width that a leaf off the wall covers.
fn covered(opening: &Opening, span: [f64; 2]) -> [f64; 2] {
    span.map(|share| opening.width_m * share)
}

fn slide(opening: &Opening, span: [f64; 2], to: f64, front: f64) -> Link {
    let y = front * (opening.depth_m / 2.0 + opening.leaf_m / 2.0 + OFF_WALL_M);
    let [x0, x1] = covered(opening, span);
    Link {
        kind: JointKind::Prismatic,
        axis: [to, 0.0, 0.0],
        limits: [0.0, TRAVEL * (x1 - x0)],
        ..link([(x0 + x1) / 2.0, y, 0.0], vec![board(opening, [x0, x1], y, opening.leaf_m)])
    }
}

/// One leaf that goes up, or as many as fit one behind the other under the ceiling.
fn rise(opening: &Opening, span: [f64; 2], front: f64, headroom_m: f64) -> Vec<Link> {
    const LEAVES_MAX: f64 = 8.0;
    let thickness = opening.leaf_m.min(0.03);
    let height = opening.top_m() - opening.z_m[0];
    let n = (height / headroom_m.max(0.01)).ceil().clamp(1.0, LEAVES_MAX);
    let part = height / n;
    let [x0, x1] = covered(opening, span);
    let link_at = |k: f64| {
        let y = front * (opening.depth_m / 2.0 + OFF_WALL_M + (thickness + 0.005) * k + thickness / 2.0);
        let centre_m = [(x0 + x1) / 2.0, y, opening.z_m[0] + part * (k + 0.5)];
        let board = Board { centre_m, size_m: [x1 - x0, thickness, part] };
        Link {
            kind: JointKind::Prismatic,
            limits: [0.0, height - part * k],
            approximate: true,
            ..link([centre_m[0], y, 0.0], vec![board])
        }
    };
    (0..n as usize).map(|k| link_at(k as f64)).collect()
}

/// Four wings around the middle.
fn turn(opening: &Opening) -> Link {
    let length = opening.width_m - 2.0 * opening.side_m;
    let (low, high) = (opening.z_m[0], opening.top_m());
    let size = |x: f64, y: f64| [x, y, high - low];
    let centre_m = [opening.width_m / 2.0, 0.0, (low + high) / 2.0];
    let boards = vec![
        Board { centre_m, size_m: size(length, opening.leaf_m) },
        Board { centre_m, size_m: size(opening.leaf_m, length) },
    ];
    Link { limits: [-TURNS, TURNS], ..link([centre_m[0], 0.0, 0.0], boards) }
}

/// The boards of a link at a value of its joint, all other joints closed, in the door's frame.
pub(crate) fn boards_at(link: &Link, q: f64) -> impl Iterator<Item = Prism> {
    let (shift, yaw) = motion(link, q);
    let (sin, cos) = (libm::sin(yaw), libm::cos(yaw));
    link.boards.iter().map(move |b| {
        let [hx, hy, hz] = b.size_m.map(|s| s / 2.0);
        let corner = |sx: f64, sy: f64| {
            let (x, y) = (b.centre_m[0] + sx * hx, b.centre_m[1] + sy * hy);
            [link.at_m[0] + shift[0] + cos * x - sin * y, link.at_m[1] + shift[1] + sin * x + cos * y]
        };
        let middle = link.at_m[2] + shift[2] + b.centre_m[2];
        Prism {
            plan_m: vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)],
            z_m: [middle - hz, middle + hz],
        }
    })
}

/// Shift and yaw of a link at a value of its joint.
fn motion(link: &Link, q: f64) -> ([f64; 3], f64) {
    match link.kind {
        JointKind::Revolute => ([0.0; 3], q * link.axis[2]),
        JointKind::Prismatic => (link.axis.map(|a| a * q), 0.0),
        JointKind::Fixed => ([0.0; 3], 0.0),
    }
}

/// Pose of a link (origin, yaw) in the door's frame for joint values of it and its parents.
pub(crate) fn pose_at(links: &[Link], index: usize, values: &[f64]) -> ([f64; 3], f64) {
    let link = &links[index];
    let (shift, own_yaw) = motion(link, values[index]);
    let (origin, yaw, from) = match link.parent {
        Some(parent) => {
            let (origin, yaw) = pose_at(links, parent, values);
            (origin, yaw, links[parent].at_m)
        }
        None => ([0.0; 3], 0.0, [0.0; 3]),
    };
    let way = [0, 1, 2].map(|k| link.at_m[k] - from[k] + shift[k]);
    let (sin, cos) = (libm::sin(yaw), libm::cos(yaw));
    let at = [origin[0] + cos * way[0] - sin * way[1], origin[1] + sin * way[0] + cos * way[1], origin[2] + way[2]];
    (at, yaw + own_yaw)
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::door_operations::leaves;

    const OPENING: Opening = Opening { width_m: 1.0, z_m: [0.01, 2.11], depth_m: 0.2, leaf_m: 0.04, side_m: 0.01 };

    fn links(operation: &str) -> Vec<Link> {
        leaves(operation, 0.5).unwrap().iter().flat_map(|l| links_of(l, &OPENING, 1.0, 3.0)).collect()
    }

    /// Extent in x and y over the whole motion.
    fn swept(link: &Link) -> [[f64; 2]; 2] {
        let n = 90;
        let values = (0..=n).map(|k| link.limits[0] + (link.limits[1] - link.limits[0]) * f64::from(k) / f64::from(n));
        let corners: Vec<[f64; 2]> = values.flat_map(|q| boards_at(link, q)).flat_map(|p| p.plan_m).collect();
        [0, 1].map(|k| {
            let at = || corners.iter().map(|c| c[k]);
            [at().fold(f64::INFINITY, f64::min), at().fold(f64::NEG_INFINITY, f64::max)]
        })
    }

    #[test]
    fn swinging_leaves_stay_between_their_jambs_and_open_to_their_side() {
        for (operation, sides) in [
            ("SINGLE_SWING_LEFT", vec![1.0]),
            ("SINGLE_SWING_RIGHT", vec![1.0]),
            ("DOUBLE_DOOR_SINGLE_SWING", vec![1.0, 1.0]),
            ("DOUBLE_DOOR_SINGLE_SWING_OPPOSITE_LEFT", vec![-1.0, 1.0]),
            ("DOUBLE_DOOR_SINGLE_SWING_OPPOSITE_RIGHT", vec![1.0, -1.0]),
        ] {
            let links = links(operation);
            assert_eq!(links.len(), sides.len());
            for (link, side) in links.iter().zip(sides) {
                let [x, y] = swept(link);
                assert!(0.0 < x[0] && x[1] < 1.0, "{operation} {x:?}");
                let front = if side > 0.0 { y } else { [-y[1], -y[0]] };
                assert!(front[0] > -0.021 && front[1] > 0.4, "{operation} {y:?}");
            }
        }
    }

    #[test]
    fn leaves_that_swing_both_ways_clear_their_jambs_too() {
        for link in links("DOUBLE_DOOR_DOUBLE_SWING") {
            let [x, y] = swept(&link);
            assert!(0.0 < x[0] && x[1] < 1.0, "{x:?}");
            assert!(y[0] < -0.4 && 0.4 < y[1]);
        }
    }

    #[test]
    fn sliding_leaves_clear_the_opening_off_the_wall() {
        let links = links("DOUBLE_DOOR_SLIDING");
        let open: Vec<Prism> = links.iter().flat_map(|l| boards_at(l, l.limits[1])).collect();
        let right_end = open[0].plan_m.iter().map(|p| p[0]).fold(f64::NEG_INFINITY, f64::max);
        let left_end = open[1].plan_m.iter().map(|p| p[0]).fold(f64::INFINITY, f64::min);
        assert!(right_end < 0.03 && 0.97 < left_end, "{right_end} {left_end}");
        assert!(links.iter().all(|l| swept(l)[1][0] >= 0.1));
    }

    #[test]
    fn a_folded_leaf_lies_on_the_other_half() {
        let links = links("FOLDING_TO_LEFT");
        let (at, yaw) = pose_at(&links, 1, &[FRAC_PI_2, -PI]);
        assert!((yaw + FRAC_PI_2).abs() < 1e-9);
        assert!(at[0] < 0.1 && at[1] > 0.4, "{at:?}");
    }

    #[test]
    fn a_door_that_rises_is_cut_to_the_headroom() {
        let leaf = leaves("ROLLINGUP", 0.5).unwrap()[0];
        assert_eq!(links_of(&leaf, &OPENING, 1.0, 3.0).len(), 1);
        let links = links_of(&leaf, &OPENING, 1.0, 0.6);
        assert_eq!(links.len(), 4);
        for link in &links {
            let open = boards_at(link, link.limits[1]).next().unwrap();
            assert!((open.z_m[0] - 2.1).abs() < 1e-9 && open.z_m[1] < 2.1 + 0.6);
        }
    }
}
