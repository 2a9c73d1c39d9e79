//! The inputs of drawing a storey that are the same for all schedule states.

use crate::layers::keepout::Margins;
use crate::model::storey_slice::StoreySlice;
use messages::{RobotProfile, Site};

/// Site, robot and slice of a storey.
#[derive(Clone, Copy)]
pub(crate) struct StoreyInputs<'a> {
    pub(crate) site: &'a Site<'a>,
    pub(crate) robot: &'a RobotProfile,
    pub(crate) storey: &'a StoreySlice,
}

impl StoreyInputs<'_> {
    /// The robot's margins in cells of the storey.
    pub(crate) fn margins(&self) -> Margins {
        let cells = |metres_m: f64| metres_m / frames::metres(self.storey.spec.cell_tenths);
        Margins { edge_cells: cells(self.robot.edge_margin_m), work_cells: cells(self.robot.work_margin_m) }
    }
}
