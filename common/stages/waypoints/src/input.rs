//! Inputs of the waypoint planner.

use crate::options::MissionPlanOptions;
use messages::{Grids, MapGrids, ScheduleState, Site};

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
