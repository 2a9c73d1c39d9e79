//! Centre waypoint of a space: the place nearest to the centroid of its floor at which the robot can stand.

use crate::barriers::Obstacle;
use crate::free_space::FreeSpace;
use crate::spaces::{Refusal, behind, closed_door};
use frames::{Map, Point2, TENTHS_PER_M};
use grid::{Class, LineOfSight};
use messages::{DoorPassageRecord, Grid, NoWaypoint, RobotProfile, ScheduleState, Site};
use std::collections::BTreeSet;

/// The centre of a space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SpaceCentre {
    pub(crate) at: Point2<Map>,
    /// Distance to the middle of the nearest cell that is not free.
    pub(crate) clearance_m: f64,
}

/// Inputs of planning a storey.
#[derive(Clone, Copy)]
pub(crate) struct StoreyInputs<'a> {
    pub(crate) site: &'a Site<'a>,
    pub(crate) schedule_state: &'a ScheduleState<'a>,
    pub(crate) grid: &'a Grid<'a>,
    pub(crate) free_space: &'a FreeSpace,
    /// Lines of sight over free cells.
    pub(crate) sight: &'a LineOfSight,
    pub(crate) robot: &'a RobotProfile,
    /// Doors of the storey.
    pub(crate) passages: &'a [DoorPassageRecord],
    /// Whether each part of the free space is reachable; part 0 never is.
    pub(crate) reached: &'a [bool],
    /// What keeps the robot from each part that it does not get to.
    pub(crate) barriers: &'a [Vec<Obstacle>],
}

impl StoreyInputs<'_> {
    /// True if the cell is reachable.
    pub(crate) fn is_reached(&self, cell: usize) -> bool {
        self.reached[self.free_space.part(cell) as usize]
    }

    /// True if the robot may stop in the cell for a scan: it is reachable, and not on a stair on which the robot drives.
    pub(crate) fn can_scan_from(&self, cell: usize) -> bool {
        self.is_reached(cell) && self.grid.class_of(cell) != Class::Stair
    }

    /// The space whose polygon contains a point.
    pub(crate) fn space_at(&self, at: Point2<Map>) -> Option<usize> {
        let cell = self.free_space.spec.cell_at(at)?;
        let space = usize::from(self.grid.space[self.free_space.spec.index(cell)]).checked_sub(1)?;
        let polygon = self.site.floor_polygon(&self.site.spaces[space]);
        polygon.contains(at.coordinates_m().map(|c| c * f64::from(TENTHS_PER_M))).then_some(space)
    }

    /// True if the robot can stand at a point of a reachable part.
    fn can_stand(&self, p: Point2<Map>) -> bool {
        cells_at(self.grid, self.free_space, self.robot, p).into_iter().any(|cell| self.is_reached(cell))
    }
}

/// The cells of the free space from which the robot gets to a point at which it can stand, clear by its radius and not keep-out: its
/// own cell and those beside it, because a point between the middles of cells may be clear although the middle of its own cell is
/// not.
pub(crate) fn cells_at(grid: &Grid<'_>, free_space: &FreeSpace, robot: &RobotProfile, p: Point2<Map>) -> Vec<usize> {
    let spec = &free_space.spec;
    let Some(cell) = spec.cell_at(p) else { return Vec::new() };
    if grid.is_keepout(spec.index(cell)) || free_space.clearance_m(p) < robot.radius_m {
        return Vec::new();
    }
    let around = |at: u32, n: u32| at.saturating_sub(1)..(at + 2).min(n);
    let (rows, columns) = (around(cell.row, spec.height), around(cell.column, spec.width));
    let cells = rows.flat_map(|row| columns.clone().map(move |column| spec.index(grid::Cell { column, row })));
    cells.filter(|cell| free_space.part(*cell) != 0).collect()
}

/// The cells of each space of a storey.
pub(crate) struct SpaceCells {
    /// Ascending within a space.
    cells: Vec<u32>,
    /// First cell of each space, by its number plus 1; 0 is outside of spaces and has none.
    first: Vec<u32>,
}

impl SpaceCells {
    pub(crate) fn of(grid: &Grid<'_>, n_spaces: usize) -> Self {
        let mut first = vec![0u32; n_spaces + 2];
        let owned = || {
            let runs = grid.space.chunk_by(|a, b| a == b).scan(0u32, |end, run| {
                let begin = std::mem::replace(end, *end + run.len() as u32);
                Some((usize::from(run[0]), begin..*end))
            });
            runs.filter(|(space, _)| *space != 0)
        };
        owned().for_each(|(space, run)| first[space + 1] += run.len() as u32);
        for k in 1..first.len() {
            first[k] += first[k - 1];
        }
        let (mut next, mut cells) = (first.clone(), vec![0; first[n_spaces + 1] as usize]);
        for (space, run) in owned() {
            let at = &mut next[space];
            let end = *at + run.len() as u32;
            cells[*at as usize..end as usize].iter_mut().zip(run).for_each(|(to, cell)| *to = cell);
            *at = end;
        }
        Self { cells, first }
    }

    fn of_space(&self, space: usize) -> impl Iterator<Item = usize> {
        let [first, end] = [self.first[space + 1], self.first[space + 2]];
        self.cells[first as usize..end as usize].iter().map(|&cell| cell as usize)
    }
}

