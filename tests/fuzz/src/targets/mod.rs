//! Fuzz targets as functions that must neither panic nor run long; the workspace tests run the committed corpora through them.

pub mod archives;
pub mod configuration;
pub mod ids;
pub mod ifc;
pub mod map_file;
pub mod schedule;
pub mod schedule_files;
pub mod stages;

mod site;
