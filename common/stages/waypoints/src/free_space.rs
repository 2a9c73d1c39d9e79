//! Free space of a storey for a robot's radius, and its connected parts.

use frames::{Map, Point2, TENTHS_PER_M, metres};
use grid::{Cell, GridSpec, LineOfSight, SparseCells, SparseLayer, sparse_distances};
use messages::{ContentHash, FloorKind, Grid, GridHead};
use petgraph::unionfind::UnionFind;
use safety::SafetyLayer;
use std::collections::BTreeSet;
use std::ops::Range;

/// The free space of a storey for a robot of one radius.
///
/// A cell is in the free space if it is free, not keep-out, and farther than the radius from the middle of every cell that
/// is not free, as costmaps measure it. Connected cells (along sides) are one part.
pub(crate) struct FreeSpace {
    pub(crate) spec: GridSpec,
    /// Squared distance of each cell to the nearest one that is not free, in cells.
    squared: SparseLayer<u32>,
    /// Part of each cell, from 1; 0 outside of the free space.
    part: SparseLayer<u32>,
    /// The cells of the free space, row by row.
    runs: Vec<Run>,
    /// Number of cells of each part; 0 for part 0.
    sizes: Vec<u32>,
    /// Cells within distances that the robot keeps from elements, if it does.
    kept_off: Option<KeptOff>,
    /// Height of the floor, in tenths of a millimetre.
    floor_z_tenths: i32,
    /// Height and slope of each cell of a storey that is not level.
    relief: Option<SparseLayer<GroundOfCell>>,
}

/// Neighbouring cells of a row, as many as there are, in one part of the free space.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Run {
    first: u32,
    length: u32,
    /// The part.
    pub(crate) part: u32,
}

impl Run {
    /// The cells.
    pub(crate) fn cells(self) -> Range<usize> {
        self.first as usize..(self.first + self.length) as usize
    }
}

/// Height, and slope in thousandths of a radian, of the ground of a cell.
#[derive(Debug, Clone, Copy)]
struct GroundOfCell {
    z_tenths: i32,
    slope_mrad: u16,
}

/// Where the robot is not, unless no other place or way serves.
struct KeptOff {
    cells: SparseLayer<bool>,
    hash: ContentHash,
}

/// Cells of the largest map of the ground outdoors over which ways are planned: its free space takes 16 bytes a cell.
const MAX_CELLS_OUTDOORS: usize = 40_000_000;

/// True for a storey over which ways are planned: not for the ground outdoors where its map is very large.
pub(crate) fn is_planned(head: &GridHead) -> bool {
    head.floor != FloorKind::Ground || head.spec().n_cells() <= MAX_CELLS_OUTDOORS
}

impl FreeSpace {
    pub(crate) fn of(grid: &Grid<'_>, radius_m: f64) -> Self {
        let spec = grid.spec();
        let is_planned = is_planned(grid.head);
        let not_free: Vec<bool> = grid.planning.iter().map(|&p| p != 0 || !is_planned).collect();
        let squared = sparse_distances(&not_free, spec.width as usize);
        drop(not_free);
        // Minimum squared distance in cells, with a tolerance of a tenth of a millimetre.
        let needed = (radius_m * f64::from(TENTHS_PER_M) - 1.0) / f64::from(spec.cell_tenths);
        let needed = (needed.max(0.0) * needed.max(0.0)).ceil() as u32;
        let stands = |cell: usize, squared: u32| !grid.is_keepout(cell) && squared >= needed.max(1);
        let mut part = squared.map(0, |cell, squared| u32::from(stands(cell, squared)));
        let mut runs = runs_of(&part, spec.width as usize);
        let sizes = label(&mut runs, spec.width);
        runs.iter().filter(|run| run.part != 1).for_each(|run| part.fill(run.cells(), run.part));
        let relief = (is_planned && !grid.elevation.is_empty()).then(|| relief_of(grid, squared.cells()));
        Self { spec, squared, part, runs, sizes, kept_off: None, floor_z_tenths: grid.head.floor_z_tenths, relief }
    }

    /// Height of the ground of a cell, in tenths of a millimetre; that of the floor where none is known.
    pub(crate) fn z_tenths(&self, cell: usize) -> i32 {
        self.relief.as_ref().map_or(self.floor_z_tenths, |relief| relief[cell].z_tenths)
    }

