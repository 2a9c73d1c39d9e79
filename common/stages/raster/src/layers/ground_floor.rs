//! The floor of a storey with ground at other heights: the surface that each cell shows, and where the ground breaks off.

use crate::model::cell_area::{slab_above_floor, to_tenths};
use crate::model::element_runs::ElementRuns;
use crate::model::gap::FLOOR_CRACK;
use crate::model::ground_patch::{GroundPatch, STEP_TOLERANCE, z_at};
use crate::model::storey_slice::StoreySlice;
use geometry::{MultiPolygon, close_gaps, difference, union_of};
use grid::{CellRect, Mask, Run, common_runs, covered_cells, overlapped_cells};
use messages::{FloorKind, RobotProfile};
use std::collections::{BTreeMap, HashMap, HashSet};

/// The surface of a cell that has no patch: the level of the storey's own floor.
pub(crate) const LEVEL: u32 = u32::MAX;

/// Rows of cells whose surfaces are compared at once.
const BAND_ROWS: u32 = 64;

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
/// that do it is the one nearest to the level of the storey: what lies deeper or higher belongs to the map of another one. Outdoors it
/// is the one nearest to the highest terrain or road of the cell, and in a hole of these, as a house has, to that beside the hole. From a
/// cell the ground breaks off where that beside it is lower by more than a step, on a stair by more than a riser.
pub(crate) fn ground_floor(
    storey: &StoreySlice,
    robot: &RobotProfile,
    level: &MultiPolygon,
    is_there: impl Fn(&GroundPatch) -> bool,
) -> GroundFloor {
    let there: Vec<u32> = (0..).zip(&storey.ground).filter(|(_, p)| is_there(p)).map(|(k, _)| k).collect();
    let patches = || there.iter().map(|&k| &storey.ground[k as usize]);
    let Some(rect) = patches().map(|p| p.rect).reduce(|a, b| a.around_both(&b)) else {
        return GroundFloor { floor: covered_cells(level, &storey.spec), patches: Vec::new() };
    };
    let all = close_gaps(&union_of(patches().map(|p| &p.area).chain([level])), FLOOR_CRACK);
    let all = if storey.shafts.is_empty() { all } else { difference(&all, &storey.shafts) };
    let mask = |area: &MultiPolygon| {
        let mut mask = Mask::new(storey.spec.width as usize, storey.spec.height as usize);
        mask.set_runs(&covered_cells(area, &storey.spec));
        mask
    };
    let mut floor = mask(&all);
    let most = f64::from(to_tenths(robot.step_height_m)) + STEP_TOLERANCE;
    let headroom = f64::from(slab_above_floor(robot)[1]);
    let elements: HashSet<u32> = patches().map(|patch| patch.element).collect();
    let of_ground = |o: &&ElementRuns| elements.contains(&o.element);
    let bodies = |obstacles| BodyCells::of(Iterator::filter(<[ElementRuns]>::iter(obstacles), of_ground));
    let holes = if storey.floor_kind == FloorKind::Ground {
        earth_around_holes(storey, &there, &floor)
    } else {
        HashMap::new()
    };
    let mut surfaces = Surfaces {
        storey,
        rect,
        holes,
        of_cell: vec![LEVEL; rect.n_cells()],
        above_level: bodies(&storey.obstacles),
        above_patches: storey.ground.iter().map(|patch| bodies(&patch.obstacles)).collect(),
    };
    let level = (storey.floor_kind != FloorKind::Ground).then(|| {
        let mut cells = mask(level);
        // Where a flight ends at the edge of the floor the higher of the two counts.
        if patches().any(|patch| patch.is_tread) {
            let rim = overlapped_cells(level, &[], &storey.spec);
            let treads = patches().filter(|patch| patch.is_tread);
            treads.for_each(|tread| cells.set_runs(&common_runs(&rim, &tread.cells)));
        }
        cells
    });
    surfaces.choose(&there, (&floor, level.as_ref()), [most, headroom]);
    let (patches, breaks) = (surfaces.patches(&floor), surfaces.breaks(&floor, to_tenths(robot.step_height_m)));
    breaks.into_iter().for_each(|cell| floor.cells[cell] = false);
    GroundFloor { patches, floor: runs_of(&floor) }
}

