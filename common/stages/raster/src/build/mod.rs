//! Builds the slice of each storey, once per site, robot and resolution.

pub(crate) mod assumed_floor;
pub(crate) mod dependents;
pub(crate) mod door;
pub(crate) mod floor_faces;
pub(crate) mod ground_patches;
mod place;
pub(crate) mod slice_count;
pub(crate) mod slicing;
mod surface_joins;
