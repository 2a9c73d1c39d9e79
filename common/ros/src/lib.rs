//! ROS 2 messages of Jazzy and later, their bytes, and maps, markers and transforms as messages.
//!
//! [`msg`] and [`srv`] have the types, by interface package; [`cdr`] their bytes, as topics of DDS and MCAP files carry them. The other modules
//! make messages from views of archives: [`maps`], [`relief`], [`markers`], [`transforms`]; [`topics`] are where they belong. Frames and stamps are arguments; nothing here
//! sends, reads files or asks a clock.
//!
//! # Guarantees
//!
//! - A type has one text, from which the definitions of all types that use it are put together;
//!   `scripts/check_ros_messages.py` compares definitions, hashes, values and bytes with rosbags.
//! - A grid holds what Nav2's map_server reads from the map file of the same layer, cell by cell.
//! - A map of `grid_map` holds the heights and slopes of the grid above the floor of its storey, cell by cell;
//!   `scripts/check_grid_map.py` compares it with the exported files.
//! - Markers begin with the deletion of those of before, and lie in the plane z = 0 of their frame.
//! - Recordings are written by the client (`services/groundplan/src/recording.rs`), from the messages that topics carry.
//!   Their time is the plan time as if the site's clock showed UTC, so that instants keep their order; stamps end in 2038.

pub mod msg;
pub mod srv;

mod cdr;
mod interface;

mod larger_cells;
mod layers;

pub mod maps;
pub mod markers;
pub mod relief;
pub mod topics;
pub mod transforms;

pub use cdr::{CdrError, cdr};
pub use interface::RosMessage;
pub use layers::Layers;
pub use relief::Relief;
