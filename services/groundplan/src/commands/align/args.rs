//! Arguments and help of `align`.

use super::initial_pose::{self, INITIAL_POSE};
use super::transform::{self, TRANSFORM};
use crate::args::{OverwriteArgs, PoseHintArgs, SiteOfRobotArgs};
use crate::failure::Failure;
use alignment::MaxUncertainty;
use messages::Alignment;
use std::path::PathBuf;

/// Arguments of `align`.
#[derive(Debug, Clone, clap::Args)]
#[command(after_help = AFTER_HELP)]
pub struct Args {
    /// Output folder of `convert`, or one map of the model: localization.yaml of a storey, with those beside it [default: the running daemon aligns
    /// the map that it follows with the site as planned]
    #[arg(long, value_name = "OUT", requires = "slam")]
    pub(super) reference: Option<PathBuf>,

    /// Map that the robot made, as its map server saves it
    #[arg(long, value_name = "MAP.yaml", requires = "reference")]
    pub(super) slam: Option<PathBuf>,

    /// Where it may lie.
    #[command(flatten)]
    pub(super) place: PoseHintArgs,

    /// Standard deviations up to which a pose may be used: metres, degrees; for the running daemon site.toml has them
    #[arg(long, num_args = 2, value_names = ["M", "DEG"], default_values_t = [0.1, 1.0], requires = "reference")]
    max_uncertainty: Vec<f64>,

    /// Write the static transform from `map`, the robot's frame, to `site_map`, the model's; only for exit code 0. Otherwise a
    /// transform of an earlier pose that is there is renamed to FILE.yaml.stale, so that no robot reads it
    #[arg(long, value_name = "FILE.yaml")]
    transform: Option<PathBuf>,

    /// Write the robot's pose in the model's map, with its covariance, as parameters of AMCL and as a message for /initialpose;
    /// only for exit code 0, and an earlier one becomes FILE.yaml.stale otherwise
    #[arg(long, value_name = "FILE.yaml")]
    initial_pose: Option<PathBuf>,

    /// Where the robot is in its own map: metres, metres, and degrees for --initial-pose [default: where its map began for
    /// --initial-pose, else not known]. The pose is that of the map around it, and may be used if it is known well enough there;
    /// without it, it must be known well enough anywhere in the map
    #[arg(long, num_args = 2..=3, value_names = ["X", "Y", "YAW"], allow_negative_numbers = true)]
    robot: Vec<f64>,

    /// Draw both maps in the best pose: walls of both green, what only the robot saw red, what it saw through orange
    #[arg(long, value_name = "FILE.png", requires = "reference")]
    pub(super) overlay: Option<PathBuf>,

    /// Write maps, route graph and waypoints of the storey moved into the robot's frame, bent as its map is; only if accepted. Where
    /// is not known to 0.2 m how its map lies nothing is free
    #[arg(long, value_name = "FOLDER", requires = "reference", conflicts_with = "free_scale")]
    pub(super) resample: Option<PathBuf>,

    /// What becomes of files of others in that folder.
    #[command(flatten)]
    pub(super) overwrite: OverwriteArgs,

    /// Evidence of earlier maps of the same drive: what is new in this map tests the poses that they found. FILE is read if it is
    /// there, and replaced by the evidence with this map; another map, or other maps of the model, begin anew
    #[arg(long, value_name = "FILE", requires = "reference", conflicts_with = "free_scale")]
    pub(super) evidence: Option<PathBuf>,

    /// The scale of the SLAM map is not reliable: try scales from 0.8 to 1.25
    #[arg(long, requires = "reference", conflicts_with_all = ["start_room", "at", "elevation", "portal"])]
    pub(super) free_scale: bool,

    /// Print one JSON document on standard output and nothing else there
    #[arg(long)]
    pub(super) json: bool,

    /// Align all pairs that FOLDER/pairs.jsonl names, for benchmarks
    #[arg(long, value_name = "FOLDER", conflicts_with_all = ["reference", "slam", "json"], requires = "json_lines")]
    pub(super) pairs: Option<PathBuf>,

    /// Print a JSON document a line, one for each pair
    #[arg(long, requires = "pairs")]
    pub(super) json_lines: bool,

