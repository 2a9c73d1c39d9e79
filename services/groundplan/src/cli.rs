//! The command line; its help is the manual.

use crate::align::align;
use crate::args::{OverwriteArgs, PlaceArgs, ScheduleArgs, SiteArgs, WorldArgs};
use crate::commands::{changes, convert, states, tasks};
use crate::deviations::deviations;
use crate::failure::Failure;
use crate::run::{Outcome, Run};
use crate::{live, manual, monitor};
use clap::{Args, Parser, Subcommand};
use std::path::PathBuf;

/// Building models (IFC) into everything a robot needs to move before it has ever seen the place.
#[derive(Debug, Parser)]
#[command(name = "groundplan", version, propagate_version = true, max_term_width = 100)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Turn building models into maps per storey, semantic JSON and waypoints
    Convert(convert::Args),
    /// Tell which elements stand and which spaces may be entered at a date
    States(states::Args),
    /// List when anything changes, or what differs between two dates
    Changes(changes::Args),
    /// List the tasks of the schedule: when they are, what they act on, what is wrong with them
    Tasks(tasks::Args),
    /// Find the pose of a robot's SLAM map in the model's: of files, or of the map that the running daemon follows
    #[command(after_help = AFTER_ALIGN)]
    Align(AlignArgs),
    /// Start the daemons of a site and look after them until SIGTERM
    Up(UpArgs),
    /// Stop the daemons of a site
    Down(SiteArgs),
    /// Tell who lives and what is wrong; exit code 0 if all is well
    Status(StatusArgs),
    /// Load models into the running daemons; without any, read those again that are loaded
    Load(LoadArgs),
    /// Set the plan time of the running daemons, or let it move; returns when the new grids are out. Without arguments, tell it
    Date(DateArgs),
    /// Give the running daemons the progress that was reported; returns when the new grids are out
    Actuals(ActualsArgs),
    /// Set the robot of the running daemons; returns when the new grids are out
    Robot(RobotSetArgs),
    /// Tell the running daemons what waypoints to plan; returns when the plan is out. Without arguments, what is configured
    Waypoints(WaypointsArgs),
    /// Give the running daemons a map that the robot made, and align it; exit code 0 if accepted
    SlamMap(SlamMapArgs),
    /// Tell what stands, is missing or has moved against the plan, as a robot's map shows it
    #[command(after_help = AFTER_DEVIATIONS)]
    Deviations(DeviationsArgs),
    /// Say that the pose that waits is right, or that elements that the robot saw through are not there
    Confirm(ConfirmArgs),
    /// Watch the running daemons in the terminal: who lives, what is published, the maps themselves
    Monitor(MonitorArgs),
    /// Look at what is on the bus
    Topic(TopicArgs),
    /// Write the files of `convert` from the running daemons, at the plan time that they hold
    Export(ExportArgs),
    /// Tell what this machine lacks to run the daemons; exit code 0 if nothing
    Doctor(DoctorArgs),
    /// Print the completion script of a shell
    Completions(CompletionsArgs),
    /// Write manual pages into a folder
    Man(ManArgs),
    /// Create and hold the bus, and do nothing else; `up` starts it
    #[command(hide = true)]
    Keeper(KeeperArgs),
}

impl Command {
    /// Runs the command.
    ///
    /// # Errors
    /// Bad usage or configuration, or work that failed.
    pub fn run(&self) -> Result<Outcome, Failure> {
        let judged = |(text, is_well)| Outcome { text, is_well };
        match self {
            Self::Convert(command) => command.run(),
            Self::States(command) => command.run(),
            Self::Changes(command) => command.run(),
            Self::Tasks(command) => command.run(),
            Self::Align(arguments) => align(arguments).map(judged),
            Self::SlamMap(arguments) => live::slam_map(arguments).map(judged),
            Self::Deviations(arguments) => deviations(arguments).map(Outcome::from),
            Self::Confirm(arguments) => live::confirm(arguments).map(Outcome::from),
            Self::Up(arguments) => live::up(arguments).map(Outcome::from),
            Self::Down(arguments) => live::down(arguments).map(Outcome::from),
            Self::Status(arguments) => live::status(arguments).map(judged),
            Self::Load(arguments) => live::load(arguments).map(Outcome::from),
            Self::Date(arguments) => live::date(arguments).map(Outcome::from),
            Self::Actuals(arguments) => live::actuals(arguments).map(Outcome::from),
            Self::Robot(arguments) => live::robot(arguments).map(Outcome::from),
            Self::Waypoints(arguments) => live::waypoints(arguments).map(Outcome::from),
            Self::Monitor(arguments) => monitor::monitor(arguments).map(Outcome::from),
            Self::Topic(arguments) => live::topic(arguments).map(Outcome::from),
            Self::Export(arguments) => live::export(arguments).map(Outcome::from),
            Self::Doctor(arguments) => live::doctor(arguments).map(judged),
            Self::Completions(arguments) => manual::completions(arguments).map(Outcome::from),
            Self::Man(arguments) => manual::man(arguments).map(Outcome::from),
            Self::Keeper(arguments) => live::keeper(arguments).map(Outcome::from),
        }
    }
}

