//! Inputs of drawing that are the same for all schedule states.

use crate::layers::keepout::Margins;
use crate::model::storey_slice::StoreyCut;
use messages::{RobotProfile, Site};

/// What does not change from phase to phase.
#[derive(Clone, Copy)]
pub(crate) struct Scene<'a> {
    pub(crate) site: &'a Site<'a>,
    pub(crate) robot: &'a RobotProfile,
    pub(crate) storey: &'a StoreyCut,
}

impl Scene<'_> {
    /// The robot's margins in cells of the storey.
    pub(crate) fn margins(&self) -> Margins {
        let cells = |metres_m: f64| metres_m / frames::metres(self.storey.spec.cell_tenths);
        Margins { edge_cells: cells(self.robot.edge_margin_m), work_cells: cells(self.robot.work_margin_m) }
    }
}
