//! The layers of a grid from the model of its storey and a schedule state.

pub(crate) mod cell_flags;
pub(crate) mod door_passage;
pub(crate) mod doorway_clearance;
pub(crate) mod doorway_connection;
pub(crate) mod floor;
pub(crate) mod ground_floor;
pub(crate) mod keepout;
pub(crate) mod localization;
pub(crate) mod other_levels;
pub(crate) mod shown_surface;
pub(crate) mod tile;