/// The centre of a space: the centroid of its floor, or the nearest place where the robot can stand.
pub(crate) fn centre_of(storey: &StoreyInputs<'_>, cells: &SpaceCells, space: usize) -> Result<SpaceCentre, Refusal> {
    let StoreyInputs { site, grid, free_space, robot, .. } = *storey;
    let record = &site.spaces[space];
    let polygon = site.floor_polygon(record);
    let inside = |p: Point2<Map>| polygon.contains(p.coordinates_m().map(|c| c * f64::from(TENTHS_PER_M)));
    let centroid = Point2::<Map>::new(record.centroid_m[0], record.centroid_m[1]);
    let at_centroid = || SpaceCentre { at: centroid, clearance_m: free_space.clearance_m(centroid) };
    let is_at_centroid = inside(centroid) && storey.can_stand(centroid);
    if is_at_centroid && !free_space.is_kept_off_at(centroid) {
        return Ok(at_centroid());
    }
    let cells = || cells.of_space(space);
    let far = |p: Point2<Map>| p.distance_m(&centroid);
    // Off the distances that the robot keeps before within them; nearest first; of equally near cells the lower row, then the lower
    // column.
    let off = |cell: usize| (free_space.is_kept_off(cell), far(free_space.middle(cell)));
    let mut nearest: Option<((bool, f64), usize)> = None;
    for cell in cells().filter(|&cell| storey.is_reached(cell)) {
        let off = off(cell);
        // Whether it is inside is asked last: that takes longest.
        if nearest.is_none_or(|(nearest, _)| off < nearest) && inside(free_space.middle(cell)) {
            nearest = Some((off, cell));
        }
    }
    if is_at_centroid && nearest.is_none_or(|((is_kept_off, _), _)| is_kept_off) {
        return Ok(at_centroid());
    }
    if let Some((_, cell)) = nearest {
        return Ok(SpaceCentre { at: free_space.middle(cell), clearance_m: free_space.clearance_of(cell) });
    }
    let mut parts = BTreeSet::new();
    for cell in cells() {
        let part = free_space.part(cell);
        if part != 0 && !parts.contains(&part) && inside(free_space.middle(cell)) {
            parts.insert(part);
        }
    }
    Err(if parts.is_empty() { no_place(site, grid, robot, space, cells) } else { not_reached(storey, &parts, space) })
}

/// Why the robot cannot stand anywhere in a space of these cells, none of which is in the free space.
pub(crate) fn no_place<C: Iterator<Item = usize>>(
    site: &Site<'_>,
    grid: &Grid<'_>,
    robot: &RobotProfile,
    space: usize,
    cells: impl Fn() -> C,
) -> Refusal {
    let has = |fits: &dyn Fn(usize) -> bool| cells().any(fits);
    if has(&|i| grid.planning[i] == 0 && !grid.is_keepout(i)) {
        Refusal::new(NoWaypoint::TooNarrow, format!("it has no free place of {} m around", robot.radius_m))
    } else if has(&|i| grid.planning[i] == 0) {
        Refusal::new(NoWaypoint::Keepout, "all of it is keep-out")
    } else if has(&|i| grid.floor[i] != 0) {
        Refusal::new(NoWaypoint::TooNarrow, "what stands in it leaves no free place")
    } else if let Some(other) = other_space_over(site, grid, space) {
        let id = site.text(site.spaces[other].global_id);
        Refusal::new(NoWaypoint::Shared, format!("its floor is that of the space {id}, which lies over it"))
    } else {
        Refusal::new(NoWaypoint::NoFloor, "it has no floor at the level of its map storey")
    }
}

/// Why no way leads to the parts of the free space in a space: what keeps the robot from that with the fewest obstacles.
fn not_reached(storey: &StoreyInputs<'_>, parts: &BTreeSet<u32>, space: usize) -> Refusal {
    let StoreyInputs { site, schedule_state, robot, .. } = *storey;
    let obstacles = parts.iter().map(|&part| storey.barriers[part as usize].as_slice());
    let fewest = obstacles.filter(|obstacles| !obstacles.is_empty()).min_by_key(|obstacles| obstacles.len());
    fewest
        .and_then(|obstacles| behind(site, schedule_state, robot, obstacles, space))
        .or_else(|| closed_door(site, robot, storey.passages, space))
        .unwrap_or_else(|| Refusal::new(NoWaypoint::Unreachable, "no way leads there from where the robot is"))
}

/// Another space that owns cells inside the polygon of this one: each cell belongs to one space only.
fn other_space_over(site: &Site<'_>, grid: &Grid<'_>, space: usize) -> Option<usize> {
    let (polygon, spec) = (site.floor_polygon(&site.spaces[space]), grid.spec());
    let bounds = polygon.bounds()?;
    // The polygon and the grid are in the same units; casts to a cell outside of the grid end at its border.
    let range = |k: usize, n: u32| {
        let cell = |tenths: i32| tenths.div_euclid(spec.cell_tenths).saturating_sub(spec.first_cell[k]).max(0) as u32;
        cell(bounds.min[k])..cell(bounds.max[k]).saturating_add(1).min(n)
    };
    let columns = range(0, spec.width);
    let cells = range(1, spec.height).flat_map(|row| columns.clone().map(move |column| grid::Cell { column, row }));
    let mut others = cells.filter_map(|cell| {
        let other = usize::from(grid.space[spec.index(cell)]).checked_sub(1).filter(|other| *other != space)?;
        polygon.contains(spec.centre_of(cell).coordinates_m().map(|c| c * f64::from(TENTHS_PER_M))).then_some(other)
    });
    others.next()
}
