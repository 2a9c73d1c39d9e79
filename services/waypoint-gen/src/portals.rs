//! Ways from storey to storey: stairs, ramps, lifts, and where to stand before them.

use crate::ground::Ground;
use crate::options::PlanOptions;
use frames::{Map, Point2, TENTHS_PER_M, metres};
use messages::{EdgeKind, ElementState, NONE, Phase, RobotProfile, Site, element_flags};
use std::collections::BTreeMap;

/// A way between two storeys, one above the other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Portal {
    /// Element of the site: the stair, ramp or lift as a whole.
    pub(crate) element: usize,
    pub(crate) kind: EdgeKind,
    /// The lower and the upper end.
    pub(crate) ends: [Staging; 2],
    /// Straight, from end to end.
    pub(crate) length_m: f64,
    /// True if this robot can take it.
    pub(crate) usable: bool,
}

/// Where to stand before a portal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Staging {
    /// Map storey.
    pub(crate) storey: usize,
    /// Cell of its grid.
    pub(crate) cell: usize,
    /// Part of its ground.
    pub(crate) part: u32,
}

/// Steps and landings belong to a storey whose floor is this near, in tenths of a millimetre.
const LEVEL_TENTHS: i64 = 4_500;

/// Farthest that a robot stands from what it is about to take, in metres, beyond its radius and the margin at edges.
const FARTHEST_M: f64 = 1.5;

/// A door this near to a lift is its door, in metres.
const LANDING_DOOR_M: f64 = 1.0;

/// The portals between neighbouring storeys, by element. An element that is not built is none.
pub(crate) fn portals(
    site: &Site<'_>,
    phase: &Phase<'_>,
    robot: &RobotProfile,
    options: &PlanOptions,
    grounds: &[&Ground],
) -> Vec<Portal> {
    let mut wholes: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (index, element) in site.elements.iter().enumerate().filter(|(_, e)| e.has(element_flags::VERTICAL)) {
        if element.n_parts > 0 && phase.effective(index) == ElementState::Built {
            wholes.entry(whole_of(site, index)).or_default().push(index);
        }
    }
    let mut portals = Vec::new();
    for (whole, elements) in wholes {
        let Some(kind) = kind_of(site, whole).or_else(|| elements.iter().find_map(|&e| kind_of(site, e))) else {
            continue;
        };
        let mut below: Option<Staging> = None;
        for (storey, ground) in grounds.iter().enumerate() {
            let entrances = entrances(site, &elements, kind, storey);
            let Some((cell, part)) = staging(ground, robot, &entrances) else { continue };
            let here = Staging { storey, cell, part };
            if let Some(below) = below {
                let length_m = length_m(site, grounds, [below, here]);
                let usable = usable(site, robot, options, whole, kind, grounds, [below, here]);
                portals.push(Portal { element: whole, kind, ends: [below, here], length_m, usable });
            }
            below = Some(here);
        }
    }
    portals
}

/// The outermost way up that an element is a part of.
fn whole_of(site: &Site<'_>, element: usize) -> usize {
    let mut at = element;
    // The bound ends cycles, which a broken file may hold.
    for _ in 0..16 {
        match site.elements[at].whole {
            NONE => break,
            whole if kind_of(site, whole as usize).is_some() => at = whole as usize,
            _ => break,
        }
    }
    at
}

fn kind_of(site: &Site<'_>, element: usize) -> Option<EdgeKind> {
    let record = &site.elements[element];
    let is_a = |entity: &str| site.text(record.lineage).split(' ').any(|e| e == entity);
    let predefined = site.text(record.predefined_type);
    if is_a("IfcStair") || is_a("IfcStairFlight") {
        Some(EdgeKind::Stair)
    } else if is_a("IfcRamp") || is_a("IfcRampFlight") {
        Some(EdgeKind::Ramp)
    } else if is_a("IfcTransportElement") {
        match predefined {
            "ESCALATOR" | "MOVINGWALKWAY" => Some(EdgeKind::Escalator),
            "CRANEWAY" | "LIFTINGGEAR" => None,
            _ => Some(EdgeKind::Lift),
        }
    } else {
        None
    }
}

