//! Where in a space a robot can stand.

use crate::reach::Reach;
use frames::{Map, Point2, TENTHS_PER_M};
use grid::{Cell, GridSpec, squared_distances};
use messages::{Grid, Site};

/// A place in a space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Centre {
    pub(crate) x_m: f64,
    pub(crate) y_m: f64,
    /// Distance to the nearest cell that is not free.
    pub(crate) clearance_m: f64,
}

/// How far every cell of a grid is from what is not free.
pub(crate) struct Clearance {
    spec: GridSpec,
    not_free: Vec<bool>,
    squared: Vec<u32>,
}

impl Clearance {
    pub(crate) fn of(grid: &Grid<'_>) -> Self {
        let not_free: Vec<bool> = grid.planning.iter().map(|&p| p != 0).collect();
        let squared = squared_distances(&not_free, grid.head.width as usize);
        Self { spec: grid.spec(), not_free, squared }
    }

    /// Distance in metres from a point to the centre of the nearest cell that is not free, as costmaps measure it; 0 on
    /// such a cell and outside the grid.
    fn at(&self, p: Point2<Map>) -> f64 {
        let Some(cell) = self.spec.cell_at(p) else { return 0.0 };
        let index = self.spec.index(cell);
        if self.not_free[index] {
            return 0.0;
        }
        // The nearest cell of a point is at most a diagonal farther than that of its own cell's centre.
        let reach = f64::from(self.squared[index]).sqrt().min(f64::from(self.spec.width.max(self.spec.height))) + 1.5;
        let range = |at: u32, n: u32| {
            let reach = reach.ceil() as u32;
            at.saturating_sub(reach)..(at + reach + 1).min(n)
        };
        let mut nearest = f64::INFINITY;
        for row in range(cell.row, self.spec.height) {
            for column in range(cell.column, self.spec.width) {
                let other = Cell { column, row };
                if self.not_free[self.spec.index(other)] {
                    let c = self.spec.centre_of(other);
                    nearest = nearest.min(libm::hypot(p.x_m - c.x_m, p.y_m - c.y_m));
                }
            }
        }
        nearest
    }

    /// The same for a cell's centre.
    pub(crate) fn at_cell(&self, index: usize) -> f64 {
        f64::from(self.squared[index]).sqrt() * self.spec.resolution_m()
    }
}