/// Arguments of `align`.
#[derive(Debug, Clone, Args)]
pub struct AlignArgs {
    /// Output folder of `convert`, or one map of the model: localization.yaml of a storey [default: the running daemon aligns
    /// the map that it follows with the site as planned]
    #[arg(long, value_name = "OUT", requires = "slam")]
    pub reference: Option<PathBuf>,

    /// Map that the robot made, as its map server saves it
    #[arg(long, value_name = "MAP.yaml", requires = "reference")]
    pub slam: Option<PathBuf>,

    /// Where it may lie.
    #[command(flatten)]
    pub place: PlaceArgs,

    /// Write the static transform from `map`, the robot's frame, to `site_map`, the model's; only if accepted
    #[arg(long, value_name = "FILE.yaml")]
    pub transform: Option<PathBuf>,

    /// Draw both maps in the best pose: walls of both green, what only the robot saw red, what it saw through orange
    #[arg(long, value_name = "FILE.png", requires = "reference")]
    pub overlay: Option<PathBuf>,

    /// Write maps, route graph and waypoints of the storey moved into the robot's frame; only if accepted
    #[arg(long, value_name = "FOLDER", requires = "reference", conflicts_with = "free_scale")]
    pub resample: Option<PathBuf>,

    /// What becomes of files of others in that folder.
    #[command(flatten)]
    pub overwrite: OverwriteArgs,

    /// Nobody vouches for the lengths of the SLAM map: try scales from 0.8 to 1.25
    #[arg(long, requires = "reference")]
    pub free_scale: bool,

    /// Print one JSON document on standard output and nothing else there
    #[arg(long)]
    pub json: bool,

    /// Align all pairs that FOLDER/pairs.jsonl names, for benchmarks
    #[arg(long, value_name = "FOLDER", conflicts_with_all = ["reference", "slam", "json"], requires = "json_lines")]
    pub pairs: Option<PathBuf>,

    /// Print a JSON document a line, one for each pair
    #[arg(long, requires = "pairs")]
    pub json_lines: bool,

    /// The site.
    #[command(flatten)]
    pub site: SiteArgs,
}

/// Arguments of `deviations`.
#[derive(Debug, Clone, Args)]
pub struct DeviationsArgs {
    /// IFC files of the site [default: what the running daemon compared]
    #[arg(value_name = "MODEL.ifc", requires = "slam")]
    pub models: Vec<PathBuf>,

    /// Map that the robot made, as its map server saves it
    #[arg(long, value_name = "MAP.yaml", requires = "models")]
    pub slam: Option<PathBuf>,

    /// Plan time that elements are judged by [default: everything is built]
    #[arg(long, value_name = "DATE", requires = "slam")]
    pub date: Option<String>,

    /// Take models of whose bodies more than half cannot be meshed, with bounding boxes for them
    #[arg(long, requires = "slam")]
    pub allow_boxes: bool,

    /// Folder for deviations.json, actuals.csv (for --actual), deviations.bcfzip (BCF 2.1) and deviations.png
    #[arg(short, long, value_name = "OUT")]
    pub out: Option<PathBuf>,

    /// What becomes of files of others in it.
    #[command(flatten)]
    pub overwrite: OverwriteArgs,

    /// Where the map may lie.
    #[command(flatten)]
    pub place: PlaceArgs,

    /// Rules and additions.
    #[command(flatten)]
    pub schedule: ScheduleArgs,

    /// Robot profile: the height of its lidar counts
    #[arg(long, value_name = "FILE")]
    pub robot: Option<PathBuf>,

    /// Print deviations.json on standard output and nothing else there
    #[arg(long)]
    pub json: bool,

    /// The site.
    #[command(flatten)]
    pub site: SiteArgs,
}

/// Arguments of `slam-map`.
#[derive(Debug, Clone, Args)]
pub struct SlamMapArgs {
    /// Map that the robot made, as its map server saves it
    #[arg(value_name = "MAP.yaml")]
    pub map: PathBuf,