    /// The same in metres, at a point.
    pub(crate) fn z_m(&self, p: Point2<Map>) -> f64 {
        let cell = self.spec.cell_at(p).map(|cell| self.spec.index(cell));
        metres(cell.map_or(self.floor_z_tenths, |cell| self.z_tenths(cell)))
    }

    /// Height of the ground at a point in metres, between the middles of the four cells around it: along a slope it stays the same.
    /// Where the robot's map has no free cell in one of these, the height of the point's own cell.
    pub(crate) fn z_between_m(&self, p: Point2<Map>) -> f64 {
        let [x, y] = self.in_cells(p).map(|at| at - 0.5);
        let (column, row) = (x.floor(), y.floor());
        let (along, up) = (x - column, y - row);
        let corner = |dx: f64, dy: f64| {
            let is_inside = |at: f64, n: u32| 0.0 <= at && at < f64::from(n);
            let (column, row) = (column + dx, row + dy);
            let is_inside = is_inside(column, self.spec.width) && is_inside(row, self.spec.height);
            let cell = is_inside.then(|| self.spec.index(Cell { column: column as u32, row: row as u32 }))?;
            self.is_free(cell).then(|| metres(self.z_tenths(cell)))
        };
        match [corner(0.0, 0.0), corner(1.0, 0.0), corner(0.0, 1.0), corner(1.0, 1.0)] {
            [Some(a), Some(b), Some(c), Some(d)] => {
                let [low, high] = [a + along * (b - a), c + along * (d - c)];
                low + up * (high - low)
            }
            _ => self.z_m(p),
        }
    }

    /// True for a cell that is free, whether or not the robot can stand on it.
    pub(crate) fn is_free(&self, cell: usize) -> bool {
        self.squared[cell] > 0
    }

    /// Slope of the ground of a cell.
    pub(crate) fn slope_rad(&self, cell: usize) -> f64 {
        self.relief.as_ref().map_or(0.0, |relief| f64::from(relief[cell].slope_mrad) / 1_000.0)
    }

    /// True for a storey whose floor is at one height.
    pub(crate) fn is_level(&self) -> bool {
        self.relief.is_none()
    }

    /// The same for a robot that keeps the distances of a layer.
    pub(crate) fn keeping_off(self, layer: Option<&SafetyLayer>) -> Self {
        let kept_off = layer.map(|layer| KeptOff {
            cells: self.squared.cells().layer_of(false, |cell| layer.is_within_distance(cell)),
            hash: layer.content_hash(),
        });
        Self { kept_off, ..self }
    }

    /// True for a cell within a distance that the robot keeps.
    pub(crate) fn is_kept_off(&self, cell: usize) -> bool {
        self.kept_off.as_ref().is_some_and(|kept_off| kept_off.cells[cell])
    }

    /// True for a point in such a cell.
    pub(crate) fn is_kept_off_at(&self, p: Point2<Map>) -> bool {
        self.spec.cell_at(p).is_some_and(|cell| self.is_kept_off(self.spec.index(cell)))
    }

    /// Hash of the layer of distances; none without one.
    pub(crate) fn kept_off_hash(&self) -> Option<ContentHash> {
        self.kept_off.as_ref().map(|kept_off| kept_off.hash)
    }

    /// Lines of sight over free cells. They are dense: whoever plans the storey makes and drops them.
    pub(crate) fn sight(&self) -> LineOfSight {
        LineOfSight::from_distances(&self.squared, self.spec.width as usize)
    }

    /// The cells of the free space, in their order.
    pub(crate) fn cells(&self) -> impl DoubleEndedIterator<Item = usize> {
        self.runs.iter().flat_map(|run| run.cells())
    }

