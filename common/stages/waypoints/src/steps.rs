//! Steps between adjacent levels, as portals.

use crate::free_space::FreeSpace;
use crate::portal::{Portal, PortalKind, Staging, length_m, staging};
use frames::{Map, Point2, metres};
use grid::Cell;
use messages::{ElementState, Grid, MAX_RISER_M, MapGrids, NONE, RobotProfile, ScheduleState, Site, element_flags};

/// Maximum height of a step between two levels, in tenths of a millimetre.
const MAX_STEP_TENTHS: i32 = 6_000;

/// Maximum number of cells taken by the edge between the levels.
const EDGE_CELLS: i64 = 3;

/// Maximum distance in height between the floor of an element and its level, in tenths of a millimetre.
const LEVEL_TENTHS: i32 = 500;

/// The four neighbours of a cell.
const DIRECTIONS: [[i64; 2]; 4] = [[1, 0], [-1, 0], [0, 1], [0, -1]];

/// The steps between adjacent map storeys whose floors are at most 0.6 m apart in height: one for every stretch of the edge
/// that is at min_cells as wide as the robot.
pub(crate) fn steps(
    site: &Site<'_>,
    schedule_state: &ScheduleState<'_>,
    robot: &RobotProfile,
    grids: &dyn MapGrids,
    free_spaces: &[&FreeSpace],
) -> Vec<Portal> {
    let mut found = Vec::new();
    let mut from_below: Vec<usize> = site.levels().map(|(storey, _)| storey).collect();
    let z = |storey: usize| site.map_storeys[storey].floor_z_tenths;
    from_below.sort_by_key(|&storey| z(storey));
    for (at, &low) in from_below.iter().enumerate() {
        for &high in &from_below[at + 1..] {
            let rise_tenths = z(high) - z(low);
            if rise_tenths == 0 || rise_tenths > MAX_STEP_TENTHS {
                continue;
            }
            let rise_m = metres(rise_tenths);
            let usable = rise_m <= robot.step_height_m || robot.climbs_stairs == 1 && rise_m <= MAX_RISER_M;
            let pair = LevelPair { free_spaces, low, high };
            let mut ends = if rise_m <= robot.step_height_m { pair.shared() } else { Vec::new() };
            if ends.is_empty() {
                ends = grids.with(low, |below| grids.with(high, |above| pair.beside(robot, [below, above])));
            }
            for ends in ends {
                let element = floor_at(site, schedule_state, free_spaces[high].middle(ends[1].cell), z(high));
                let length_m = length_m(free_spaces, ends);
                found.push(Portal { element, kind: PortalKind::Step, ends, length_m, usable });
            }
        }
    }
    found
}

/// A built element with floor at a point and height, or [`NONE`].
fn floor_at(site: &Site<'_>, schedule_state: &ScheduleState<'_>, at: Point2<Map>, z: i32) -> usize {
    let is_there = |k: usize| {
        let element = &site.elements[k];
        let spans =
            |axis: usize, m: f64| metres(element.min_tenths[axis]) <= m && m <= metres(element.max_tenths[axis]);
        element.has(element_flags::FLOOR)
            && element.n_parts > 0
            && schedule_state.effective(k) == ElementState::Built
            && spans(0, at.x_m())
            && spans(1, at.y_m())
            && element.min_tenths[2] <= z + LEVEL_TENTHS
            && z - LEVEL_TENTHS <= element.max_tenths[2]
    };
    (0..site.elements.len()).find(|&k| is_there(k)).unwrap_or(NONE as usize)
}

/// Two adjacent levels.
struct LevelPair<'a> {
    free_spaces: &'a [&'a FreeSpace],
    low: usize,
    high: usize,
}

