//! The floor of a storey with ground at other heights: the surface that each cell shows, and where the ground breaks off.

use crate::layers::shown_surface::{LEVEL, shown_surface};
use crate::model::band_surfaces::{BandSurfaces, Source, bands};
use crate::model::cell_area::{slab_above_floor, to_tenths};
use crate::model::element_runs::ElementRuns;
use crate::model::gap::FLOOR_CRACK;
use crate::model::ground_patch::{GroundPatch, STEP_TOLERANCE, z_at};
use crate::model::storey_slice::StoreySlice;
use geometry::{MultiPolygon, close_gaps, difference, union_of};
use grid::{CellRect, Mask, Run, common_runs, covered_cells, overlapped_cells};
use messages::{NONE, RobotProfile};
use rustc_hash::FxHashMap;

/// Floor cells, and which of them show a patch.
#[derive(Debug, Default)]
pub(crate) struct GroundFloor {
    /// Cells that floor covers whole, without those from which the ground breaks off.
    pub(crate) floor: Vec<Run>,
    /// Cells that show a patch, by its index among those of the storey; also those from which the ground breaks off.
    pub(crate) patches: Vec<(Run, u32)>,
}

/// The floor of the patches that are there and of the storey's own level, `level`.
///
/// A cell shows one surface. Of surfaces above each other one counts only if the robot fits below the next, and below its body; of those
/// that do it is the one nearest to the level of the storey: what lies deeper or higher belongs to the map of another one. From a
/// cell the ground breaks off where that beside it is lower by more than a step, on a stair by more than a riser.
///
/// The ground outdoors has no level; its floor is made in `incremental/outdoor_floor.rs`.
pub(crate) fn ground_floor(
    storey: &StoreySlice,
    robot: &RobotProfile,
    level: &MultiPolygon,
    is_there: impl Fn(&GroundPatch) -> bool,
) -> GroundFloor {
    let there: Vec<u32> = (0..).zip(&storey.ground).filter(|(_, p)| is_there(p)).map(|(k, _)| k).collect();
    let patches = || there.iter().map(|&k| &storey.ground[k as usize]);
    if there.is_empty() {
        return GroundFloor { floor: covered_cells(level, &storey.spec), patches: Vec::new() };
    }
    let all = close_gaps(&union_of(patches().map(|p| &p.area).chain([level])), FLOOR_CRACK);
    let all = if storey.shafts.is_empty() { all } else { difference(&all, &storey.shafts) };
    let mask = |runs: &[Run]| {
        let mut mask = Mask::new(storey.spec.width as usize, storey.spec.height as usize);
        mask.set_runs(runs);
        mask
    };
    let covered = covered_cells(&all, &storey.spec);
    let floor = mask(&covered);
    let most = f64::from(to_tenths(robot.step_height_m)) + STEP_TOLERANCE;
    let headroom = f64::from(slab_above_floor(robot)[1]);
    let mut elements: Vec<u32> = patches().map(|patch| patch.element).collect();
    elements.sort_unstable();
    elements.dedup();
    let of_ground = |o: &&ElementRuns| elements.binary_search(&o.element).is_ok();
    let bodies = |obstacles| BodyCells::of(Iterator::filter(<[ElementRuns]>::iter(obstacles), of_ground));
    let mut cells_of_level = mask(&covered_cells(level, &storey.spec));
    // Where a flight ends at the edge of the floor the higher of the two counts.
    if patches().any(|patch| patch.is_tread) {
        let rim = overlapped_cells(level, &[], &storey.spec);
        let treads = patches().filter(|patch| patch.is_tread);
        treads.for_each(|tread| cells_of_level.set_runs(&common_runs(&rim, &tread.cells)));
    }
    let mut surfaces = Surfaces {
        storey,
        rect: CellRect { min: [0; 2], max: [0; 2] },
        of_cell: Vec::new(),
        above_level: bodies(&storey.obstacles),
        above_patches: there.iter().map(|&k| (k, bodies(&storey.ground[k as usize].obstacles))).collect(),
    };
    let (mut found, mut breaks) = (Vec::new(), Vec::new());
    for rect in apart(patches().map(|patch| patch.rect)) {
        let there: Vec<u32> = there.iter().copied().filter(|&k| storey.ground[k as usize].rect.meets(&rect)).collect();
        surfaces.rect = rect;
        surfaces.of_cell.clear();
        surfaces.of_cell.resize(rect.n_cells(), LEVEL);
        surfaces.choose(&there, (&floor, &cells_of_level), [most, headroom]);
        found.extend(surfaces.patches(&floor));
        breaks.extend(surfaces.breaks(&floor, to_tenths(robot.step_height_m)));
    }
    breaks.sort_unstable();
    GroundFloor { patches: found, floor: without_cells(&covered, &breaks, storey.spec.width) }
}

