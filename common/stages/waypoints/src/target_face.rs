//! Target faces: the sides of occupied cells that scans are to see, found in the class and planning layers of a grid.

use grid::Class;
use messages::Grid;
use std::ops::Range;

/// A side of an occupied cell towards a free cell. Positions and lengths are in cells.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct TargetFace {
    /// Middle of the side, a thousandth of a cell in front of it.
    pub(crate) middle: [f64; 2],
    /// Unit normal of the surface of the cell, estimated in a window of 5 x 5 cells.
    pub(crate) normal: [f64; 2],
    /// Direction of the side.
    pub(crate) side: [i8; 2],
    /// The free cell in front.
    pub(crate) front: u32,
    /// Space of the free cell plus 1; 0 for none.
    pub(crate) space: u16,
}

/// All target faces of a storey, in tiles.
#[derive(Debug, Default)]
pub(crate) struct TargetFaces {
    pub(crate) all: Vec<TargetFace>,
    /// First face of each tile, row-major, and the number of faces.
    first: Vec<u32>,
    tiles_wide: usize,
}

/// A tile with faces.
#[derive(Debug, Clone)]
pub(crate) struct FaceTile {
    /// Their indices.
    pub(crate) faces: Range<u32>,
    /// Corners around the middles of the faces, in cells.
    pub(crate) low: [f64; 2],
    pub(crate) high: [f64; 2],
}

/// Side of a tile in cells.
const TILE: usize = 16;

/// Offset of the middle of a face in front of the side, in cells.
const IN_FRONT: f64 = 1e-3;

const SIDES: [[i8; 2]; 4] = [[1, 0], [-1, 0], [0, 1], [0, -1]];

impl TargetFaces {
    /// The target faces of a grid, between cells occupied by elements and free cells. `wanted` tells for an occupied and a
    /// free cell whether the face between them is a target.
    pub(crate) fn of(grid: &Grid<'_>, wanted: impl Fn(usize, usize) -> bool) -> Self {
        let (width, height) = (grid.head.width as usize, grid.head.height as usize);
        let tiles_wide = width.div_ceil(TILE);
        let n_tiles = tiles_wide * height.div_ceil(TILE);
        let mut found: Vec<(u32, TargetFace)> = Vec::new();
        for row in 1..height.saturating_sub(1) {
            let line = row * width;
            for cell in line + 1..(line + width).saturating_sub(1) {
                if grid.planning[cell] != 100 || grid.class[cell] == Class::None.id() {
                    continue;
                }
                for side in SIDES {
                    let front = beside(cell, side, width);
                    if grid.planning[front] == 0 && wanted(cell, front) {
                        let tile = row / TILE * tiles_wide + (cell - line) / TILE;
                        found.push((tile as u32, face(grid, cell, front, side)));
                    }
                }
            }
        }
        // A stable sort keeps the order of cells within a tile.
        found.sort_by_key(|(tile, _)| *tile);
        let (tiles, all): (Vec<u32>, Vec<TargetFace>) = found.into_iter().unzip();
        Self { all, first: firsts(tiles, n_tiles), tiles_wide }
    }

    /// The faces that are not marked.
    pub(crate) fn without(&self, marked: &[bool]) -> Self {
        let tiles = self.first.windows(2).zip(0u32..).flat_map(|(ends, tile)| (ends[0]..ends[1]).map(move |_| tile));
        let rest: Vec<(u32, u32)> = tiles.zip(0..).filter(|(_, face)| !marked[*face as usize]).collect();
        let (tiles, numbers): (Vec<u32>, Vec<u32>) = rest.into_iter().unzip();
        let all = numbers.iter().map(|&face| self.all[face as usize]).collect();
        Self { all, first: firsts(tiles, self.first.len() - 1), tiles_wide: self.tiles_wide }
    }

    /// The tiles with faces within `range` cells of a point, in the order of their faces.
    pub(crate) fn near(&self, at: [f64; 2], range: f64) -> impl Iterator<Item = FaceTile> {
        let n_rows = self.first.len().saturating_sub(1).checked_div(self.tiles_wide).unwrap_or(0);
        let tiles = move |at: f64, n: usize| {
            let tile = |c: f64| (c.max(0.0) as usize / TILE).min(n);
            tile(at - range)..(tile(at + range) + 1).min(n)
        };
        let columns = tiles(at[0], self.tiles_wide);
        let all = tiles(at[1], n_rows).flat_map(move |row| columns.clone().map(move |column| (row, column)));
        all.filter_map(move |(row, column)| {
            let tile = row * self.tiles_wide + column;
            let low = [column, row].map(|k| (k * TILE) as f64 - 2.0 * IN_FRONT);
            let faces = self.first[tile]..self.first[tile + 1];
            (!faces.is_empty()).then(|| FaceTile { faces, low, high: low.map(|c| c + TILE as f64 + 4.0 * IN_FRONT) })
        })
    }
}

