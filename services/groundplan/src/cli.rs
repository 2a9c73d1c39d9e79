//! The command line; its help is the manual.

use crate::args::{ModelArgs, OverwriteArgs, PlaceArgs, RobotArgs, ScheduleArgs, SiteArgs, WorldArgs};
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
    #[command(after_help = AFTER_CONVERT)]
    Convert(ConvertArgs),
    /// Tell which elements stand and which spaces may be entered at a date
    #[command(after_help = AFTER_STATES)]
    States(StatesArgs),
    /// List when anything changes, or what differs between two dates
    #[command(after_help = AFTER_CHANGES)]
    Changes(ChangesArgs),
    /// List the tasks of the schedule: when they are, what they act on, what is wrong with them
    #[command(after_help = AFTER_TASKS)]
    Tasks(TasksArgs),
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

const AFTER_CONVERT: &str = "\
Files in OUT (written whole or not at all, the same bytes for the same input):
  manifest.json                 storeys, frames, robot, sources, sha256 of every file
  report.json                   what was counted, assumed, replaced by a box, left out; doors, regions
  semantic.json                 every element and space by GlobalId, with its footprints
  waypoints.{json,csv,geojson}  centres of spaces and scans that cover them, as a tour; why a space has none
  waypoints.wgs84.geojson       the same by longitude and latitude, where the model's projected system can be computed
  site-graph.json               spaces, doors and junctions of all storeys, with stairs and lifts between them
  site-frame.json               the map frame; a later run into the same OUT keeps it
  world/                        with --world: world.sdf for Gazebo and other simulators, with meshes; lookup.json: what its
                                models are, by GlobalId; doors.urdf; site.glb for viewers
  storeys/<index>-<name>/
    planning.{pgm,yaml}         for global planning: 0 occupied, 254 free, 205 unknown or no floor
    localization.{pgm,yaml}     what a lidar sees of finished structure
    keepout.{pgm,yaml}          Nav2 keep-out mask: 0 drop-offs, work and margins, 205 elsewhere
    waypoints.yaml              this storey's waypoints for Nav2
    route.geojson               this storey's graph for Nav2's route server, with ways to others
    semantic.png  classes.png   for people; class ids for programs
    waypoints.png               what scans see, the tour and its stops
With --date all these are in OUT/<date>/, and OUT/manifest.json lists the dates.

A line per storey ends with `31 of 156 m2 reached, 5 parts` where waypoints cannot be everywhere:
of the floor on which the middle of the robot can be, indoors and outdoors, 31 m2 hang together
with where it begins; the rest is in other parts, which report.json lists. It begins at [tour]
start of --waypoints, else on each storey in the part with the most room area, of those with a
stair, ramp, lift or outer door.

Examples:
  groundplan convert house.ifc -o maps
  groundplan convert architecture.ifc structure.ifczip -o maps --robot config/robots/legged.toml
  groundplan convert house.ifc -o maps --resolution 0.1 --json | jq .storeys
  groundplan convert house.ifc -o maps --storeys 0 --storeys 'Level 2*'
  groundplan convert house.ifc -o maps --date 2024-04-15
  groundplan convert house.ifc -o maps --date all --schedule config/schedule.toml
  groundplan convert house.ifc -o maps --world --date 2024-04-15 --barriers

Exit codes: 0 done, 1 failed, 2 bad usage or configuration. RUST_LOG=debug shows the steps.";

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

