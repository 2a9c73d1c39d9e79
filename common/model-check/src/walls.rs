//! Walls that do not meet: gaps at their ends through which one side sees the other.

use crate::causes::IssueCode;
use crate::document::Place;
use crate::evidence::{Found, Subject};
use export::rounded;
use frames::{Map, Point2, metres};
use geometry::{MultiPolygon, OrientedBox, Point, Slab, edges, footprint};
use grid::Class;
use messages::{FloorKind, Grid, NONE, Site};

/// Walls that are nearer meet: 10 mm, as exactly as people draw.
const MEETS: f64 = 100.0;
/// A wider gap is a way: the width of the smallest robots.
const WIDEST: f64 = 5_000.0;
/// Half the thickness of the thickest wall whose ends are looked at.
const MAX_HALF_THICKNESS: f64 = 3_500.0;
/// A wall is at least as much longer than thick.
const MIN_SLENDER: f64 = 1.5;
/// How far from the wall's side it is looked what lies there: 0.2 m.
const BESIDE: f64 = 2_000.0;

/// What bounds rooms at the height of the robot, in plan.
struct Solid {
    element: u32,
    area: MultiPolygon,
    bounds: [f64; 4],
}

/// Gaps at the ends of the walls of a storey.
pub(crate) fn gaps(site: &Site<'_>, grid: &Grid<'_>) -> Vec<Found> {
    if grid.head.floor == FloorKind::Ground {
        return Vec::new();
    }
    let [lo, hi] = grid.head.slab_tenths.map(|above| grid.head.floor_z_tenths + above);
    let slab = Slab { lo, hi };
    let bounds_room =
        |class: Class| !matches!(class, Class::None | Class::Furniture | Class::Mep | Class::Railing | Class::Slab);
    let solid = |k: usize| {
        let record = &site.elements[k];
        let is_there =
            record.n_parts > 0 && bounds_room(record.class()) && slab.meets(record.min_tenths[2], record.max_tenths[2]);
        let area = is_there.then(|| footprint(site.element_meshes(record), slab).area)?;
        let b = area.bounds()?;
        let bounds = [b.min[0], b.min[1], b.max[0], b.max[1]].map(f64::from);
        Some(Solid { element: k as u32, area, bounds })
    };
    let solids: Vec<Solid> = (0..site.elements.len()).filter_map(solid).collect();
    let mut all: Vec<Found> = Vec::new();
    for wall in solids.iter().filter(|solid| site.elements[solid.element as usize].class() == Class::Wall) {
        for found in ends_of(site, grid, &solids, wall) {
            // A corner that is open is seen from both of its walls.
            let is_known = |known: &&mut Found| {
                let (a, b) = (known.place.as_ref(), found.place.as_ref());
                a.zip(b).is_some_and(|(a, b)| {
                    let [p, q] = [a.middle_m(), b.middle_m()];
                    libm::hypot(p[0] - q[0], p[1] - q[1]) < metres(WIDEST as i32)
                })
            };
            match all.iter_mut().find(is_known) {
                Some(_) => {}
                None => all.push(found),
            }
        }
    }
    all
}

/// Gaps at the two ends of a wall.
fn ends_of(site: &Site<'_>, grid: &Grid<'_>, solids: &[Solid], wall: &Solid) -> Vec<Found> {
    let record = &site.elements[wall.element as usize];
    let points: Vec<Point> =
        site.element_meshes(record).flat_map(|mesh| mesh.vertices.iter().map(|v| [v[0], v[1]])).collect();
    let Some(body) = OrientedBox::smallest_around(&points) else { return Vec::new() };
    let body = if body.half[0] >= body.half[1] {
        body
    } else {
        OrientedBox { centre: body.centre, axis: body.across(), half: [body.half[1], body.half[0]] }
    };
    if body.half[1] > MAX_HALF_THICKNESS || body.half[0] < MIN_SLENDER * body.half[1] {
        return Vec::new();
    }
    [1.0, -1.0].into_iter().filter_map(|sign| gap_at(site, grid, solids, wall, (&body, sign))).collect()
}

