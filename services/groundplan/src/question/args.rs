//! Arguments that all questions share.

use crate::args::{ModelArgs, RobotArgs, ScheduleArgs, SiteOfRobotArgs};
use crate::failure::Failure;
use clap::{Arg, ArgAction};
use std::path::{Path, PathBuf};
use waypoints::MissionPlanOptions;

/// Of what a question is asked: of model files, or of the running daemons.
#[derive(Debug, Clone, clap::Args)]
#[command(mut_args(belongs_to_models))]
pub(crate) struct QuestionArgs {
    /// IFC files of one site [default: the running daemons are asked]
    #[arg(value_name = "MODEL.ifc")]
    pub(super) models: Vec<PathBuf>,

    /// Date of the answer: a day (2024-04-15, throughout it) or an instant (2024-04-15T08:30:00) [default: of models, everything is
    /// built; of the running daemons, the maps that they hold]
    #[arg(long, value_name = "DATE")]
    pub(super) date: Option<String>,

    /// Do not draw the maps of later dates to find out when the answer changes
    #[arg(long)]
    pub(super) only_now: bool,

    /// Options of waypoints, as for `convert`, of maps that are drawn for the answer: where the robot starts, the lifts that
    /// it takes, and by what its ways are chosen; the running daemons answer for now by those of their mission plan
    /// [default: see config/waypoints.toml]
    #[arg(long, value_name = "FILE")]
    waypoints: Option<PathBuf>,

    /// Rules and additions.
    #[command(flatten)]
    pub(super) schedule: ScheduleArgs,

    /// The robot.
    #[command(flatten)]
    pub(super) robot: RobotArgs,

    /// Take a file of whose bodies more than half cannot be meshed, with bounding boxes for them
    #[arg(long)]
    allow_boxes: bool,

    /// The site.
    #[command(flatten)]
    pub(super) site: SiteOfRobotArgs,

    /// Print one JSON document on standard output and nothing else there
    #[arg(long, action = ArgAction::SetTrue)]
    pub(super) json: bool,
}

/// Arguments that only matter with model files; the daemons have their own schedule and robot.
const OF_MODELS: [&str; 8] =
    ["schedule", "schedule_file", "link", "delay", "actuals", "robot", "resolution", "allow_boxes"];
/// Arguments of the running daemons.
const OF_DAEMONS: [&str; 3] = ["config", "demo", "robot_name"];

fn belongs_to_models(argument: Arg) -> Arg {
    let id = argument.get_id().as_str();
    if OF_MODELS.contains(&id) {
        argument.requires("models")
    } else if OF_DAEMONS.contains(&id) {
        argument.conflicts_with("models")
    } else {
        argument
    }
}

impl QuestionArgs {
    /// Paths of the model files; none if the running daemons are asked.
    pub(crate) fn models(&self) -> &[PathBuf] {
        &self.models
    }

    /// Paths of all files that are read.
    pub(crate) fn inputs(&self) -> impl Iterator<Item = &Path> {
        self.models.iter().map(PathBuf::as_path).chain(self.schedule.inputs())
    }

    /// The models.
    pub(super) fn model(&self) -> ModelArgs {
        ModelArgs::new(self.models.clone(), self.allow_boxes)
    }

    /// The options of waypoints that are given, if any. No answer tells of flight waypoints.
    pub(super) fn waypoint_options(&self) -> Result<Option<MissionPlanOptions>, Failure> {
        let read = |path| daemon::read_parsed("options of waypoints", path, MissionPlanOptions::parse);
        let options = self.waypoints.as_deref().map(read).transpose().map_err(Failure::usage)?;
        Ok(options.map(|options| MissionPlanOptions { flight: None, ..options }))
    }
}
