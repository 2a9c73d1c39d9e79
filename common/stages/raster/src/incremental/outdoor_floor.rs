//! The floor of the ground outdoors: kept from one schedule state to the next, and made anew where finished elements differ.
//!
//! Which cells floor covers is kept by tiles, each for the sets of finished elements that were met; the surface that a cell
//! shows and where the ground breaks off are recomputed around what differs. All of it follows from the finished elements
//! alone, not from what was there before. After one pass through all states it allocates nothing.

use crate::layers::floor::{MAX_CACHED_BYTES, bit_is_set, set_bit};
use crate::layers::ground_floor::breaks_off;
use crate::layers::shown_surface::{LEVEL, Stack, StackBuffers, Surface};
use crate::model::band_surfaces::{BandSurfaces, Source, bands};
use crate::model::cell_area::{slab_above_floor, to_tenths};
use crate::model::gap::FLOOR_CRACK;
use crate::model::ground_patch::GroundPatch;
use crate::model::obstacle_squares::ObstacleSquares;
use crate::model::storey_inputs::StoreyInputs;
use crate::model::storey_slice::StoreySlice;
use geometry::{close_gaps, union_of};
use grid::{CellRect, GridSpec, Run, SparseCells, SparseLayer, covered_cells, join_rects};
use messages::NONE;
use rayon::prelude::*;
use std::collections::HashMap;

/// Columns and rows of the tiles in which floor is united.
const TILE_CELLS: u32 = 256;

/// Distance from a tile within which faces count for its floor, in tenths of a millimetre: more than the closing of cracks reaches.
const BESIDE_TILE: i32 = 500;

/// What is known of a cell.
mod bits {
    /// Floor covers it whole.
    pub(super) const COVERED: u8 = 1;
    /// Terrain or a road overlaps it.
    pub(super) const EARTH: u8 = 2;
    /// Other ground overlaps it.
    pub(super) const OTHER: u8 = 4;
    /// Covered, and the ground does not break off from it.
    pub(super) const FLOOR: u8 = 8;
    /// In a hole beside which there is earth, whose height is known.
    pub(super) const HAS_EARTH_BESIDE: u8 = 16;
    /// While holes are filled: in one that is looked at.
    pub(super) const OF_HOLE: u8 = 32;
    /// While holes are filled: earth beside them, or reached by a wave.
    pub(super) const OF_WAVE: u8 = 64;
    /// While holes are filled: what it shows is chosen anew anyway.
    pub(super) const DIRTY: u8 = 128;
}

/// The floor of a storey of the ground outdoors.
#[derive(Debug)]
pub(crate) struct OutdoorFloor {
    tiles: Vec<Tile>,
    patch_squares: ObstacleSquares,
    /// By patch: its floor index, or [`NONE`] for what is always there.
    index_of_patch: Vec<u32>,
    /// By patch: obstacles on it that are bodies of ground, and their floor index.
    bodies: Vec<Vec<(u32, u32)>>,
    surfaces: Vec<Surface>,
    /// By floor index: around its patches, and around its bodies on others.
    areas: Vec<[Option<CellRect>; 2]>,
    /// By floor index: true for terrain and roads.
    is_earth: Vec<bool>,
    /// The finished elements of what is kept; `None` before the first.
    finished: Option<Vec<u64>>,
    /// A byte of [`bits`] per cell.
    cells: Vec<u8>,
    /// Height of the earth beside the hole in which a cell lies.
    earth_beside: SparseLayer<f64>,
    buffers: Buffers,
}

/// What is reused from one update to the next.
#[derive(Debug, Default)]
struct Buffers {
    /// Where finished elements differ, and what follows from that.
    dirty: Vec<CellRect>,
    /// Of these, where holes of the earth may differ.
    of_holes: Vec<CellRect>,
    beside: Vec<CellRect>,
    before: Vec<u8>,
    near: Vec<u32>,
    in_band: BandSurfaces,
    stack: StackBuffers,
    row: Vec<bool>,
    shown: Vec<u32>,
    holes: Holes,
}

/// The holes of the earth that are looked at.
#[derive(Debug, Default)]
struct Holes {
    /// Their cells, hole by hole, each with the height that it had.
    cells: Vec<(usize, Option<f64>)>,
    /// Where the cells of each hole end.
    ends: Vec<usize>,
    /// Earth beside them, with its height.
    rim: Vec<(usize, f64)>,
    next: Vec<(usize, f64)>,
}

/// The cells that floor covers whole, in a part of the storey.
#[derive(Debug)]
struct Tile {
    rect: CellRect,
    /// With what counts for it beside.
    around: CellRect,
    /// Those that may cover cells of it.
    patches: Vec<u32>,
    /// Floor indices of these.
    elements: Vec<u32>,
    /// The bits of the finished ones of `elements`: those before, and those now; behind a word of zeros, so that none is empty
    /// but before the first.
    before: Vec<u64>,
    finished: Vec<u64>,
    covered: HashMap<Box<[u64]>, Vec<Run>>,
}

