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
mod score;
mod search;
mod verdict;

mod alignment;
mod deviations;
mod overlay;

pub use alignment::{AlignedPose, Alignment, Hint, MapFromSlam, PreparedMap, align_maps};
pub use deviations::{DeviationInput, deviations};
pub use map_file::{MapFault, MapFileError, OccupancyMap};
pub use overlay::overlay;
pub use raster::Cell;
pub use score::Evidence;
pub use verdict::Verdict;
