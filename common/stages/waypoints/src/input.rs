//! Inputs of the waypoint planner.

use crate::options::MissionPlanOptions;
use messages::{Grids, MapGrids, ScheduleState, Site};
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
    /// The distances that the robot keeps on a storey, if it does.
    pub(crate) fn safety_layer(&self, at: usize) -> Option<SafetyLayer> {
        if self.index.safety_rules.is_empty() {
            return None;
        }
        let of = SafetyInput { site: self.site, schedule_state: self.schedule_state, index: self.index };
        self.grids.with(at, |grid| SafetyLayer::of(of, grid))
    }
}
