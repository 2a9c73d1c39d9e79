//! Alignment: a map of the model and a SLAM map in, the rigid motion between them out, with covariance and verdict.
//!
//! Candidates come from wall points with signed normals, corners that vote, and correlation; every pose is refined, and compared
//! by walls and their corners, free space, and what the robot saw through: furniture hides walls, but lets nobody through them. One is
//! accepted if it is wrong with a probability below 0.1 %: by what only it explains and no other pose, and by how well it fits at all.
//! A symmetric building is ambiguous, with every pose and the place where the robot finds out ([`Alignment::decide`]), until a hint decides.
//!
//! ```text
//! groundplan align --reference maps --slam robot.yaml                       # on any storey
//! groundplan align --reference maps --storey 0 --slam robot.yaml --hint 3 4 90 --json
//! groundplan align --reference maps --slam robot.yaml --overlay overlay.png --transform site_map.yaml
//! groundplan align --reference maps --slam robot.yaml --start-room U.04     # poses that begin in another room are excluded
//! groundplan align --reference maps --slam robot.yaml --resample moved      # maps, routes and waypoints in the robot's frame
//! groundplan align --reference maps --slam robot.yaml --evidence drive      # with what earlier maps of the drive said
//! groundplan align --reference maps --slam robot.yaml --free-scale          # the scale of the SLAM map is estimated, too
//! ```
//!
//! A growing map is looked at again and again: poses that earlier looks found are tested by what is new since ([`Looks`]), so that
//! several looks say more than the newest alone, and none counts a part twice.
//!
//! A daemon follows the map that the robot publishes on `slam-map` or saves to a file, from one map to the next
//! ([`Follower`]), and searches all poses behind that:
//!
//! ```text
//! groundplan slam-map robot.yaml         # aligned with the planned site; the exit code says what the pose is worth
//! groundplan align                       # searches now; --hint, --storey, --transform as for files
//! groundplan confirm                     # accepts a pending pose: one that would change by more than max_jump
//! ```
//!
//! The published pose follows the robot's map; it never jumps by itself, and survives every daemon. What it is worth for the
//! newest map is its validity ([`PoseStatus::validity`]): only an effective pose may be used.

mod image;
mod occupied_runs;
mod random_generator;
mod thresholds;

mod pose;

mod corners;
mod features;
mod wall_point_cells;
mod wall_points;

mod corner_voting;
mod correlation;
mod rotations;

mod refine;

mod held_out;
mod known_cells;
mod of_this_building;

mod candidate;
mod contrast;
mod scale;
mod score;
mod verdict;

mod candidates;
mod search;

mod map_parts;
mod part_fit;
mod part_poses;
mod part_tree;
mod pose_field;

mod track;

mod rooms;

mod decision;
mod exclusion;

mod looks;
mod prepared_map;

mod alignment;
mod look_result;

mod ambiguity;
mod archives;
mod distinction;
mod map_fault;
mod overlay;
mod place_hints;
mod reference;
mod scale_search;
mod site_places;
mod storeys_in_map;
mod unbent_map;

mod follower;

pub use alignment::{AlignedPose, Alignment, Hint, align_maps};
pub use archives::{AlignmentSources, MaxUncertainty, PoseStatus};
pub use contrast::Contrast;
pub use decision::{DecidingPlace, Decision, NamedPlace};
pub use distinction::{Distinction, MAX_COMPARED_POSES, distinction};
pub use exclusion::Exclusion;
pub use follower::{Follower, MaxJump};
pub use held_out::{HeldOut, PoseHistory};
pub use looks::{Looks, references_hash};

pub use overlay::overlay;
pub use place_hints::{Area, PlaceHint, align_maps_within};
pub use pose_field::{HOLDS_M, LocalPose, PoseExtent, PoseField};
pub use prepared_map::PreparedMap;
pub use reference::{ReferenceError, References};
pub use rooms::{Room, UnknownRoom};
pub use scale::Scale;
pub use scale_search::align_maps_at_any_scale;
pub use score::CornersInSight;
pub use site_places::{Portal, SitePlaces, UnknownPlace, joined};
pub use track::track_map;
