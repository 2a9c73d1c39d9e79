//! Buildings whose elements are known by GlobalId, with elements removed, displaced or cut, as simulated SLAM maps.
//!
//! The elements are those that `groundplan convert --with-geometry` wrote, sectioned here from their triangles: what
//! compares the maps with the model is judged by a section, a view and a list of changes that are not its own.

mod changed_building;
mod changes;
mod leafs;
mod model;
mod runs;
mod section;
mod sightings;

pub use model::ModelError;
pub use runs::{RunError, RunOptions, write_runs};
