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
//!
//! # Guarantees
//!
//! - Poses are searched by corners and by correlation of walls; refinement with narrow scales keeps a pose in place among
//!   furniture, wide ones find it in a distorted map. Then the walls that the best pose explains, without furniture and what
//!   was seen of other buildings, are searched again: wings that are alike are found.
//! - Poses are ranked by their log odds: the walls that the model has, each line of them for at most half a metre, and what
//!   the robot would have seen through, which furniture cannot explain. Two poses are told apart by their contrast, what only
//!   one of them explains: what both explain, or neither, tells nothing about which is right. Walls that lie on the model's
//!   within 5 cm count once more: a wrong pose fits, but less sharply. So do corners: walls that lie on others by chance
//!   seldom end where those end.
//! - A pose is accepted if it is wrong with a probability below 0.1 %: no other pose of the building may be right, by the
//!   contrasts with all of them together, and the map must be of this building and storey, by its fit and its lead over the
//!   other poses that were found: where a map is of elsewhere, the best is the best of many that fit by chance, and stands
//!   little above them. Poses within half a metre and 10 degrees of the best are no rivals of it: how well the place is known
//!   is a matter of the covariance. What was seen through must be made up for by corners, or the map may be of another storey
//!   with the same outer walls. Both are calibrated on simulated maps of the right, of another building and of another storey
//!   (`tests/slam-simulator`, `scripts/calibrate-alignment`).
//! - A growing map is searched anew as a whole at each look, and poses that earlier looks found are tested by what is new: no
//!   search chose them by that. The log odds that the map is of this building are those of the look, or those of an earlier
//!   look with all that was new since, whichever is more; rivals are always compared on the newest map.
//! - Evidence over looks is an archive (`alignment-evidence`): a function of the model's maps, the SLAM map and the archive
//!   before it. It holds which places any look has known, so that parts of maps that overlap count once, and those within 0.3
//!   m of them not again when a loop closure bends the map. A look counts if a tenth is new: a verdict hardly depends on how
//!   often maps come. A map that knows less than half of what was known is another one, and begins anew; so does one that is
//!   compared with other maps of the model.
//! - What an earlier look accepted is not withdrawn or replaced in silence: `change` of the alignment, a warning in `status`
//!   and a line in the history say so, with the reason.
//! - How well walls hold the pose is a matter of its covariance, not of the verdict: a pose that is known too little is
//!   accepted and uncertain, and gives no transform.
//! - A SLAM map bends, so an accepted pose is followed from part to part (`map_parts`, `part_fit`, `part_tree`,
//!   `part_poses`): parts are connected floor within 3 m, the motion from one to the next is a random walk, and the walls
//!   that the model has are its measurements. They are visited from the part that fits best, those first that are known best;
//!   of three drifts that one counts which explains most for the freedom that it takes. Beyond parts that walls bear out
//!   uncertainty grows by 5 cm after a metre, whatever was chosen: a map that is straight where the model has its walls tells
//!   nothing about where it has none.
//! - A bend hides walls and corners from one pose: a pose that is refused though it is likely is judged again with the map
//!   straightened by the poses of its parts, and must be accepted in the same place (`unbent_map`).
//! - What does not lie on the storey of the pose is looked for on the others (`storeys_in_map`): over it after a lift, beside
//!   it after a stair; an answer says where a map shows two.
//! - The answer says for which part of the map the pose holds, how far off it is beyond that, and of how much that is not
//!   known. Whoever knows where the robot is asks for the pose there (`messages::Alignment::pose_at`, the one rule for `--robot`, files
//!   and ROS); without that a pose must be known well enough anywhere in the map.
//! - The transform on `/tf_static` is that around the robot: it follows a bend by at most 5 cm a second, takes a jump of more than half a metre at once, and is withdrawn
//!   where the robot drives beyond what is known. Maps that are moved into the SLAM frame never follow the robot's place, but
//!   the whole field: local poses are blended to a smooth motion (`frames::BentMotion`), and where a place is known less well
//!   than 0.2 m free cells are unknown (`messages::SlamFrame`, the one rule for files, ROS and deviations). A frame stays in
//!   use until a newer map lies elsewhere by 5 cm, so that maps do not change with each look.
//! - A symmetric building is ambiguous, with every pose, until an operator gives a hint.
//! - An ambiguous answer names the place to drive to (`decide`, with what hints excluded a field of the `alignment` archive):
//!   unseen, reachable whichever pose is right, with walls in view that stand by one pose and not by another; or it says that
//!   nothing in the model decides. It is named by its room by each pose, and by its place in the SLAM map, where the robot
//!   can drive in any case.
//! - Storeys, rooms, elevation and portals exclude poses; they never make one fit. Where the map fits clearly better in a
//!   pose that they exclude, none is accepted, because the hint may be wrong.
//! - The published pose follows the robot's map in small steps, is held where the newest map does not support it, and jumps
//!   only when an operator confirms; another place must win three searches in a row before it is offered.
//! - An alignment says what its pose is worth for the newest map: only an effective one may be used, not one that waits for
//!   an operator, is held, is uncertain, or whose map was refused.
//! - The reference is the planned site, so that what is observed never changes what it is compared with.
//! - Thresholds of acceptance are in one file, with their reasons; those of a method are beside it.
//!
//! # Where
//!
//! - alignment: acceptance of a pose: `src/verdict.rs`, `src/score.rs`, `src/thresholds.rs`
//! - alignment: features of a map: `src/wall_points.rs`, `src/corners.rs`
//! - alignment: reference for the robot's map: `src/reference.rs`
//! - alignment: poses that are tried: `src/rotations.rs`, `src/corner_voting.rs`, `src/correlation.rs`

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
pub use rooms::Room;
pub use scale::Scale;
pub use scale_search::align_maps_at_any_scale;
pub use score::CornersInSight;
pub use site_places::{Portal, SitePlaces, UnknownPlace, joined};
pub use track::track_map;
