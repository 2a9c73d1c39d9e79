//! Width of a doorway between obstacles, measured on footprints and therefore independent of the resolution.

use crate::model::cell_area::{cells_around, cells_beside};
use crate::model::presence::Presence;
use crate::model::storey_inputs::StoreyInputs;
use frames::TENTHS_PER_M;
use geometry::{Footprint, OrientedBox};
use grid::Class;
use messages::{NONE, ScheduleState};

/// Distance between samples along a line across the doorway: 1 cm.
const STEP: f64 = 0.01 * TENTHS_PER_M as f64;

/// Offsets of the sampled lines from the middle of the doorway, as shares of its half depth.
const ACROSS: [f64; 5] = [-0.95, -0.5, 0.0, 0.5, 0.95];

/// A doorway of which walls leave less than this has no opening.
const MIN_OPENING_M: f64 = 0.10;

/// Samples within this distance of a sheet without thickness are covered by it.
const SHEET_REACH: f64 = 0.005 * TENTHS_PER_M as f64;

/// The width that obstacles leave of a doorway.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct DoorwayClearance {
    /// Free width of the narrowest line.
    pub(crate) width_m: f64,
    /// Element that covers the most samples, or [`NONE`].
    pub(crate) obstacle: u32,
    /// True if walls close the doorway.
    pub(crate) is_walled_up: bool,
}

/// Indices of the obstacles near a doorway, each with the number of samples that it covers; a reused buffer.
pub(crate) type CoveredSamples = Vec<(u32, u32)>;

/// The width that the obstacles of a schedule state, without doors, leave of a doorway.
pub(crate) fn doorway_clearance(
    way: &OrientedBox,
    inputs: StoreyInputs<'_>,
    schedule_state: &ScheduleState<'_>,
    nearby: &mut CoveredSamples,
) -> DoorwayClearance {
    let storey = inputs.storey;
    nearby.clear();
    if let Some(cells) = cells_beside(way, &storey.spec) {
        let is_near = |index: &u32| {
            let obstacle = &storey.obstacles[*index as usize];
            let presence = Presence::of(schedule_state.effective(obstacle.element as usize));
            let meets = obstacle.rect.is_some_and(|rect| rect.meets(&cells));
            // What a robot drives on is in nobody's way.
            let is_ground = presence == Presence::Built && storey.ground.iter().any(|p| p.element == obstacle.element);
            obstacle.class != Class::Door && presence.is_obstacle() && meets && !is_ground
        };
        nearby.extend(storey.obstacle_squares.around(cells).filter(is_near).map(|index| (index, 0)));
        nearby.sort_unstable();
        nearby.dedup();
    }
    let (mut width_m, mut width_of_walls_m) = (f64::INFINITY, f64::INFINITY);
    for v in ACROSS {
        let [all_m, walls_m] = widest_m(way, v * way.half[1], inputs, nearby);
        (width_m, width_of_walls_m) = (width_m.min(all_m), width_of_walls_m.min(walls_m));
    }
    let most = nearby.iter().filter(|s| s.1 > 0).max_by_key(|s| (s.1, std::cmp::Reverse(s.0)));
    DoorwayClearance {
        width_m,
        obstacle: most.map_or(NONE, |s| storey.obstacles[s.0 as usize].element),
        is_walled_up: width_of_walls_m < MIN_OPENING_M,
    }
}

/// Widest free stretches of the line across a doorway at offset `v` from its middle: between all obstacles, and between
/// walls alone.
fn widest_m(way: &OrientedBox, v: f64, inputs: StoreyInputs<'_>, nearby: &mut CoveredSamples) -> [f64; 2] {
    let StoreyInputs { site, storey, .. } = inputs;
    let n_steps = (2.0 * way.half[0] / STEP).floor().max(0.0) as u32;
    let (mut best, mut now) = ([0u32; 2], [0u32; 2]);
    for k in 0..n_steps {
        let at = way.at((f64::from(k) + 0.5) * STEP - way.half[0], v);
        let cell = cells_around(std::iter::once(at), SHEET_REACH, &storey.spec);
        let mut is_free = [true; 2];
        for (index, n_covered) in nearby.iter_mut() {
            let obstacle = &storey.obstacles[*index as usize];
            let is_beside = cell.zip(obstacle.rect).is_some_and(|(cell, rect)| cell.meets(&rect));
            if is_beside && storey.footprint(site, obstacle.element).is_some_and(|f| covers(f, at)) {
                *n_covered += 1;
                is_free[0] = false;
                // Members and plates of a curtain wall are reported by name.
                is_free[1] &= obstacle.class != Class::Wall;
            }
        }
        for kind in 0..2 {
            now[kind] = if is_free[kind] { now[kind] + 1 } else { 0 };
            best[kind] = best[kind].max(now[kind]);
        }
    }
    best.map(|n| f64::from(n) * STEP / f64::from(TENTHS_PER_M))
}

fn covers(footprint: &Footprint, at: [f64; 2]) -> bool {
    footprint.area.contains(at)
        || footprint.lines.iter().any(|[a, b]| distance(at, a.map(f64::from), b.map(f64::from)) < SHEET_REACH)
}

/// Distance of a point from a line segment.
fn distance(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let d = [b[0] - a[0], b[1] - a[1]];
    let e = [p[0] - a[0], p[1] - a[1]];
    let length2 = d[0] * d[0] + d[1] * d[1];
    let t = if length2 > 0.0 { ((e[0] * d[0] + e[1] * d[1]) / length2).clamp(0.0, 1.0) } else { 0.0 };
    let off = [e[0] - t * d[0], e[1] - t * d[1]];
    (off[0] * off[0] + off[1] * off[1]).sqrt()
}