impl Tile {
    /// Makes the covered cells for these finished elements, if they were not made before; returns the bytes that it keeps more.
    fn prepare(&mut self, storey: &StoreySlice, index_of_patch: &[u32], finished: &[u64]) -> usize {
        let Self { rect, patches, elements, before, finished: own, covered, .. } = self;
        std::mem::swap(before, own);
        own.clear();
        own.push(0);
        for (k, index) in (0..).zip(&*elements) {
            set_bit(own, k + 64, bit_is_set(finished, *index));
        }
        if covered.contains_key(own.as_slice()) {
            return 0;
        }
        let is_there = |patch: u32| match index_of_patch[patch as usize] {
            NONE => true,
            index => bit_is_set(finished, index),
        };
        let areas = patches.iter().filter(|&&patch| is_there(patch)).map(|&patch| &storey.ground[patch as usize].area);
        let spec = GridSpec {
            first_cell: [0, 1].map(|k| storey.spec.first_cell[k] + rect.min[k] as i32),
            width: rect.width() as u32,
            height: rect.height() as u32,
            ..storey.spec
        };
        let mut runs = covered_cells(&close_gaps(&union_of(areas), FLOOR_CRACK), &spec);
        for run in &mut runs {
            let [column, row] = rect.min;
            *run = Run { row: run.row + row, start: run.start + column, end: run.end + column };
        }
        runs.shrink_to_fit();
        let bytes = size_of_val(runs.as_slice());
        covered.insert(own.as_slice().into(), runs);
        bytes
    }

    /// The covered cells before, of which none are known before the first, and those now.
    fn covered(&self) -> [&[Run]; 2] {
        [&self.before, &self.finished].map(|of| self.covered.get(of.as_slice()).map_or(&[][..], Vec::as_slice))
    }
}

impl OutdoorFloor {
    /// That of a storey before the first update.
    pub(crate) fn new(storey: &StoreySlice) -> Self {
        Self::in_tiles(storey, TILE_CELLS)
    }

    fn in_tiles(storey: &StoreySlice, side: u32) -> Self {
        let whole = storey.whole();
        // Sorted, as their floor indices are.
        let floors: Vec<u32> =
            storey.dependents.iter().filter(|d| d.floor_index.is_some()).map(|d| d.element).collect();
        let index_of = |element: u32| floors.binary_search(&element).map_or(NONE, |index| index as u32);
        let index_of_patch: Vec<u32> = storey.ground.iter().map(|patch| index_of(patch.element)).collect();
        let of_patch = |patch: &GroundPatch| -> Vec<(u32, u32)> {
            let bodies = (0..).zip(&patch.obstacles).map(|(k, body)| (k, index_of(body.element)));
            bodies.filter(|(_, index)| *index != NONE).collect()
        };
        let bodies: Vec<Vec<(u32, u32)>> = storey.ground.iter().map(of_patch).collect();
        let surfaces = storey.ground.iter().map(Surface::of).collect();
        let (mut areas, mut is_earth) = (vec![[None; 2]; floors.len()], vec![false; floors.len()]);
        let mut add = |index: u32, kind: usize, rect: CellRect| {
            let around: &mut Option<CellRect> = &mut areas[index as usize][kind];
            *around = Some(around.map_or(rect, |around| around.around_both(&rect)));
        };
        for ((patch, &index), bodies) in storey.ground.iter().zip(&index_of_patch).zip(&bodies) {
            if index != NONE {
                add(index, 0, patch.rect);
                is_earth[index as usize] |= patch.is_outdoors;
            }
            for &(body, index) in bodies {
                patch.obstacles[body as usize].rect.into_iter().for_each(|rect| add(index, 1, rect));
            }
        }
        let patch_squares = ObstacleSquares::of(storey.ground.iter().map(|patch| Some(patch.rect)), &storey.spec);
        let mut is_other = vec![false; storey.spec.n_cells()];
        for patch in storey.ground.iter().filter(|patch| !patch.is_outdoors) {
            whole.clip(&patch.cells, whole.width()).for_each(|cells| is_other[cells].fill(true));
        }
        let holes = SparseCells::of(is_other.len(), |cell| is_other[cell]);
        Self {
            tiles: whole.tiles(side).map(|rect| tile(storey, &patch_squares, &index_of_patch, rect)).collect(),
            patch_squares,
            index_of_patch,
            bodies,
            surfaces,
            areas,
            is_earth,
            finished: None,
            cells: vec![0; storey.spec.n_cells()],
            earth_beside: holes.layer(0.0),
            buffers: Buffers::default(),
        }
    }

    /// True for a cell of floor.
    pub(crate) fn is_floor(&self, cell: usize) -> bool {
        self.cells[cell] & bits::FLOOR != 0
    }

    /// The floor, as sorted runs.
    pub(crate) fn runs(&self, width: usize) -> Vec<Run> {
        let mut runs = Vec::new();
        for (row, cells) in (0..).zip(self.cells.chunks_exact(width.max(1))) {
            let mut from = 0;
            for same in cells.chunk_by(|a, b| (a ^ b) & bits::FLOOR == 0) {
                if same[0] & bits::FLOOR != 0 {
                    runs.push(Run { row, start: from as u32, end: (from + same.len()) as u32 });
                }
                from += same.len();
            }
        }
        runs
    }

