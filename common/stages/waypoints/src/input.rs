//! Inputs of the waypoint planner.

use crate::options::PlanOptions;
use messages::{Grid, Grids, Phase, Site};

/// What a plan is made from; the grids are those that the index names, in its order, and all are of the site.
#[derive(Clone, Copy)]
pub struct PlanInput<'a> {
    /// Geometry and facts.
    pub site: &'a Site<'a>,
    /// States at the plan time.
    pub phase: &'a Phase<'a>,
    /// Index of the grids: robot and doors.
    pub index: &'a Grids<'a>,
    /// One grid per map storey, in their order.
    pub grids: &'a [Grid<'a>],
    /// What to plan.
    pub options: &'a PlanOptions,
}
