//! Pairs adjacent doors that are leaves of one opening, unless a mullion stands between them.

use frames::TENTHS_PER_M;
use geometry::{FillRule, Footprint, MultiPolygon, OrientedBox, Point, Slab, footprint, intersection, union};
use messages::{ElementRecord, NONE, SiteBuilder};

/// Leaves are at most this far apart, and overlap by no more.
const MAX_GAP: f64 = 0.10 * TENTHS_PER_M as f64;

/// Leaves of one opening lie in one plane up to this.
const MAX_OFFSET: f64 = 0.02 * TENTHS_PER_M as f64;

/// Leaves of one opening end at one height up to this.
const MAX_SILL_DIFFERENCE: i32 = TENTHS_PER_M / 20;

/// Distance from the joint of two leaves within which a mullion is searched.
const BESIDE_JOINT: f64 = 0.05 * TENTHS_PER_M as f64;

/// Elements within this height of the threshold or the lintel are part of it.
const RIM: i32 = TENTHS_PER_M / 20;

/// A robot is no higher than this.
const ROBOT_HEIGHT: i32 = 2 * TENTHS_PER_M;

/// Leaves are at least this high.
const MIN_LEAF_HEIGHT: i32 = TENTHS_PER_M / 2;

/// Minimum area of a mullion in the joint.
const MIN_AREA_M2: f64 = 1e-4;

/// Axes that differ by a smaller sine are parallel.
const PARALLEL: f64 = 0.05;

/// Sets [`messages::DoorRecord::beside`] of all doors.
pub(crate) fn join_leaves(builder: &mut SiteBuilder) {
    let reach = |k: usize, axis: usize| {
        let plan = &builder.doors[k].passage;
        plan.half[0] * plan.axis[axis].abs() + plan.half[1] * plan.axis[1 - axis].abs() + MAX_GAP
    };
    let low = |k: usize| builder.doors[k].passage.centre[0] - reach(k, 0);
    let mut order: Vec<usize> = (0..builder.doors.len()).filter(|&k| builder.doors[k].passage.half[0] > 0.0).collect();
    order.sort_by(|&a, &b| low(a).total_cmp(&low(b)).then(a.cmp(&b)));
    let mut joints = Vec::new();
    for (at, &a) in order.iter().enumerate() {
        let end = builder.doors[a].passage.centre[0] + reach(a, 0);
        for &b in order[at + 1..].iter().take_while(|&&b| low(b) <= end) {
            if let Some(joint) = joint_of(builder, a, b).filter(|joint| is_free(builder, [a, b], joint)) {
                joints.push((a, b, joint));
            }
        }
    }
    // The nearest first, so that every side of a door has one neighbour.
    joints.sort_by(|p, q| p.2.gap.abs().total_cmp(&q.2.gap.abs()).then((p.0, p.1).cmp(&(q.0, q.1))));
    for (a, b, joint) in joints {
        let sides = [(a, joint.sides[0]), (b, joint.sides[1])];
        if sides.iter().all(|&(door, side)| builder.doors[door].beside[side] == NONE) {
            builder.doors[a].beside[joint.sides[0]] = b as u32;
            builder.doors[b].beside[joint.sides[1]] = a as u32;
        }
    }
}

/// The joint between two leaves.
struct Joint {
    /// The side of each at which the other lies: against or along its axis.
    sides: [usize; 2],
    /// Width of the gap between them; negative where they overlap.
    gap: f64,
    /// In plan, with what stands right beside it.
    plan: MultiPolygon,
    /// From the higher threshold to the lower lintel, as far as a robot reaches.
    slab: Slab,
}

