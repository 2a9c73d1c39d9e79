//! Which patches of ground the cells of a rectangle show, and where what stands on a patch is in the way: most patches are below
//! or above those that show, and nothing on them is looked at.

use crate::layers::cell_flags::FLOOR;
use crate::layers::ground_floor::LEVEL;
use crate::model::cell_area::to_tenths;
use crate::model::ground_patch::{GroundPatch, STEP_TOLERANCE, level_z, z_at};
use crate::model::storey_slice::StoreySlice;
use grid::{CellRect, GridSpec};
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

    /// Around the cells that show a patch.
    pub(crate) fn around(&self, patch: u32) -> Option<CellRect> {
        self.around.get(&patch).copied()
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
        let GroundPatch { obstacles, lidar, .. } = &self.storey.ground[self.k as usize];
        let rects = obstacles.iter().chain(lidar).filter_map(|element| element.rect);
        let stands = rects.reduce(|a, b| a.around_both(&b))?;
        let of_shown = shown.around.iter().filter(|(k, cells)| cells.meets(&stands) && self.may_go_on(**k, cells));
        let all = of_shown.map(|(_, cells)| *cells).chain(shown.without_floor);
        all.reduce(|a, b| a.around_both(&b))
    }

    /// False if a patch nowhere goes on from this one in the cells of a rectangle.
    fn may_go_on(&self, other: u32, cells: &CellRect) -> bool {
        let spec: &GridSpec = &self.storey.spec;
        let [own, other] = [self.k, other].map(|k| &self.storey.ground[k as usize].plane);
        // The difference of two planes is greatest and least at corners.
        let [[left, low], [right, high]] =
            [cells.min.map(|k| f64::from(k) + 0.5), cells.max.map(|k| f64::from(k) - 0.5)];
        let corners = [[left, low], [right, low], [left, high], [right, high]];
        let off = corners.map(|corner| z_at(own, corner, spec) - z_at(other, corner, spec));
        let most = self.most + 1.0;
        off.iter().any(|off| *off <= most) && off.iter().any(|off| *off >= -most)
    }
}