/// Points at which one enters on a storey: what of the way lies at its level; for a lift its doors, else its outline.
fn entrances(site: &Site<'_>, elements: &[usize], kind: EdgeKind, storey: usize) -> Vec<Point2<Map>> {
    let floor = i64::from(site.map_storeys[storey].floor_z_tenths);
    let point = |x: i32, y: i32| Point2::new(metres(x), metres(y));
    if kind != EdgeKind::Lift {
        let vertices = elements.iter().flat_map(|&e| site.element_meshes(&site.elements[e])).flat_map(|m| m.vertices);
        let level = vertices.filter(|v| (i64::from(v[2]) - floor).abs() <= LEVEL_TENTHS);
        return level.map(|v| point(v[0], v[1])).collect();
    }
    let boxes = elements.iter().map(|&e| &site.elements[e]);
    let here =
        boxes.filter(|e| i64::from(e.min_tenths[2]) - LEVEL_TENTHS <= floor && floor < i64::from(e.max_tenths[2]));
    let mut points = Vec::new();
    for lift in here {
        let outside = |p: [f64; 2]| {
            let beyond = |k: usize| (metres(lift.min_tenths[k]) - p[k]).max(p[k] - metres(lift.max_tenths[k])).max(0.0);
            libm::hypot(beyond(0), beyond(1))
        };
        let doors = site.doors.iter().filter(|d| {
            let z = i64::from(site.elements[d.element as usize].min_tenths[2]);
            (z - floor).abs() <= LEVEL_TENTHS
        });
        let centres = doors.map(|d| d.passage.centre.map(|c| c / f64::from(TENTHS_PER_M)));
        let near: Vec<Point2<Map>> =
            centres.filter(|c| outside(*c) <= LANDING_DOOR_M).map(|c| Point2::new(c[0], c[1])).collect();
        if near.is_empty() {
            let [x, y] = [0, 1].map(|k| [lift.min_tenths[k], lift.max_tenths[k]]);
            let middle = |r: [i32; 2]| r[0].midpoint(r[1]);
            points.extend([
                point(x[0], middle(y)),
                point(x[1], middle(y)),
                point(middle(x), y[0]),
                point(middle(x), y[1]),
            ]);
        } else {
            points.extend(near);
        }
    }
    points
}

/// The cell on which the robot stands nearest to any of the entrances, and its part.
fn staging(ground: &Ground, robot: &RobotProfile, entrances: &[Point2<Map>]) -> Option<(usize, u32)> {
    let spec = &ground.spec;
    let reach = ((FARTHEST_M + robot.radius_m + robot.edge_margin_m) / spec.resolution_m()).ceil() as u32;
    let mut cells: Vec<grid::Cell> = entrances.iter().filter_map(|p| spec.cell_at(*p)).collect();
    cells.sort_unstable();
    cells.dedup();
    let mut nearest: Option<(u64, usize)> = None;
    for at in cells {
        // What is farther than the nearest so far is not looked at.
        let reach = nearest.map_or(reach, |(d2, _)| reach.min(d2.isqrt() as u32 + 1));
        let range = |at: u32, n: u32| at.saturating_sub(reach)..(at + reach + 1).min(n);
        for row in range(at.row, spec.height) {
            for column in range(at.column, spec.width) {
                let cell = spec.index(grid::Cell { column, row });
                let d2 = u64::from(row.abs_diff(at.row)).pow(2) + u64::from(column.abs_diff(at.column)).pow(2);
                if ground.part(cell) != 0 && d2 <= u64::from(reach).pow(2) && nearest.is_none_or(|n| (d2, cell) < n) {
                    nearest = Some((d2, cell));
                }
            }
        }
    }
    nearest.map(|(_, cell)| (cell, ground.part(cell)))
}

fn length_m(site: &Site<'_>, grounds: &[&Ground], ends: [Staging; 2]) -> f64 {
    let [a, b] = ends.map(|end| grounds[end.storey].middle(end.cell));
    let [low, high] = ends.map(|end| metres(site.map_storeys[end.storey].floor_z_tenths));
    libm::hypot(libm::hypot(b.x_m - a.x_m, b.y_m - a.y_m), high - low)
}

fn usable(
    site: &Site<'_>,
    robot: &RobotProfile,
    options: &PlanOptions,
    whole: usize,
    kind: EdgeKind,
    grounds: &[&Ground],
    ends: [Staging; 2],
) -> bool {
    match kind {
        EdgeKind::Stair => robot.climbs_stairs == 1,
        EdgeKind::Ramp => {
            let [a, b] = ends.map(|end| grounds[end.storey].middle(end.cell));
            let [low, high] = ends.map(|end| metres(site.map_storeys[end.storey].floor_z_tenths));
            libm::atan2(high - low, libm::hypot(b.x_m - a.x_m, b.y_m - a.y_m)) <= robot.max_slope_rad
        }
        EdgeKind::Lift => options.takes_lift(site, whole),
        EdgeKind::Escalator | EdgeKind::Floor | EdgeKind::Door => false,
    }
}