    /// The same by runs of neighbouring cells.
    pub(crate) fn runs(&self) -> impl DoubleEndedIterator<Item = Run> + '_ {
        self.runs.iter().copied()
    }

    /// Part of a cell, from 1; 0 outside of the free space.
    pub(crate) fn part(&self, cell: usize) -> u32 {
        self.part[cell]
    }

    /// Number of parts, and number of the last part.
    pub(crate) fn n_parts(&self) -> u32 {
        self.sizes.len() as u32 - 1
    }

    /// Number of cells of a part.
    pub(crate) fn size(&self, part: u32) -> u32 {
        self.sizes[part as usize]
    }

    /// Distance in metres from a point to the middle of the nearest cell that is not free; 0 on such a cell and outside the
    /// grid.
    pub(crate) fn clearance_m(&self, p: Point2<Map>) -> f64 {
        let Some(at) = self.spec.cell_at(p) else { return 0.0 };
        let cell = self.spec.index(at);
        if self.squared[cell] == 0 || self.middle(cell) == p {
            return self.clearance_of(cell);
        }
        // The nearest such cell of the point is between these distances from the middle of its cell.
        let [min_squared, max_squared] =
            [f64::from(self.squared[cell]), (f64::from(self.squared[cell]).sqrt() + 1.5).powi(2)];
        let (column, row) = (i64::from(at.column), i64::from(at.row));
        let mut nearest = f64::INFINITY;
        let reach = (max_squared.sqrt() as i64).min(i64::from(self.spec.height));
        let resolution_m = self.spec.resolution_m();
        // From the row of the point outwards, until a row is farther away as a whole.
        for dy in (0..=reach).flat_map(|dy| [-dy, dy]) {
            if (dy.abs() - 1) as f64 * resolution_m > nearest {
                break;
            }
            let far = (dy * dy) as f64;
            let from = (min_squared - far).max(0.0).sqrt() as i64;
            let to = (max_squared - far).max(0.0).sqrt() as i64;
            for side in [1, -1] {
                // To the first cell of the row that is not free, each time over those that are free around the cell before.
                let mut dx = from;
                while dx <= to && (dx - 1) as f64 * resolution_m <= nearest {
                    let [x, y] = [column + side * dx, row + dy];
                    if !(0..i64::from(self.spec.width)).contains(&x) || !(0..i64::from(self.spec.height)).contains(&y) {
                        break;
                    }
                    let other = Cell { column: x as u32, row: y as u32 };
                    let squared = self.squared[self.spec.index(other)];
                    if squared == 0 {
                        nearest = nearest.min(p.distance_m(&self.spec.centre_of(other)));
                        break;
                    }
                    dx += f64::from(squared).sqrt().ceil() as i64;
                }
            }
        }
        nearest
    }

    /// Squared distance from the middle of a cell to that of the nearest cell that is not free, in cells.
    pub(crate) fn squared_clearance(&self, cell: usize) -> u32 {
        self.squared[cell]
    }

    /// The same distance in metres.
    pub(crate) fn clearance_of(&self, cell: usize) -> f64 {
        f64::from(self.squared[cell]).sqrt() * self.spec.resolution_m()
    }

    /// The middle of a cell.
    pub(crate) fn middle(&self, cell: usize) -> Point2<Map> {
        self.spec.centre_of(self.spec.cell_of(cell))
    }

    /// A point in cells from the lower left corner of the grid.
    pub(crate) fn in_cells(&self, p: Point2<Map>) -> [f64; 2] {
        let origin = self.spec.origin_m();
        [(p.x_m() - origin[0]) / self.spec.resolution_m(), (p.y_m() - origin[1]) / self.spec.resolution_m()]
    }
}

/// Ground of the cells of a storey that is not level. A doorway without floor has that of the cells beside it.
fn relief_of(grid: &Grid<'_>, cells: &SparseCells) -> SparseLayer<GroundOfCell> {
    let spec = grid.spec();
    let level = GroundOfCell { z_tenths: grid.head.floor_z_tenths, slope_mrad: 0 };
    let ground = |cell: usize| {
        let of_height = |z_tenths: i32| GroundOfCell { z_tenths, slope_mrad: grid.slope[cell] };
        grid.height_tenths(cell).map_or(level, of_height)
    };
    let mut relief = cells.layer_of(level, ground);
    let is_without = |cell: &usize| grid.planning[*cell] == 0 && grid.height_tenths(*cell).is_none();
    let mut without: BTreeSet<usize> = cells.iter().filter(is_without).collect();
    loop {
        let known_beside = |cell: usize| {
            let is_known = |other: &usize| !without.contains(other) && grid.planning[*other] == 0;
            spec.beside(cell).find(is_known)
        };
        let found: Vec<(usize, usize)> = without.iter().filter_map(|&cell| Some((cell, known_beside(cell)?))).collect();
        if found.is_empty() {
            return relief;
        }
        for (cell, beside) in found {
            relief[cell] = relief[beside];
            without.remove(&cell);
        }
    }
}

