//! Finds the map of a robot that drives between a storey and the ground outdoors, by what both maps show around it.
//!
//! Before doors and on terraces both maps show one place at one height; there the robot stays on the map that it is on. It is on the
//! ground once nothing within half a metre of it is floor of its storey, and on a storey once whatever is ground within half a metre of
//! it is floor of that storey at the same height. It has come there by driving: from a place that both maps showed a short while ago.

use frames::{Map, Point2, metres};
use grid::Cell;
use messages::{FloorKind, Grid};

/// A robot changes its map so far behind the place up to which both maps show one, in metres: it does not come and go in a doorway.
const BEYOND_M: f64 = 0.5;
/// The longest way of a robot between two looks, in metres.
const MAX_WAY_M: f64 = 3.0;

/// Follows a robot between storeys and the ground outdoors.
#[derive(Debug, Default)]
pub(crate) struct OutdoorFollower {
    /// The last place of the robot that the map of a storey and that of the ground both showed, and the storey.
    shared: Option<(usize, Point2<Map>)>,
}

impl OutdoorFollower {
    /// Takes where a robot is now that was on a storey, with the grids of all storeys: the storey that it has come to, if it is another
    /// one; `None` for a storey that is not among them. Heights are one that differ by `step_m` at most.
    pub(crate) fn update(
        &mut self,
        grids: &[Grid<'_>],
        storey: usize,
        robot: Point2<Map>,
        step_m: f64,
    ) -> Option<usize> {
        let ground = grids.iter().position(|grid| grid.head.floor == FloorKind::Ground)?;
        if storey >= grids.len() {
            return None;
        }
        let is_one = |a: f64, b: f64| (a - b).abs() <= step_m;
        let on_ground = floor_m(&grids[ground], robot);
        let is_on_both = |&level: &usize| {
            level != ground
                && on_ground
                    .is_some_and(|z_m| floor_m(&grids[level], robot).is_some_and(|level_m| is_one(z_m, level_m)))
        };
        let levels = if storey == ground { 0..grids.len() } else { storey..storey + 1 };
        let both = levels.clone().find(is_on_both);
        if let Some(level) = both {
            self.shared = Some((level, robot));
        }
        self.shared = self.shared.filter(|(level, at)| levels.contains(level) && at.distance_m(&robot) <= MAX_WAY_M);
        let (level, _) = self.shared?;
        if storey == ground {
            let is_of_level =
                |(at, z_m): (Point2<Map>, f64)| floor_m(&grids[level], at).is_some_and(|level_m| is_one(level_m, z_m));
            (both == Some(level) && floor_around(&grids[ground], robot).all(is_of_level)).then_some(level)
        } else {
            (on_ground.is_some() && floor_around(&grids[level], robot).next().is_none()).then_some(ground)
        }
    }
}

/// Height of the floor of a map at a place.
fn floor_m(grid: &Grid<'_>, at: Point2<Map>) -> Option<f64> {
    let spec = grid.spec();
    grid.height_tenths(spec.index(spec.cell_at(at)?)).map(metres)
}

/// The middles of the cells of a map with floor within [`BEYOND_M`] of a place, with its heights.
fn floor_around<'a>(grid: &'a Grid<'_>, place: Point2<Map>) -> impl Iterator<Item = (Point2<Map>, f64)> + 'a {
    let (spec, origin_m) = (grid.spec(), grid.spec().origin_m());
    let [rows, columns] = [1, 0].map(|axis| {
        let at = |off_m: f64| (place.coordinates_m()[axis] + off_m - origin_m[axis]) / spec.resolution_m();
        let n = if axis == 0 { spec.width } else { spec.height };
        at(-BEYOND_M).floor().clamp(0.0, f64::from(n)) as u32..at(BEYOND_M).ceil().clamp(0.0, f64::from(n)) as u32
    });
    let cells = rows.flat_map(move |row| columns.clone().map(move |column| Cell { column, row }));
    cells.filter_map(move |cell| {
        let middle = spec.centre_of(cell);
        let z_m = grid.height_tenths(spec.index(cell)).map(metres);
        z_m.filter(|_| middle.distance_m(&place) <= BEYOND_M).map(|z_m| (middle, z_m))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::{ArchiveBuffer, FLOOR_BUILT, GridHead, GridWriter};

    const CELL_TENTHS: i32 = 1_000;

    /// A map of 10 by 4 m whose floor reaches from one column to another, at a height.
    fn map(columns: [u32; 2], floor: FloorKind, floor_z_tenths: i32) -> ArchiveBuffer {
        let head = GridHead {
            cell_tenths: CELL_TENTHS,
            width: 100,
            height: 40,
            floor_z_tenths,
            floor: floor.into(),
            ..GridHead::EMPTY
        };
        let mut buffer = ArchiveBuffer::zeroed(GridWriter::len_of(head.spec().n_cells()));
        let mut writer = GridWriter::new(buffer.bytes_mut(), &head);
        let layers = writer.layers();
        for (cell, floor) in layers.floor.iter_mut().enumerate() {
            let column = cell as u32 % 100;
            *floor = if (columns[0]..columns[1]).contains(&column) { FLOOR_BUILT } else { 0 };
        }
        writer.seal();
        buffer
    }

    /// The storeys of a robot that drives along x and begins on one; 0 is a house up to x = 4 m, 1 another floor of it, 2 the yard from
    /// x = 2.5 m on.
    fn storeys(mut storey: usize, house_z_tenths: i32, way_m: &[f64]) -> Vec<usize> {
        let maps = [
            map([0, 40], FloorKind::Built, house_z_tenths),
            map([0, 40], FloorKind::Built, house_z_tenths + 30_000),
            map([25, 100], FloorKind::Ground, 0),
        ];
        let grids: Vec<Grid<'_>> = maps.iter().map(|map| Grid::open(map.bytes()).unwrap()).collect();
        let mut follower = OutdoorFollower::default();
        let look = |&x: &f64| {
            storey = follower.update(&grids, storey, Point2::new(x, 2.0), 0.05).unwrap_or(storey);
            storey
        };
        way_m.iter().map(look).collect()
    }

    #[test]
    fn a_robot_that_drives_out_of_a_house_is_on_the_ground_half_a_metre_behind_it_and_comes_back() {
        let way_m = [2.0, 3.0, 3.9, 4.2, 4.4, 4.6, 6.0];
        assert_eq!(storeys(0, 0, &way_m), [0, 0, 0, 0, 0, 2, 2]);
        let back_m = [6.0, 4.2, 3.9, 3.7, 3.4, 3.0, 2.0];
        assert_eq!(storeys(2, 0, &back_m), [2, 2, 2, 2, 0, 0, 0]);
        let there_and_back_m = [3.0, 4.2, 3.8, 4.3, 3.6];
        assert_eq!(storeys(0, 0, &there_and_back_m), [0; 5]);
    }

    #[test]
    fn a_storey_that_a_revision_took_away_is_left_to_others() {
        assert_eq!(storeys(3, 0, &[3.0, 4.6]), [3; 2]);
    }

    #[test]
    fn floor_at_another_height_is_no_way_out() {
        assert_eq!(storeys(0, 600, &[2.0, 3.0, 3.9, 4.6, 6.0]), [0; 5]);
        assert_eq!(storeys(1, 0, &[2.0, 3.0, 3.9, 4.6, 6.0]), [1; 5]);
        assert_eq!(storeys(2, 600, &[6.0, 4.6, 3.4, 2.6]), [2; 4]);
    }

    #[test]
    fn a_robot_that_was_not_seen_to_drive_out_is_where_it_was() {
        assert_eq!(storeys(0, 0, &[1.0, 6.0, 7.0]), [0; 3], "a jump of its pose");
        assert_eq!(storeys(0, 0, &[3.9, 7.5]), [0; 2]);
    }
}