    /// Print one JSON document on standard output and nothing else there
    #[arg(long)]
    pub json: bool,

    /// The site.
    #[command(flatten)]
    pub site: SiteArgs,
}

/// Arguments of `confirm`.
#[derive(Debug, Clone, Args)]
pub struct ConfirmArgs {
    /// These elements are not there although they are planned to be: the maps leave them out until they are seen [default: the
    /// pose that waits is right]
    #[arg(value_name = "GLOBALID")]
    pub absent: Vec<String>,

    /// Print one JSON document on standard output and nothing else there
    #[arg(long)]
    pub json: bool,

    /// The site.
    #[command(flatten)]
    pub site: SiteArgs,
}

/// Arguments of `up`.
#[derive(Debug, Clone, Args)]
pub struct UpArgs {
    /// The site.
    #[command(flatten)]
    pub site: SiteArgs,
}

/// Arguments of `keeper`.
#[derive(Debug, Clone, Args)]
pub struct KeeperArgs {
    /// The site.
    #[command(flatten)]
    pub site: SiteArgs,

    /// Stop when standard input ends
    #[arg(long)]
    pub with_stdin: bool,
}

/// Arguments of `status`.
#[derive(Debug, Clone, Args)]
pub struct StatusArgs {
    /// The site.
    #[command(flatten)]
    pub site: SiteArgs,

    /// Print one JSON document on standard output and nothing else there
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `load`.
#[derive(Debug, Clone, Args)]
pub struct LoadArgs {
    /// IFC files of one site
    #[arg(value_name = "MODEL.ifc")]
    pub models: Vec<PathBuf>,

    /// Return when the site is out; grids follow
    #[arg(long)]
    pub no_wait: bool,

    /// The site.
    #[command(flatten)]
    pub site: SiteArgs,
}

/// Arguments of `date`.
#[derive(Debug, Clone, Args)]
pub struct DateArgs {
    /// Plan time: 2024-04-15 (its midnight), 2024-04-15T08:30:00, or with an offset, see site_zone in the schedule rules
    #[arg(value_name = "DATE")]
    pub date: Option<String>,

    /// The next instant at which anything changes
    #[arg(long, conflicts_with = "date")]
    pub next: bool,

    /// Follow the clock of this machine, in the site_zone of the schedule rules
    #[arg(long, conflicts_with_all = ["date", "next"])]
    pub wall: bool,

    /// Run at a rate: 3600 is an hour a second; from DATE, or from where the plan time is
    #[arg(long, value_name = "RATE", conflicts_with_all = ["next", "wall"])]
    pub simulate: Option<f64>,

    /// Return when the plan time is on disk; grids follow
    #[arg(long)]
    pub no_wait: bool,

    /// The site.
    #[command(flatten)]
    pub site: SiteArgs,
}

/// Arguments of `actuals`.
#[derive(Debug, Clone, Args)]
pub struct ActualsArgs {
    /// CSV table with the columns id, start, finish; it replaces what was reported before
    #[arg(value_name = "FILE.csv", required_unless_present = "clear")]
    pub file: Option<PathBuf>,

    /// Nothing was reported
    #[arg(long, conflicts_with = "file")]
    pub clear: bool,

    /// The site.
    #[command(flatten)]
    pub site: SiteArgs,
}

/// Arguments of `robot`.
#[derive(Debug, Clone, Args)]
pub struct RobotSetArgs {
    /// Robot profile, see config/robots
    #[arg(value_name = "FILE")]
    pub profile: PathBuf,

    /// The site.
    #[command(flatten)]
    pub site: SiteArgs,
}

/// Arguments of `waypoints`.
#[derive(Debug, Clone, Args)]
pub struct WaypointsArgs {
    /// What to plan and with which sensor, see config/waypoints.toml [default: what is configured]
    #[arg(value_name = "FILE")]
    pub options: Option<PathBuf>,

    /// Only this space, by name, long name or GlobalId, with * and ?; may be repeated
    #[arg(long, value_name = "SPACE")]
    pub space: Vec<String>,

    /// Scan only what was built since this plan time
    #[arg(long, value_name = "DATE")]
    pub changed_since: Option<String>,

    /// The site.
    #[command(flatten)]
    pub site: SiteArgs,
}

/// Arguments of `export`.
#[derive(Debug, Clone, Args)]
pub struct ExportArgs {
    /// Output folder; earlier output in it is replaced as a whole, unless files in it were added or altered since
    #[arg(value_name = "OUT")]
    pub out: PathBuf,

    /// What becomes of files of others in it.
    #[command(flatten)]
    pub overwrite: OverwriteArgs,

