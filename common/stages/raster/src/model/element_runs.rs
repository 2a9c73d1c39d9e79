//! The cells of an element that stands in the way.

use super::door::StoreyDoor;
use grid::{CellRect, Class, Run};

/// An element that reaches into the slab of a storey.
#[derive(Debug)]
pub(crate) struct ElementRuns {
    pub(crate) element: u32,
    pub(crate) class: Class,
    pub(crate) runs: Vec<Run>,
    /// Around the runs.
    pub(crate) rect: Option<CellRect>,
    pub(crate) door: Option<StoreyDoor>,
}
