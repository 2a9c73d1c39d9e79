//! ROS 2 messages of Jazzy and later, their bytes, and maps, markers and transforms as messages.
//!
//! [`msg`] and [`srv`] have the types, by interface package; [`cdr`] their bytes, as topics of DDS and MCAP files carry them. The other modules
//! make messages from views of archives: [`maps`], [`markers`], [`transforms`]; [`topics`] are where they belong. Frames and stamps are arguments; nothing here
//! sends, reads files or asks a clock.

pub mod msg;
pub mod srv;

mod cdr;
mod interface;

mod layers;

pub mod maps;
pub mod markers;
pub mod topics;
pub mod transforms;

pub use cdr::{CdrError, cdr};
pub use interface::RosMessage;
pub use layers::Layers;