    /// Go on until SIGTERM: write OUT/epochs/EPOCH for every new set of maps, and let the link OUT/current name the newest
    #[arg(long)]
    pub watch: bool,

    /// Run this program after each swap of the link, with the new folder as its argument
    #[arg(long, value_name = "PROGRAM", requires = "watch")]
    pub on_change: Option<PathBuf>,

    /// Keep this many epochs
    #[arg(long, value_name = "N", default_value_t = 5, requires = "watch")]
    pub keep: usize,

    /// The world.
    #[command(flatten)]
    pub world: WorldArgs,

    /// The site.
    #[command(flatten)]
    pub site: SiteArgs,
}

/// Arguments of `monitor`.
#[derive(Debug, Clone, Args)]
pub struct MonitorArgs {
    /// The site.
    #[command(flatten)]
    pub site: SiteArgs,

    /// Print everything that is shown as one JSON document a line, on every change
    #[arg(long)]
    pub json: bool,

    /// Stop after this time
    #[arg(long = "for", value_name = "SECONDS")]
    pub seconds: Option<f64>,
}

/// Arguments of `doctor`.
#[derive(Debug, Clone, Args)]
pub struct DoctorArgs {
    /// The site.
    #[command(flatten)]
    pub site: SiteArgs,

    /// Print one JSON document on standard output and nothing else there
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `completions`.
#[derive(Debug, Clone, Args)]
pub struct CompletionsArgs {
    /// Which shell
    #[arg(value_name = "SHELL")]
    pub shell: clap_complete::Shell,
}

/// Arguments of `man`.
#[derive(Debug, Clone, Args)]
pub struct ManArgs {
    /// Where to
    #[arg(value_name = "FOLDER")]
    pub folder: PathBuf,
}

/// Arguments of `topic`.
#[derive(Debug, Clone, Args)]
pub struct TopicArgs {
    /// What to look at.
    #[command(subcommand)]
    pub command: TopicCommand,
}

/// What to look at.
#[derive(Debug, Clone, Subcommand)]
pub enum TopicCommand {
    /// List the topics that have a sample
    List {
        /// Print one JSON document on standard output and nothing else there
        #[arg(long)]
        json: bool,
        /// The site.
        #[command(flatten)]
        site: SiteArgs,
    },
    /// Print the last sample of a topic as JSON: what it is, what it was made from
    Echo {
        /// site, phase, grids, grid/00 ..
        topic: String,
        /// Go on with every sample that comes, one a line, until SIGTERM
        #[arg(long)]
        follow: bool,
        /// On one line
        #[arg(long)]
        json: bool,
        /// The site.
        #[command(flatten)]
        site: SiteArgs,
    },
    /// Measure how often samples of a topic come, how large they are, and how long they take
    Hz {
        /// site, phase, grids, grid/00 ..
        topic: String,
        /// Measure for this time [default: until SIGTERM]
        #[arg(long = "for", value_name = "SECONDS")]
        seconds: Option<f64>,
        /// Print one JSON document on standard output and nothing else there
        #[arg(long)]
        json: bool,
        /// The site.
        #[command(flatten)]
        site: SiteArgs,
    },
}

const AFTER_ALIGN: &str = "\
The model's maps are those of all storeys in a folder that `convert` wrote, or one of them; the robot's is a
Nav2 map file of any resolution and origin. The answer is the motion `map_from_slam`:
p_map = R(yaw) p_slam + (x, y), with its covariance, or every pose that fits as well, or why there is none.

  accepted    one pose fits, and no other comes near
  ambiguous   several fit alike: a symmetric building, repeated rooms; all are told
  refused     another building or storey, too little overlap, too little structure

Exit codes: 0 accepted, 1 ambiguous, refused or failed, 2 bad usage.

Examples:
  groundplan align --reference maps --slam robot.yaml
  groundplan align --reference maps --storey 0 --slam robot.yaml --hint 3 4 90 --json";

const AFTER_DEVIATIONS: &str = "\
Observed: it stands where the model has it; absent: the robot saw through its place; displaced: it stands beside it;
unseen: nothing can be said, as of glass, doors, and whatever does not cross the lidar's plane or was hidden.
Judged by the plan at the date: on plan, late, early, displaced, unknown. Nothing changes a map by itself: give
actuals.csv to --actual, or see [align] apply and `groundplan confirm`.

Examples:
  groundplan deviations house.ifc --slam robot.yaml --date 2024-04-15 -o deviations
  groundplan deviations -o deviations

Exit codes: 0 done, 1 failed (the map's pose is not accepted), 2 bad usage or configuration.";