const AFTER_STATES: &str = "\
Dates are local to the site, or carry an offset, which is converted to the site's zone.
States are those of an instant: 2024-04-15 is its midnight, or 2024-04-15T08:30:00.
A map serves a whole day: `convert --date 2024-04-15` draws the union of all instants of the day,
which is `--date 2024-04-15 --until 2024-04-15` here. For a date without a time, what differs during
the day is told, too (\"whole_day\" in JSON). In a union a space is blocked if it is at any instant,
and an element that does not stand throughout is in_progress.
States of elements: not_started, in_progress, built, being_removed, removed.
Reasons of blocked spaces: task:GlobalId, before_room_date, or what the rules say (private).

Examples:
  groundplan states house.ifc --date 2024-04-15
  groundplan states house.ifc --date 2024-04-15T08:00:00 --date 2024-05-02 --json | jq '.[].spaces'
  groundplan states house.ifc --date 2024-04-15 --until 2024-04-19
  groundplan states house.ifc --date 2024-04-15 --delay 'Partition walls=5d'

Exit codes: 0 done, 1 failed, 2 bad usage or configuration.";

const AFTER_CHANGES: &str = "\
With --diff the maps of both dates are drawn for the robot and compared: which elements come and go, which doors can
be passed and which no longer, which spaces can be reached and which not.

Examples:
  groundplan changes house.ifc
  groundplan changes house.ifc --json | jq -r '.change_instants[]'
  groundplan changes house.ifc --diff 2024-04-15 2024-05-02

Exit codes: 0 done, 1 failed, 2 bad usage or configuration.";

const AFTER_TASKS: &str = "\
Dates are local to the site: written, rolled up from nested tasks, or computed from sequence,
durations and calendars. A task acts on elements that it constructs or removes, and on spaces that
are closed while it is at work. The file may link elements on which it has no effect, because it has
no dates, is of another kind, or another source goes before it.
The JSON document has a schema: config/schemas/tasks.schema.json.

Examples:
  groundplan tasks house.ifc
  groundplan tasks house.ifc --task 'Partition walls' --date 2024-04-15T08:00:00
  groundplan tasks house.ifc --json | jq -r '.tasks[] | [.start, .name] | @tsv'

Exit codes: 0 done, 1 failed, 2 bad usage or configuration.";

/// Arguments of `states`.
#[derive(Debug, Clone, Args)]
pub struct StatesArgs {
    /// The date, an instant: 2024-04-15 is its midnight; may be repeated
    #[arg(long, value_name = "DATE", required = true)]
    pub date: Vec<String>,

    /// Tell the union from the date until this one, as `convert` draws it; a day counts whole
    #[arg(long, value_name = "DATE")]
    pub until: Option<String>,

    /// Rules and additions.
    #[command(flatten)]
    pub schedule: ScheduleArgs,

    /// The site.
    #[command(flatten)]
    pub model: ModelArgs,

    /// Print one JSON document on standard output and nothing else there; an array if there are several dates
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `tasks`.
#[derive(Debug, Clone, Args)]
pub struct TasksArgs {
    /// Only this task, by GlobalId, identification or name; may be repeated
    #[arg(long, value_name = "TASK")]
    pub task: Vec<String>,

    /// Tell the status at this date: 2024-04-15 (its midnight) or 2024-04-15T08:30:00
    #[arg(long, value_name = "DATE")]
    pub date: Option<String>,

    /// Rules and additions.
    #[command(flatten)]
    pub schedule: ScheduleArgs,

    /// The site.
    #[command(flatten)]
    pub model: ModelArgs,

    /// Print one JSON document on standard output and nothing else there
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `changes`.
#[derive(Debug, Clone, Args)]
pub struct ChangesArgs {
    /// What differs between two dates
    #[arg(long, num_args = 2, value_names = ["A", "B"])]
    pub diff: Vec<String>,

    /// Rules and additions.
    #[command(flatten)]
    pub schedule: ScheduleArgs,

    /// The robot, for --diff.
    #[command(flatten)]
    pub robot: RobotArgs,

    /// The site.
    #[command(flatten)]
    pub model: ModelArgs,

    /// Print one JSON document on standard output and nothing else there
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `convert`.
#[derive(Debug, Clone, Args)]
pub struct ConvertArgs {
    /// Output folder; earlier output in it is replaced as a whole, unless files in it were added or altered since
    #[arg(short, long, value_name = "OUT")]
    pub out: PathBuf,

    /// What becomes of files of others in it.
    #[command(flatten)]
    pub overwrite: OverwriteArgs,

    /// Date of the maps: a day (2024-04-15, the union over it), an instant (2024-04-15T00:00:00 is its midnight, as in
    /// `states`), or `all`: a folder per change in OUT [default: everything is built]
    #[arg(long, value_name = "DATE")]
    pub date: Option<String>,

    /// End of the period that the maps serve; a day counts whole
    #[arg(long, value_name = "DATE", requires = "date")]
    pub until: Option<String>,

    /// Rules and additions.
    #[command(flatten)]
    pub schedule: ScheduleArgs,

    /// The robot.
    #[command(flatten)]
    pub robot: RobotArgs,

    /// Which waypoints are planned, with which sensor [default: centres and scans, see config/waypoints.toml]
    #[arg(long, value_name = "FILE")]
    pub waypoints: Option<PathBuf>,

    /// Write the maps, waypoints and routes of these storeys only: index, GlobalId or name, with * and ?; may be repeated,
    /// or separated by commas. Indices stay those of the whole building; ways over storeys that are left out still count for
    /// what can be reached, and are not in the site graph. semantic.json, report.json and world/ are of the whole building
    /// [default: all]
    #[arg(long, value_name = "WHICH")]
    pub storeys: Vec<String>,

    /// Write vertices, faces and edges of every element into semantic.json
    #[arg(long)]
    pub with_geometry: bool,

    /// The world.
    #[command(flatten)]
    pub world: WorldArgs,

    /// Use the map frame of this site-frame.json [default: that of OUT, if there is one]
    #[arg(long, value_name = "FILE", conflicts_with = "new_frame")]
    pub frame: Option<PathBuf>,

    /// Fix the map frame anew and raise its epoch: maps and waypoints of earlier runs no longer fit
    #[arg(long)]
    pub new_frame: bool,

    /// Write maps that are blank, or storeys with spaces and no obstacle
    #[arg(long)]
    pub allow_empty: bool,

    /// The site.
    #[command(flatten)]
    pub model: ModelArgs,

    /// Print one JSON summary on standard output and nothing else there
    #[arg(long)]
    pub json: bool,
}