    /// Makes it the floor of these finished elements, by floor index. `patch_of` is the patch that each cell shows, or [`LEVEL`].
    /// Rectangles around the cells whose floor or patch is another one are added to `differing`.
    pub(crate) fn update(
        &mut self,
        inputs: StoreyInputs<'_>,
        finished: &[u64],
        patch_of: &mut [u32],
        differing: &mut Vec<CellRect>,
    ) {
        let Self { finished: kept, areas, is_earth, buffers, .. } = self;
        let Buffers { dirty, of_holes, .. } = buffers;
        dirty.clear();
        of_holes.clear();
        match kept {
            None => dirty.push(inputs.storey.whole()),
            Some(kept) => {
                let all = (0..).zip(&*areas).zip(&*is_earth);
                for ((_, areas), &is_earth) in
                    all.filter(|((k, _), _)| bit_is_set(kept, *k) != bit_is_set(finished, *k))
                {
                    dirty.extend(areas.iter().flatten());
                    of_holes.extend(areas[0].filter(|_| is_earth));
                }
            }
        }
        let kept = kept.get_or_insert_default();
        kept.clear();
        kept.extend_from_slice(finished);
        if dirty.is_empty() {
            return;
        }
        join_rects(dirty);
        self.cover(inputs.storey);
        self.find_ground(inputs.storey);
        self.fill_holes(inputs.storey);
        join_rects(&mut self.buffers.dirty);
        self.choose(inputs, patch_of, differing);
        self.find_breaks(inputs, patch_of, differing);
    }

    /// Looks which cells are covered, in all tiles that meet what is dirty. What differs beside that is dirty, too.
    fn cover(&mut self, storey: &StoreySlice) {
        let width = storey.spec.width as usize;
        let Self { tiles, index_of_patch, finished, cells, buffers, .. } = self;
        let Buffers { dirty, of_holes, beside, .. } = buffers;
        let finished = finished.as_deref().unwrap_or_default();
        let is_dirty = |tile: &Tile| dirty.iter().any(|rect| rect.meets(&tile.around));
        let prepare = |tile: &mut Tile| if is_dirty(tile) { tile.prepare(storey, index_of_patch, finished) } else { 0 };
        let bytes: usize = tiles.par_iter_mut().map(prepare).sum();
        beside.clear();
        for tile in tiles.iter().filter(|tile| is_dirty(tile)) {
            let [mut around, mut around_holes]: [Option<CellRect>; 2] = [None; 2];
            let mut runs = tile.covered();
            for row in tile.rect.min[1]..tile.rect.max[1] {
                let [old, new] = runs.map(|runs| runs.split_at(runs.partition_point(|run| run.row <= row)));
                runs = [old.1, new.1];
                if old.0 == new.0 {
                    continue;
                }
                let place =
                    |run: &Run| row as usize * width + run.start as usize..row as usize * width + run.end as usize;
                old.0.iter().for_each(|run| cells[place(run)].iter_mut().for_each(|cell| *cell &= !bits::COVERED));
                new.0.iter().for_each(|run| cells[place(run)].iter_mut().for_each(|cell| *cell |= bits::COVERED));
                let both = || old.0.iter().chain(new.0);
                let (Some(start), Some(end)) = (both().map(|run| run.start).min(), both().map(|run| run.end).max())
                else {
                    continue;
                };
                let here = CellRect { min: [start, row], max: [end, row + 1] };
                around = Some(around.map_or(here, |around| around.around_both(&here)));
                let is_other = |cell: &u8| cell & (bits::EARTH | bits::OTHER) == bits::OTHER;
                let of_row = || here.rows(width).flat_map(|row| &cells[row]);
                if of_row().any(is_other) {
                    around_holes = Some(around_holes.map_or(here, |around| around.around_both(&here)));
                }
            }
            let is_within = |inner: &CellRect| {
                dirty.iter().any(|rect| (0..2).all(|k| rect.min[k] <= inner.min[k] && inner.max[k] <= rect.max[k]))
            };
            beside.extend(around.filter(|around| !is_within(around)));
            of_holes.extend(around_holes);
        }
        dirty.append(beside);
        join_rects(dirty);
        self.limit_cache(bytes);
    }

    /// Forgets what tiles keep, but for what is in use, if that is too much.
    fn limit_cache(&mut self, more: usize) {
        if more == 0 {
            return;
        }
        let runs = self.tiles.iter().flat_map(|tile| tile.covered.values());
        if runs.map(|runs| size_of_val(runs.as_slice())).sum::<usize>() <= MAX_CACHED_BYTES {
            return;
        }
        for Tile { covered, finished, .. } in &mut self.tiles {
            covered.retain(|of, _| **of == **finished);
        }
    }

