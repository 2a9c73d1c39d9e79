//! What each fuzz target does with its bytes: a function that must neither panic nor take long. The tests of the workspace run the
//! committed corpora through the same functions.

pub mod archives;
pub mod configuration;
pub mod ifc;
pub mod map_file;
pub mod schedule;
pub mod stages;

mod site;
