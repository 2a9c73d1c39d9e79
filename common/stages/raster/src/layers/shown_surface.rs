//! Chooses the one of several surfaces above each other that cells show: for a cell, and for rectangles of cells at once.

use crate::model::band_surfaces::FILLED;
use crate::model::ground_patch::{GroundPatch, corner_middles, level_z, z_at};
use geometry::Plane;
use grid::{CellRect, GridSpec};

/// The surface of a cell that has no patch: the level of the storey's own floor.
pub(crate) const LEVEL: u32 = u32::MAX;

/// Heights that differ by less may be in either order in a cell between others, by rounding; in tenths of a millimetre.
const CLEAR: f64 = 1e-3;

/// Rectangles of fewer cells are looked at cell by cell.
const FEW_CELLS: usize = 4;

/// The one of several surfaces above each other that a cell shows: the nearest to a height of those below whose next one the robot
/// fits, and on which no body of ground is in its way. They are sorted by height then.
pub(crate) fn shown_surface(
    above: &mut [(f64, u32)],
    reference: f64,
    headroom: f64,
    is_filled: impl Fn(u32) -> bool,
) -> u32 {
    let order = |a: &(f64, u32), b: &(f64, u32)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
    // Mostly they are as those of the cell before.
    if !above.is_sorted_by(|a, b| order(a, b).is_le()) {
        above.sort_unstable_by(order);
    }
    let is_roofed = |k: usize| above.get(k + 1).is_some_and(|next| next.0 - above[k].0 <= headroom);
    let is_open = |k: usize| !is_roofed(k) && (above.len() == 1 || !is_filled(above[k].1));
    // Where the robot fits below none, what is in its way there closes the cell.
    let mut nearest: Option<(bool, f64, u32)> = None;
    for (k, &(z, surface)) in above.iter().enumerate() {
        let off = (z - reference).abs();
        let is_better = |is_closed: bool| nearest.is_none_or(|(closed, least, _)| (is_closed, off) < (closed, least));
        if is_better(false) {
            let is_closed = !is_open(k);
            if is_better(is_closed) {
                nearest = Some((is_closed, off, surface));
            }
        }
    }
    nearest.map_or(LEVEL, |(_, _, surface)| surface)
}

/// What is asked of a patch of ground in each of its cells.
#[derive(Debug)]
pub(crate) struct Surface {
    plane: Plane,
    /// Its height, if it is level.
    level_z: Option<f64>,
    is_outdoors: bool,
}

impl Surface {
    pub(crate) fn of(patch: &GroundPatch) -> Self {
        Self { plane: patch.plane, level_z: level_z(&patch.plane), is_outdoors: patch.is_outdoors }
    }

    fn z(&self, place: [f64; 2], spec: &GridSpec) -> f64 {
        self.level_z.unwrap_or_else(|| z_at(&self.plane, place, spec))
    }
}

/// Surfaces above each other outdoors, and which of them cells show: of those on which the robot fits the nearest to the highest
/// terrain or road.
pub(crate) struct Stack<'a> {
    pub(crate) spec: &'a GridSpec,
    /// By patch.
    pub(crate) all: &'a [Surface],
    /// Of the cells that are looked at: patches, with [`FILLED`] where a body stands on them.
    pub(crate) surfaces: &'a [u32],
    /// What the robot needs above a surface.
    pub(crate) headroom: f64,
}

/// Buffers of a [`Stack`].
#[derive(Debug, Default)]
pub(crate) struct StackBuffers {
    above: Vec<(f64, u32)>,
    at_corners: Vec<AtCorners>,
}

/// A surface at the corners of a rectangle.
#[derive(Debug, Clone, Copy)]
struct AtCorners {
    z: [f64; 4],
    surface: u32,
    is_level: bool,
    /// The robot fits below the next one, and no body is in its way.
    is_open: bool,
}

