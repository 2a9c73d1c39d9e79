//! Finds the patches of ground that the cells of a rectangle show, and the cells in which what stands on a patch is in the way: most
//! patches are below or above those that show, and nothing on them is looked at.

use crate::layers::cell_flags::FLOOR;
use crate::layers::shown_surface::LEVEL;
use crate::model::cell_area::to_tenths;
use crate::model::ground_patch::{STEP_TOLERANCE, are_apart, corner_middles, level_z, z_at};
use crate::model::storey_slice::StoreySlice;
use grid::CellRect;
use messages::RobotProfile;
use rustc_hash::FxHashMap;
use std::cell::Cell;

/// The patches that the cells of a rectangle show.
#[derive(Debug, Default)]
pub(crate) struct ShownPatches {
    /// By patch: around the cells that show it.
    around: FxHashMap<u32, CellRect>,
    /// Around cells without patch and without floor.
    without_floor: Option<CellRect>,
}

impl ShownPatches {
    /// Makes it what the cells of a rectangle show, by the patch and the flags of each cell of the storey.
    pub(crate) fn find(&mut self, patch_of: &[u32], flags: &[u8], rect: &CellRect, width: usize) {
        self.around.clear();
        self.without_floor = None;
        for (y, row) in (rect.min[1]..).zip(rect.rows(width)) {
            let mut from = 0;
            for same in patch_of[row.clone()].chunk_by(|a, b| a == b) {
                let cells = from..from + same.len();
                from = cells.end;
                let [start, end] = [cells.start, cells.end].map(|k| rect.min[0] + k as u32);
                let here = CellRect { min: [start, y], max: [end, y + 1] };
                if same[0] != LEVEL {
                    let around = self.around.entry(same[0]).or_insert(here);
                    *around = around.around_both(&here);
                } else if flags[row.clone()][cells].iter().any(|flags| flags & FLOOR == 0) {
                    self.without_floor = Some(self.without_floor.map_or(here, |around| around.around_both(&here)));
                }
            }
        }
    }

    /// The patches in any order, each with a rectangle around the cells that show it.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (u32, CellRect)> {
        self.around.iter().map(|(patch, around)| (*patch, *around))
    }
}

/// Where what stands on or beside a patch stands in the way.
pub(crate) struct StandsInWay<'a> {
    storey: &'a StoreySlice,
    /// The patch.
    k: u32,
    is_level: bool,
    /// Greatest difference of height to a patch that goes on from it.
    most: f64,
    /// The last level patch that a cell showed, and whether it goes on from this one, which is level, too: neighbours show the same.
    last: Cell<(u32, bool)>,
}

impl<'a> StandsInWay<'a> {
    pub(crate) fn of(storey: &'a StoreySlice, robot: &RobotProfile, k: u32) -> Self {
        let is_level = level_z(&storey.ground[k as usize].plane).is_some();
        let most = f64::from(to_tenths(robot.step_height_m)) + STEP_TOLERANCE;
        Self { storey, k, is_level, most, last: Cell::new((k, true)) }
    }

    /// True in a cell that shows the patch `shown`: in cells of the patch, in those of one that goes on from it, and where there is no
    /// floor.
    pub(crate) fn stands_on(&self, shown: u32, cell: usize, flags: u8) -> bool {
        if shown == LEVEL || shown == self.k {
            return shown == self.k || flags & FLOOR == 0;
        }
        let (last, goes_on) = self.last.get();
        if shown == last {
            return goes_on;
        }
        let [own, other] = [self.k, shown].map(|k| &self.storey.ground[k as usize]);
        let goes_on = (own.z_of(cell, &self.storey.spec) - other.z_of(cell, &self.storey.spec)).abs() <= self.most;
        if self.is_level && level_z(&other.plane).is_some() {
            self.last.set((shown, goes_on));
        }
        goes_on
    }