    /// Looks where earth and other ground is, in what is dirty.
    fn find_ground(&mut self, storey: &StoreySlice) {
        let width = storey.spec.width as usize;
        let Self { patch_squares, index_of_patch, finished, cells, buffers, .. } = self;
        let finished = finished.as_deref().unwrap_or_default();
        let Buffers { dirty, of_holes, before, near, .. } = buffers;
        for rect in dirty.iter() {
            before.clear();
            for row in rect.rows(width) {
                before.extend_from_slice(&cells[row.clone()]);
                cells[row].iter_mut().for_each(|cell| *cell &= !(bits::EARTH | bits::OTHER));
            }
            find_near(near, rect, patch_squares, index_of_patch, finished);
            for patch in near.iter().map(|&k| &storey.ground[k as usize]) {
                let bit = if patch.is_outdoors { bits::EARTH } else { bits::OTHER };
                rect.clip(&patch.cells, width).flatten().for_each(|cell| cells[cell] |= bit);
            }
            let mut around = None;
            let rows = (rect.min[1]..).zip(rect.rows(width)).zip(before.chunks_exact(rect.width().max(1)));
            for ((y, row), before) in rows {
                let differs = |(a, b): (&u8, &u8)| is_of_hole(*a) != is_of_hole(*b) || (a ^ b) & bits::EARTH != 0;
                add_row(&mut around, || cells[row.clone()].iter().zip(before).map(differs), [rect.min[0], y]);
            }
            of_holes.extend(around);
        }
    }

    /// Finds the heights of the earth beside the holes that it has under other ground, such as houses: for each cell of a hole
    /// that of the nearest place beside it, along the cells of the hole. What differs is dirty, too.
    fn fill_holes(&mut self, storey: &StoreySlice) {
        let width = storey.spec.width as usize;
        let whole = storey.whole();
        let Self { patch_squares, index_of_patch, finished, cells, earth_beside, buffers, .. } = self;
        let finished = finished.as_deref().unwrap_or_default();
        let Buffers { dirty, of_holes, near, holes, .. } = buffers;
        holes.cells.clear();
        holes.ends.clear();
        holes.rim.clear();
        join_rects(of_holes);
        for row in of_holes.iter().flat_map(|rect| rect.rows(width)) {
            for cell in &mut cells[row] {
                *cell = *cell & !bits::HAS_EARTH_BESIDE | if is_of_hole(*cell) { bits::DIRTY } else { 0 };
            }
        }
        for rect in of_holes.iter() {
            for cell in rect.grown(1, &whole).rows(width).flatten() {
                if is_of_hole(cells[cell]) {
                    holes.find(cell, &storey.spec, (cells, earth_beside));
                }
            }
        }
        holes.rim.sort_unstable_by_key(|(cell, _)| *cell);
        if let Some(rect) = around_cells(holes.rim.iter().map(|(cell, _)| *cell), width) {
            find_near(near, &rect, patch_squares, index_of_patch, finished);
            let earth = near.iter().map(|&k| &storey.ground[k as usize]).filter(|patch| patch.is_outdoors);
            for patch in earth {
                for run in rect.clip(&patch.cells, width) {
                    let from = holes.rim.partition_point(|(cell, _)| *cell < run.start);
                    for (cell, z) in holes.rim[from..].iter_mut().take_while(|(cell, _)| *cell < run.end) {
                        *z = z.max(patch.z_of(*cell, &storey.spec));
                    }
                }
            }
        }
        holes.rim.iter().for_each(|(cell, _)| cells[*cell] &= !bits::OF_WAVE);
        holes.spread(&storey.spec, (cells, earth_beside));
        let mut begin = 0;
        for &end in &holes.ends {
            let hole = &holes.cells[begin..end];
            begin = end;
            let now = |cell: usize| (cells[cell] & bits::HAS_EARTH_BESIDE != 0).then(|| earth_beside[cell]);
            let differs =
                |(cell, before): &&(usize, Option<f64>)| cells[*cell] & bits::DIRTY == 0 && now(*cell) != *before;
            dirty.extend(around_cells(hole.iter().filter(differs).map(|(cell, _)| *cell), width));
            hole.iter().for_each(|(cell, _)| cells[*cell] &= !(bits::OF_HOLE | bits::DIRTY));
        }
    }

