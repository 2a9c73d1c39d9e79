//! A map of the model and the robot's own in, the motion between them out: features, poses, how sure they are.
//!
//! The method is that of wall faces with signed normals and corners that vote, beside correlation; every pose is refined and
//! scored by walls and free space, and one is accepted only if no other comes near it.

mod chance;
mod image;
mod thresholds;

mod corners;
mod faces;
mod features;

mod correlation;
mod rotations;
mod same_pose;
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
mod overlay;
mod reference;

mod follower;

pub use alignment::{AlignedPose, Alignment, Hint, PreparedMap, align_maps};
pub use any_scale::align_maps_at_any_scale;
pub use archives::{Counting, MadeFrom};
pub use follower::{Follower, MaxJump};
pub use overlay::overlay;
pub use reference::{ReferenceError, References};
pub use scale::Scale;
pub use track::track_map;
