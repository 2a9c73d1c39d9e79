//! Divides a SLAM map into parts: connected free cells within squares, each with the wall points that face it. Parts are linked
//! where free cells lead from one to the other, as the robot went that drew them.

use crate::features::Features;
use crate::wall_points::WallPoint;
use occupancy::{Cell, Raster};
use petgraph::unionfind::UnionFind;
use std::collections::BTreeMap;

/// Side of the squares, in cells: 3 m, within which a map hardly bends.
const SIDE_CELLS: usize = 60;
/// Fewer free cells are noise beyond a wall.
const MIN_CELLS: usize = 24;
/// Fewer neighbouring cells on the border of two squares are no way.
const MIN_WAY_CELLS: usize = 3;
/// Where the part of a wall point is looked for: before it, in metres.
const BEFORE_WALL_M: [f64; 4] = [0.08, 0.13, 0.18, 0.25];
/// Pieces of a map to which no free cells lead are linked up to this distance, in metres, and known less well: by this factor.
const MAX_BRIDGE_M: f64 = 8.0;
const BRIDGE_FACTOR: f64 = 2.0;

/// The cells of no part.
const NO_PART: u32 = u32::MAX;

/// A part of a SLAM map.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct MapPart {
    /// Mean of its free cells.
    pub(crate) centre: [f64; 2],
    /// Number of its free cells.
    pub(crate) n_cells: usize,
    /// The walls that face it.
    pub(crate) wall_points: Vec<WallPoint>,
}

/// A way between two parts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PartLink {
    pub(crate) to: usize,
    /// Between both centres.
    pub(crate) length_m: f64,
}

/// All parts of a SLAM map.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct MapParts {
    pub(crate) parts: Vec<MapPart>,
    /// The ways from each part.
    pub(crate) links: Vec<Vec<PartLink>>,
    of_cell: Vec<u32>,
}

impl MapParts {
    pub(crate) fn of(slam: &Features) -> Self {
        let raster = &slam.raster;
        let (of_cell, mut parts) = labelled(raster);
        for wall_point in slam.wall_points() {
            let before = BEFORE_WALL_M.iter().find_map(|before_m| {
                let place = [0, 1].map(|k| wall_point.at[k] + before_m * wall_point.normal[k]);
                raster.index_at(place).map(|index| of_cell[index]).filter(|part| *part != NO_PART)
            });
            if let Some(part) = before {
                parts[part as usize].wall_points.push(*wall_point);
            }
        }
        let links = linked(&parts, raster.width, &of_cell);
        Self { parts, links, of_cell }
    }

    /// The part of a cell; `None` for cells that are not free, and for noise.
    pub(crate) fn of_cell(&self, index: usize) -> Option<usize> {
        Some(self.of_cell[index]).filter(|part| *part != NO_PART).map(|part| part as usize)
    }
}

/// The part of each cell, and all parts without their walls.
fn labelled(raster: &Raster) -> (Vec<u32>, Vec<MapPart>) {
    let mut of_cell = vec![NO_PART; raster.cells.len()];
    let mut is_done = vec![false; raster.cells.len()];
    let mut parts = Vec::new();
    for start in 0..raster.cells.len() {
        if is_done[start] || raster.cells[start] != Cell::Free {
            continue;
        }
        let members = connected(raster, start, &mut is_done);
        if members.len() < MIN_CELLS {
            continue;
        }
        let number = parts.len() as u32;
        members.iter().for_each(|&index| of_cell[index] = number);
        let mean = |k: usize| members.iter().map(|&index| raster.middle(index)[k]).sum::<f64>() / members.len() as f64;
        parts.push(MapPart { centre: [mean(0), mean(1)], n_cells: members.len(), wall_points: Vec::new() });
    }
    (of_cell, parts)
}

/// The free cells that are connected with one within its square.
fn connected(raster: &Raster, start: usize, is_done: &mut [bool]) -> Vec<usize> {
    let (width, height) = (raster.width, raster.height);
    let square = |index: usize| [index % width / SIDE_CELLS, index / width / SIDE_CELLS];
    let home = square(start);
    let mut members = vec![start];
    is_done[start] = true;
    let mut next = 0;
    while next < members.len() {
        let index = members[next];
        next += 1;
        let (column, row) = (index % width, index / width);
        let left = (column > 0).then(|| index - 1);
        let right = (column + 1 < width).then(|| index + 1);
        let below = (row > 0).then(|| index - width);
        let above = (row + 1 < height).then(|| index + width);
        for beside in [left, right, below, above].into_iter().flatten() {
            if !is_done[beside] && raster.cells[beside] == Cell::Free && square(beside) == home {
                is_done[beside] = true;
                members.push(beside);
            }
        }
    }
    members
}

