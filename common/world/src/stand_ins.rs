//! Stand-ins in the world: plates for assumed floor, walls that close blocked spaces.

use crate::doors::{is_door, is_hung};
use crate::static_elements::{StaticElement, storey_at};
use convex::convex_partition;
use export::ExportInput;
use frames::{TENTHS_PER_M, metres};
use geometry::{MultiPolygon, OrientedBox, union_of};
use grid::Class;
use messages::{BoxRecord, FloorKind, NONE, SpaceRecord, space_flags};

/// Thickness of assumed floors and barriers, in metres.
const FLOOR_M: f64 = 0.1;
const BARRIER_M: f64 = 0.02;

/// Height of a barrier where that of the passage is unknown.
const BARRIER_HEIGHT_M: f64 = 2.0;

/// Distances from a passage at which its spaces are probed, in tenths of a millimetre.
const PROBES: [f64; 3] = [1_000.0, 3_000.0, 6_000.0];

/// Plates under what is assumed to be floor: the plans of rooms without a slab, or of a storey that has neither slabs nor rooms.
pub(crate) fn assumed_floors(input: &ExportInput<'_>) -> Vec<StaticElement> {
    let site = input.site;
    let mut found = Vec::new();
    for (storey, record) in (0..).zip(site.map_storeys) {
        let is_assumed = |s: &&SpaceRecord| s.map_storey == storey && s.has(space_flags::ASSUMED_FLOOR);
        let rooms: Vec<MultiPolygon> = site.spaces.iter().filter(is_assumed).map(|s| site.floor_polygon(s)).collect();
        let [x0, y0, x1, y1] = record.bounds_tenths;
        let rings = match record.floor.get() {
            FloorKind::AssumedFromEnclosure => vec![vec![[x0, y0], [x1, y0], [x1, y1], [x0, y1]]],
            _ if rooms.is_empty() => continue,
            _ => convex_partition(&union_of(&rooms)),
        };
        let link = format!("assumed_floor_{storey}_{}", site.text(record.global_id));
        found.push(StaticElement::slab(link, Class::Slab, storey, rings, metres(record.floor_z_tenths), FLOOR_M));
    }
    found
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
