//! Inputs of the waypoint planner.

use crate::free_space::is_planned;
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
    /// The doors on the map of a storey. The ground outdoors has none of its own, but those of other storeys that begin at its height.
    pub(crate) fn passages(&self, grid: &Grid<'_>) -> Vec<DoorPassageRecord> {
        if grid.head.floor != FloorKind::Ground {
            return self.doors_of(grid.head.map_storey);
        }
        let is_here = |door: &&DoorPassageRecord| {
            let (record, robot) = (&self.site.doors[door.door as usize], &self.index.head.robot);
            heights_at(grid, door.way.to_box()).any(|z| self.site.is_door_at(record, robot, f64::from(z)))
        };
        if is_planned(grid.head) { self.index.doors.iter().filter(is_here).copied().collect() } else { Vec::new() }
    }

    /// The same where no grid is open: only that of the ground outdoors is opened for it.
    pub(crate) fn passages_at(&self, at: usize) -> Vec<DoorPassageRecord> {
        let head = self.grids.head(at);
        if head.floor != FloorKind::Ground {
            return self.doors_of(head.map_storey);
        }
        self.grids.with(at, |grid| self.passages(grid))
    }

    fn doors_of(&self, map_storey: u32) -> Vec<DoorPassageRecord> {
        self.index.doors.iter().filter(|door| door.map_storey == map_storey).copied().collect()
    }

    /// The distances that the robot keeps on a storey, if it does.
    pub(crate) fn safety_layer(&self, at: usize) -> Option<SafetyLayer> {
        if !is_planned(self.grids.head(at)) {
            return None;
        }
        let of = SafetyInput { site: self.site, schedule_state: self.schedule_state, index: self.index };
        self.grids.with(at, |grid| SafetyLayer::of(of, grid))
    }
}

/// Heights of the ground on a line through a doorway, from 0.3 m before it to 0.3 m behind it.
fn heights_at(grid: &Grid<'_>, way: OrientedBox) -> impl Iterator<Item = i32> {
    let spec = grid.spec();
    let reach = way.half[1] + BEFORE_DOOR;
    let n_steps = (2.0 * reach / f64::from(spec.cell_tenths)).ceil().max(1.0) as u32;
    (0..=n_steps).filter_map(move |k| {
        let [x, y] = way.at(0.0, reach * (2.0 * f64::from(k) / f64::from(n_steps) - 1.0));
        let at = Point2::<Map>::new(x / f64::from(TENTHS_PER_M), y / f64::from(TENTHS_PER_M));
        spec.cell_at(at).and_then(|cell| grid.height_tenths(spec.index(cell)))
    })
}

/// Reach of the search for ground before a doorway, in tenths of a millimetre.
const BEFORE_DOOR: f64 = 0.3 * TENTHS_PER_M as f64;