/// The surface of each cell of a rectangle.
struct Surfaces<'a> {
    storey: &'a StoreySlice,
    rect: CellRect,
    /// Height of the earth beside the hole in which a cell lies, outdoors.
    holes: HashMap<usize, f64>,
    of_cell: Vec<u32>,
    /// Where bodies of ground stand in the way on the storey's level, and on each patch.
    above_level: BodyCells,
    above_patches: Vec<BodyCells>,
}

/// Cells of bodies, as sorted runs of each.
struct BodyCells(Vec<Vec<Run>>);

impl BodyCells {
    fn of<'a>(bodies: impl Iterator<Item = &'a ElementRuns>) -> Self {
        Self(bodies.map(|body| body.runs.clone()).collect())
    }

    fn hold(&self, column: u32, row: u32) -> bool {
        self.0.iter().any(|runs| {
            let at = runs.partition_point(|run| (run.row, run.end) <= (row, column));
            runs.get(at).is_some_and(|run| run.row == row && run.start <= column)
        })
    }
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

    fn z(&self, surface: u32, middle: [f64; 2]) -> f64 {
        match self.storey.ground.get(surface as usize) {
            Some(patch) => z_at(&patch.plane, middle, &self.storey.spec),
            None => f64::from(self.storey.floor_z),
        }
    }

    /// Height of the highest terrain or road among the surfaces of a cell; without any that beside the hole in which it lies, and where
    /// nothing is beside it that of the map storey, the median of all ground.
    fn earth_z(&self, cell: usize, surfaces: &[(f64, u32)]) -> f64 {
        let is_earth = |(_, surface): &&(f64, u32)| self.storey.ground[*surface as usize].is_outdoors;
        let highest = surfaces.iter().filter(is_earth).map(|(z, _)| *z).reduce(f64::max);
        highest.or_else(|| self.holes.get(&cell).copied()).unwrap_or(f64::from(self.storey.floor_z))
    }

    fn choose(&mut self, there: &[u32], (floor, level): (&Mask, Option<&Mask>), [step, headroom]: [f64; 2]) {
        let width = self.width();
        let mut in_band: Vec<(usize, u32)> = Vec::new();
        let mut above: Vec<(f64, u32)> = Vec::new();
        for first in (self.rect.min[1]..self.rect.max[1]).step_by(BAND_ROWS as usize) {
            let band = CellRect {
                min: [self.rect.min[0], first],
                max: [self.rect.max[0], self.rect.max[1].min(first + BAND_ROWS)],
            };
            in_band.clear();
            for &k in there {
                let patch = &self.storey.ground[k as usize];
                if patch.rect.meets(&band) {
                    in_band.extend(band.clip(&patch.cells, width).flatten().map(|cell| (cell, k)));
                }
            }
            in_band.sort_unstable();
            for same in in_band.chunk_by(|a, b| a.0 == b.0) {
                let cell = same[0].0;
                if !floor.cells[cell] {
                    continue;
                }
                let (column, row) = ((cell % width) as u32, (cell / width) as u32);
                let middle = [f64::from(column) + 0.5, f64::from(row) + 0.5];
                above.clear();
                above.extend(same.iter().map(|&(_, k)| (self.z(k, middle), k)));
                let reference = level.map_or_else(|| self.earth_z(cell, &above), |_| f64::from(self.storey.floor_z));
                let off = |z: f64| (z - reference).abs();
                // A patch that begins here is the level floor of this place.
                if level.is_some_and(|level| level.cells[cell]) && above.iter().all(|(z, _)| off(*z) > step) {
                    above.push((f64::from(self.storey.floor_z), LEVEL));
                }
                above.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
                let is_roofed = |k: usize| above.get(k + 1).is_some_and(|next| next.0 - above[k].0 <= headroom);
                let is_filled = |surface: u32| {
                    self.above_patches.get(surface as usize).unwrap_or(&self.above_level).hold(column, row)
                };
                let is_open = |k: &usize| !is_roofed(*k) && (above.len() == 1 || !is_filled(above[*k].1));
                // Where the robot fits below none, what is in its way there closes the cell.
                let nearest = (0..above.len())
                    .min_by(|&a, &b| {
                        let is_closed = |k: usize| !is_open(&k);
                        is_closed(a).cmp(&is_closed(b)).then(off(above[a].0).total_cmp(&off(above[b].0)))
                    })
                    .map(|k| above[k]);
                let at = self.at(cell);
                self.of_cell[at] = nearest.map_or(LEVEL, |(_, k)| k);
            }
        }
    }

    /// Cells beside which the ground is lower by more than a step, or by more than one climbs on a patch.
    fn breaks(&self, floor: &Mask, step: i32) -> Vec<usize> {
        let climb = |surface: u32| self.storey.ground.get(surface as usize).map_or(step, |patch| patch.climb);
        let (width, height) = (self.width(), self.storey.spec.height as usize);
        let surface = |cell: usize| {
            let place = [(cell % width) as u32, (cell / width) as u32];
            let is_in = (0..2).all(|k| self.rect.min[k] <= place[k] && place[k] < self.rect.max[k]);
            if is_in { self.of_cell[self.at(cell)] } else { LEVEL }
        };
        let mut found = Vec::new();
        for cell in self.rect.rows(width).flatten().filter(|&cell| floor.cells[cell]) {
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
                let most = f64::from(climb(own).max(climb(beside))) + STEP_TOLERANCE;
                floor.cells[other] && beside != own && self.z(own, middle) - self.z(beside, middle) > most
            };
            if neighbours.into_iter().flatten().any(is_lower) {
                found.push(cell);
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

/// Heights of the terrain and roads beside the holes that these have under other ground, such as houses: for each cell of a hole that
/// of the nearest place beside it, along the cells of the hole.
fn earth_around_holes(storey: &StoreySlice, there: &[u32], floor: &Mask) -> HashMap<usize, f64> {
    let patches = || there.iter().map(|&k| &storey.ground[k as usize]);
    let (spec, width) = (&storey.spec, storey.spec.width as usize);
    let whole = CellRect::whole(spec.width, spec.height);
    let cells_of = |patch: &'_ GroundPatch| whole.clip(&patch.cells, width).flatten().collect::<Vec<usize>>();
    if patches().all(|patch| patch.is_outdoors) {
        return HashMap::new();
    }
    let mut earth = Mask::new(width, spec.height as usize);
    patches().filter(|patch| patch.is_outdoors).for_each(|patch| earth.set_runs(&patch.cells));
    let others = patches().filter(|patch| !patch.is_outdoors).flat_map(cells_of);
    let mut waiting: HashSet<usize> = others.filter(|&cell| floor.cells[cell] && !earth.cells[cell]).collect();
    let mut heights: HashMap<usize, f64> = HashMap::new();
    let beside = waiting.iter().flat_map(|&cell| spec.beside(cell)).filter(|&cell| earth.cells[cell]);
    let beside: HashSet<usize> = beside.collect();
    for patch in patches().filter(|patch| patch.is_outdoors) {
        for cell in whole.clip(&patch.cells, width).flatten().filter(|cell| beside.contains(cell)) {
            let highest = heights.entry(cell).or_insert(f64::NEG_INFINITY);
            *highest = highest.max(patch.z_of(cell, spec));
        }
    }
    let mut rim: Vec<usize> = heights.keys().copied().collect();
    while !rim.is_empty() {
        let mut reached: BTreeMap<usize, f64> = BTreeMap::new();
        for cell in rim {
            for beside in spec.beside(cell).filter(|beside| waiting.contains(beside)) {
                let highest = reached.entry(beside).or_insert(f64::NEG_INFINITY);
                *highest = highest.max(heights[&cell]);
            }
        }
        rim = reached.keys().copied().collect();
        rim.iter().for_each(|cell| {
            waiting.remove(cell);
        });
        heights.extend(reached);
    }
    heights
}

fn runs_of(mask: &Mask) -> Vec<Run> {
    let mut runs = Vec::new();
    for (row, cells) in (0..).zip(mask.cells.chunks_exact(mask.width.max(1))) {
        let mut from = 0;
        for same in cells.chunk_by(|a, b| a == b) {
            if same[0] {
                runs.push(Run { row, start: from as u32, end: (from + same.len()) as u32 });
            }
            from += same.len();
        }
    }
    runs
}
