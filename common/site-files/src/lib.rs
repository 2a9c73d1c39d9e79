//! All files of a site at a plan time: archives that belong together in, paths and bytes out.
//!
//! `export` makes the files of every output; here those of the other formats join them, which each need more than maps: the simulation
//! world, the cloud and the octree of structure, the ground, what the control of fleets reads, building maps for Open-RMF. No bus, no
//! output folder, no clock.
//!
//! # Guarantees
//!
//! - The same archives and formats give the same bytes, whoever asks: the converter, `groundplan export` and the server of a site.
//! - [`SiteFiles::each_file`] gives each file away as soon as it is made. Of the formats that are asked for, all files are in memory
//!   together; of the maps, one.

mod error;
mod optional_files;
mod site_files;

pub use error::SiteFilesError;
pub use optional_files::OptionalFiles;
pub use site_files::{SiteArchives, SiteFiles};