    /// Chooses the surface that each dirty cell shows: of those above each other on which the robot fits the nearest to the
    /// highest terrain or road of the cell, in a hole of these to that beside the hole, and where nothing is beside it to the
    /// height of the map storey, the median of all ground.
    fn choose(&mut self, inputs: StoreyInputs<'_>, patch_of: &mut [u32], differing: &mut Vec<CellRect>) {
        let StoreyInputs { robot, storey, .. } = inputs;
        let width = storey.spec.width as usize;
        let headroom = f64::from(slab_above_floor(robot)[1]);
        let Self {
            patch_squares, index_of_patch, bodies, surfaces: all, finished, cells, earth_beside, buffers, ..
        } = self;
        let finished = finished.as_deref().unwrap_or_default();
        let Buffers { dirty, near, in_band, stack, shown, .. } = buffers;
        let is_covered = |cell: usize| cells[cell] & bits::COVERED != 0;
        let reference = |cell: usize| {
            let is_in_hole = cells[cell] & bits::HAS_EARTH_BESIDE != 0;
            is_covered(cell).then(|| if is_in_hole { earth_beside[cell] } else { f64::from(storey.floor_z) })
        };
        for band in dirty.iter().flat_map(bands) {
            find_near(near, &band, patch_squares, index_of_patch, finished);
            let of_patch = |&k: &u32| {
                let there = bodies[k as usize].iter().filter(|(_, index)| bit_is_set(finished, *index));
                let body = move |body: u32| &storey.ground[k as usize].obstacles[body as usize];
                let in_band = move |at: &u32| body(*at).rect.is_some_and(|rect| rect.meets(&band));
                there.map(|(body, _)| *body).filter(in_band).map(move |body| Source { surface: k, body })
            };
            let runs = |Source { surface, body }: Source| {
                let patch = &storey.ground[surface as usize];
                patch.obstacles.get(body as usize).map_or(patch.cells.as_slice(), |body| body.runs.as_slice())
            };
            shown.clear();
            shown.resize(band.n_cells(), LEVEL);
            let patches = near.iter().filter(|k| storey.ground[**k as usize].rect.meets(&band));
            let patches = patches.map(|&surface| Source { surface, body: NONE });
            let sources = patches.chain(near.iter().flat_map(of_patch));
            in_band.rects(&band, sources, runs, |rect, surfaces| {
                let surfaces = Stack { spec: &storey.spec, all, surfaces, headroom };
                surfaces.choose(stack, &rect, &reference, &mut |rect, surface| {
                    let in_band = CellRect {
                        min: [0, 1].map(|k| rect.min[k] - band.min[k]),
                        max: [0, 1].map(|k| rect.max[k] - band.min[k]),
                    };
                    for (row, at) in rect.rows(width).zip(in_band.rows(band.width())) {
                        let of_row = cells[row].iter().zip(&mut shown[at]);
                        of_row
                            .for_each(|(cell, shown)| *shown = if cell & bits::COVERED != 0 { surface } else { LEVEL });
                    }
                });
            });
            let mut around = None;
            for ((y, row), shown) in (band.min[1]..).zip(band.rows(width)).zip(shown.chunks_exact(band.width().max(1)))
            {
                let changes = || patch_of[row.clone()].iter().zip(shown).map(|(a, b)| a != b);
                add_row(&mut around, changes, [band.min[0], y]);
                patch_of[row].copy_from_slice(shown);
            }
            differing.extend(around);
        }
    }

    /// Looks from which cells the ground breaks off, in what is dirty and the cells beside it.
    fn find_breaks(&mut self, inputs: StoreyInputs<'_>, patch_of: &[u32], differing: &mut Vec<CellRect>) {
        let StoreyInputs { robot, storey, .. } = inputs;
        let (width, whole) = (storey.spec.width as usize, storey.whole());
        let step = to_tenths(robot.step_height_m);
        let Self { cells, buffers, .. } = self;
        let Buffers { dirty, row: is_floor, .. } = buffers;
        for rect in dirty.iter().flat_map(|rect| rect.grown(1, &whole).tiles(TILE_CELLS)) {
            let mut around = None;
            for (y, row) in (rect.min[1]..).zip(rect.rows(width)) {
                let is_inner = 0 < y && y + 1 < storey.spec.height;
                is_floor.clear();
                is_floor.extend(row.clone().map(|cell| {
                    let is_covered = |cell: usize| cells[cell] & bits::COVERED != 0;
                    let is_level = || {
                        let beside = [cell - 1, cell + 1, cell - width, cell + width];
                        beside.iter().all(|beside| patch_of[*beside] == patch_of[cell])
                    };
                    is_covered(cell)
                        && (is_inner && is_level()
                            || !breaks_off(storey, step, cell, |cell| patch_of[cell], is_covered))
                }));
                let changes =
                    || cells[row.clone()].iter().zip(&*is_floor).map(|(cell, now)| (cell & bits::FLOOR != 0) != *now);
                add_row(&mut around, changes, [rect.min[0], y]);
                for (cell, &is_floor) in cells[row].iter_mut().zip(&*is_floor) {
                    *cell = *cell & !bits::FLOOR | if is_floor { bits::FLOOR } else { 0 };
                }
            }
            differing.extend(around);
        }
    }
}

impl Holes {
    /// Finds the hole of a cell, if it was not found, and the earth beside it. Heights are taken from its cells.
    fn find(&mut self, seed: usize, spec: &GridSpec, (cells, earth_beside): (&mut [u8], &SparseLayer<f64>)) {
        if cells[seed] & bits::OF_HOLE != 0 {
            return;
        }
        let add = |found: &mut Vec<(usize, Option<f64>)>, cell: usize, state: &mut u8| {
            let before = (*state & bits::HAS_EARTH_BESIDE != 0).then(|| earth_beside[cell]);
            *state = *state & !bits::HAS_EARTH_BESIDE | bits::OF_HOLE;
            found.push((cell, before));
        };
        let mut at = self.cells.len();
        add(&mut self.cells, seed, &mut cells[seed]);
        while at < self.cells.len() {
            for beside in spec.beside(self.cells[at].0) {
                let state = &mut cells[beside];
                if is_of_hole(*state) && *state & bits::OF_HOLE == 0 {
                    add(&mut self.cells, beside, state);
                } else if *state & (bits::EARTH | bits::OF_WAVE) == bits::EARTH {
                    *state |= bits::OF_WAVE;
                    self.rim.push((beside, f64::NEG_INFINITY));
                }
            }
            at += 1;
        }
        self.ends.push(self.cells.len());
    }

