//! Connected parts of a storey's floor: their rooms and ways in, and the part in which a robot begins without a start.

use crate::ground::Ground;
use crate::input::PlanInput;
use crate::portal::Portal;
use crate::reachability::Reached;
use crate::start_pose::cells_around;
use frames::{Point2, TENTHS_PER_M};
use messages::{AttributeKind, DoorRecord, FloorPartRecord, Grid, NONE, Site, space_flags};

/// What speaks for beginning in a part of a storey's floor.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct PartFacts {
    /// Cells in it, those of indoor rooms only where the storey has any.
    pub(crate) room_cells: u32,
    /// True if a stair, ramp, lift or outer door leads to it.
    pub(crate) has_way_in: bool,
}

/// A part with a way in is preferred if it has at least this share of the room area of the part that has the most: a landing
/// before a lift is no storey.
const LEAST_SHARE: f64 = 0.1;

/// An outer door leads to the floor in which the robot can stand within this distance of its passage, beyond the robot's radius.
const DOOR_REACH_M: f64 = 0.5;

/// Facts of each part of a storey, from part 0, to which nobody gets.
pub(crate) fn part_facts(input: &PlanInput<'_>, storey: usize, ground: &Ground, portals: &[Portal]) -> Vec<PartFacts> {
    let (site, grid) = (input.site, &input.grids[storey]);
    let mut facts = vec![PartFacts::default(); ground.n_parts() as usize + 1];
    let is_room = |space: u16| {
        let flags = usize::from(space).checked_sub(1).map(|k| &site.spaces[k]);
        flags.is_some_and(|s| !s.has(space_flags::EXTERNAL) && !s.has(space_flags::METADATA_ONLY))
    };
    let has_rooms = grid.space.iter().any(|&space| is_room(space));
    for (cell, &space) in grid.space.iter().enumerate() {
        let counts = ground.part(cell) != 0 && (!has_rooms || is_room(space));
        facts[ground.part(cell) as usize].room_cells += u32::from(counts);
    }
    for end in portals.iter().flat_map(|p| p.ends).filter(|end| end.storey == storey) {
        facts[end.part as usize].has_way_in = true;
    }
    for passage in input.index.doors.iter().filter(|d| d.map_storey == grid.head.map_storey) {
        let door = &site.doors[passage.door as usize];
        if is_outer(site, door, passage.sides_with_floor) {
            for part in parts_at(ground, grid, door, input.index.head.robot.radius_m) {
                facts[part as usize].has_way_in = true;
            }
        }
    }
    facts
}

/// The part in which a robot begins that is put onto a storey: of those with a way in the one with the most room area, unless
/// that is small beside another part; 0 if there is none. Of equals the larger one, then the lower number.
pub(crate) fn first_part(ground: &Ground, facts: &[PartFacts]) -> u32 {
    let most = facts.iter().map(|f| f.room_cells).max().unwrap_or(0);
    let is_preferred =
        |f: &PartFacts| f.has_way_in && f.room_cells > 0 && f64::from(f.room_cells) >= LEAST_SHARE * f64::from(most);
    let rank = |&part: &u32| {
        let f = &facts[part as usize];
        (is_preferred(f), f.room_cells, ground.size(part), std::cmp::Reverse(part))
    };
    (1..=ground.n_parts()).max_by_key(rank).unwrap_or(0)
}

/// True if a door leads out of the building: its property says so, or it joins a room with the outdoors; in a model without
/// rooms, if there is floor on one of its sides only.
fn is_outer(site: &Site<'_>, door: &DoorRecord, sides_with_floor: u32) -> bool {
    let element = &site.elements[door.element as usize];
    let told = site.element_attributes(element).iter().find(|a| {
        a.kind == AttributeKind::Boolean as u32
            && (site.text(a.set), site.text(a.name)) == ("Pset_DoorCommon", "IsExternal")
    });
    if let Some(told) = told {
        return told.number == 1.0;
    }
    let is_outdoors = |space: u32| space == NONE || site.spaces[space as usize].has(space_flags::EXTERNAL);
    match door.spaces.map(is_outdoors) {
        [true, true] => site.spaces.is_empty() && sides_with_floor == 1,
        [a, b] => a != b,
    }
}

/// The parts beside a door, those in its rooms where it has any.
fn parts_at(ground: &Ground, grid: &Grid<'_>, door: &DoorRecord, radius_m: f64) -> Vec<u32> {
    let indoors = |cell: usize| {
        let space = u32::from(grid.space[cell]).checked_sub(1);
        door.spaces == [NONE; 2] || space.is_some_and(|space| door.spaces.contains(&space))
    };
    let tenths = f64::from(TENTHS_PER_M);
    let [x_m, y_m] = door.passage.centre.map(|c| c / tenths);
    let half_m = door.passage.half[0].max(door.passage.half[1]) / tenths;
    let near = cells_around(ground, Point2::new(x_m, y_m), half_m + radius_m + DOOR_REACH_M);
    let mut parts: Vec<u32> = near.filter(|(_, cell)| indoors(*cell)).map(|(_, cell)| ground.part(cell)).collect();
    parts.sort_unstable();
    parts.dedup();
    parts
}

/// What is told of the parts of all storeys, storey by storey, from large to small.
pub(crate) fn floor_parts(
    input: &PlanInput<'_>,
    grounds: &[&Ground],
    reached: &Reached,
    facts: &[Vec<PartFacts>],
) -> Vec<FloorPartRecord> {
    let mut told = Vec::new();
    for (storey, ground) in grounds.iter().enumerate() {
        let cell_m2 = ground.spec.resolution_m().powi(2);
        let mut middles = vec![0; ground.n_parts() as usize + 1];
        for cell in (0..ground.spec.n_cells()).rev() {
            let middle = &mut middles[ground.part(cell) as usize];
            // Of equals the lowest cell.
            if ground.part(cell) != ground.part(*middle) || ground.clearance_of(cell) >= ground.clearance_of(*middle) {
                *middle = cell;
            }
        }
        let record = |part: u32| {
            let facts = facts[storey][part as usize];
            let at = ground.middle(middles[part as usize]);
            FloorPartRecord {
                area_m2: f64::from(ground.size(part)) * cell_m2,
                room_m2: f64::from(facts.room_cells) * cell_m2,
                at_m: [at.x_m, at.y_m],
                map_storey: input.grids[storey].head.map_storey,
                is_reached: u32::from(reached.parts[storey][part as usize]),
                has_way_in: u32::from(facts.has_way_in),
                reserved: 0,
            }
        };
        let mut parts: Vec<FloorPartRecord> = (1..=ground.n_parts()).map(record).collect();
        parts.retain(|p| p.area_m2 >= FloorPartRecord::LEAST_M2);
        parts.sort_by(|a, b| b.area_m2.total_cmp(&a.area_m2));
        told.extend(parts);
    }
    told
}