/// Rectangles of which no two meet, around all of these.
fn apart(rects: impl Iterator<Item = CellRect>) -> Vec<CellRect> {
    let mut found: Vec<CellRect> = Vec::new();
    for mut rect in rects {
        while let Some(k) = found.iter().position(|other| other.meets(&rect)) {
            rect = rect.around_both(&found.swap_remove(k));
        }
        found.push(rect);
    }
    found
}

/// Sorted runs that do not meet, without sorted cells that lie in them.
fn without_cells(runs: &[Run], mut cells: &[usize], width: u32) -> Vec<Run> {
    let mut found = Vec::with_capacity(runs.len() + cells.len());
    for &Run { row, start, end } in runs {
        let mut from = start;
        let behind = row as usize * width as usize + end as usize;
        let (inside, rest) = cells.split_at(cells.partition_point(|cell| *cell < behind));
        cells = rest;
        for cell in inside {
            let column = (cell % width as usize) as u32;
            if from < column {
                found.push(Run { row, start: from, end: column });
            }
            from = column + 1;
        }
        if from < end {
            found.push(Run { row, start: from, end });
        }
    }
    found
}

/// The surface of each cell of a rectangle.
struct Surfaces<'a> {
    storey: &'a StoreySlice,
    rect: CellRect,
    of_cell: Vec<u32>,
    /// Where bodies of ground stand in the way on the storey's level, and on each patch.
    above_level: BodyCells<'a>,
    above_patches: FxHashMap<u32, BodyCells<'a>>,
}

/// Cells of bodies: the rectangle and the sorted runs of each.
struct BodyCells<'a>(Vec<(CellRect, &'a [Run])>);

impl<'a> BodyCells<'a> {
    fn of(bodies: impl Iterator<Item = &'a ElementRuns>) -> Self {
        Self(bodies.filter_map(|body| Some((body.rect?, body.runs.as_slice()))).collect())
    }

    fn hold(&self, column: u32, row: u32) -> bool {
        let is_in = |rect: &CellRect| {
            [column, row].iter().zip(rect.min.iter().zip(&rect.max)).all(|(at, (min, max))| min <= at && at < max)
        };
        self.0.iter().filter(|(rect, _)| is_in(rect)).any(|(_, runs)| {
            let at = runs.partition_point(|run| (run.row, run.end) <= (row, column));
            runs.get(at).is_some_and(|run| run.row == row && run.start <= column)
        })
    }
}

/// Height of a surface, or of its continuation, at a place in columns and rows, in tenths of a millimetre.
pub(crate) fn surface_z(storey: &StoreySlice, surface: u32, place: [f64; 2]) -> f64 {
    match storey.ground.get(surface as usize) {
        Some(patch) => z_at(&patch.plane, place, &storey.spec),
        None => f64::from(storey.floor_z),
    }
}

/// True if the ground beside a cell of floor is lower by more than a step, or by more than one climbs on a patch. `surface` and
/// `is_floor` tell of cells by index.
pub(crate) fn breaks_off(
    storey: &StoreySlice,
    step: i32,
    cell: usize,
    surface: impl Fn(usize) -> u32,
    is_floor: impl Fn(usize) -> bool,
) -> bool {
    let (width, height) = (storey.spec.width as usize, storey.spec.height as usize);
    let climb = |surface: u32| storey.ground.get(surface as usize).map_or(step, |patch| patch.climb);
    let own = surface(cell);
    let (column, row) = (cell % width, cell / width);
    let (x, y) = (column as f64 + 0.5, row as f64 + 0.5);
    let neighbours = [
        (column > 0).then(|| (cell - 1, [x - 0.5, y])),
        (column + 1 < width).then(|| (cell + 1, [x + 0.5, y])),
        (row > 0).then(|| (cell - width, [x, y - 0.5])),
        (row + 1 < height).then(|| (cell + width, [x, y + 0.5])),
    ];
    let is_lower = |(other, middle): (usize, [f64; 2])| {
        let beside = surface(other);
        beside != own && is_floor(other) && {
            let most = f64::from(climb(own).max(climb(beside))) + STEP_TOLERANCE;
            surface_z(storey, own, middle) - surface_z(storey, beside, middle) > most
        }
    };
    neighbours.into_iter().flatten().any(is_lower)
}