impl LevelPair<'_> {
    /// The cell of a level at a column and row counted from the frame's origin.
    fn cell(&self, storey: usize, [x, y]: [i64; 2]) -> Option<usize> {
        let spec = &self.free_spaces[storey].spec;
        let [column, row] = [x - i64::from(spec.first_cell[0]), y - i64::from(spec.first_cell[1])];
        let is_inside = 0 <= column && column < i64::from(spec.width) && 0 <= row && row < i64::from(spec.height);
        is_inside.then(|| spec.index(Cell { column: column as u32, row: row as u32 }))
    }

    /// Column and row of a cell of a level counted from the frame's origin.
    fn place(&self, storey: usize, cell: usize) -> [i64; 2] {
        let spec = &self.free_spaces[storey].spec;
        let at = spec.cell_of(cell);
        [i64::from(at.column) + i64::from(spec.first_cell[0]), i64::from(at.row) + i64::from(spec.first_cell[1])]
    }

    /// The cell of a level at a place, if it is free.
    fn free_cell(&self, storey: usize, grid: &Grid<'_>, place: [i64; 2]) -> Option<usize> {
        self.cell(storey, place).filter(|&cell| grid.planning[cell] == 0)
    }

    /// Places in the free space of both levels, where the height difference is within the robot's step height: one for every
    /// pair of parts.
    fn shared(&self) -> Vec<[Staging; 2]> {
        let mut found: Vec<[Staging; 2]> = Vec::new();
        let [low, high] = [self.low, self.high];
        for cell in self.free_spaces[high].cells() {
            let Some(below) = self.cell(low, self.place(high, cell)) else { continue };
            let ends = [(low, below), (high, cell)].map(|(storey, cell)| Staging {
                storey,
                cell,
                part: self.free_spaces[storey].part(cell),
            });
            let is_known = |known: &[Staging; 2]| (0..2).all(|k| known[k].part == ends[k].part);
            if ends[0].part != 0 && !found.iter().any(is_known) {
                found.push(ends);
            }
        }
        found
    }

    /// Staging poses on both sides of every stretch where free floor of one level adjoins that of the other; `grids` are
    /// those of the lower and the upper level.
    fn beside(&self, robot: &RobotProfile, grids: [&Grid<'_>; 2]) -> Vec<[Staging; 2]> {
        let mut contacts: Vec<([i64; 2], usize)> = Vec::new();
        let high = self.free_spaces[self.high];
        for cell in (0..high.spec.n_cells()).filter(|&cell| grids[1].planning[cell] == 0) {
            let place = self.place(self.high, cell);
            contacts.extend(DIRECTIONS.iter().find_map(|d| self.across(grids, place, *d)).map(|below| (place, below)));
        }
        let min_cells = (2.0 * robot.radius_m / high.spec.resolution_m()).ceil() as usize;
        let stretches = stretches(&contacts).into_iter().filter(|stretch| stretch.len() >= min_cells);
        stretches.filter_map(|stretch| self.stagings(robot, contacts[stretch[stretch.len() / 2]])).collect()
    }

    /// The first free cell of the lower level across the edge in a direction, if there is no obstacle between.
    fn across(&self, [below, above]: [&Grid<'_>; 2], place: [i64; 2], direction: [i64; 2]) -> Option<usize> {
        let ahead = |n: i64| [place[0] + n * direction[0], place[1] + n * direction[1]];
        if self.free_cell(self.high, above, ahead(1)).is_some() {
            return None;
        }
        for n in 1..=EDGE_CELLS {
            if let Some(cell) = self.free_cell(self.low, below, ahead(n)) {
                return Some(cell);
            }
            if self.cell(self.high, ahead(n)).is_none_or(|cell| above.planning[cell] > 0) {
                return None;
            }
        }
        None
    }

    fn stagings(&self, robot: &RobotProfile, (place, below): ([i64; 2], usize)) -> Option<[Staging; 2]> {
        let cell = self.cell(self.high, place)?;
        let staging = |storey: usize, cell: usize| {
            let free_space = self.free_spaces[storey];
            let (cell, part) = staging(free_space, robot, &[free_space.middle(cell)])?;
            Some(Staging { storey, cell, part })
        };
        Some([staging(self.low, below)?, staging(self.high, cell)?])
    }
}

/// Indices of the contacts of every connected stretch, in the order in which they are found from its first.
fn stretches(contacts: &[([i64; 2], usize)]) -> Vec<Vec<usize>> {
    let mut taken = vec![false; contacts.len()];
    // Sorted by row, then column, so that neighbours are found by binary search.
    let mut order: Vec<usize> = (0..contacts.len()).collect();
    let key = |k: usize| [contacts[k].0[1], contacts[k].0[0]];
    order.sort_by_key(|&k| key(k));
    let at =
        |place: [i64; 2]| order.binary_search_by_key(&[place[1], place[0]], |&k| key(k)).ok().map(|found| order[found]);
    let mut found = Vec::new();
    for &first in &order {
        if std::mem::replace(&mut taken[first], true) {
            continue;
        }
        let mut stretch = vec![first];
        let mut next = 0;
        while let Some(&here) = stretch.get(next) {
            next += 1;
            let [x, y] = contacts[here].0;
            for [dx, dy] in (-1..=1).flat_map(|dx| [-1, 0, 1].map(|dy| [dx, dy])) {
                if let Some(k) = at([x + dx, y + dy])
                    && !std::mem::replace(&mut taken[k], true)
                {
                    stretch.push(k);
                }
            }
        }
        found.push(stretch);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::free_space::tests::drawn_at;
    use bytemuck::Zeroable;
    use messages::{FloorKind, MapStoreyRecord, ScheduleStateBuilder, SiteBuilder};

    /// Kinds and use of the steps between two levels, drawn as text, the upper one so much higher.
    fn found(low: &str, high: &str, rise_tenths: i32, robot: RobotProfile) -> Vec<(PortalKind, bool, [u32; 2])> {
        let mut builder = SiteBuilder::default();
        let floor = FloorKind::Built.into();
        for floor_z_tenths in [rise_tenths, 0] {
            builder.map_storeys.push(MapStoreyRecord { floor_z_tenths, floor, ..Zeroable::zeroed() });
        }
        let site = builder.finish();
        let site = Site::open(site.bytes()).unwrap();
        let schedule_state = ScheduleStateBuilder::everything_built(site.content_hash(), 0, 0).finish();
        let schedule_state = ScheduleState::open(schedule_state.bytes()).unwrap();
        let buffers = [drawn_at(high, rise_tenths), drawn_at(low, 0)];
        let grids = buffers.each_ref().map(|b| Grid::open(b.bytes()).unwrap());
        let free_spaces = grids.each_ref().map(|g| FreeSpace::of(g, robot.radius_m));
        let steps = steps(&site, &schedule_state, &robot, &grids.as_slice(), &free_spaces.each_ref());
        steps.iter().map(|s| (s.kind, s.usable, s.ends.map(|e| e.storey as u32))).collect()
    }

    /// Five rows of a hall: the left half is floor of the lower level, the right half of the upper one, whose edge is a wall
    /// to the lower one.
    const LOW: &str = "##############\n#......#######\n#......#######\n#......#######\n#......#######\n##############";
    const HIGH: &str = "##############\n#      .......\n#      .......\n#      .......\n#      .......\n##############";

    fn robot(step_height_m: f64, climbs_stairs: u32) -> RobotProfile {
        RobotProfile { radius_m: 0.1, edge_margin_m: 0.0, step_height_m, climbs_stairs, ..RobotProfile::DEFAULT }
    }

    #[test]
    fn a_step_joins_levels_that_lie_beside_each_other_and_its_height_decides() {
        let of = |rise: i32, robot: RobotProfile| found(LOW, HIGH, rise, robot);
        assert_eq!(of(1_300, robot(0.05, 0)), [(PortalKind::Step, false, [1, 0])]);
        assert_eq!(of(1_300, robot(0.05, 1)), [(PortalKind::Step, true, [1, 0])], "a robot that climbs stairs");
        assert_eq!(of(1_300, robot(0.15, 0)), [(PortalKind::Step, true, [1, 0])]);
        assert_eq!(of(4_500, robot(0.05, 1)), [(PortalKind::Step, false, [1, 0])], "higher than a riser");
        assert_eq!(of(9_000, robot(0.05, 1)), [], "a wall");
    }

    #[test]
    fn a_railing_at_the_edge_and_a_gap_narrower_than_the_robot_are_no_step() {
        let railing = HIGH.replace("#      .", "#      #");
        assert_eq!(found(LOW, &railing, 1_300, robot(0.05, 0)), []);
        let wide = RobotProfile { radius_m: 0.25, ..robot(0.05, 0) };
        assert_eq!(found(LOW, HIGH, 1_300, wide), []);
    }

    #[test]
    fn where_a_step_is_nothing_to_a_robot_both_levels_are_one_floor() {
        let both = "##############\n#............#\n#............#\n#............#\n#............#\n##############";
        assert_eq!(found(both, both, 1_300, robot(0.15, 0)), [(PortalKind::Step, true, [1, 0])]);
    }
}
