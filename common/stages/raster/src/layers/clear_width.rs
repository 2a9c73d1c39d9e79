//! Clear width of a doorway between obstacles, measured on footprints and so independent of the map's resolution.

use crate::model::cell_area::cells_beside;
use crate::model::presence::Look;
use crate::model::storey_slice::StoreyCut;
use frames::TENTHS_PER_M;
use geometry::{Footprint, OrientedBox};
use grid::Class;
use messages::{NONE, Phase};

/// Distance between places that are looked at along a way: 1 cm.
const STEP: f64 = 0.01 * TENTHS_PER_M as f64;

/// Places across a way, from 0 in its middle to 1 at its side, that are looked at.
const ACROSS: [f64; 5] = [-0.95, -0.5, 0.0, 0.5, 0.95];

/// A wall that leaves less than this of a way has no opening there.
const LEAST_OPENING_M: f64 = 0.10;

/// A sheet without thickness stands in the way of places that are this near.
const SHEET: f64 = 0.005 * TENTHS_PER_M as f64;

/// What obstacles leave of a way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Between {
    /// Width of its narrowest line.
    pub(crate) width_m: f64,
    /// Element that takes most of it, or [`NONE`].
    pub(crate) obstacle: u32,
    /// True if walls leave nothing of it.
    pub(crate) is_walled_up: bool,
}

/// Places of the storey's obstacles that stand near a way, with how many samples each covers, in memory that is used again.
pub(crate) type Standing = Vec<(u32, u32)>;

/// What the obstacles of a phase leave of a way, doors not counted.
pub(crate) fn between_obstacles(
    way: &OrientedBox,
    storey: &StoreyCut,
    phase: &Phase<'_>,
    standing: &mut Standing,
) -> Between {
    standing.clear();
    let cells = cells_beside(way, &storey.spec);
    let is_near = |rect| cells.zip(rect).is_some_and(|(a, b): (grid::CellRect, _)| a.meets(&b));
    for (place, obstacle) in (0..).zip(&storey.obstacles) {
        let look = Look::of(phase.effective(obstacle.element as usize));
        if obstacle.class != Class::Door && look.is_obstacle() && is_near(obstacle.rect) {
            standing.push((place, 0));
        }
    }
    let (mut width_m, mut width_of_walls_m) = (f64::INFINITY, f64::INFINITY);
    for v in ACROSS {
        let [all_m, walls_m] = widest_m(way, v * way.half[1], storey, standing);
        (width_m, width_of_walls_m) = (width_m.min(all_m), width_of_walls_m.min(walls_m));
    }
    let most = standing.iter().filter(|s| s.1 > 0).max_by_key(|s| (s.1, std::cmp::Reverse(s.0)));
    Between {
        width_m,
        obstacle: most.map_or(NONE, |s| storey.obstacles[s.0 as usize].element),
        is_walled_up: width_of_walls_m < LEAST_OPENING_M,
    }
}

/// The widest that all obstacles, and that walls alone, leave of the line along a way at this offset from its middle.
fn widest_m(way: &OrientedBox, v: f64, storey: &StoreyCut, standing: &mut Standing) -> [f64; 2] {
    let n_steps = (2.0 * way.half[0] / STEP).floor().max(0.0) as u32;
    let (mut best, mut now) = ([0u32; 2], [0u32; 2]);
    for k in 0..n_steps {
        let at = way.at((f64::from(k) + 0.5) * STEP - way.half[0], v);
        let mut is_free = [true; 2];
        for (place, n_covered) in standing.iter_mut() {
            let obstacle = &storey.obstacles[*place as usize];
            if footprint_of(storey, obstacle.element).is_some_and(|f| covers(f, at)) {
                *n_covered += 1;
                is_free[0] = false;
                // Members and plates of a curtain wall are told by name.
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

fn footprint_of(storey: &StoreyCut, element: u32) -> Option<&Footprint> {
    let at = storey.footprints.binary_search_by_key(&element, |(e, _)| *e).ok()?;
    Some(&storey.footprints[at].1)
}

fn covers(footprint: &Footprint, at: [f64; 2]) -> bool {
    footprint.area.contains(at)
        || footprint.lines.iter().any(|[a, b]| distance(at, a.map(f64::from), b.map(f64::from)) < SHEET)
}

/// Distance of a point from a line between two others.
fn distance(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let d = [b[0] - a[0], b[1] - a[1]];
    let e = [p[0] - a[0], p[1] - a[1]];
    let length2 = d[0] * d[0] + d[1] * d[1];
    let t = if length2 > 0.0 { ((e[0] * d[0] + e[1] * d[1]) / length2).clamp(0.0, 1.0) } else { 0.0 };
    let off = [e[0] - t * d[0], e[1] - t * d[1]];
    (off[0] * off[0] + off[1] * off[1]).sqrt()
}