    /// Gives each cell the height of the nearest earth, of several the highest: in waves from the rim inwards.
    fn spread(&mut self, spec: &GridSpec, (cells, earth_beside): (&mut [u8], &mut SparseLayer<f64>)) {
        let Self { rim: wave, next, .. } = self;
        while !wave.is_empty() {
            next.clear();
            for &(cell, z) in wave.iter() {
                for beside in spec.beside(cell) {
                    let state = &mut cells[beside];
                    if *state & (bits::OF_HOLE | bits::HAS_EARTH_BESIDE) != bits::OF_HOLE {
                        continue;
                    }
                    if *state & bits::OF_WAVE == 0 {
                        *state |= bits::OF_WAVE;
                        earth_beside[beside] = z;
                        next.push((beside, z));
                    } else if earth_beside[beside] < z {
                        earth_beside[beside] = z;
                    }
                }
            }
            for (cell, z) in next.iter_mut() {
                cells[*cell] = cells[*cell] & !bits::OF_WAVE | bits::HAS_EARTH_BESIDE;
                *z = earth_beside[*cell];
            }
            std::mem::swap(wave, next);
        }
    }
}

/// True for a cell of floor under which there is no earth.
fn is_of_hole(cell: u8) -> bool {
    cell & (bits::COVERED | bits::OTHER | bits::EARTH) == bits::COVERED | bits::OTHER
}

fn tile(storey: &StoreySlice, squares: &ObstacleSquares, index_of_patch: &[u32], rect: CellRect) -> Tile {
    let cell = storey.spec.cell_tenths.unsigned_abs();
    let around = rect.grown(BESIDE_TILE.unsigned_abs().div_ceil(cell).max(2), &storey.whole());
    let mut patches: Vec<u32> = squares.around(around).collect();
    patches.sort_unstable();
    patches.dedup();
    patches.retain(|&k| around.clip(&storey.ground[k as usize].cells, storey.spec.width as usize).next().is_some());
    let mut elements: Vec<u32> = patches.iter().map(|&k| index_of_patch[k as usize]).filter(|k| *k != NONE).collect();
    elements.sort_unstable();
    elements.dedup();
    Tile { rect, around, patches, elements, before: Vec::new(), finished: Vec::new(), covered: HashMap::new() }
}

/// Finds the finished patches that may meet a rectangle, in their order.
fn find_near(
    near: &mut Vec<u32>,
    rect: &CellRect,
    squares: &ObstacleSquares,
    index_of_patch: &[u32],
    finished: &[u64],
) {
    let is_there = |k: &u32| match index_of_patch[*k as usize] {
        NONE => true,
        index => bit_is_set(finished, index),
    };
    near.clear();
    near.extend(squares.around(*rect).filter(is_there));
    near.sort_unstable();
    near.dedup();
}

/// Extends a rectangle to the cells of a row, which begins at a column and row, that differ.
fn add_row<I>(around: &mut Option<CellRect>, differs: impl Fn() -> I, [column, row]: [u32; 2])
where
    I: ExactSizeIterator<Item = bool> + DoubleEndedIterator,
{
    let is = |differs: bool| differs;
    let (Some(first), Some(last)) = (differs().position(is), differs().rposition(is)) else { return };
    let [start, end] = [first, last + 1].map(|k| column + k as u32);
    let here = CellRect { min: [start, row], max: [end, row + 1] };
    *around = Some(around.map_or(here, |around| around.around_both(&here)));
}

