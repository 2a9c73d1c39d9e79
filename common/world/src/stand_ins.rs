//! Stand-ins in the world: plates for assumed floor, walls that close blocked spaces.

use crate::doors::{is_door, is_hung};
use crate::static_elements::{StaticElement, storey_at};
use convex::convex_partition;
use export::ExportInput;
use frames::{Point2, TENTHS_PER_M, metres};
use geometry::{FillRule, MultiPolygon, OrientedBox, Ring, union, union_of};
use grid::{CellRect, Class};
use messages::{BoxRecord, FLOOR_ASSUMED, FloorKind, Grid, NONE, SpaceRecord, space_flags};

/// Thickness of assumed floors and barriers, in metres.
const FLOOR_M: f64 = 0.1;
const BARRIER_M: f64 = 0.02;

/// Height of a barrier where that of the passage is unknown.
const BARRIER_HEIGHT_M: f64 = 2.0;

/// Distances from a passage at which its spaces are probed, in tenths of a millimetre.
const PROBES: [f64; 3] = [1_000.0, 3_000.0, 6_000.0];

/// Plates under what is assumed to be floor on the maps: the plans of rooms without a slab and the doorways between them, or the cells
/// of a storey that has neither slabs nor rooms.
pub(crate) fn assumed_floors(input: &ExportInput<'_>) -> Vec<StaticElement> {
    let site = input.site;
    let plates = |grid: &Grid<'_>| {
        let storey = grid.head.map_storey;
        let record = &site.map_storeys[storey as usize];
        let plans = match record.floor.get() {
            FloorKind::AssumedFromEnclosure => assumed_cells(grid),
            // Before anything of a storey is built that has slabs, nothing is assumed.
            _ if !grid.floor.contains(&FLOOR_ASSUMED) => Vec::new(),
            _ => convex_partition(&assumed_rooms(input, grid)),
        };
        let link = format!("assumed_floor_{storey}_{}", site.text(record.global_id));
        (!plans.is_empty())
            .then(|| StaticElement::slab(link, Class::Slab, storey, plans, metres(record.floor_z_tenths), FLOOR_M))
    };
    input.grids.each(plates).flatten().collect()
}

/// The plans of a storey's rooms without a slab, and of the openings between rooms in which the map has assumed floor.
fn assumed_rooms(input: &ExportInput<'_>, grid: &Grid<'_>) -> MultiPolygon {
    let (site, spec) = (input.site, grid.spec());
    let is_assumed = |s: &&SpaceRecord| s.map_storey == grid.head.map_storey && s.has(space_flags::ASSUMED_FLOOR);
    let rooms = site.spaces.iter().filter(is_assumed).map(|s| site.floor_polygon(s));
    let is_doorway = |plan: &OrientedBox| {
        let [x, y] = plan.at(0.0, 0.0).map(|c| c / f64::from(TENTHS_PER_M));
        let cell = spec.cell_at(Point2::new(x, y));
        cell.is_some_and(|cell| grid.floor[spec.index(cell)] == FLOOR_ASSUMED)
    };
    let plans = site.openings.iter().filter(|o| o.plan.half[0] > 0.0).map(|o| o.plan.to_box());
    let doorways = plans.filter(is_doorway).map(|plan| union(&[plan.ring()], FillRule::NonZero));
    union_of(&rooms.chain(doorways).collect::<Vec<_>>())
}

