//! Date-independent model of a storey: cells of elements, spaces, passages and doors.

pub(crate) mod cell_area;
pub(crate) mod door;
pub(crate) mod door_leaves;
pub(crate) mod gap;
pub(crate) mod other_levels;
pub(crate) mod presence;
pub(crate) mod storey_slice;
