//! Arguments and help of `deviations`.

use crate::args::{OverwriteArgs, PoseHintArgs, ScheduleArgs, SiteOfRobotArgs};
use std::path::PathBuf;

/// Arguments of `deviations`.
#[derive(Debug, Clone, clap::Args)]
#[command(after_help = AFTER_HELP)]
pub struct Args {
    /// IFC files of the site [default: what the running daemon compared]
    #[arg(value_name = "MODEL.ifc", requires = "slam")]
    pub(super) models: Vec<PathBuf>,

    /// Map that the robot made, as its map server saves it
    #[arg(long, value_name = "MAP.yaml", requires = "models")]
    pub(super) slam: Option<PathBuf>,

    /// Plan time that elements are judged by [default: everything is built]
    #[arg(long, value_name = "DATE", requires = "slam")]
    pub(super) date: Option<String>,

    /// Take models of whose bodies more than half cannot be meshed, with bounding boxes for them
    #[arg(long, requires = "slam")]
    pub(super) allow_boxes: bool,

    /// Folder for deviations.json, actuals.csv (for --actuals), deviations.bcfzip (BCF) and deviations.png;
    /// with --schedule-file also progress.csv and progress.xml (MS Project XML), for the planner, and XER and P6 XML files as they
    /// are but for the progress (progress-NAME)
    #[arg(short, long, value_name = "OUT")]
    pub(super) out: Option<PathBuf>,

    /// Waypoints of the model (waypoints.json) to carry into the robot's map, also where it is bent: OUT/goals.json
    #[arg(long, value_name = "WAYPOINTS.json", requires = "slam", requires = "out")]
    pub(super) goals: Option<PathBuf>,

    /// Topics of an earlier comparison (deviations.bcfzip, also after others worked on it): OUT/deviations.bcfzip is made of it.
    /// Topics of elements that the robot saw in place since are closed, with a comment; new ones are added, none is lost
    #[arg(long, value_name = "OLD.bcfzip", requires = "out")]
    pub(super) bcf: Option<PathBuf>,

    /// Version of deviations.bcfzip; after an earlier one its version stays
    #[arg(long, value_name = "VERSION", requires = "out", conflicts_with = "bcf", default_value = "2.1", value_parser = ["2.1", "3.0"])]
    pub(super) bcf_version: String,

    /// What becomes of files of others in it.
    #[command(flatten)]
    pub(super) overwrite: OverwriteArgs,

    /// Where the map may lie.
    #[command(flatten)]
    pub(super) place: PoseHintArgs,

    /// Pose map_from_slam that is known, of a map of the storey: metres, metres, degrees. It is neither searched nor judged
    #[arg(
        long,
        num_args = 3,
        value_names = ["X", "Y", "YAW"],
        allow_negative_numbers = true,
        requires = "slam",
        requires = "storey",
        conflicts_with = "hint"
    )]
    pose: Option<Vec<f64>>,

    /// Standard deviations of that, at the middle of the map: metres, degrees
    #[arg(long, num_args = 2, value_names = ["M", "DEG"], default_values_t = [0.03, 0.2], requires = "pose")]
    pose_deviation: Vec<f64>,

    /// Rules and additions.
    #[command(flatten)]
    pub(super) schedule: ScheduleArgs,

    /// Robot profile: the height of its lidar counts
    #[arg(long, value_name = "FILE")]
    pub(super) robot: Option<PathBuf>,

    /// Print deviations.json on standard output and nothing else there
    #[arg(long)]
    pub(super) json: bool,

    /// The site.
    #[command(flatten)]
    pub(super) site: SiteOfRobotArgs,
}

/// A pose of the robot's map that the caller knows.
pub(super) struct KnownPose {
    /// x, y and yaw of `map_from_slam`.
    pub(super) x_y_yaw: [f64; 3],
    /// Standard deviation of the place of the middle of the map.
    pub(super) place_m: f64,
    /// Standard deviation of yaw.
    pub(super) yaw_rad: f64,
}

impl Args {
    pub(super) fn known_pose(&self) -> Option<KnownPose> {
        let &[x_m, y_m, yaw_deg] = self.pose.as_deref()?.first_chunk::<3>()?;
        let &[place_m, deviation_deg] = self.pose_deviation.first_chunk::<2>()?;
        Some(KnownPose { x_y_yaw: [x_m, y_m, yaw_deg.to_radians()], place_m, yaw_rad: deviation_deg.to_radians() })
    }
}

const AFTER_HELP: &str = "\
Observed: it stands where the model has it; absent: the robot saw through its place; displaced: it stands beside it;
unseen: nothing can be said, as of glass, doors, and what does not cross the lidar's plane or was hidden.
Compared with the planned states at the date: on plan, late, early, displaced, unknown. Nothing changes a map by itself: give
actuals.csv to --actuals, or see [align] apply and `groundplan confirm`.
Goals on the storey of the map are told in the model's map and in the robot's (map, slam), with standard deviations (deviation);
is_corrected: surfaces around show how the map is bent there; otherwise the pose of the whole map carried them.

Examples:
  groundplan deviations house.ifc --slam robot.yaml --date 2024-04-15 -o deviations
  groundplan deviations house.ifc --slam robot.yaml -o deviations --goals maps/waypoints.json
  groundplan deviations -o deviations
  groundplan deviations -o later --bcf deviations/deviations.bcfzip

Exit codes: 0 done, 1 failed (the map's pose is not accepted), 2 bad usage or configuration.";