fn joint_of(builder: &SiteBuilder, a: usize, b: usize) -> Option<Joint> {
    let heights = [a, b].map(|door| {
        let element = &builder.elements[builder.doors[door].element as usize];
        [element.min_tenths[2], element.max_tenths[2]]
    });
    let (bottom, top) = (heights[0][0].max(heights[1][0]), heights[0][1].min(heights[1][1]));
    if bottom - heights[0][0].min(heights[1][0]) > MAX_SILL_DIFFERENCE || top - bottom < MIN_LEAF_HEIGHT {
        return None;
    }
    let [p, q] = [a, b].map(|door| builder.doors[door].passage.to_box());
    let turn = p.axis[0] * q.axis[1] - p.axis[1] * q.axis[0];
    let along = p.axis[0] * q.axis[0] + p.axis[1] * q.axis[1];
    let off = [0, 1].map(|k| q.centre[k] - p.centre[k]);
    let u = off[0] * p.axis[0] + off[1] * p.axis[1];
    let v = off[1] * p.axis[0] - off[0] * p.axis[1];
    let gap = u.abs() - p.half[0] - q.half[0];
    if turn.abs() > PARALLEL || v.abs() > p.half[1].max(q.half[1]) + MAX_OFFSET || gap.abs() > MAX_GAP {
        return None;
    }
    let side_of_a = usize::from(u > 0.0);
    // The axis of the other may run the other way.
    let side_of_b = if along > 0.0 { 1 - side_of_a } else { side_of_a };
    let joint = OrientedBox {
        centre: p.at(u.signum() * (p.half[0] + gap / 2.0), v / 2.0),
        axis: p.axis,
        half: [gap.abs() / 2.0 + BESIDE_JOINT, p.half[1].max(q.half[1]) + v.abs() / 2.0],
    };
    Some(Joint {
        sides: [side_of_a, side_of_b],
        gap,
        plan: union(&[joint.ring()], FillRule::NonZero),
        slab: Slab { lo: bottom + RIM, hi: (top - RIM).min(bottom + ROBOT_HEIGHT) },
    })
}

/// True if no other element stands where two leaves meet. What a door itself is made of moves with it.
fn is_free(builder: &SiteBuilder, doors: [usize; 2], joint: &Joint) -> bool {
    let Some(bounds) = joint.plan.bounds() else { return false };
    let own = doors.map(|door| builder.doors[door].element);
    let stands_there = |(index, e): (u32, &ElementRecord)| {
        let is_near = e.n_parts > 0
            && joint.slab.meets(e.min_tenths[2], e.max_tenths[2])
            && (0..2).all(|k| e.min_tenths[k] <= bounds.max[k] && bounds.min[k] <= e.max_tenths[k]);
        is_near
            && !own.contains(&index)
            && !own.contains(&e.whole)
            && covers(&footprint(builder.meshes(e.first_part, e.n_parts), joint.slab), &joint.plan)
    };
    !(0..).zip(&builder.elements).any(stands_there)
}

fn covers(footprint: &Footprint, joint: &MultiPolygon) -> bool {
    intersection(&footprint.area, joint).area_m2() > MIN_AREA_M2
        || footprint.lines.iter().any(|line| meets(line, joint))
}

