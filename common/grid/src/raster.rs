//! Conservative rasterisation of polygons into runs of cells.
//!
//! A row of cells is a band of heights. The part of a band that a polygon covers is the union of the ranges of its edges in
//! the band and of its interior on one line through the band. Bands and cells are taken half a tenth of a millimetre smaller
//! on all sides, so that a face on a cell's border touches one side only, and an overlap counts from a tenth of a
//! millimetre.
//!
//! Of a body that is cut at a slab every triangle is painted by itself: a cell overlaps the union of parts if it overlaps
//! one of them, so that nothing has to be united.

use crate::bitmap::Bitmap;
use crate::{CellRect, GridSpec, Run};
use geometry::{Bounds, MultiPolygon, Point, SlabCut, edges};

const INSET: f64 = 0.5;

/// The cells that the area overlaps or the lines touch, as sorted runs that do not meet.
///
/// Lines touch the cells on both sides of a border they lie on. Parts outside the grid are cut off.
pub fn overlapped_cells(area: &MultiPolygon, lines: &[[Point; 2]], spec: &GridSpec) -> Vec<Run> {
    let mut bands = Bands::new(spec);
    for (a, b) in area.rings().flat_map(|ring| edges(ring)) {
        bands.add_edge(a, b);
    }
    for [a, b] in lines {
        bands.add_line(*a, *b);
    }
    let mut runs = Vec::new();
    bands.for_each(|row, ranges, interiors| {
        let first = runs.len();
        runs.extend(ranges.iter().chain(interiors).filter_map(|&range| overlapped(row, range, bands.cell, spec)));
        runs[first..].sort_unstable();
        merge(&mut runs, first);
    });
    runs
}

/// The cells that a cut body overlaps, as [`overlapped_cells`] of its footprint: linear in its parts.
///
/// Where the footprint has a corner at which edges of parts cross, its coordinates are rounded and those of the parts are not:
/// a cell may differ if an edge is within a tenth of a millimetre of its border.
pub fn cells_of_cut(cut: &SlabCut, spec: &GridSpec) -> Vec<Run> {
    if cut.is_united() {
        return overlapped_cells(cut.sections.first().unwrap_or(&MultiPolygon::default()), &cut.lines, spec);
    }
    let sections = cut.sections.iter().filter_map(MultiPolygon::bounds);
    let bounds = [Bounds::of(cut.plans().flatten().copied()), Bounds::of(cut.lines.iter().flatten().copied())];
    let all = bounds.into_iter().flatten().chain(sections).reduce(Bounds::joined);
    let Some(rect) = all.and_then(|bounds| cells_around(bounds, spec)) else { return Vec::new() };
    let mut bitmap = Bitmap::new(rect);
    let bands = Bands::new(spec);
    let mut ranges = Vec::new();
    cut.plans().for_each(|plan| bands.paint_convex(plan, spec, &mut ranges, &mut bitmap));
    for section in &cut.sections {
        bitmap.set_runs(&overlapped_cells(section, &[], spec));
    }
    bitmap.set_runs(&overlapped_cells(&MultiPolygon::default(), &cut.lines, spec));
    bitmap.runs()
}

/// The cells whose whole square lies in the area, as sorted runs that do not meet.
pub fn covered_cells(area: &MultiPolygon, spec: &GridSpec) -> Vec<Run> {
    let mut bands = Bands::new(spec);
    for (a, b) in area.rings().flat_map(|ring| edges(ring)) {
        bands.add_edge(a, b);
    }
    let mut runs = Vec::new();
    bands.for_each(|row, ranges, interiors| {
        let first = runs.len();
        for &[lo, hi] in interiors {
            let mut from = lo;
            // Ranges are sorted by their lower ends: walk the gaps between them.
            for &[cut_lo, cut_hi] in ranges.iter().filter(|r| r[0] < hi && lo < r[1]) {
                push_inside(&mut runs, row, from, cut_lo, &bands, spec);
                from = from.max(cut_hi);
            }
            push_inside(&mut runs, row, from, hi, &bands, spec);
        }
        runs[first..].sort_unstable();
        merge(&mut runs, first);
    });
    runs
}

