//! Places at which the robot can stand at an end of a way.

use super::way::{NoPlace, WayEnd};
use crate::free_space::FreeSpace;
use crate::input::MissionPlanInput;
use crate::options::Start;
use crate::portal::{Portal, Staging};
use crate::reachability::Reachability;
use crate::space_centre::{cells_at, no_place};
use crate::spaces::{Refusal, refused};
use crate::start_pose::{place_blocked, start_cell};
use frames::{Point2, TENTHS_PER_M};
use messages::NoWaypoint;
use std::collections::BTreeMap;

/// The places at an end: of a point one, of a space one in each part of the floor, in the order of their shares of the space.
///
/// # Errors
/// Why there is none.
pub(super) fn places_at(
    input: &MissionPlanInput<'_>,
    free_spaces: &[&FreeSpace],
    end: WayEnd,
) -> Result<Vec<Staging>, NoPlace> {
    let storey_of = |map_storey: u32| input.grids.heads().position(|head| head.map_storey == map_storey);
    let not_mapped = || NoPlace { why: NoWaypoint::NotMapped, reason: "its map storey has no map".to_owned() };
    match end {
        WayEnd::Space(space) => {
            if let Some(refusal) = refused(input.site, input.schedule_state, input.options, space).filter(keeps_out) {
                return Err(refusal.into());
            }
            let storey = storey_of(input.site.spaces[space].map_storey).ok_or_else(not_mapped)?;
            places_in(input, storey, free_spaces[storey], space)
        }
        WayEnd::Point { map_storey, at } => {
            let storey = storey_of(map_storey).ok_or_else(not_mapped)?;
            let start = Start { storey: storey as u32, x_m: at.x_m(), y_m: at.y_m() };
            match start_cell(free_spaces, start) {
                Some((storey, cell)) => Ok(vec![Staging { storey, cell, part: free_spaces[storey].part(cell) }]),
                None => {
                    let free_space = free_spaces[storey];
                    let reason = input.grids.with(storey, |grid| place_blocked(input.site, grid, free_space, start));
                    Err(NoPlace { why: NoWaypoint::Unreachable, reason })
                }
            }
        }
    }
}

/// Spaces outdoors and such as close soon have no waypoint; a way may begin or end there.
fn keeps_out(refusal: &Refusal) -> bool {
    !matches!(refusal.why, NoWaypoint::External | NoWaypoint::Closing | NoWaypoint::NotAsked)
}

impl From<Refusal> for NoPlace {
    fn from(refusal: Refusal) -> Self {
        Self { why: refusal.why, reason: refusal.reason }
    }
}

/// The places in a space: its centroid if the robot can stand there, as for its waypoint, then in each part of the free space the cell
/// nearest to that, of equals the lower one.
fn places_in(
    input: &MissionPlanInput<'_>,
    storey: usize,
    free_space: &FreeSpace,
    space: usize,
) -> Result<Vec<Staging>, NoPlace> {
    let [x_m, y_m] = input.site.spaces[space].centroid_m;
    let centroid = Point2::new(x_m, y_m);
    input.grids.with(storey, |grid| {
        let number = space + 1;
        let is_in = |cell: &usize| usize::from(grid.space[*cell]) == number;
        // By part: number of cells, and the nearest.
        let mut parts: BTreeMap<u32, (u32, usize)> = BTreeMap::new();
        let far_m = |cell: usize| free_space.middle(cell).distance_m(&centroid);
        for cell in free_space.cells().filter(is_in) {
            let (n_cells, nearest) = parts.entry(free_space.part(cell)).or_insert((0, cell));
            *n_cells += 1;
            if far_m(cell) < far_m(*nearest) {
                *nearest = cell;
            }
        }
        let polygon = input.site.floor_polygon(&input.site.spaces[space]);
        let is_inside = polygon.contains(centroid.coordinates_m().map(|c| c * f64::from(TENTHS_PER_M)));
        // Where rooms overlap it may lie in a cell of another one.
        let at_centroid =
            cells_at(grid, free_space, &input.index.head.robot, centroid).into_iter().filter(|_| is_inside);
        let at_centroid = at_centroid.min_by(|a, b| far_m(*a).total_cmp(&far_m(*b)).then(a.cmp(b)));
        if parts.is_empty() && at_centroid.is_none() {
            let cells = || (0..grid.space.len()).filter(is_in);
            return Err(no_place(input.site, grid, &input.index.head.robot, space, cells).into());
        }
        let mut places: Vec<(u32, Staging)> =
            parts.into_iter().map(|(part, (n_cells, cell))| (n_cells, Staging { storey, cell, part })).collect();
        places.sort_by_key(|(n_cells, place)| (std::cmp::Reverse(*n_cells), place.part));
        let first = at_centroid.map(|cell| Staging { storey, cell, part: free_space.part(cell) });
        let others = places.into_iter().map(|(_, place)| place);
        let others = others.filter(|place| first.is_none_or(|first| first.part != place.part));
        Ok(first.into_iter().chain(others).collect())
    })
}

/// All parts that the robot gets to from a place.
pub(super) fn reached_from(free_spaces: &[&FreeSpace], portals: &[Portal], start: Staging) -> Reachability {
    let [x_m, y_m] = free_spaces[start.storey].middle(start.cell).coordinates_m();
    Reachability::of(free_spaces, portals, &[], Some(Start { storey: start.storey as u32, x_m, y_m }))
}