fn gap_at(
    site: &Site<'_>,
    grid: &Grid<'_>,
    solids: &[Solid],
    wall: &Solid,
    (body, sign): (&OrientedBox, f64),
) -> Option<Found> {
    let end = [body.at(sign * body.half[0], -body.half[1]), body.at(sign * body.half[0], body.half[1])];
    // Where the end is not as the box says, the wall is cut or bent there.
    let (_, off_own) = nearest(&wall.area, end)?;
    let own_whole = site.elements[wall.element as usize].whole;
    if libm::hypot(off_own[0], off_own[1]) > MEETS {
        return None;
    }
    let near = |solid: &&Solid| {
        let is_other = solid.element != wall.element;
        let whole = site.elements[solid.element as usize].whole;
        let is_part = solid.element == own_whole || whole == wall.element || (whole != NONE && whole == own_whole);
        let b = solid.bounds;
        let [x0, x1] = [end[0][0].min(end[1][0]) - WIDEST, end[0][0].max(end[1][0]) + WIDEST];
        let [y0, y1] = [end[0][1].min(end[1][1]) - WIDEST, end[0][1].max(end[1][1]) + WIDEST];
        is_other && !is_part && b[0] <= x1 && x0 <= b[2] && b[1] <= y1 && y0 <= b[3]
    };
    let mut best: Option<(f64, [f64; 2], [f64; 2], u32)> = None;
    for solid in solids.iter().filter(near) {
        let (from, off) = nearest(&solid.area, end)?;
        let far = libm::hypot(off[0], off[1]);
        if far <= MEETS {
            return None;
        }
        if best.is_none_or(|(nearest, ..)| far < nearest) {
            best = Some((far, from, [from[0] + off[0], from[1] + off[1]], solid.element));
        }
    }
    let (width, from, to, other) = best.filter(|(far, ..)| *far <= WIDEST)?;
    let is_wall = matches!(site.elements[other as usize].class(), Class::Wall | Class::Column | Class::CurtainWall);
    let middle = [0, 1].map(|k| (from[k] + to[k]) / 2.0);
    let across = body.across();
    let beside = |side: f64| [0, 1].map(|k| middle[k] + side * (body.half[1] + BESIDE) * across[k]);
    let sides = [beside(1.0), beside(-1.0)];
    let sees = |to: [f64; 2]| !solids.iter().any(|solid| crosses(solid, [middle, to]));
    // A corner may be seen through at an angle: then the way leads on from the middle of the gap.
    let [a, b] = sides.map(|p| lies(grid, p));
    if !is_wall || !sides.into_iter().all(sees) || a == b || a == Side::Inside || b == Side::Inside {
        return None;
    }
    let rooms: Vec<u32> = [a, b]
        .into_iter()
        .filter_map(|side| match side {
            Side::Room(space) => Some(space),
            _ => None,
        })
        .collect();
    if rooms.is_empty() {
        return None;
    }
    let other_name = answers::ElementRef::of(site, other as usize);
    let width_m = width / f64::from(frames::TENTHS_PER_M);
    let text = format!("a gap of {width_m:.2} m to {} {}", other_name.ifc_type, other_name.label());
    let mut found = Found::of(IssueCode::WallGap, Subject::Element(wall.element as usize), text);
    let (min, max) = ([0, 1].map(|k| from[k].min(to[k])), [0, 1].map(|k| from[k].max(to[k])));
    let bounds_m = [min, max].map(|p| p.map(|c| rounded(c / f64::from(frames::TENTHS_PER_M))));
    let z_m = rounded(metres(grid.head.floor_z_tenths));
    found.place = Some(Place { storey: Some(grid.head.map_storey), bounds_m, z_m });
    found.rooms = rooms;
    // Cells are occupied that a wall touches: what is narrow is closed on the map, whatever the walls are.
    let spec = grid.spec();
    let cell = spec.cell_at(Point2::<Map>::new(middle[0] * 1e-4, middle[1] * 1e-4)).map(|cell| spec.index(cell));
    let is_open = cell.is_some_and(|cell| grid.planning[cell] != 100);
    Some(if is_open { found } else { found.without_effect_on_maps() })
}