impl Stack<'_> {
    /// Calls `show` with rectangles that make up this one and the surface that their cells show. `reference` is the height of a cell
    /// where neither terrain nor road is; `None` for a cell whose surface does not count.
    pub(crate) fn choose(
        &self,
        buffers: &mut StackBuffers,
        rect: &CellRect,
        reference: &impl Fn(usize) -> Option<f64>,
        show: &mut impl FnMut(&CellRect, u32),
    ) {
        if let [] | [_] = self.surfaces {
            return show(rect, self.surfaces.first().map_or(LEVEL, |only| only & !FILLED));
        }
        if let Some(surface) = self.of_all_cells(buffers, rect, reference) {
            return show(rect, surface);
        }
        if rect.n_cells() < FEW_CELLS {
            for cell in rect.tiles(1) {
                let place = self.spec.width as usize * cell.min[1] as usize + cell.min[0] as usize;
                if let Some(reference) = reference(place) {
                    show(&cell, self.of_cell(buffers, &cell, reference));
                }
            }
            return;
        }
        let axis = usize::from(rect.width() < rect.height());
        let middle = rect.min[axis].midpoint(rect.max[axis]);
        let (mut low, mut high) = (*rect, *rect);
        (low.max[axis], high.min[axis]) = (middle, middle);
        self.choose(buffers, &low, reference, show);
        self.choose(buffers, &high, reference, show);
    }

    fn surface(&self, surface: u32) -> &Surface {
        &self.all[(surface & !FILLED) as usize]
    }

    fn of_cell(&self, buffers: &mut StackBuffers, cell: &CellRect, reference: f64) -> u32 {
        let middle = cell.min.map(|k| f64::from(k) + 0.5);
        let above = &mut buffers.above;
        above.clear();
        above.extend(self.surfaces.iter().map(|&k| (self.surface(k).z(middle, self.spec), k & !FILLED)));
        let earth = above.iter().filter(|(_, k)| self.surface(*k).is_outdoors).map(|(z, _)| *z).reduce(f64::max);
        let is_filled = |k: u32| self.surfaces.contains(&(k | FILLED));
        shown_surface(above, earth.unwrap_or(reference), self.headroom, is_filled)
    }

    /// The surface that all cells of a rectangle show, or one that would if no cell counts; `None` if the corners do not tell.
    ///
    /// Heights of planes and their differences are greatest and least at corners: what compares clearly and alike at all of them does so
    /// everywhere between.
    fn of_all_cells(
        &self,
        buffers: &mut StackBuffers,
        rect: &CellRect,
        reference: &impl Fn(usize) -> Option<f64>,
    ) -> Option<u32> {
        let corners = corner_middles(rect);
        let at_corners = &mut buffers.at_corners;
        at_corners.clear();
        at_corners.extend(self.surfaces.iter().map(|&surface| {
            let of = self.surface(surface);
            let z = corners.map(|corner| of.z(corner, self.spec));
            AtCorners { z, surface, is_level: of.level_z.is_some(), is_open: surface & FILLED == 0 }
        }));
        at_corners.sort_unstable_by(|a, b| {
            let patch = |of: &AtCorners| of.surface & !FILLED;
            a.z[0].total_cmp(&b.z[0]).then(patch(a).cmp(&patch(b)))
        });
        for k in 1..at_corners.len() {
            let (below, next) = (at_corners[k - 1], at_corners[k]);
            let gap = [0, 1, 2, 3].map(|k| next.z[k] - below.z[k]);
            let is_exact = below.is_level && next.is_level;
            if !is_exact && gap.iter().any(|gap| *gap <= CLEAR) {
                return None;
            }
            let is_roofed = gap[0] <= self.headroom;
            let is_clear = |gap: &f64| (gap - self.headroom).abs() > CLEAR && (*gap <= self.headroom) == is_roofed;
            if !is_exact && !gap.iter().all(is_clear) {
                return None;
            }
            at_corners[k - 1].is_open &= !is_roofed;
        }
        let references = self.references(at_corners, rect, reference);
        let is_same_everywhere = references.as_flattened().iter().all(|z| *z == references[0][0]);
        let any_is_open = at_corners.iter().any(|surface| surface.is_open);
        let candidates = || at_corners.iter().enumerate().filter(|(_, surface)| surface.is_open == any_is_open);
        let off = |surface: &AtCorners| (surface.z[0] - references[0][0]).abs();
        // The lower of two that are as near.
        let (shown, nearest) = candidates().reduce(|a, b| if off(b.1) < off(a.1) { b } else { a })?;
        let is_nearer_than = |(k, other): (usize, &AtCorners)| {
            let is_exact = is_same_everywhere && nearest.is_level && other.is_level;
            let is_same = nearest.is_level && other.is_level && nearest.z[0] == other.z[0];
            k == shown || is_exact || is_same || {
                let beyond_middle = |z: &[f64; 4], k: usize| z[k] * 2.0 - nearest.z[k] - other.z[k];
                let at_all = || references.iter().flat_map(|z| [0, 1, 2, 3].map(|k| beyond_middle(z, k)));
                if shown < k { at_all().all(|z| z <= -CLEAR) } else { at_all().all(|z| z > CLEAR) }
            }
        };
        candidates().all(is_nearer_than).then_some(nearest.surface & !FILLED)
    }

    /// The least and the greatest height at the corners of a rectangle to which surfaces are compared.
    fn references(
        &self,
        at_corners: &[AtCorners],
        rect: &CellRect,
        reference: &impl Fn(usize) -> Option<f64>,
    ) -> [[f64; 4]; 2] {
        let earth = || at_corners.iter().filter(|at| self.surface(at.surface).is_outdoors);
        if let Some(highest) = earth().next_back() {
            // They are in the same order everywhere.
            return [highest.z; 2];
        }
        let cells = || rect.rows(self.spec.width as usize).flatten();
        let (mut least, mut greatest) = (f64::INFINITY, f64::NEG_INFINITY);
        for z in cells().filter_map(reference) {
            (least, greatest) = (least.min(z), greatest.max(z));
        }
        // Where no cell counts any height will do.
        if least <= greatest { [[least; 4], [greatest; 4]] } else { [[0.0; 4]; 2] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const SPEC: GridSpec = GridSpec { cell_tenths: 100, first_cell: [0; 2], width: 40, height: 30 };

    /// Level, or rising along x or y, or both; some meet, some are the same.
    fn surface() -> impl Strategy<Value = Surface> {
        let z = prop::sample::select(vec![0, 50, 400, 900, 1_000, 1_900]);
        let rise = || prop::sample::select(vec![0, 0, 0, 100, -200, 700]);
        (z, rise(), rise(), any::<bool>()).prop_map(|(z, along_x, along_y, is_outdoors)| {
            let plane = Plane::of(&[[0, 0, z], [4_000, 0, z + along_x], [0, 3_000, z + along_y]]);
            Surface { plane, level_z: level_z(&plane), is_outdoors }
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2_048))]
        #[test]
        fn cells_of_a_rectangle_show_what_each_would_alone(
            all in prop::collection::vec(surface(), 0..7),
            is_filled in prop::collection::vec(prop::bool::weighted(0.2), 7),
            min in [0u32..35, 0u32..25],
            size in [1u32..36, 1u32..26],
            references in prop::collection::vec(prop::option::weighted(0.9, prop::sample::select(vec![0.0, 475.0, 700.0])), 1..5),
        ) {
            let filled = |k: u32| if is_filled[k as usize] { FILLED } else { 0 };
            let surfaces: Vec<u32> = (0..all.len() as u32).map(|k| k | filled(k)).collect();
            let stack = Stack { spec: &SPEC, all: &all, surfaces: &surfaces, headroom: 500.0 };
            let max = [(min[0] + size[0]).min(SPEC.width), (min[1] + size[1]).min(SPEC.height)];
            let rect = CellRect { min, max };
            let reference = |cell: usize| references[cell / 17 % references.len()];
            let (mut shown, mut buffers) = (vec![None; SPEC.n_cells()], StackBuffers::default());
            stack.choose(&mut buffers, &rect, &reference, &mut |cells, surface| {
                cells.rows(SPEC.width as usize).flatten().for_each(|cell| shown[cell] = Some(surface));
            });
            for cell in rect.tiles(1) {
                let at = (cell.min[1] * SPEC.width + cell.min[0]) as usize;
                if let Some(reference) = reference(at) {
                    let alone = match &*surfaces {
                        [only] => only & !FILLED,
                        _ => stack.of_cell(&mut buffers, &cell, reference),
                    };
                    prop_assert_eq!((cell, shown[at]), (cell, Some(alone)));
                }
            }
        }
    }
}