/// The runs of cells that are not 0, each as part 0 so far.
fn runs_of(part: &SparseLayer<u32>, width: usize) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    for (start, values) in part.chunks() {
        let mut at = 0;
        while let Some(n) = values[at..].iter().position(|&value| value != 0) {
            let end = values[at + n..].iter().position(|&value| value == 0).map_or(values.len(), |n_on| at + n + n_on);
            let (mut first, last) = (start + at + n, start + end);
            // A chunk may go on in the next row, or begin in the middle of a run.
            while first < last {
                let row_end = (first / width + 1) * width;
                let length = last.min(row_end) - first;
                match runs.last_mut() {
                    Some(before) if before.cells().end == first && first % width != 0 => before.length += length as u32,
                    _ => runs.push(Run { first: first as u32, length: length as u32, part: 0 }),
                }
                first += length;
            }
            at = end;
        }
    }
    runs
}

/// Numbers the parts of runs that touch along sides, from 1, by their lowest cells; returns the number of cells of each,
/// beginning with number 0.
///
/// # Source
/// Two passes with a table of equivalent labels: Rosenfeld, Pfaltz, "Sequential operations in digital picture processing",
/// Journal of the ACM 13, 1966.
fn label(runs: &mut [Run], width: u32) -> Vec<u32> {
    let mut joined = UnionFind::<u32>::new(runs.len());
    let end = |run: &Run| run.first + run.length;
    let mut below = 0;
    for at in 0..runs.len() {
        let run = runs[at];
        while end(&runs[below]) + width <= run.first {
            below += 1;
        }
        let over = runs[below..at].iter().take_while(|other| other.first + width < end(&run)).count();
        for other in below..below + over {
            joined.union(other as u32, at as u32);
        }
    }
    let mut part_of = vec![0; runs.len()];
    let mut sizes = vec![0];
    for (run, set) in runs.iter_mut().zip(joined.into_labeling()) {
        let part = &mut part_of[set as usize];
        if *part == 0 {
            *part = sizes.len() as u32;
            sizes.push(0);
        }
        run.part = *part;
        sizes[*part as usize] += run.length;
    }
    sizes
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use grid::Class;
    use messages::{ArchiveBuffer, GridHead, GridWriter};
    use proptest::prelude::*;

    /// Floors of 26 x 18 cells with things of three cells and more on them, to be drawn.
    pub(crate) fn floors() -> impl Strategy<Value = String> {
        let thing = (1usize..24, 1usize..16, 3usize..8, 3usize..8);
        prop::collection::vec(thing, 0..8).prop_map(|things| {
            let is_under = |x: usize, y: usize| {
                let covers = |t: &(usize, usize, usize, usize)| t.0 <= x && x < t.0 + t.2 && t.1 <= y && y < t.1 + t.3;
                [0, 25].contains(&x) || [0, 17].contains(&y) || things.iter().any(covers)
            };
            let row = |y: usize| (0..26).map(|x| if is_under(x, y) { '#' } else { '.' }).collect::<String>();
            (0..18).map(row).collect::<Vec<_>>().join("\n")
        })
    }

    /// A grid as text, a character a cell of 0.1 m, the north first: `#` is wall, `~` keep-out, a blank unknown, all else free;
    /// `a` is the first space.
    pub(crate) fn drawn(text: &str) -> ArchiveBuffer {
        drawn_at(text, 0)
    }

    /// The same with its floor at a height in tenths of a millimetre.
    pub(crate) fn drawn_at(text: &str, floor_z_tenths: i32) -> ArchiveBuffer {
        let rows: Vec<&[u8]> = text.lines().filter(|l| !l.is_empty()).map(str::as_bytes).collect();
        let (width, height) = (rows[0].len() as u32, rows.len() as u32);
        let head = GridHead { cell_tenths: 1_000, width, height, floor_z_tenths, ..GridHead::EMPTY };
        let mut buffer = ArchiveBuffer::zeroed(GridWriter::len_of(head.spec().n_cells()));
        let mut writer = GridWriter::new(buffer.bytes_mut(), &head);
        let layers = writer.layers();
        for (cell, &character) in rows.iter().rev().flat_map(|r| r.iter()).enumerate() {
            (layers.planning[cell], layers.class[cell]) = match character {
                b'#' => (100, Class::Wall.id()),
                b' ' => (-1, Class::None.id()),
                _ => (0, Class::None.id()),
            };
            layers.keepout[cell] = if character == b'~' { 100 } else { -1 };
            layers.space[cell] = u16::from(character == b'a');
        }
        writer.seal();
        buffer
    }

    fn free_space(text: &str, radius_m: f64) -> FreeSpace {
        FreeSpace::of(&Grid::open(drawn(text).bytes()).unwrap(), radius_m)
    }

    /// Where it can stand, as text: the numbers of the parts.
    fn parts(text: &str, radius_m: f64) -> String {
        let free_space = free_space(text, radius_m);
        let number = |cell: usize| char::from_digit(free_space.part(cell), 10).filter(|c| *c != '0').unwrap_or('.');
        let cells: Vec<char> = (0..free_space.spec.n_cells()).map(number).collect();
        let rows: Vec<String> =
            cells.chunks(free_space.spec.width as usize).rev().map(|r| r.iter().collect()).collect();
        rows.join("\n")
    }

    #[test]
    fn a_robot_stands_as_far_from_walls_as_its_radius() {
        let room = "#######\n#.....#\n#.....#\n#.....#\n#.....#\n#.....#\n#######";
        assert_eq!(parts(room, 0.1), ".......\n.11111.\n.11111.\n.11111.\n.11111.\n.11111.\n.......");
        assert_eq!(parts(room, 0.2), ".......\n.......\n..111..\n..111..\n..111..\n.......\n.......");
        assert_eq!(parts(room, 0.200_05), parts(room, 0.2), "a tenth of a millimetre is no obstacle");
        assert_eq!(parts(room, 0.21), ".......\n.......\n.......\n...1...\n.......\n.......\n.......");
    }

    #[test]
    fn keep_out_is_not_free_and_a_robot_may_reach_over_it() {
        assert_eq!(parts("#######\n#..~..#\n#..~..#\n#######", 0.1), ".......\n.11.22.\n.11.22.\n.......");
        assert_eq!(parts("#######\n#.~~..#\n#.....#\n#######", 0.1), ".......\n.1..11.\n.11111.\n.......");
    }

    #[test]
    fn unknown_is_not_free() {
        assert_eq!(parts("#####\n#. .#\n#...#\n#####", 0.2), ".....\n.....\n.....\n.....");
    }

    #[test]
    fn parts_hang_together_along_sides_and_are_numbered_from_below() {
        let text = "######\n#..#.#\n#.#..#\n##...#\n######";
        assert_eq!(parts(text, 0.1), "......\n.22.1.\n.2.11.\n..111.\n......");
        let free_space = free_space(text, 0.1);
        assert_eq!((free_space.n_parts(), free_space.size(1), free_space.size(2)), (2, 6, 3));
    }

    #[test]
    fn clearance_is_the_distance_to_the_middle_of_the_nearest_cell_that_is_not_free() {
        let text = "##########\n#........#\n#..##....#\n#........#\n#.......##\n#........#\n#......  #\n##########";
        let free_space = free_space(text, 0.1);
        let cells = 0..free_space.spec.n_cells();
        let stops: Vec<Point2<Map>> =
            cells.filter(|&c| free_space.squared[c] == 0).map(|c| free_space.middle(c)).collect();
        for k in 0..2_000 {
            // Places all over the map, none of them twice.
            let p = Point2::<Map>::new(f64::from(k * 617 % 2_000) / 2_000.0, f64::from(k) / 2_500.0);
            let cell = free_space.spec.index(free_space.spec.cell_at(p).unwrap());
            let nearest = stops.iter().map(|s| s.distance_m(&p)).fold(f64::INFINITY, f64::min);
            let expected = if free_space.squared[cell] == 0 { 0.0 } else { nearest };
            assert!((free_space.clearance_m(p) - expected).abs() < 1e-12, "{p:?}: {expected}");
        }
        assert_eq!(free_space.clearance_m(Point2::new(-0.1, 0.3)), 0.0, "outside of the grid");
        assert!((free_space.clearance_of(free_space.spec.width as usize * 3 + 1) - 0.1).abs() < 1e-12);
    }
}