/// The cells of the grid that touch these bounds.
fn cells_around(bounds: Bounds, spec: &GridSpec) -> Option<CellRect> {
    let cell = i64::from(spec.cell_tenths);
    let n = [spec.width, spec.height].map(i64::from);
    let place = |c: i32, k: usize| i64::from(c).div_euclid(cell) - i64::from(spec.first_cell[k]);
    // A face on a border touches the cells on both sides if it is a line.
    let min = [0, 1].map(|k| (place(bounds.min[k], k) - 1).clamp(0, n[k]) as u32);
    let max = [0, 1].map(|k| (place(bounds.max[k], k) + 2).clamp(0, n[k]) as u32);
    (min[0] < max[0] && min[1] < max[1]).then_some(CellRect { min, max })
}

fn push_inside(runs: &mut Vec<Run>, row: i64, lo: f64, hi: f64, bands: &Bands, spec: &GridSpec) {
    push_clipped(runs, row, ((lo - INSET) / bands.cell).ceil(), ((hi + INSET) / bands.cell).floor(), spec);
}

fn push_clipped(runs: &mut Vec<Run>, row: i64, start: f64, end: f64, spec: &GridSpec) {
    runs.extend(clipped(row, start, end, spec));
}

/// The run of these columns, counted from the frame's origin, inside the grid.
fn clipped(row: i64, start: f64, end: f64, spec: &GridSpec) -> Option<Run> {
    let first = f64::from(spec.first_cell[0]);
    let (start, end) = ((start - first).max(0.0), (end - first).min(f64::from(spec.width)));
    (start < end).then_some(Run { row: row as u32, start: start as u32, end: end as u32 })
}

/// The cells of a row that a range of widths overlaps.
fn overlapped(row: i64, [lo, hi]: [f64; 2], cell: f64, spec: &GridSpec) -> Option<Run> {
    clipped(row, floor((lo + INSET) / cell), ceil((hi - INSET) / cell), spec)
}

/// The largest whole number that is not more; of numbers that have a fraction, which conversions do not change otherwise.
fn floor(x: f64) -> f64 {
    let whole = x as i64 as f64;
    if whole > x { whole - 1.0 } else { whole }
}

/// The smallest whole number that is not less.
fn ceil(x: f64) -> f64 {
    -floor(-x)
}

/// Joins sorted runs of one row, from `first` on, that overlap or touch.
fn merge(runs: &mut Vec<Run>, first: usize) {
    let mut last = first;
    for k in first + 1..runs.len() {
        if runs[k].start <= runs[last].end {
            runs[last].end = runs[last].end.max(runs[k].end);
        } else {
            last += 1;
            runs[last] = runs[k];
        }
    }
    runs.truncate(if first < runs.len() { last + 1 } else { first });
}

/// Edges in the bands of a grid.
struct Bands {
    cell: f64,
    first_row: i64,
    n_rows: i64,
    /// (row, lower end, upper end) of an edge's part in a band.
    ranges: Vec<(i64, f64, f64)>,
    /// (row, x) where an edge passes the band's lower line.
    crossings: Vec<(i64, f64)>,
}

impl Bands {
    fn new(spec: &GridSpec) -> Self {
        Self {
            cell: f64::from(spec.cell_tenths),
            first_row: i64::from(spec.first_cell[1]),
            n_rows: i64::from(spec.height),
            ranges: Vec::new(),
            crossings: Vec::new(),
        }
    }

    /// Rows of the grid whose bands meet the heights `lo..=hi`.
    fn rows(&self, lo: f64, hi: f64) -> std::ops::Range<i64> {
        let first = floor((lo + INSET) / self.cell) as i64 - self.first_row;
        let end = ceil((hi - INSET) / self.cell) as i64 - self.first_row;
        first.max(0)..end.min(self.n_rows)
    }

    fn band(&self, row: i64) -> (f64, f64) {
        let bottom = (row + self.first_row) as f64 * self.cell;
        (bottom + INSET, bottom + self.cell - INSET)
    }

    fn add_edge(&mut self, a: Point, b: Point) {
        let edge = Edge::of(a, b);
        for row in self.rows(edge.low[1], edge.high[1]) {
            let (bottom, top) = self.band(row);
            let [lower, upper] = edge.ends_between(bottom, top);
            self.ranges.push((row, lower.min(upper), lower.max(upper)));
            if edge.low[1] < bottom && bottom < edge.high[1] {
                self.crossings.push((row, lower));
            }
        }
    }