    /// Around the cells, of those of a rectangle, in which [`Self::stands_on`] may be true of what stands on the patch.
    pub(crate) fn around(&self, shown: &ShownPatches) -> Option<CellRect> {
        let stands = self.storey.ground[self.k as usize].stands?;
        let of_shown = shown.around.iter().filter(|(k, cells)| cells.meets(&stands) && self.may_go_on(**k, cells));
        CellRect::around_all(of_shown.map(|(_, cells)| *cells).chain(shown.without_floor))
    }

    /// False if a patch nowhere goes on from this one in the cells of a rectangle.
    fn may_go_on(&self, other: u32, cells: &CellRect) -> bool {
        let [own, other] = [self.k, other].map(|k| &self.storey.ground[k as usize].plane);
        let off = |place: [f64; 2]| z_at(own, place, &self.storey.spec) - z_at(other, place, &self.storey.spec);
        !are_apart(&corner_middles(cells).map(off), self.most)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::element_runs::ElementRuns;
    use crate::model::ground_patch::GroundPatch;
    use geometry::{MultiPolygon, Plane};
    use grid::{Class, GridSpec, Run};
    use proptest::prelude::*;

    const SPEC: GridSpec = GridSpec { cell_tenths: 100, first_cell: [0; 2], width: 40, height: 30 };

    /// A patch through three heights, on which something stands everywhere.
    fn patch([z, along_x, along_y]: [i32; 3]) -> GroundPatch {
        let runs: Vec<Run> = (0..SPEC.height).map(|row| Run { row, start: 0, end: SPEC.width }).collect();
        let rect = CellRect::whole(SPEC.width, SPEC.height);
        let wall = ElementRuns { element: 0, class: Class::Wall, rect: Some(rect), runs, door: None };
        GroundPatch {
            element: 0,
            is_outdoors: true,
            is_tread: false,
            climb: 0,
            plane: Plane::of(&[[0, 0, z], [4_000, 0, z + along_x], [0, 3_000, z + along_y]]),
            area: MultiPolygon::default(),
            cells: Vec::new(),
            rect,
            obstacles: vec![wall],
            lidar: Vec::new(),
            stands: Some(rect),
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(512))]
        #[test]
        fn what_stands_on_a_patch_is_looked_at_wherever_it_may_be_in_the_way(
            planes in prop::collection::vec([0i32..3_000, -2_000i32..2_000, -2_000i32..2_000], 1..5),
            boxes in prop::collection::vec((0u32..40, 0u32..30, 1u32..20, 1u32..20, 0u32..5, any::<bool>()), 0..6),
            corners in [0u32..40, 0u32..30, 1u32..40, 1u32..30],
        ) {
            let mut storey = StoreySlice::of_ground_outdoors(SPEC, 0);
            storey.ground = planes.into_iter().map(patch).collect();
            let whole = storey.whole();
            let (mut patch_of, mut flags) = (vec![LEVEL; SPEC.n_cells()], vec![FLOOR; SPEC.n_cells()]);
            for (x, y, w, h, k, has_floor) in boxes {
                let rect = CellRect { min: [x, y], max: [(x + w).min(40), (y + h).min(30)] };
                for cell in rect.rows(whole.width()).flatten() {
                    patch_of[cell] = if (k as usize) < storey.ground.len() { k } else { LEVEL };
                    flags[cell] = if has_floor { FLOOR } else { 0 };
                }
            }
            let [x, y, w, h] = corners;
            let rect = CellRect { min: [x, y], max: [(x + w).min(40), (y + h).min(30)] };
            let mut shown = ShownPatches::default();
            shown.find(&patch_of, &flags, &rect, whole.width());
            for k in 0..storey.ground.len() as u32 {
                let way = StandsInWay::of(&storey, &RobotProfile::DEFAULT, k);
                let around = way.around(&shown);
                for cell in rect.tiles(1) {
                    let at = cell.rows(whole.width()).next().unwrap().start;
                    let is_in = |around: Option<CellRect>| around.is_some_and(|around| around.meets(&cell));
                    prop_assert!(is_in(around) || !way.stands_on(patch_of[at], at, flags[at]), "{k} in {cell:?}");
                    prop_assert!(is_in(shown.around.get(&k).copied()) || patch_of[at] != k, "{k} in {cell:?}");
                }
            }
        }
    }
}