/// Links between parts that share a border, and the shortest between pieces of the map that share none.
fn linked(parts: &[MapPart], width: usize, of_cell: &[u32]) -> Vec<Vec<PartLink>> {
    let mut borders: BTreeMap<[u32; 2], usize> = BTreeMap::new();
    for (index, &part) in of_cell.iter().enumerate() {
        let right = (index % width + 1 < width).then(|| of_cell[index + 1]);
        for other in right.into_iter().chain(of_cell.get(index + width).copied()) {
            if part != other && part != NO_PART && other != NO_PART {
                *borders.entry([part.min(other), part.max(other)]).or_default() += 1;
            }
        }
    }
    let between_m = |[a, b]: [usize; 2]| distance_m(parts[a].centre, parts[b].centre);
    let mut links = vec![Vec::new(); parts.len()];
    let mut link = |[a, b]: [usize; 2], length_m: f64| {
        links[a].push(PartLink { to: b, length_m });
        links[b].push(PartLink { to: a, length_m });
    };
    let mut pieces = UnionFind::<usize>::new(parts.len());
    for (pair, _) in borders.into_iter().filter(|(_, n_cells)| *n_cells >= MIN_WAY_CELLS) {
        let pair = pair.map(|part| part as usize);
        pieces.union(pair[0], pair[1]);
        link(pair, between_m(pair));
    }
    // What was seen through glass, or beyond a passage that is not free cell by cell.
    let pairs = (0..parts.len()).flat_map(|a| (0..a).map(move |b| [b, a]));
    let mut bridges: Vec<([usize; 2], f64)> = pairs
        .filter(|[a, b]| !pieces.equiv(*a, *b))
        .map(|pair| (pair, between_m(pair)))
        .filter(|(_, length_m)| *length_m < MAX_BRIDGE_M)
        .collect();
    bridges.sort_by(|a, b| a.1.total_cmp(&b.1));
    for ([a, b], length_m) in bridges {
        if pieces.union(a, b) {
            link([a, b], BRIDGE_FACTOR * length_m);
        }
    }
    links
}

fn distance_m(a: [f64; 2], b: [f64; 2]) -> f64 {
    libm::hypot(a[0] - b[0], a[1] - b[1])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wall_points::Surfaces;
    use occupancy::CELL_M;

    /// Two rooms of 2.5 m beside each other with a wall between them, `door` cells of which are free.
    fn rooms(door: std::ops::Range<usize>) -> MapParts {
        let (width, height) = (120, 60);
        let cell = |k: usize| {
            let [x, y] = [k % width, k / width];
            let is_wall =
                !(5..115).contains(&x) || !(5..55).contains(&y) || ((58..62).contains(&x) && !door.contains(&y));
            if is_wall { Cell::Occupied } else { Cell::Free }
        };
        let cells: Vec<Cell> = (0..width * height).map(cell).collect();
        MapParts::of(&Features::of(Raster::of(&cells, width, CELL_M), Surfaces { depth_m: 0.025, are_whole: false }))
    }

    #[test]
    fn parts_are_linked_where_free_cells_lead_from_one_to_the_other() {
        let open = rooms(20..40);
        assert_eq!(open.parts.len(), 2);
        assert_eq!(open.links[0].iter().map(|link| link.to).collect::<Vec<_>>(), [1]);
        let direct_m = distance_m(open.parts[0].centre, open.parts[1].centre);
        assert!((open.links[0][0].length_m - direct_m).abs() < 1e-12);
    }

    #[test]
    fn rooms_without_a_way_are_linked_as_what_is_known_less_well() {
        let closed = rooms(0..0);
        let direct_m = distance_m(closed.parts[0].centre, closed.parts[1].centre);
        assert!((closed.links[1][0].length_m - BRIDGE_FACTOR * direct_m).abs() < 1e-12);
    }

    #[test]
    fn a_wall_belongs_to_the_room_that_it_faces() {
        for (part, sign) in rooms(20..40).parts.iter().zip([-1.0, 1.0]) {
            assert!(part.wall_points.len() > 100);
            let middle_m = 60.0 * CELL_M;
            assert!(part.wall_points.iter().all(|w| (w.at[0] - middle_m) * sign > -0.15), "of the other room");
        }
    }
}