    /// Sets the cells that a convex polygon overlaps. `ranges` is room for what it covers of each row.
    fn paint_convex(&self, corners: &[Point], spec: &GridSpec, ranges: &mut Vec<[f64; 2]>, bitmap: &mut Bitmap) {
        let Some(bounds) = Bounds::of(corners.iter().copied()) else { return };
        let [low, high] = [bounds.min, bounds.max].map(|p| p.map(f64::from));
        let rows = self.rows(low[1], high[1]);
        // Most triangles of fine meshes lie in one cell.
        let in_column =
            |row| overlapped(row, [low[0], high[0]], self.cell, spec).filter(|run| run.end - run.start == 1);
        if let Some(run) = (rows.end - rows.start == 1).then(|| in_column(rows.start)).flatten() {
            bitmap.set(run);
            return;
        }
        ranges.clear();
        ranges.resize((rows.end - rows.start).max(0) as usize, [f64::INFINITY, f64::NEG_INFINITY]);
        for (a, b) in edges(corners) {
            let edge = Edge::of(a, b);
            // Rows that it may meet, and one more on both sides.
            let [first, last] = [edge.low[1], edge.high[1]].map(|y| (y / self.cell) as i64 - self.first_row);
            for row in (first - 2).max(rows.start)..(last + 3).min(rows.end) {
                let (bottom, top) = self.band(row);
                if edge.low[1] <= top && bottom <= edge.high[1] {
                    let range = &mut ranges[(row - rows.start) as usize];
                    for x in edge.ends_between(bottom, top) {
                        *range = [range[0].min(x), range[1].max(x)];
                    }
                }
            }
        }
        for (row, range) in rows.zip(&*ranges) {
            if let Some(run) = overlapped(row, *range, self.cell, spec) {
                bitmap.set(run);
            }
        }
    }

    fn add_line(&mut self, a: Point, b: Point) {
        let (a, b) = if a[1] <= b[1] { (a, b) } else { (b, a) };
        let (a, b) = (a.map(f64::from), b.map(f64::from));
        let slope = if b[1] > a[1] { (b[0] - a[0]) / (b[1] - a[1]) } else { 0.0 };
        for row in self.rows(a[1] - 2.0 * INSET, b[1] + 2.0 * INSET) {
            let (bottom, top) = self.band(row);
            let lower = if a[1] < bottom && bottom < b[1] { a[0] + (bottom - a[1]) * slope } else { a[0] };
            let upper = if a[1] < top && top < b[1] { a[0] + (top - a[1]) * slope } else { b[0] };
            let (lower, upper) = if b[1] <= bottom {
                (b[0], b[0])
            } else if top <= a[1] {
                (a[0], a[0])
            } else {
                (lower, upper)
            };
            self.ranges.push((row, lower.min(upper) - 2.0 * INSET, lower.max(upper) + 2.0 * INSET));
        }
    }

    /// Calls `visit(row, ranges sorted by lower end, interior intervals)` for every row with ranges or crossings.
    fn for_each(&self, mut visit: impl FnMut(i64, &[[f64; 2]], &[[f64; 2]])) {
        let by_row = |a: &(i64, f64, f64), b: &(i64, f64, f64)| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1));
        let mut ranges = self.ranges.clone();
        ranges.sort_unstable_by(by_row);
        let mut crossings = self.crossings.clone();
        crossings.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let (mut crossings, mut of_row, mut interiors) = (crossings.as_slice(), Vec::new(), Vec::new());
        for same in ranges.chunk_by(|a, b| a.0 == b.0) {
            let row = same[0].0;
            of_row.clear();
            of_row.extend(same.iter().map(|r| [r.1, r.2]));
            // A row with crossings has the ranges of the edges that cross.
            let n = crossings.iter().take_while(|c| c.0 == row).count();
            interiors.clear();
            interiors.extend(crossings[..n].chunks_exact(2).map(|pair| [pair[0].1, pair[1].1]));
            crossings = &crossings[n..];
            visit(row, &of_row, &interiors);
        }
    }
}

/// An edge from its lower end, so that neighbours that share it give equal results.
struct Edge {
    low: [f64; 2],
    high: [f64; 2],
    /// Width per height; 0 if it is level.
    slope: f64,
}

impl Edge {
    fn of(a: Point, b: Point) -> Self {
        let (a, b) = if (a[1], a[0]) <= (b[1], b[0]) { (a, b) } else { (b, a) };
        let (low, high) = (a.map(f64::from), b.map(f64::from));
        let slope = if high[1] > low[1] { (high[0] - low[0]) / (high[1] - low[1]) } else { 0.0 };
        Self { low, high, slope }
    }