/// Index of the first face of each tile, from the sorted tiles of all faces.
fn firsts(tiles: Vec<u32>, n_tiles: usize) -> Vec<u32> {
    let mut first = vec![0u32; n_tiles + 1];
    tiles.into_iter().for_each(|tile| first[tile as usize + 1] += 1);
    for k in 1..first.len() {
        first[k] += first[k - 1];
    }
    first
}

fn beside(cell: usize, side: [i8; 2], width: usize) -> usize {
    cell.wrapping_add_signed(isize::from(side[0]) + isize::from(side[1]) * width as isize)
}

fn face(grid: &Grid<'_>, cell: usize, front: usize, side: [i8; 2]) -> TargetFace {
    let width = grid.head.width as usize;
    let [dx, dy] = side.map(f64::from);
    let out = 0.5 + IN_FRONT;
    let middle = [(cell % width) as f64 + 0.5 + out * dx, (cell / width) as f64 + 0.5 + out * dy];
    TargetFace { middle, normal: normal(grid, front, side), side, front: front as u32, space: grid.space[front] }
}

/// Side and middle index of the 5 x 5 window around the free cell, stored as bits of a word.
const N: i32 = 5;
const MIDDLE: i32 = 12;

/// Unit vector away from the occupied cells of the face's surface in the 5 x 5 window around the free cell: those
/// 8-connected with the cell of the face. Cells on the other side of a thin wall are not connected in the window.
fn normal(grid: &Grid<'_>, front: usize, side: [i8; 2]) -> [f64; 2] {
    let (width, height) = (grid.head.width as i32, grid.head.height as i32);
    let (column, row) = (front as i32 % width, front as i32 / width);
    let mut occupied = 0u32;
    for k in 0..N * N {
        let (x, y) = (column + k % N - 2, row + k / N - 2);
        if 0 <= x && x < width && 0 <= y && y < height && grid.planning[(y * width + x) as usize] == 100 {
            occupied |= 1 << k;
        }
    }
    let mut surface = 1u32 << (MIDDLE - i32::from(side[0]) - i32::from(side[1]) * N);
    loop {
        let grown = spread(surface) & occupied;
        if grown == surface {
            break;
        }
        surface = grown;
    }
    let (mut x, mut y) = (0, 0);
    for k in (0..N * N).filter(|k| surface & (1 << k) != 0) {
        (x, y) = (x - (k % N - 2), y - (k / N - 2));
    }
    let length = f64::from(x * x + y * y).sqrt();
    if length == 0.0 { side.map(f64::from) } else { [f64::from(x) / length, f64::from(y) / length] }
}