/// The centre of a space, or why it has none.
pub(crate) fn centre_of(
    site: &Site<'_>,
    grid: &Grid<'_>,
    clearance: &Clearance,
    reach: &Reach,
    space: usize,
    radius_m: f64,
) -> Result<Centre, String> {
    let spec = grid.spec();
    let record = &site.spaces[space];
    let polygon = site.floor_polygon(record);
    let inside = |p: Point2<Map>| polygon.contains([p.x_m, p.y_m].map(|c| c * f64::from(TENTHS_PER_M)));
    let centroid = Point2::<Map>::new(record.centroid_m[0], record.centroid_m[1]);
    let at_centroid = clearance.at(centroid);
    let is_reached = spec.cell_at(centroid).is_some_and(|cell| reach.is_beside(&spec, cell));
    if inside(centroid) && at_centroid >= radius_m && is_reached {
        return Ok(Centre { x_m: centroid.x_m, y_m: centroid.y_m, clearance_m: at_centroid });
    }
    let own = space as u16 + 1;
    let cells = || grid.space.iter().enumerate().filter(|(_, s)| **s == own).map(|(index, _)| index);
    let centre = |index: usize| spec.centre_of(spec.cell_of(index));
    let far = |p: Point2<Map>| libm::hypot(p.x_m - centroid.x_m, p.y_m - centroid.y_m);
    let clear = cells().filter(|&i| reach.contains(i) && inside(centre(i)));
    // Nearest first; of equally near cells the lower row, then the lower column.
    let nearest = clear.min_by(|&a, &b| far(centre(a)).total_cmp(&far(centre(b))).then(a.cmp(&b)));
    if let Some(index) = nearest {
        let p = centre(index);
        return Ok(Centre { x_m: p.x_m, y_m: p.y_m, clearance_m: clearance.at_cell(index) });
    }
    Err(if cells().any(|index| reach.can_stand(index) && inside(centre(index))) {
        "no way leads there from the largest part of the storey".to_owned()
    } else if cells().any(|index| grid.planning[index] == 0 && grid.keepout[index] == 0) {
        format!("it has no free place of {radius_m} m around")
    } else if cells().any(|index| grid.planning[index] == 0) {
        "all of it is keep-out".to_owned()
    } else {
        "it has no floor at the level of its map storey".to_owned()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::{ArchiveBuffer, GridHead, GridWriter, RingRecord, SiteBuilder, SpaceRecord};

    /// A space with this floor polygon (decimetres) on a grid of 0.1 m, on which `free` says where a robot can be.
    fn find(corners: &[[i32; 2]], centroid_m: [f64; 2], free: impl Fn(u32, u32) -> bool) -> Result<Centre, String> {
        let mut builder = SiteBuilder::default();
        builder.points.extend(corners.iter().map(|c| c.map(|v| v * 1_000)));
        builder.rings.push(RingRecord { first_point: 0, n_points: corners.len() as u32 });
        builder.spaces.push(SpaceRecord {
            n_rings: 1,
            centroid_m,
            map_storey: messages::NONE,
            storey: messages::NONE,
            ..bytemuck::Zeroable::zeroed()
        });
        let site = builder.finish();
        let site = Site::open(site.bytes()).unwrap();
        let head = GridHead { cell_tenths: 1_000, width: 40, height: 30, ..bytemuck::Zeroable::zeroed() };
        let mut buffer = ArchiveBuffer::zeroed(GridWriter::len_of(1_200));
        let mut writer = GridWriter::new(buffer.bytes_mut(), &head);
        let layers = writer.layers();
        layers.space.fill(1);
        for (index, planning) in layers.planning.iter_mut().enumerate() {
            let cell = head.spec().cell_of(index);
            *planning = if free(cell.column, cell.row) { 0 } else { 100 };
        }
        writer.seal();
        let grid = Grid::open(buffer.bytes()).unwrap();
        let clearance = Clearance::of(&grid);
        centre_of(&site, &grid, &clearance, &Reach::of(&grid, &clearance, 0.3), 0, 0.3)
    }

    const ROOM: [[i32; 2]; 4] = [[0, 0], [40, 0], [40, 30], [0, 30]];

    #[test]
    fn a_centroid_that_is_inside_and_clear_stays_to_the_last_digit() {
        let found = find(&ROOM, [2.0123, 1.5321], |c, _| c > 3).unwrap();
        assert_eq!((found.x_m, found.y_m), (2.0123, 1.5321));
        assert!((found.clearance_m - 1.6625).abs() < 1e-3, "to the centre of the nearest cell: {}", found.clearance_m);
    }

    #[test]
    fn a_blocked_centroid_moves_to_the_nearest_clear_place() {
        // A column of 0.4 m at the middle.
        let found = find(&ROOM, [2.0, 1.5], |c, r| !((18..22).contains(&c) && (13..17).contains(&r))).unwrap();
        assert!(found.clearance_m >= 0.3);
        assert!(libm::hypot(found.x_m - 2.0, found.y_m - 1.5) < 0.6, "{found:?}");
    }

    #[test]
    fn the_centre_of_an_l_is_inside_the_l() {
        let l = [[0, 0], [40, 0], [40, 8], [8, 8], [8, 30], [0, 30]];
        let found = find(&l, [1.4, 1.1], |_, _| true).unwrap();
        assert!(found.x_m < 0.8 || found.y_m < 0.8, "{found:?}");
    }

    #[test]
    fn a_space_too_narrow_for_the_robot_has_a_reason() {
        assert!(find(&ROOM, [2.0, 1.5], |c, _| c % 3 != 0).unwrap_err().contains("no free place"));
        assert!(find(&ROOM, [2.0, 1.5], |_, _| false).unwrap_err().contains("no floor"));
    }

    #[test]
    fn the_smaller_of_two_parts_is_not_reached() {
        // A wall across the room, the robot's part on the right.
        let found = find(&ROOM, [0.8, 1.5], |c, _| c != 15).unwrap();
        assert!(found.x_m > 1.6, "{found:?}");
        let left = [[0, 0], [14, 0], [14, 30], [0, 30]];
        assert!(find(&left, [0.7, 1.5], |c, _| c != 15).unwrap_err().contains("no way leads there"));
    }
}
