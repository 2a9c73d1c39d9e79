//! The grid on which elements are cut to a slab and drawn.

use super::door::storey_door;
use super::slice_count::reaches;
use crate::model::element_runs::ElementRuns;
use geometry::{LazyFootprint, Plane, Slab, SlabCut};
use grid::{CellRect, Class, GridSpec, Run, cells_of_cut, common_runs};
use messages::{DoorRecord, ElementRecord, FloorKind, RobotProfile, Site, element_flags};
use rayon::prelude::*;

/// Where elements are drawn.
#[derive(Clone, Copy)]
pub(super) struct Place<'a> {
    pub(super) site: &'a Site<'a>,
    pub(super) robot: &'a RobotProfile,
    pub(super) spec: &'a GridSpec,
    pub(super) map_storey: usize,
}

impl Place<'_> {
    /// Cells and footprints of the elements that reach into a slab, by element.
    pub(super) fn cut_elements(
        &self,
        slab: Slab,
        wanted: impl Fn(&ElementRecord) -> bool + Sync,
        sliced: impl Fn() + Sync,
    ) -> (Vec<ElementRuns>, Vec<(u32, LazyFootprint)>) {
        let elements = (0..self.site.elements.len() as u32).into_par_iter();
        let cut = |element: u32| {
            let record = &self.site.elements[element as usize];
            let cut = SlabCut::of(self.site.element_meshes(record), slab);
            let is_there = !cut.is_empty();
            let found =
                is_there.then(|| (self.element_runs(element, &cut, None), (element, LazyFootprint::of(cut, slab))));
            sliced();
            found
        };
        let wanted = elements.filter(|&k| {
            let record = &self.site.elements[k as usize];
            reaches(record, slab) && wanted(record)
        });
        wanted.filter_map(cut).unzip()
    }

    /// Cells of a cut element, and its door. On a patch of ground, its plane and the cells around it, only those within these cells.
    pub(super) fn element_runs(&self, element: u32, cut: &SlabCut, patch: Option<(&Plane, &[Run])>) -> ElementRuns {
        let record = &self.site.elements[element as usize];
        let runs = cells_of_cut(cut, self.spec);
        let runs = if let Some((_, around)) = patch { common_runs(&runs, around) } else { runs };
        let stands_here = |door: &DoorRecord| self.has_door(door, patch.map(|(plane, _)| plane));
        let door = storey_door(self.site, self.robot, self.spec, (record.door, &runs), stands_here);
        ElementRuns { element, class: record.class(), rect: CellRect::around(&runs), runs, door }
    }

    /// True if a door belongs to this map storey; on the ground outdoors, which is no level, if it begins at the height of the patch.
    fn has_door(&self, door: &DoorRecord, patch: Option<&Plane>) -> bool {
        match patch.filter(|_| self.site.map_storeys[self.map_storey].floor == FloorKind::Ground) {
            Some(plane) => self.site.is_door_at(door, self.robot, plane.z(door.passage.centre)),
            None => door.map_storey == self.map_storey as u32,
        }
    }
}

/// True for structure that a lidar sees: not glass, furniture or doors.
pub(super) fn is_lasting(element: &ElementRecord) -> bool {
    let class = matches!(
        element.class(),
        Class::Wall | Class::Column | Class::CurtainWall | Class::Stair | Class::Ramp | Class::Slab
    );
    class && !element.has(element_flags::GLASS)
}