/// Dilates a window by one cell, corners included.
fn spread(cells: u32) -> u32 {
    const ALL: u32 = (1 << 25) - 1;
    const NOT_FIRST: u32 = 0b11110_11110_11110_11110_11110;
    const NOT_LAST: u32 = 0b01111_01111_01111_01111_01111;
    let row = cells | (cells & NOT_LAST) << 1 | (cells & NOT_FIRST) >> 1;
    (row | row << N | row >> N) & ALL
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::free_space::tests::drawn;

    fn faces(text: &str) -> TargetFaces {
        TargetFaces::of(&Grid::open(drawn(text).bytes()).unwrap(), |_, _| true)
    }

    /// Degrees between the normals of the faces and a direction, the largest.
    fn off_degrees(faces: &[&TargetFace], direction: [f64; 2]) -> f64 {
        let length = libm::hypot(direction[0], direction[1]);
        let cos = |f: &&TargetFace| (f.normal[0] * direction[0] + f.normal[1] * direction[1]) / length;
        faces.iter().map(|f| libm::acos(cos(f).clamp(-1.0, 1.0)).to_degrees()).fold(0.0, f64::max)
    }

    /// A room of this size with walls of a cell around it, and a frame of nothing.
    fn room(rows: &[&str]) -> String {
        let line = |row: &str| format!(" #{row}# ");
        let (blank, wall) = (" ".repeat(rows[0].len() + 4), line(&"#".repeat(rows[0].len())));
        let inner = rows.iter().map(|r| line(r));
        [blank.clone(), wall.clone()].into_iter().chain(inner).chain([wall, blank]).collect::<Vec<_>>().join("\n")
    }

    #[test]
    fn every_side_between_wall_and_floor_is_a_face_a_little_in_front_of_it() {
        let faces = faces(&room(&["..", ".."]));
        assert_eq!(faces.all.len(), 8);
        for face in &faces.all {
            let inward = [3.0 - face.middle[0], 3.0 - face.middle[1]];
            assert!(inward[0] * f64::from(face.side[0]) + inward[1] * f64::from(face.side[1]) > 0.9);
            let border = |c: f64| [2.001, 3.999].iter().any(|b| (c - b).abs() < 1e-9);
            assert!(border(face.middle[0]) || border(face.middle[1]), "{face:?}");
        }
    }

    #[test]
    fn only_what_is_wanted_is_a_face_and_unknown_cells_have_none() {
        let text = room(&["a.", " ."]);
        assert_eq!(faces(&text).all.len(), 6, "none before the unknown cell");
        let buffer = drawn(&text);
        let grid = Grid::open(buffer.bytes()).unwrap();
        let of_space = TargetFaces::of(&grid, |_, front| grid.space[front] == 1);
        assert_eq!(of_space.all.iter().map(|f| f.space).collect::<Vec<_>>(), [1, 1]);
    }

    #[test]
    fn normals_of_a_straight_wall_look_straight_away_from_it() {
        let faces = faces(&room(&["..........", "..........", "..........", "..........", "..........", ".........."]));
        // Far from the corners, where two walls are in the window.
        let low: Vec<&TargetFace> =
            faces.all.iter().filter(|f| f.side == [0, 1] && (5.0..9.0).contains(&f.middle[0])).collect();
        assert_eq!(low.len(), 4);
        assert_eq!(off_degrees(&low, [0.0, 1.0]), 0.0);
    }

    #[test]
    fn normals_of_a_wall_at_45_degrees_are_within_20_degrees() {
        let row = |k: usize| format!("{}{}", "#".repeat(k), ".".repeat(24 - k));
        let rows: Vec<String> = (0..20).map(row).collect();
        let faces = faces(&room(&rows.iter().map(String::as_str).collect::<Vec<_>>()));
        // Floor lies above the stairs of cells, to the right.
        let is_slope = |f: &&TargetFace| {
            let off = f.middle[0] + f.middle[1] - 22.0;
            (4.0..17.0).contains(&f.middle[0]) && (5.0..18.0).contains(&f.middle[1]) && off.abs() < 2.0
        };
        let slope: Vec<&TargetFace> = faces.all.iter().filter(is_slope).collect();
        assert!(slope.len() > 20, "{}", slope.len());
        let off = off_degrees(&slope, [1.0, 1.0]);
        assert!(off <= 20.0, "{off} degrees");
    }

    #[test]
    fn a_thin_wall_has_two_sides() {
        let faces = faces(&room(&["..........", "..........", "..........", "##########", "..........", ".........."]));
        for (side, middle_y) in [([0i8, 1i8], 5.001), ([0, -1], 3.999)] {
            let own = |f: &&TargetFace| f.side == side && (f.middle[1] - middle_y).abs() < 1e-9;
            let inner: Vec<&TargetFace> =
                faces.all.iter().filter(own).filter(|f| (5.0..9.0).contains(&f.middle[0])).collect();
            assert_eq!((inner.len(), off_degrees(&inner, [0.0, f64::from(side[1])])), (4, 0.0));
        }
    }

    #[test]
    fn a_pillar_of_one_cell_has_four_faces_that_look_outward() {
        let faces = faces(&room(&[".......", ".......", ".......", "...#...", ".......", ".......", "......."]));
        let pillar: Vec<&TargetFace> =
            faces.all.iter().filter(|f| f.middle.iter().all(|c| (4.5..6.5).contains(c))).collect();
        assert_eq!(pillar.len(), 4);
        pillar.iter().for_each(|f| assert_eq!(f.normal, f.side.map(f64::from)));
    }

    #[test]
    fn faces_near_a_place_are_in_order_and_none_in_range_is_missing() {
        let row = |k: usize| if k % 7 == 3 { "...#......".repeat(7) } else { ".".repeat(70) };
        let rows: Vec<String> = (0..50).map(row).collect();
        let faces = faces(&room(&rows.iter().map(String::as_str).collect::<Vec<_>>()));
        let some: Vec<bool> = (0..faces.all.len()).map(|k| k % 3 == 0).collect();
        let rest = faces.without(&some);
        assert!(rest.all.len() == some.iter().filter(|s| !**s).count());
        for (list, at) in [(&faces, [20.5, 30.5]), (&faces, [2.5, 2.5]), (&rest, [70.5, 51.5])] {
            let near: Vec<u32> = list.near(at, 9.0).flat_map(|tile| tile.faces).collect();
            assert!(near.is_sorted());
            for (k, face) in list.all.iter().enumerate() {
                let far = libm::hypot(face.middle[0] - at[0], face.middle[1] - at[1]);
                assert!(far > 9.0 || near.contains(&(k as u32)), "{face:?} from {at:?}");
            }
            for tile in list.near(at, 9.0) {
                let is_within = |c: f64, k: usize| tile.low[k] < c && c < tile.high[k];
                let faces = tile.faces.clone().map(|k| list.all[k as usize]);
                assert!(faces.into_iter().all(|face| (0..2).all(|k| is_within(face.middle[k], k))), "{tile:?}");
            }
            assert!(near.len() < list.all.len(), "tiles far away are not looked at");
        }
    }
}
