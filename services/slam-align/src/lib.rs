//! A map of the model and the robot's own in, the motion between them out: features, poses, how sure they are.
//!
//! The method is that of wall faces with signed normals and corners that vote, beside correlation; every pose is refined and
//! scored by walls and free space, and one is accepted only if no other comes near it.
//!
//! [`deviations`] then tells of every element whether it is where the model has it, and what stands beside them.

mod chance;
mod image;
mod map_file;
mod raster;
mod thresholds;

mod corners;
mod faces;
mod features;

mod correlation;
mod pose;
mod rotations;
mod votes;

mod refine;
mod scale;
mod score;
mod search;
mod track;
mod verdict;

mod alignment;
mod any_scale;
mod archives;
mod deviations;
mod overlay;
mod reference;

mod follower;
mod kept;
mod observed;
mod output;
mod robot_map;
mod worker;

pub mod service;

pub use alignment::{AlignedPose, Alignment, Hint, MapFromSlam, PreparedMap, align_maps};
pub use any_scale::align_maps_at_any_scale;
pub use archives::{Counting, MadeFrom};
pub use deviations::{DeviationInput, deviations};
pub use follower::{Follower, MaxJump};
pub use map_file::{MapFault, MapFileError, OccupancyMap};
pub use overlay::overlay;
pub use raster::Cell;
pub use reference::{ReferenceError, References};
pub use scale::Scale;
pub use track::track_map;