impl Surfaces<'_> {
    fn width(&self) -> usize {
        self.storey.spec.width as usize
    }

    /// Index in `of_cell` of a cell of the grid in the rectangle.
    fn at(&self, cell: usize) -> usize {
        let (column, row) = (cell % self.width(), cell / self.width());
        (row - self.rect.min[1] as usize) * self.rect.width() + column - self.rect.min[0] as usize
    }

    fn choose(&mut self, there: &[u32], (floor, level): (&Mask, &Mask), [step, headroom]: [f64; 2]) {
        let width = self.width();
        let mut in_band = BandSurfaces::default();
        let mut above: Vec<(f64, u32)> = Vec::new();
        let storey = self.storey;
        for band in bands(&self.rect) {
            let in_band_too = there.iter().filter(|k| storey.ground[**k as usize].rect.meets(&band));
            let sources = in_band_too.map(|&surface| Source { surface, body: NONE });
            let runs = |source: Source| storey.ground[source.surface as usize].cells.as_slice();
            in_band.rects(&band, sources, runs, |rect, surfaces| {
                let cells = rect.rows(width).flatten().filter(|&cell| floor.cells[cell] && !surfaces.is_empty());
                for cell in cells {
                    let at = self.at(cell);
                    let is_of_level = level.cells[cell];
                    if let ([only], false) = (surfaces, is_of_level) {
                        self.of_cell[at] = *only;
                        continue;
                    }
                    let [column, row] = [cell % width, cell / width].map(|k| k as u32);
                    let middle = [f64::from(column) + 0.5, f64::from(row) + 0.5];
                    above.clear();
                    above.extend(surfaces.iter().map(|&k| (surface_z(self.storey, k, middle), k)));
                    let reference = f64::from(self.storey.floor_z);
                    // A patch that begins here is the level floor of this place.
                    if is_of_level && above.iter().all(|(z, _)| (z - reference).abs() > step) {
                        above.push((reference, LEVEL));
                    }
                    let bodies = |surface: u32| self.above_patches.get(&surface).unwrap_or(&self.above_level);
                    self.of_cell[at] =
                        shown_surface(&mut above, reference, headroom, |surface| bodies(surface).hold(column, row));
                }
            });
        }
    }

    /// Cells beside which the ground is lower by more than a step, or by more than one climbs on a patch.
    fn breaks(&self, floor: &Mask, step: i32) -> Vec<usize> {
        let width = self.width();
        let surface = |cell: usize| {
            let place = [(cell % width) as u32, (cell / width) as u32];
            let is_in = (0..2).all(|k| self.rect.min[k] <= place[k] && place[k] < self.rect.max[k]);
            if is_in { self.of_cell[self.at(cell)] } else { LEVEL }
        };
        let across = self.rect.width();
        let mut found = Vec::new();
        for (cells, first) in self.rect.rows(width).zip((0..).step_by(across)) {
            for (cell, at) in cells.zip(first..).filter(|&(cell, _)| floor.cells[cell]) {
                let own = self.of_cell[at];
                let (column, row) = (cell % width, cell / width);
                let place = [column as u32, row as u32];
                let is_inner = (0..2).all(|k| self.rect.min[k] < place[k] && place[k] + 1 < self.rect.max[k]);
                if is_inner && [at - 1, at + 1, at - across, at + across].iter().all(|at| self.of_cell[*at] == own) {
                    continue;
                }
                if breaks_off(self.storey, step, cell, surface, |other| floor.cells[other]) {
                    found.push(cell);
                }
            }
        }
        found
    }

    /// Runs of floor cells that show a patch.
    fn patches(&self, floor: &Mask) -> Vec<(Run, u32)> {
        let mut found = Vec::new();
        for (row, cells) in (self.rect.min[1]..).zip(self.rect.rows(self.width())) {
            let start = cells.start;
            let surface = |cell: usize| if floor.cells[cell] { self.of_cell[self.at(cell)] } else { LEVEL };
            let surfaces: Vec<u32> = cells.map(surface).collect();
            let mut from = 0;
            for same in surfaces.chunk_by(|a, b| a == b) {
                if same[0] != LEVEL {
                    let column = (start % self.width() + from) as u32;
                    found.push((Run { row, start: column, end: column + same.len() as u32 }, same[0]));
                }
                from += same.len();
            }
        }
        found
    }
}
