//! Arguments and help of `deviations`.

use crate::args::{OverwriteArgs, PoseHintArgs, ScheduleArgs, SiteArgs};
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

    /// Folder for deviations.json, actuals.csv (for --actual), deviations.bcfzip (BCF 2.1) and deviations.png
    #[arg(short, long, value_name = "OUT")]
    pub(super) out: Option<PathBuf>,

    /// What becomes of files of others in it.
    #[command(flatten)]
    pub(super) overwrite: OverwriteArgs,

    /// Where the map may lie.
    #[command(flatten)]
    pub(super) place: PoseHintArgs,

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
    pub(super) site: SiteArgs,
}

const AFTER_HELP: &str = "\
Observed: it stands where the model has it; absent: the robot saw through its place; displaced: it stands beside it;
unseen: nothing can be said, as of glass, doors, and what does not cross the lidar's plane or was hidden.
Compared with the planned states at the date: on plan, late, early, displaced, unknown. Nothing changes a map by itself: give
actuals.csv to --actual, or see [align] apply and `groundplan confirm`.

Examples:
  groundplan deviations house.ifc --slam robot.yaml --date 2024-04-15 -o deviations
  groundplan deviations -o deviations

Exit codes: 0 done, 1 failed (the map's pose is not accepted), 2 bad usage or configuration.";
