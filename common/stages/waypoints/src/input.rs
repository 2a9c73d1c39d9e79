//! Inputs of the waypoint planner.

use crate::options::MissionPlanOptions;
use frames::{Map, Point2, TENTHS_PER_M};
use geometry::OrientedBox;
use messages::{DoorPassageRecord, FloorKind, Grid, Grids, MapGrids, ScheduleState, Site};
use safety::{SafetyInput, SafetyLayer};

/// The archives and options of a mission plan. The grids are those of the index, in its order, and all belong to the
/// site.
#[derive(Clone, Copy)]
pub struct MissionPlanInput<'a> {
    /// Geometry and attributes.
    pub site: &'a Site<'a>,
    /// States at the plan time.
    pub schedule_state: &'a ScheduleState<'a>,
    /// Index of the grids, with robot and door passages.
    pub index: &'a Grids<'a>,
    /// One grid per map storey, in their order.
    pub grids: &'a dyn MapGrids,
    /// Options of a mission plan.
    pub options: &'a MissionPlanOptions,
}

impl MissionPlanInput<'_> {
    /// The doors of a storey. The ground outdoors has none of its own, but those of other storeys that begin at its height.
    pub(crate) fn passages(&self, at: usize) -> Vec<DoorPassageRecord> {
        let head = self.grids.head(at);
        if head.floor != FloorKind::Ground {
            return self.index.doors.iter().filter(|door| door.map_storey == head.map_storey).copied().collect();
        }
        self.grids.with(at, |grid| {
            let is_here = |door: &&DoorPassageRecord| {
                let floor_z = self.site.map_storeys[door.map_storey as usize].floor_z_tenths;
                is_at_ground(grid, &door.way.to_box(), floor_z)
            };
            self.index.doors.iter().filter(is_here).copied().collect()
        })
    }

    /// The distances that the robot keeps on a storey, if it does.
    pub(crate) fn safety_layer(&self, at: usize) -> Option<SafetyLayer> {
        if self.index.safety_rules.is_empty() {
            return None;
        }
        let of = SafetyInput { site: self.site, schedule_state: self.schedule_state, index: self.index };
        self.grids.with(at, |grid| SafetyLayer::of(of, grid))
    }
}

/// True if there is ground in a doorway, or within 0.3 m before it, as high as the floor of the door, within the sill of a doorway.
fn is_at_ground(grid: &Grid<'_>, way: &OrientedBox, floor_z: i32) -> bool {
    let spec = grid.spec();
    let reach = way.half[1] + BEFORE_DOOR;
    let n_steps = (2.0 * reach / f64::from(spec.cell_tenths)).ceil().max(1.0) as u32;
    (0..=n_steps).any(|k| {
        let [x, y] = way.at(0.0, reach * (2.0 * f64::from(k) / f64::from(n_steps) - 1.0));
        let at = Point2::<Map>::new(x / f64::from(TENTHS_PER_M), y / f64::from(TENTHS_PER_M));
        let height = spec.cell_at(at).and_then(|cell| grid.height_tenths(spec.index(cell)));
        height.is_some_and(|z| (z - floor_z).abs() <= MAX_SILL)
    })
}

/// Reach of the search for ground before a doorway, and height of its sill, in tenths of a millimetre.
const BEFORE_DOOR: f64 = 0.3 * TENTHS_PER_M as f64;
const MAX_SILL: i32 = TENTHS_PER_M / 10;
