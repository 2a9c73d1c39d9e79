//! Reachable floor per storey, and spaces that are on no map storey.

use crate::input::ExportInput;
use crate::manifest::status_of;
use crate::text::rounded;
use messages::{FloorPartRecord, Grid, MissionPlan, NONE, space_flags};
use schemars::JsonSchema;
use serde::Serialize;

/// How much of a storey's floor the robot gets to.
///
/// What is counted is floor on which the middle of the robot can be: free, off keep-out, and as far from what is not free as its
/// radius, indoors and outdoors.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct FloorReach {
    /// Floor on which the middle of the robot can be, whether it gets there or not.
    pub standing_m2: f64,
    /// That of it to which the robot gets.
    pub reached_m2: f64,
    /// Connected parts of it from 0.1 m2, from large to small.
    pub parts: Vec<FloorPart>,
}

/// A connected part of a storey's floor.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct FloorPart {
    /// Its area.
    pub area_m2: f64,
    /// That of it which lies in indoor rooms; all of it on a storey without any.
    pub room_m2: f64,
    /// The place in it that is farthest from what is not free, in `map`.
    pub at_m: [f64; 2],
    /// True if the robot gets to it.
    pub reached: bool,
    /// True if a stair, ramp, lift or outer door leads to it.
    pub has_way_in: bool,
}

impl FloorReach {
    /// Of a map storey.
    pub fn of(mission_plan: &MissionPlan<'_>, map_storey: u32) -> Self {
        let part = |p: &FloorPartRecord| FloorPart {
            area_m2: rounded(p.area_m2),
            room_m2: rounded(p.room_m2),
            at_m: p.at_m.map(rounded),
            reached: p.is_reached == 1,
            has_way_in: p.has_way_in == 1,
        };
        let storey = mission_plan.storeys.iter().find(|s| s.map_storey == map_storey);
        let (reached_m2, unreached_m2) = storey.map_or((0.0, 0.0), |s| (s.reached_m2, s.unreached_m2));
        Self {
            standing_m2: rounded(reached_m2 + unreached_m2),
            reached_m2: rounded(reached_m2),
            parts: mission_plan.floor_parts.iter().filter(|p| p.map_storey == map_storey).map(part).collect(),
        }
    }

    /// `31 of 156 m2 reached, 5 parts`, if the robot does not get to all parts.
    pub fn text(&self) -> Option<String> {
        let missing_m2 = self.standing_m2 - self.reached_m2;
        self.parts.iter().any(|p| !p.reached).then(|| {
            // Areas that round to the same number would seem to be reached.
            let decimals = usize::from(missing_m2 < 1.0 || self.standing_m2 < 10.0);
            let parts = diagnostics::counted(self.parts.len(), "part");
            let Self { standing_m2: standing, reached_m2: reached, .. } = self;
            format!("{reached:.decimals$} of {standing:.decimals$} m2 reached, {parts}")
        })
    }
}

/// A room that is on no map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RoomNotMapped {
    /// The space.
    pub space: u32,
    /// Why not.
    pub reason: NotMapped,
}

/// Why a room is on no map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NotMapped {
    /// No map storey is at the height of its floor.
    NoLevel,
    /// It is a lift shaft, a riser or a pit.
    Shaft,
    /// There is a map storey, and no floor under the room.
    NoFloor,
}

impl NotMapped {
    /// The reason as a sentence about the room.
    pub fn text(self) -> &'static str {
        match self {
            Self::NoLevel => "its floor is on no map storey",
            Self::Shaft => "it is a lift shaft, a riser or a pit, where nobody walks",
            Self::NoFloor => "there is no floor (slab, covering) under it at the level of its map storey",
        }
    }
}

/// A room has floor if as much of its cells are floor.
const MIN_FLOOR_SHARE: f64 = 0.02;

/// Rooms with a body that are on no map, from large to small: no gross areas, nothing outdoors. Of storeys that are not
/// written, or have no floor anywhere yet, there is no report.
pub fn spaces_not_mapped(input: &ExportInput<'_>) -> Vec<RoomNotMapped> {
    let site = input.site;
    let mut without_floor = vec![false; site.spaces.len()];
    for cells in input.grids.each(|grid| (status_of(grid) == "ok").then(|| cells_of_spaces(grid, site.spaces.len()))) {
        for (space, [all, floor]) in cells.into_iter().flatten().enumerate().filter(|(_, [all, _])| *all > 0) {
            without_floor[space] = f64::from(floor) < f64::from(all) * MIN_FLOOR_SHARE;
        }
    }
    let room = |space: usize| {
        let record = &site.spaces[space];
        let is_room =
            record.n_rings > 0 && !record.has(space_flags::METADATA_ONLY) && !record.has(space_flags::EXTERNAL);
        let reason = match (record.map_storey == NONE, without_floor[space]) {
            (true, _) if record.has(space_flags::SHAFT) => NotMapped::Shaft,
            (true, _) => NotMapped::NoLevel,
            (false, true) => NotMapped::NoFloor,
            (false, false) => return None,
        };
        is_room.then_some(RoomNotMapped { space: space as u32, reason })
    };
    let mut rooms: Vec<RoomNotMapped> = (0..site.spaces.len()).filter_map(room).collect();
    let area_m2 = |room: &RoomNotMapped| site.spaces[room.space as usize].area_m2;
    rooms.sort_by(|a, b| area_m2(b).total_cmp(&area_m2(a)).then(a.space.cmp(&b.space)));
    rooms
}

/// Of each space, its cells, and those of them that are floor.
fn cells_of_spaces(grid: &Grid<'_>, n_spaces: usize) -> Vec<[u32; 2]> {
    let mut cells = vec![[0u32; 2]; n_spaces];
    let mut floors = grid.floor;
    for run in grid.space.chunk_by(|a, b| a == b) {
        let floors = floors.split_off(..run.len()).unwrap_or_default();
        if let Some(counts) = usize::from(run[0]).checked_sub(1).and_then(|k| cells.get_mut(k)) {
            counts[0] += run.len() as u32;
            counts[1] += floors.iter().map(|floor| u32::from(*floor != 0)).sum::<u32>();
        }
    }
    cells
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reach(standing_m2: f64, parts: &[(f64, bool)]) -> FloorReach {
        let part = |&(area_m2, reached): &(f64, bool)| FloorPart {
            area_m2,
            room_m2: area_m2,
            at_m: [0.0; 2],
            reached,
            has_way_in: false,
        };
        let reached_m2 = rounded(parts.iter().filter(|p| p.1).map(|p| p.0).sum());
        FloorReach { standing_m2, reached_m2, parts: parts.iter().map(part).collect() }
    }

    #[test]
    fn the_line_tells_what_is_reached_of_what_and_in_how_many_parts() {
        let text = |standing_m2, parts: &[(f64, bool)]| reach(standing_m2, parts).text().unwrap_or_default();
        assert_eq!(
            text(156.2, &[(60.0, false), (50.0, false), (31.0, true), (10.0, false), (5.2, false)]),
            "31 of 156 m2 reached, 5 parts"
        );
        assert_eq!(text(100.0, &[(99.8, true), (0.2, false)]), "99.8 of 100.0 m2 reached, 2 parts");
        assert_eq!(text(4.0, &[(4.0, false)]), "0.0 of 4.0 m2 reached, 1 part");
        assert_eq!(text(31.0, &[(31.0, true)]), "", "all of it is reached");
        assert_eq!(text(31.05, &[(31.0, true)]), "", "but for a place to stand");
        assert_eq!(text(0.0, &[]), "");
    }
}
