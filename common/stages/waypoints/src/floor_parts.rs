//! Parts of a storey's free space: room area, access from outside, and the default part of a robot without a start.

use crate::free_space::FreeSpace;
use crate::input::MissionPlanInput;
use crate::portal::Portal;
use crate::reachability::Reachability;
use crate::start_pose::cells_around;
use frames::{Point2, TENTHS_PER_M};
use messages::{AttributeKind, DoorRecord, FloorPartRecord, Grid, NONE, Site, space_flags};

/// Properties of a part by which the default part is chosen.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct PartProperties {
    /// Number of its cells; only those of indoor rooms where the storey has rooms.
    pub(crate) room_cells: u32,
    /// True if a stair, ramp, lift or outer door leads to it.
    pub(crate) has_way_in: bool,
    /// True if an outer door leads to it.
    pub(crate) has_outer_door: bool,
}

/// A part with access is preferred if it has at least this share of the largest room area of a part, so that a lift landing
/// is not preferred.
const MIN_ROOM_SHARE: f64 = 0.1;

/// Distance from the passage of an outer door, beyond the robot's radius, within which it gives access to a part.
const DOOR_REACH_M: f64 = 0.5;

/// Properties of each part of a storey, beginning with the unreachable part 0.
pub(crate) fn part_properties(
    input: &MissionPlanInput<'_>,
    storey: usize,
    grid: &Grid<'_>,
    free_space: &FreeSpace,
    portals: &[Portal],
) -> Vec<PartProperties> {
    let site = input.site;
    let mut properties = vec![PartProperties::default(); free_space.n_parts() as usize + 1];
    // By the number of a space in a grid; 0 is none.
    let of_spaces = site.spaces.iter().map(|s| !s.has(space_flags::EXTERNAL) && !s.has(space_flags::METADATA_ONLY));
    let is_room: Vec<bool> = std::iter::once(false).chain(of_spaces).collect();
    let has_rooms = grid.space.iter().any(|&space| is_room[usize::from(space)]);
    let in_room = |space: &&u16| !has_rooms || is_room[usize::from(**space)];
    for run in free_space.runs() {
        properties[run.part as usize].room_cells += grid.space[run.cells()].iter().filter(in_room).count() as u32;
    }
    for end in portals.iter().flat_map(|p| p.ends).filter(|end| end.storey == storey) {
        properties[end.part as usize].has_way_in = true;
    }
    for passage in input.passages(grid) {
        let door = &site.doors[passage.door as usize];
        if is_outer(site, door, passage.sides_with_floor) {
            for part in parts_at(free_space, grid, door, input.index.head.robot.radius_m) {
                properties[part as usize].has_way_in = true;
                properties[part as usize].has_outer_door = true;
            }
        }
    }
    properties
}

/// The default part of a storey: of those with access the one with the largest room area, unless that is small compared with
/// another part; 0 if there is none. Of equals the larger one, then the lower number.
pub(crate) fn first_part(free_space: &FreeSpace, properties: &[PartProperties]) -> u32 {
    let max_cells = properties.iter().map(|f| f.room_cells).max().unwrap_or(0);
    let is_preferred = |f: &PartProperties| {
        f.has_way_in && f.room_cells > 0 && f64::from(f.room_cells) >= MIN_ROOM_SHARE * f64::from(max_cells)
    };
    let rank = |&part: &u32| {
        let f = &properties[part as usize];
        (is_preferred(f), f.room_cells, free_space.size(part), std::cmp::Reverse(part))
    };
    (1..=free_space.n_parts()).max_by_key(rank).unwrap_or(0)
}

/// True for an outer door: by its property, or because it connects a room with the outdoors; in a model without rooms, if it
/// has floor on one side only.
fn is_outer(site: &Site<'_>, door: &DoorRecord, sides_with_floor: u32) -> bool {
    let element = &site.elements[door.element as usize];
    let property = site.element_attributes(element).iter().find(|a| {
        a.kind == AttributeKind::Boolean && (site.text(a.set), site.text(a.name)) == ("Pset_DoorCommon", "IsExternal")
    });
    if let Some(property) = property {
        return property.number == 1.0;
    }
    let is_outdoors = |space: u32| space == NONE || site.spaces[space as usize].has(space_flags::EXTERNAL);
    match door.spaces.map(is_outdoors) {
        [true, true] => site.spaces.is_empty() && sides_with_floor == 1,
        [a, b] => a != b,
    }
}

/// The parts beside a door; only those in its rooms where it has rooms.
pub(crate) fn parts_at(free_space: &FreeSpace, grid: &Grid<'_>, door: &DoorRecord, radius_m: f64) -> Vec<u32> {
    let indoors = |cell: usize| {
        let space = u32::from(grid.space[cell]).checked_sub(1);
        door.spaces == [NONE; 2] || space.is_some_and(|space| door.spaces.contains(&space))
    };
    let tenths = f64::from(TENTHS_PER_M);
    let [x_m, y_m] = door.passage.centre.map(|c| c / tenths);
    let half_m = door.passage.half[0].max(door.passage.half[1]) / tenths;
    let near = cells_around(free_space, Point2::new(x_m, y_m), half_m + radius_m + DOOR_REACH_M);
    let mut parts: Vec<u32> = near.filter(|(_, cell)| indoors(*cell)).map(|(_, cell)| free_space.part(cell)).collect();
    parts.sort_unstable();
    parts.dedup();
    parts
}

/// Records of the parts of all storeys, storey by storey, by decreasing size.
pub(crate) fn floor_parts(
    input: &MissionPlanInput<'_>,
    free_spaces: &[&FreeSpace],
    reached: &Reachability,
    properties: &[Vec<PartProperties>],
) -> Vec<FloorPartRecord> {
    let mut records = Vec::new();
    for (storey, free_space) in free_spaces.iter().enumerate() {
        let cell_m2 = free_space.spec.resolution_m().powi(2);
        let mut middles = vec![0; free_space.n_parts() as usize + 1];
        let mut farthest = vec![0; middles.len()];
        for run in free_space.runs() {
            let part = run.part as usize;
            for cell in run.cells() {
                // Of equals the cell with the lowest index.
                let squared = free_space.squared_clearance(cell);
                if squared > farthest[part] {
                    (farthest[part], middles[part]) = (squared, cell);
                }
            }
        }
        let record = |part: u32| {
            let properties = properties[storey][part as usize];
            let at = free_space.middle(middles[part as usize]);
            FloorPartRecord {
                area_m2: f64::from(free_space.size(part)) * cell_m2,
                room_m2: f64::from(properties.room_cells) * cell_m2,
                at_m: at.coordinates_m(),
                map_storey: input.grids.head(storey).map_storey,
                is_reached: u32::from(reached.parts[storey][part as usize]),
                has_way_in: u32::from(properties.has_way_in),
                reserved: 0,
            }
        };
        let mut parts: Vec<FloorPartRecord> = (1..=free_space.n_parts()).map(record).collect();
        parts.retain(|p| p.area_m2 >= FloorPartRecord::MIN_AREA_M2);
        parts.sort_by(|a, b| b.area_m2.total_cmp(&a.area_m2));
        records.extend(parts);
    }
    records
}