    /// Where its part between two heights begins and ends; it must meet them.
    fn ends_between(&self, bottom: f64, top: f64) -> [f64; 2] {
        let at = |y: f64| self.low[0] + (y - self.low[1]) * self.slope;
        let lower = if self.low[1] < bottom { at(bottom) } else { self.low[0] };
        let upper = if self.high[1] > top { at(top) } else { self.high[0] };
        [lower, upper]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{FillRule, Footprint, MeshView, Slab, footprint, union};
    use proptest::prelude::*;

    fn spec(cell_tenths: i32) -> GridSpec {
        GridSpec { cell_tenths, first_cell: [-10, -10], width: 20, height: 20 }
    }

    fn region(ring: &[Point]) -> MultiPolygon {
        union(&[ring.to_vec()], FillRule::NonZero)
    }

    fn cells(runs: &[Run]) -> Vec<(u32, u32)> {
        runs.iter().flat_map(|r| (r.start..r.end).map(|c| (r.row, c))).collect()
    }

    #[test]
    fn a_face_on_a_border_touches_one_side_only() {
        let square = region(&[[0, 0], [1000, 0], [1000, 500], [0, 500]]);
        assert_eq!(overlapped_cells(&square, &[], &spec(500)), [Run { row: 10, start: 10, end: 12 }]);
        assert_eq!(covered_cells(&square, &spec(500)), [Run { row: 10, start: 10, end: 12 }]);
    }

    #[test]
    fn a_tenth_of_a_millimetre_is_positive_area() {
        let square = region(&[[-1, -1], [501, -1], [501, 501], [-1, 501]]);
        assert_eq!(cells(&overlapped_cells(&square, &[], &spec(500))).len(), 9);
        assert_eq!(covered_cells(&square, &spec(500)), [Run { row: 10, start: 10, end: 11 }]);
    }

    #[test]
    fn a_thin_wall_never_vanishes() {
        let wall = region(&[[100, -4000], [101, -4000], [101, 4000], [100, 4000]]);
        assert_eq!(cells(&overlapped_cells(&wall, &[], &spec(500))).len(), 16);
    }

    #[test]
    fn a_line_on_a_border_touches_both_sides() {
        let rows = cells(&overlapped_cells(&MultiPolygon::default(), &[[[500, 100], [500, 900]]], &spec(500)));
        assert_eq!(rows, [(10, 10), (10, 11), (11, 10), (11, 11)]);
        let rows = cells(&overlapped_cells(&MultiPolygon::default(), &[[[100, 500], [400, 500]]], &spec(500)));
        assert_eq!(rows, [(10, 10), (11, 10)]);
    }

    #[test]
    fn what_lies_outside_the_grid_is_cut_off() {
        let huge = region(&[[-90_000, -90_000], [90_000, -90_000], [90_000, 90_000], [-90_000, 90_000]]);
        assert_eq!(cells(&overlapped_cells(&huge, &[], &spec(500))).len(), 400);
        assert_eq!(cells(&covered_cells(&huge, &spec(500))).len(), 400);
    }

    /// A slow, obvious version: clip the polygon to the cell and look at what is left.
    fn share(area: &MultiPolygon, spec: &GridSpec, column: u32, row: u32) -> f64 {
        let corner = |k: usize, c: u32| (spec.first_cell[k] + c as i32) * spec.cell_tenths;
        let (x, y, s) = (corner(0, column), corner(1, row), spec.cell_tenths);
        let cell = region(&[[x, y], [x + s, y], [x + s, y + s], [x, y + s]]);
        geometry::intersection(area, &cell).area_m2() / cell.area_m2()
    }

    type Mesh = (Vec<[i32; 3]>, Vec<[u32; 3]>);

    /// Closed surfaces of four faces each, in one mesh.
    fn tetrahedra(corners: &[[[i32; 3]; 4]]) -> Mesh {
        let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
        for [a, b, c, d] in corners {
            let side = |p: &[i32; 3]| [0, 1, 2].map(|k| i64::from(p[k] - a[k]));
            let (u, v, w) = (side(b), side(c), side(d));
            let across = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
            let volume: i64 = (0..3).map(|k| across[k] * w[k]).sum();
            let base = vertices.len() as u32;
            vertices.extend([a, b, c, d]);
            let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
            triangles
                .extend(faces.map(|[i, j, k]| if volume < 0 { [i, k, j] } else { [i, j, k] }.map(|i: u32| base + i)));
        }
        (vertices.into_iter().copied().collect(), triangles)
    }

    fn corner() -> impl Strategy<Value = [i32; 3]> {
        (-4_900..4_900i32, -4_900..4_900i32, -3_000..5_000i32).prop_map(|(x, y, z)| [x, y, z])
    }

    proptest! {
        #[test]
        fn cells_of_a_cut_are_those_of_its_footprint(
            bodies in prop::collection::vec([corner(), corner(), corner(), corner()], 1..8), n_lost in 0..2usize,
        ) {
            let (vertices, mut triangles) = tetrahedra(&bodies);
            triangles.truncate(triangles.len() - n_lost);
            let mesh = MeshView { vertices: &vertices, triangles: &triangles, closed: n_lost == 0 };
            let (spec, slab) = (spec(500), Slab { lo: 0, hi: 2_000 });
            let cut = SlabCut::of([mesh], slab);
            let found = cells(&cells_of_cut(&cut, &spec));
            let Footprint { area, lines } = footprint([mesh], slab);
            // Corners of the union are rounded: what they can be off bounds the cells from both sides.
            let grown = geometry::offset(&area, 3).unwrap();
            let most = cells(&overlapped_cells(&grown, &lines, &spec));
            prop_assert!(found.iter().all(|cell| most.contains(cell)));
            let shrunk = geometry::offset(&area, -3).unwrap();
            let least = cells(&overlapped_cells(&shrunk, &lines, &spec));
            prop_assert!(least.iter().all(|cell| found.contains(cell)));
        }

        #[test]
        fn cells_of_blocks_are_exactly_those_of_their_footprint(
            blocks in prop::collection::vec((-90..80i32, -90..80i32, 1..90i32, 1..90i32, 0..40i32), 1..8),
        ) {
            let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
            for (x, y, width, depth, z) in blocks {
                let [x, y, width, depth, z] = [x, y, width, depth, z].map(|c| c * 50);
                let base = vertices.len() as u32;
                let plan = [[x, y], [x + width, y], [x + width, y + depth], [x, y + depth]];
                vertices.extend([z, z + 1_000].into_iter().flat_map(|z| plan.map(|[x, y]| [x, y, z])));
                let quads = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];
                triangles.extend(quads.iter().flat_map(|q: &[u32; 4]| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]].map(|t| t.map(|i| base + i))));
            }
            let mesh = MeshView { vertices: &vertices, triangles: &triangles, closed: true };
            let (spec, slab) = (spec(500), Slab { lo: 0, hi: 2_000 });
            let footprint = footprint([mesh], slab);
            prop_assert_eq!(
                cells_of_cut(&SlabCut::of([mesh], slab), &spec),
                overlapped_cells(&footprint.area, &footprint.lines, &spec)
            );
        }

        #[test]
        fn cells_agree_with_clipping_them_one_by_one(
            points in prop::collection::vec([-4_900..4_900i32, -4_900..4_900i32], 3..9),
        ) {
            // Self-crossing rings are resolved first; even-odd makes holes of some.
            let area = union(&[points], FillRule::EvenOdd);
            let spec = spec(500);
            let (touched, inside) = (cells(&overlapped_cells(&area, &[], &spec)), cells(&covered_cells(&area, &spec)));
            for row in 0..20 {
                for column in 0..20 {
                    let share = share(&area, &spec, column, row);
                    // Overlaps of a few tenths of a millimetre may go either way: clipping rounds corners.
                    if share > 0.02 {
                        prop_assert!(touched.contains(&(row, column)), "missed {column} {row} share {share}");
                    }
                    if share == 0.0 {
                        prop_assert!(!inside.contains(&(row, column)));
                    }
                    if share < 0.98 {
                        prop_assert!(!inside.contains(&(row, column)), "covered {column} {row} share {share}");
                    }
                    if inside.contains(&(row, column)) {
                        prop_assert!(touched.contains(&(row, column)));
                    }
                }
            }
            if let Some(Bounds { min, max }) = area.bounds() {
                let reach = |c: i32| c.div_euclid(500) + 10;
                for (row, column) in touched {
                    prop_assert!(reach(min[0]) <= column as i32 && column as i32 <= reach(max[0]));
                    prop_assert!(reach(min[1]) <= row as i32 && row as i32 <= reach(max[1]));
                }
            }
        }
    }
}