/// Rectangles around the cells of assumed floor: rows that are alike are one.
fn assumed_cells(grid: &Grid<'_>) -> Vec<Ring> {
    let spec = grid.spec();
    let (mut open, mut closed): (Vec<CellRect>, Vec<CellRect>) = (Vec::new(), Vec::new());
    for (row, cells) in (0..).zip(grid.floor.chunks(spec.width as usize)) {
        let mut next = Vec::new();
        let mut start = 0;
        for run in cells.chunk_by(|a, b| (*a == FLOOR_ASSUMED) == (*b == FLOOR_ASSUMED)) {
            let end = start + run.len() as u32;
            if run[0] == FLOOR_ASSUMED {
                let is_above = |r: &CellRect| (r.min[0], r.max[0]) == (start, end);
                let min = open.iter().position(is_above).map_or([start, row], |at| open.swap_remove(at).min);
                next.push(CellRect { min, max: [end, row + 1] });
            }
            start = end;
        }
        closed.append(&mut open);
        open = next;
    }
    closed.append(&mut open);
    let corner = |at: [u32; 2]| [0, 1].map(|k| (spec.first_cell[k] + at[k] as i32) * spec.cell_tenths);
    let ring = |rect: &CellRect| {
        let ([x0, y0], [x1, y1]) = (corner(rect.min), corner(rect.max));
        vec![[x0, y0], [x1, y0], [x1, y1], [x0, y1]]
    };
    closed.iter().map(ring).collect()
}

/// A thin wall in each passage between a blocked space and one that is not: (the door that hangs there, the wall).
pub(crate) fn barriers(input: &ExportInput<'_>) -> Vec<(Option<u32>, StaticElement)> {
    let site = input.site;
    let blocked = |space: Option<usize>| space.is_some_and(|s| input.schedule_state.is_blocked(s));
    let closes = |plan: &OrientedBox, bottom_m: f64| {
        let [a, b] = joined(input, plan, bottom_m).map(blocked);
        a != b
    };
    let barrier = |link: String, plan: BoxRecord, [low, high]: [f64; 2]| {
        let scale = f64::from(TENTHS_PER_M);
        let [x, y] = plan.centre.map(|c| c / scale);
        let size_m = [2.0 * plan.half[0] / scale, BARRIER_M, high - low];
        StaticElement::plate(link, Class::Other, storey_at(input, low), [x, y, (low + high) / 2.0], plan.axis, size_m)
    };
    let mut found = Vec::new();
    for (index, door) in (0..).zip(site.doors).filter(|(_, d)| is_door(input, d.element)) {
        let record = &site.elements[door.element as usize];
        let [a, b] = door.spaces.map(|s| (s != NONE).then_some(s as usize)).map(blocked);
        if a != b {
            let low = metres(record.min_tenths[2]);
            let high = low + door.overall_height_m.max(0.5);
            let link = format!("barrier_{}", site.text(record.global_id));
            found.push((is_hung(input, door).then_some(index), barrier(link, door.passage, [low, high])));
        }
    }
    for opening in site.openings.iter().filter(|o| o.plan.half[0] > 0.0 && o.filling == NONE) {
        let low = metres(opening.bottom_z_tenths);
        let high = metres(opening.top_z_tenths).max(low + BARRIER_HEIGHT_M / 2.0);
        // A window's sill is no passage.
        let floor = metres(site.map_storeys.get(storey_at(input, low) as usize).map_or(0, |s| s.floor_z_tenths));
        let stands = opening.host != NONE && input.schedule_state.effective(opening.host as usize).is_obstacle();
        if stands && low < floor + 0.2 && closes(&opening.plan.to_box(), low) {
            let link = format!("barrier_{}", site.text(opening.global_id));
            found.push((None, barrier(link, opening.plan, [low, high])));
        }
    }
    found
}

/// The spaces on both sides of a passage.
fn joined(input: &ExportInput<'_>, plan: &OrientedBox, bottom_m: f64) -> [Option<usize>; 2] {
    let site = input.site;
    let level = || site.spaces.iter().enumerate().filter(|(_, s)| (metres(s.floor_z_tenths) - bottom_m).abs() < 0.5);
    [-1.0, 1.0].map(|side| {
        PROBES.iter().find_map(|off| {
            let p = plan.at(0.0, side * (plan.half[1] + off));
            level().find(|(_, s)| site.floor_polygon(s).contains(p)).map(|(k, _)| k)
        })
    })
}
