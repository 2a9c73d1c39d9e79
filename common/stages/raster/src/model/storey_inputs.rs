//! The inputs of drawing a storey that are the same for all schedule states.

use super::storey_slice::StoreySlice;
use messages::{RobotProfile, Site};

/// Site, robot and slice of a storey.
#[derive(Clone, Copy)]
pub(crate) struct StoreyInputs<'a> {
    pub(crate) site: &'a Site<'a>,
    pub(crate) robot: &'a RobotProfile,
    pub(crate) storey: &'a StoreySlice,
}