/// True if a line comes to lie in the joint, looked at every 5 mm.
fn meets([a, b]: &[Point; 2], joint: &MultiPolygon) -> bool {
    let d = [0, 1].map(|k| f64::from(b[k]) - f64::from(a[k]));
    let n = (libm::hypot(d[0], d[1]) / 50.0).ceil().max(1.0);
    (0..=n as u32).any(|k| joint.contains([0, 1].map(|i| f64::from(a[i]) + d[i] * f64::from(k) / n)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;
    use messages::{BoxRecord, DoorRecord, PartRecord};
    use proptest::prelude::*;

    /// An element with a box turned by an angle about the origin; corners in metres.
    fn element(b: &mut SiteBuilder, angle_rad: f64, low: [f64; 3], high: [f64; 3]) -> u32 {
        let (sin, cos) = (libm::sin(angle_rad), libm::cos(angle_rad));
        let corner = |k: usize| [0, 1, 2].map(|i| if k >> i & 1 == 0 { low[i] } else { high[i] });
        let turned = |[x, y, z]: [f64; 3]| [x * cos - y * sin, x * sin + y * cos, z];
        let vertices: Vec<[i32; 3]> =
            (0..8).map(|k| turned(corner(k)).map(|m| (m * f64::from(TENTHS_PER_M)).round() as i32)).collect();
        let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let (first_vertex, first_triangle) = (b.vertices.len() as u32, b.triangles.len() as u32);
        b.triangles.extend(faces.iter().flat_map(|[p, q, r, s]| [[*p, *q, *r], [*p, *r, *s]]));
        b.parts.push(PartRecord {
            first_vertex,
            n_vertices: 8,
            first_triangle,
            n_triangles: 12,
            closed: 1,
            ..Zeroable::zeroed()
        });
        let bound = |k: usize, pick: fn(i32, i32) -> i32| vertices.iter().map(|v| v[k]).reduce(pick).unwrap_or(0);
        b.elements.push(ElementRecord {
            first_part: b.parts.len() as u32 - 1,
            n_parts: 1,
            min_tenths: [0, 1, 2].map(|k| bound(k, i32::min)),
            max_tenths: [0, 1, 2].map(|k| bound(k, i32::max)),
            whole: NONE,
            ..Zeroable::zeroed()
        });
        b.vertices.extend(vertices);
        b.elements.len() as u32 - 1
    }

    /// A leaf from one place to another on the x axis before the turn; `way` is the sign of its axis.
    fn leaf(b: &mut SiteBuilder, angle_rad: f64, [from, to]: [f64; 2], sill: f64, way: f64) {
        let element = element(b, angle_rad, [from, -0.03, sill], [to, 0.03, sill + 2.1]);
        let (sin, cos) = (libm::sin(angle_rad), libm::cos(angle_rad));
        let tenths = f64::from(TENTHS_PER_M);
        let middle = (from + to) / 2.0 * tenths;
        b.doors.push(DoorRecord {
            clear_width_from: messages::ClearWidth::Assumed.into(),
            element,
            beside: [NONE; 2],
            passage: BoxRecord {
                centre: [middle * cos, middle * sin],
                axis: [way * cos, way * sin],
                half: [(to - from) / 2.0 * tenths, 0.03 * tenths],
            },
            ..Zeroable::zeroed()
        });
    }

    fn beside(b: &mut SiteBuilder) -> Vec<[u32; 2]> {
        join_leaves(b);
        b.doors.iter().map(|d| d.beside).collect()
    }

    #[test]
    fn leaves_that_touch_are_of_one_opening_and_those_with_a_mullion_between_them_are_not() {
        let pair = |mullion: bool| {
            let mut b = SiteBuilder::default();
            leaf(&mut b, 0.0, [0.0, 0.56], 0.0, 1.0);
            leaf(&mut b, 0.0, [0.56, 1.07], 0.0, 1.0);
            if mullion {
                element(&mut b, 0.0, [0.535, -0.025, 0.0], [0.585, 0.025, 2.5]);
            }
            beside(&mut b)
        };
        assert_eq!(pair(false), [[NONE, 1], [0, NONE]]);
        assert_eq!(pair(true), [[NONE; 2]; 2]);
    }

    #[test]
    fn a_transom_above_and_a_threshold_below_are_no_mullions() {
        let mut b = SiteBuilder::default();
        leaf(&mut b, 0.0, [0.0, 0.5], 0.0, 1.0);
        leaf(&mut b, 0.0, [0.5, 1.0], 0.0, 1.0);
        element(&mut b, 0.0, [0.0, -0.05, 2.1], [1.0, 0.05, 2.2]);
        element(&mut b, 0.0, [0.0, -0.05, -0.1], [1.0, 0.05, 0.02]);
        assert_eq!(beside(&mut b), [[NONE, 1], [0, NONE]]);
    }

    #[test]
    fn doors_apart_at_an_angle_or_at_another_height_are_on_their_own() {
        let pair = |second: &dyn Fn(&mut SiteBuilder)| {
            let mut b = SiteBuilder::default();
            leaf(&mut b, 0.0, [0.0, 0.9], 0.0, 1.0);
            second(&mut b);
            beside(&mut b)
        };
        assert_eq!(pair(&|b| leaf(b, 0.0, [1.05, 1.95], 0.0, 1.0)), [[NONE; 2]; 2]);
        assert_eq!(pair(&|b| leaf(b, 1.0, [0.0, 0.9], 0.0, 1.0)), [[NONE; 2]; 2]);
        assert_eq!(pair(&|b| leaf(b, 0.0, [0.9, 1.8], 1.0, 1.0)), [[NONE; 2]; 2]);
        assert_eq!(pair(&|b| leaf(b, 0.0, [0.9, 1.8], 0.0, -1.0)), [[NONE, 1], [NONE, 0]], "axes may be turned");
    }

    proptest! {
        #[test]
        fn turning_a_row_of_leaves_changes_nothing(angle_rad in -3.0..3.0f64, n in 2usize..6) {
            let mut b = SiteBuilder::default();
            for k in 0..n {
                leaf(&mut b, angle_rad, [0.6 * k as f64, 0.6 * (k + 1) as f64], 0.0, 1.0);
            }
            let next = |k: usize| if k < n { k as u32 } else { NONE };
            let expected: Vec<[u32; 2]> = (0..n).map(|k| [next(k.wrapping_sub(1)), next(k + 1)]).collect();
            prop_assert_eq!(beside(&mut b), expected);
        }
    }
}
