//! Date-independent model of a storey: cells of elements, spaces, passages and doors.

pub(crate) mod band_surfaces;
pub(crate) mod cell_area;
pub(crate) mod door;
pub(crate) mod door_leaves;
pub(crate) mod element_runs;
pub(crate) mod gap;
pub(crate) mod ground_patch;
pub(crate) mod obstacle_squares;
pub(crate) mod other_levels;
pub(crate) mod presence;
pub(crate) mod storey_inputs;
pub(crate) mod storey_slice;