/// The rectangle around cells by index; `None` if there are none.
fn around_cells(cells: impl Iterator<Item = usize>, width: usize) -> Option<CellRect> {
    let places = cells.map(|cell| [cell % width, cell / width].map(|k| k as u32));
    let rects = places.map(|place| CellRect { min: place, max: place.map(|k| k + 1) });
    CellRect::around_all(rects)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::element_runs::ElementRuns;
    use crate::model::storey_slice::Dependent;
    use geometry::{FillRule, MultiPolygon, Plane, union};
    use grid::{Class, Mask, overlapped_cells};
    use messages::{RobotProfile, Site, SiteBuilder};
    use proptest::prelude::*;
    use std::collections::{BTreeMap, BTreeSet};

    const WIDTH: u32 = 70;
    const HEIGHT: u32 = 50;

    /// Ground over a rectangle in tenths of a millimetre that rises along x.
    #[derive(Debug, Clone)]
    struct Piece {
        min: [i32; 2],
        size: [i32; 2],
        z: [i32; 2],
        is_outdoors: bool,
        is_always_there: bool,
        /// Where a body of it stands on all that is below.
        body: Option<([i32; 2], [i32; 2])>,
    }

    fn piece() -> impl Strategy<Value = Piece> {
        let place = || ([-200..6_500i32, -200..4_500i32], [100..5_000i32, 100..4_000i32]);
        // Two heights between which the robot fits, and some near the lower one.
        let z = prop::sample::select(vec![[0, 0], [0, 0], [200, 200], [0, 900], [20_000, 20_000], [20_000, 20_000]]);
        let body = prop::option::weighted(0.3, place());
        (place(), z, 0..4u8, any::<bool>(), body).prop_map(|((min, size), z, kind, is_always_there, body)| Piece {
            min,
            size,
            z,
            is_outdoors: kind == 0,
            is_always_there: kind == 0 && is_always_there,
            body,
        })
    }

    fn rectangle(min: [i32; 2], size: [i32; 2]) -> MultiPolygon {
        let [[x0, y0], [x1, y1]] = [min, [min[0] + size[0], min[1] + size[1]]];
        union(&[vec![[x0, y0], [x1, y0], [x1, y1], [x0, y1]]], FillRule::NonZero)
    }

    fn storey(pieces: &[Piece]) -> StoreySlice {
        let spec = GridSpec { cell_tenths: 100, first_cell: [0; 2], width: WIDTH, height: HEIGHT };
        let mut storey = StoreySlice::of_ground_outdoors(spec, 100);
        let body = |element: u32, (min, size)| {
            let runs = overlapped_cells(&rectangle(min, size), &[], &spec);
            ElementRuns { element, class: Class::Slab, rect: CellRect::around(&runs), runs, door: None }
        };
        let bodies = || (0..).zip(pieces).filter(|(_, piece)| !piece.is_always_there);
        for (element, piece) in (0..).zip(pieces) {
            let area = rectangle(piece.min, piece.size);
            let cells = overlapped_cells(&area, &[], &spec);
            let Some(rect) = CellRect::around(&cells) else { continue };
            let ([x0, y0], [w, h], [from, to]) = (piece.min, piece.size, piece.z);
            storey.ground.push(GroundPatch {
                element: if piece.is_always_there { NONE } else { element },
                is_outdoors: piece.is_outdoors,
                is_tread: false,
                climb: 500,
                plane: Plane::of(&[[x0, y0, from], [x0 + w, y0, to], [x0, y0 + h, from]]),
                area,
                cells,
                rect: rect.grown(2, &storey.whole()),
                obstacles: bodies().filter_map(|(k, piece)| Some(body(k, piece.body?))).collect(),
                lidar: Vec::new(),
                stands: None,
            });
        }
        let floors = storey.ground.iter().map(|patch| patch.element).filter(|element| *element != NONE);
        let dependent = |(index, element)| Dependent {
            element,
            cells: None,
            floor_index: Some(index),
            floor: None,
            overhead: None,
        };
        storey.dependents = (0..).zip(floors).map(dependent).collect();
        storey
    }

    /// Floor and patch of each cell, from all of the storey at once.
    fn at_once(storey: &StoreySlice, robot: &RobotProfile, is_finished: impl Fn(u32) -> bool) -> Vec<(bool, u32)> {
        let spec = storey.spec;
        let there: Vec<(u32, &GroundPatch)> =
            (0..).zip(&storey.ground).filter(|(_, p)| p.element == NONE || is_finished(p.element)).collect();
        let mut covered = Mask::new(WIDTH as usize, HEIGHT as usize);
        let areas = there.iter().map(|(_, patch)| &patch.area);
        covered.set_runs(&covered_cells(&close_gaps(&union_of(areas), FLOOR_CRACK), &spec));
        let has = |runs: &[Run], cell: usize| {
            let (column, row) = ((cell % WIDTH as usize) as u32, (cell / WIDTH as usize) as u32);
            runs.iter().any(|run| run.row == row && run.start <= column && column < run.end)
        };
        let cells = 0..covered.cells.len();
        let of_cell: Vec<Vec<u32>> = cells
            .clone()
            .map(|cell| there.iter().filter(|(_, p)| has(&p.cells, cell)).map(|(k, _)| *k).collect())
            .collect();
        let z = |k: u32, cell: usize| storey.ground[k as usize].z_of(cell, &spec);
        let earth_z = |cell: usize| {
            let earth = of_cell[cell].iter().filter(|k| storey.ground[**k as usize].is_outdoors);
            earth.map(|k| z(*k, cell)).reduce(f64::max)
        };
        // Heights spread from the earth beside holes, one ring of cells after the other.
        let mut heights: BTreeMap<usize, f64> = cells.clone().filter_map(|cell| Some((cell, earth_z(cell)?))).collect();
        let mut waiting: BTreeSet<usize> =
            cells.clone().filter(|&cell| covered.cells[cell] && earth_z(cell).is_none()).collect();
        loop {
            let highest = |cell: usize| spec.beside(cell).filter_map(|k| heights.get(&k).copied()).reduce(f64::max);
            let ring: Vec<(usize, f64)> = waiting.iter().filter_map(|&cell| Some((cell, highest(cell)?))).collect();
            if ring.is_empty() {
                break;
            }
            for (cell, _) in &ring {
                waiting.remove(cell);
            }
            heights.extend(ring);
        }
        let headroom = f64::from(slab_above_floor(robot)[1]);
        let shown = |cell: usize| {
            let mut above: Vec<(f64, u32)> = of_cell[cell].iter().map(|&k| (z(k, cell), k)).collect();
            above.sort_by(|a, b| a.partial_cmp(b).unwrap());
            let reference = heights.get(&cell).copied().unwrap_or(f64::from(storey.floor_z));
            let ranked = above.iter().enumerate().map(|(n, &(z, k))| {
                let is_roofed = above.get(n + 1).is_some_and(|next| next.0 - z <= headroom);
                let bodies = || storey.ground[k as usize].obstacles.iter();
                let is_ground = |element: u32| storey.dependents.iter().any(|dependent| dependent.element == element);
                let stands = |element: u32| is_ground(element) && is_finished(element);
                let is_filled = || bodies().any(|body| stands(body.element) && has(&body.runs, cell));
                (is_roofed || above.len() > 1 && is_filled(), (z - reference).abs(), k)
            });
            // The lower of two that are as near.
            let best = ranked.reduce(|a, b| if (b.0, b.1) < (a.0, a.1) { b } else { a });
            if covered.cells[cell] { best.map_or(LEVEL, |(_, _, k)| k) } else { LEVEL }
        };
        let shown: Vec<u32> = cells.clone().map(shown).collect();
        let step = to_tenths(robot.step_height_m);
        let breaks = |cell: usize| breaks_off(storey, step, cell, |k| shown[k], |k| covered.cells[k]);
        cells.map(|cell| (covered.cells[cell] && !breaks(cell), shown[cell])).collect()
    }

    /// Floor that is kept from one set of finished pieces to the next, of which each differs by one piece, against floor that is
    /// made at once.
    fn check(pieces: &[Piece], built_first: u16, changes: &[u32], side: u32) -> Result<(), TestCaseError> {
        let site = SiteBuilder::default().finish();
        let site = Site::open(site.bytes()).unwrap();
        let storey = storey(pieces);
        let robot = RobotProfile::DEFAULT;
        let inputs = StoreyInputs { site: &site, robot: &robot, storey: &storey };
        let mut kept = OutdoorFloor::in_tiles(&storey, side);
        let mut patch_of = vec![LEVEL; storey.spec.n_cells()];
        let mut before = vec![(false, LEVEL); storey.spec.n_cells()];
        let mut built = built_first;
        for element in changes {
            built ^= 1 << element;
            let is_finished = |element: u32| built >> element & 1 == 1;
            let mut finished = Vec::new();
            for dependent in &storey.dependents {
                set_bit(&mut finished, dependent.floor_index.unwrap(), is_finished(dependent.element));
            }
            let mut differing = Vec::new();
            kept.update(inputs, &finished, &mut patch_of, &mut differing);
            let expected = at_once(&storey, &robot, is_finished);
            for (cell, expected) in expected.iter().enumerate() {
                let place = storey.spec.cell_of(cell);
                prop_assert_eq!((place, (kept.is_floor(cell), patch_of[cell])), (place, *expected));
                let [x, y] = [place.column, place.row];
                let is_in = |rect: &CellRect| rect.meets(&CellRect { min: [x, y], max: [x + 1, y + 1] });
                prop_assert!(before[cell] == *expected || differing.iter().any(is_in), "{place:?} is not told");
            }
            before = expected;
        }
        let mut mask = Mask::new(WIDTH as usize, HEIGHT as usize);
        mask.set_runs(&kept.runs(WIDTH as usize));
        prop_assert!(mask.cells.iter().zip(&before).all(|(floor, (expected, _))| floor == expected));
        Ok(())
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(512))]
        #[test]
        fn floor_that_is_kept_is_floor_that_is_made_at_once(
            pieces in prop::collection::vec(piece(), 1..12),
            built_first in any::<u16>(),
            changes in prop::collection::vec(0..12u32, 1..10),
            side in prop::sample::select(vec![7, 16, 64, 256]),
        ) {
            check(&pieces, built_first, &changes, side)?;
        }
    }

    #[test]
    fn a_hole_follows_earth_that_rises_and_falls_where_other_earth_stays() {
        let piece = |min, size, z: i32, is_outdoors: bool| Piece {
            min,
            size,
            z: [z; 2],
            is_outdoors,
            is_always_there: false,
            body: None,
        };
        let pieces = [
            piece([0, 0], [2_000, 5_000], 0, true),
            piece([0, 0], [2_000, 5_000], 20_000, true),
            piece([2_000, 1_000], [4_000, 2_000], 0, false),
            piece([2_000, 1_000], [4_000, 2_000], 20_000, false),
        ];
        check(&pieces, 0b1101, &[1, 1, 0, 1, 0], 16).unwrap();
    }
}