    /// The site.
    #[command(flatten)]
    pub(super) site: SiteOfRobotArgs,
}

const AFTER_HELP: &str = "\
The model's maps are those of all storeys in a folder that `convert` wrote, or one of them; the robot's is a
Nav2 map file of any resolution and origin. The answer is the motion `map_from_slam`:
p_map = R(yaw) p_slam + (x, y), with its covariance, or every pose that fits as well, or why there is none.

  accepted    one pose fits, and no other comes near; no other building would fit so well
  ambiguous   several fit alike: a symmetric building, repeated rooms; all are listed, with a place to drive to at
              which the model tells them apart, or with the hints to give where it does not
  refused     another building or storey, too little overlap, too little structure

Accepted is a pose that is wrong with a probability below 0.1 % (`wrong_probability`); it may be used if it is also known
well enough (`usable`): see --max-uncertainty. A SLAM map bends: a pose holds for the part of it where the walls bear it
out, and the answer has the outline of that part, its share of the walls, how far off the pose is beyond it, and of how
much that is not known (`holds`). --robot X Y asks for the pose where the robot is.

One map alone tells nothing about the storey (`storey_claim`: not_tested); with the folder of all it is tested, and with
--storey it is as given, unless another one fits clearly better; those that fit as well are named (`storeys_alike`), also where
another hint excludes them: then the storey is as given, too.

--storey, --start-room, --at, --elevation and --portal exclude poses that contradict them; the answer says how many. Where the
map fits clearly better in a pose that is excluded, none is accepted: the hint may be wrong.

A map that grows is looked at again: with --evidence a pose that an earlier look found is tested by what the robot has
seen since, and is accepted as soon as all of it suffices. If a later look does not accept it any more, the answer says
so (`change`).

Of the running daemon the validity is printed, too: whether the pose may be used for the newest map.

  effective          the newest map bears the pose out
  waits_for_confirm  another pose waits for `groundplan confirm`
  held               the newest map does not bear the pose out, or waits for its search
  refused            the newest map was searched, and no pose is accepted
  uncertain          the newest map bears the pose out, but holds it less well than max_uncertainty where the robot is,
                     or anywhere in the map if nobody knows where that is

Exit codes: 0 accepted and effective, 1 failed, and of files ambiguous, refused or uncertain, 2 bad usage;
of the running daemon 3 waits_for_confirm, 4 held, 5 refused or ambiguous, 6 uncertain. A pose that is
followed stays effective, and `usable`, while a search is ambiguous.

Examples:
  groundplan align --reference maps --slam robot.yaml
  groundplan align --reference maps --storey 0 --slam robot.yaml --hint 3 4 90 --json
  groundplan align --reference maps --slam robot.yaml --start-room U.04 --initial-pose amcl.yaml";

impl Args {
    /// Standard deviations up to which a pose may be used.
    pub(super) fn max_uncertainty(&self) -> MaxUncertainty {
        let [m, deg] = self.max_uncertainty.first_chunk::<2>().copied().unwrap_or_default();
        MaxUncertainty::in_degrees(m, deg)
    }

    /// Where the robot is in its own map, if that is known.
    pub(super) fn robot_m(&self) -> Option<[f64; 2]> {
        let began = self.initial_pose.as_ref().map(|_| [0.0; 2]);
        self.robot.first_chunk::<2>().copied().or(began)
    }

    /// Writes static transform and initial pose of an alignment, if they are asked for and the pose may be used.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub(super) fn write_pose(&self, alignment: &Alignment<'_>) -> Result<(), Failure> {
        if let Some(path) = &self.transform {
            TRANSFORM.write(path, alignment, self.robot_m(), transform::text)?;
        }
        let Some(path) = &self.initial_pose else { return Ok(()) };
        let [x_m, y_m] = self.robot.first_chunk::<2>().copied().unwrap_or_default();
        let yaw_deg = self.robot.get(2).copied().unwrap_or_default();
        INITIAL_POSE
            .write(path, alignment, self.robot_m(), |pose| initial_pose::text(pose, [x_m, y_m, yaw_deg.to_radians()]))
    }
}