/// What lies at a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Side {
    /// A room.
    Room(u32),
    /// Floor outside of rooms, or none.
    Elsewhere,
    /// An element.
    Inside,
}

fn lies(grid: &Grid<'_>, p: [f64; 2]) -> Side {
    let spec = grid.spec();
    let Some(cell) = spec.cell_at(Point2::<Map>::new(p[0] * 1e-4, p[1] * 1e-4)) else { return Side::Elsewhere };
    let cell = spec.index(cell);
    match grid.space[cell].checked_sub(1) {
        _ if grid.planning[cell] == 100 => Side::Inside,
        Some(space) => Side::Room(u32::from(space)),
        None => Side::Elsewhere,
    }
}

/// The point of a segment that is nearest to a region, and the step from there to the region.
fn nearest(area: &MultiPolygon, segment: [[f64; 2]; 2]) -> Option<([f64; 2], [f64; 2])> {
    if let Some(inside) = segment.into_iter().find(|p| area.contains(*p)) {
        return Some((inside, [0.0; 2]));
    }
    let mut best: Option<(f64, [f64; 2], [f64; 2])> = None;
    for (a, b) in area.rings().flat_map(|ring| edges(ring)) {
        let edge = [a.map(f64::from), b.map(f64::from)];
        if meet(segment, edge) {
            return Some((segment[0], [0.0; 2]));
        }
        let ends = segment.map(|p| (p, on_segment(p, edge)));
        let corners = edge.map(|q| (on_segment(q, segment), q));
        for (p, q) in ends.into_iter().chain(corners) {
            let off = [q[0] - p[0], q[1] - p[1]];
            let far = libm::hypot(off[0], off[1]);
            if best.is_none_or(|(least, ..)| far < least) {
                best = Some((far, p, off));
            }
        }
    }
    best.map(|(_, p, off)| (p, off))
}

/// The point of a segment that is nearest to a point.
fn on_segment(p: [f64; 2], [a, b]: [[f64; 2]; 2]) -> [f64; 2] {
    let along = [b[0] - a[0], b[1] - a[1]];
    let squared = along[0] * along[0] + along[1] * along[1];
    let part = if squared > 0.0 { ((p[0] - a[0]) * along[0] + (p[1] - a[1]) * along[1]) / squared } else { 0.0 };
    [0, 1].map(|k| a[k] + part.clamp(0.0, 1.0) * along[k])
}

/// True if two segments cross.
fn meet(s: [[f64; 2]; 2], t: [[f64; 2]; 2]) -> bool {
    let side = |[a, b]: [[f64; 2]; 2], p: [f64; 2]| (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
    let parts = |line: [[f64; 2]; 2], of: [[f64; 2]; 2]| (side(line, of[0]) > 0.0) != (side(line, of[1]) > 0.0);
    parts(s, t) && parts(t, s)
}

/// True if a segment meets a solid.
fn crosses(solid: &Solid, segment: [[f64; 2]; 2]) -> bool {
    let b = solid.bounds;
    let [x0, x1] = [segment[0][0].min(segment[1][0]), segment[0][0].max(segment[1][0])];
    let [y0, y1] = [segment[0][1].min(segment[1][1]), segment[0][1].max(segment[1][1])];
    if b[0] > x1 || x0 > b[2] || b[1] > y1 || y0 > b[3] {
        return false;
    }
    let cut =
        solid.area.rings().flat_map(|r| edges(r)).any(|(a, b)| meet(segment, [a.map(f64::from), b.map(f64::from)]));
    cut || segment.into_iter().any(|p| solid.area.contains(p))
}
