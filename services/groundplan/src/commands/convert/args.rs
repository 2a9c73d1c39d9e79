//! Arguments and help of `convert`.

use crate::args::{MeshCacheArgs, ModelArgs, OptionalFilesArgs, OverwriteArgs, RecordingArgs, RobotArgs, ScheduleArgs};
use std::path::PathBuf;

/// Arguments of `convert`.
#[derive(Debug, Clone, clap::Args)]
#[command(after_help = AFTER_HELP)]
pub struct Args {
    /// Output folder; earlier output in it is replaced as a whole, unless files in it were added or altered since
    #[arg(short, long, value_name = "OUT", required_unless_present = "mcap")]
    pub(super) out: Option<PathBuf>,

    /// With --date all: record the maps and markers of every change as stamped ROS 2 messages, to be played as a film of the
    /// construction; an earlier recording there is replaced
    #[arg(long, value_name = "FILE.mcap")]
    pub(super) mcap: Option<PathBuf>,

    /// What it has.
    #[command(flatten)]
    pub(super) recording: RecordingArgs,

    /// What becomes of files of others in it.
    #[command(flatten)]
    pub(super) overwrite: OverwriteArgs,

    /// Date of the maps: a day (2024-04-15, the union over it), an instant (2024-04-15T00:00:00 is its midnight, as in
    /// `states`), or `all`: a folder per change in OUT [default: everything is built]
    #[arg(long, value_name = "DATE")]
    pub(super) date: Option<String>,

    /// With --date all: everything built, if nothing has a date.
    #[arg(skip)]
    pub(crate) or_everything: bool,

    /// End of the period that the maps serve; a day counts whole
    #[arg(long, value_name = "DATE", requires = "date")]
    pub(super) until: Option<String>,

    /// Draw what is certain enough by [uncertainty] of the rules: obstacle is what may be there, floor what stands almost
    /// surely, closed what may be closed; and write the probability of obstacles as an image and a map
    #[arg(long, requires = "date")]
    pub(super) probability: bool,

    /// Rules and additions.
    #[command(flatten)]
    pub(super) schedule: ScheduleArgs,

    /// The robot.
    #[command(flatten)]
    pub(super) robot: RobotArgs,

    /// Which waypoints are planned, with which sensor [default: centres and scans, see config/waypoints.toml]
    #[arg(long, value_name = "FILE")]
    pub(super) waypoints: Option<PathBuf>,

    /// Write the maps, waypoints and routes of these storeys only: index, GlobalId or name, with * and ?; may be repeated,
    /// or separated by commas. Indices stay those of the whole building; ways over storeys that are left out still count for
    /// what can be reached, and are not in the site graph. semantic.json, report.json and world/ are of the whole building
    /// [default: all]
    #[arg(long, value_name = "WHICH")]
    pub(super) storeys: Vec<String>,

    /// Write vertices, faces and edges of every element into semantic.json
    #[arg(long)]
    pub(super) with_geometry: bool,

    /// Write exact footprints of all elements into semantic.json, which may take long and much room where they have much
    /// detail [default: exact ones of doors and floors; within 5 mm of structure, and a third of a cell of furniture and
    /// equipment]
    #[arg(long)]
    pub(super) exact_footprints: bool,

    /// Files beside those of every output.
    #[command(flatten)]
    pub(super) optional_files: OptionalFilesArgs,

    /// Use the map frame of this site-frame.json [default: that of OUT, if there is one]
    #[arg(long, value_name = "FILE", conflicts_with = "new_frame")]
    pub(super) frame: Option<PathBuf>,

    /// Fix the map frame anew and raise its epoch: maps and waypoints of earlier runs no longer fit
    #[arg(long)]
    pub(super) new_frame: bool,

    /// Write maps that are blank, or storeys with spaces and no obstacle
    #[arg(long)]
    pub(super) allow_empty: bool,

    /// The site.
    #[command(flatten)]
    pub(super) model: ModelArgs,

    /// Meshes of earlier conversions.
    #[command(flatten)]
    pub(super) meshes: MeshCacheArgs,

    /// Print one JSON summary on standard output and nothing else there, and progress as JSON lines on standard error
    #[arg(long)]
    pub(super) json: bool,
}

const AFTER_HELP: &str = "\
Files in OUT (written whole or not at all, the same bytes for the same input):
  manifest.json                 storeys, frames, robot, sources, sha256 of every file
  report.json                   what was counted, assumed, replaced by a box, left out; doors, regions
  semantic.json                 every element and space by GlobalId, with its footprints
  waypoints.{json,csv,geojson}  centres of spaces and scans that cover them, as a tour; why a space has none
  flight.json                   with [flight] in --waypoints: places in the air for drones
  waypoints.wgs84.geojson       the same by longitude and latitude, where the model's projected system can be computed
  site-graph.json               spaces, doors and junctions of all storeys, with stairs and lifts between them
  site-frame.json               the map frame; a later run into the same OUT keeps it
  world/                        with --world: world.sdf for Gazebo and other simulators, with meshes; lookup.json: what its
                                models are, by GlobalId; doors.urdf; site.glb for viewers; site.usda
                                with --usd; ground.xml: terrain and roads for MuJoCo, where
                                there are any
  cloud/                        with --cloud: structure.{pcd,ply}: the surfaces of what stands finished as points with normals,
                                for lidars that look in three dimensions; structure.json: their elements, by GlobalId
  octomap/                      with --octomap: structure.bt, an OctoMap: cells that structure occupies, cells that are free in
                                open rooms, all else unknown; structure.json: its volume, elements and rooms, by GlobalId
  fleet/vda5050/                with --fleet vda5050: zone sets and maps of storeys; maps.json:
                                instant actions that download them before the date and enable them at it
  fleet/lif/site.lif.json       with --fleet lif: the route graph as a layout for each storey
  open-rmf/                     with --open-rmf: NAME.building.yaml for the traffic editor,
                                NAME.site.json for the site editor, nav_graphs/0.yaml for fleet
                                adapters: levels, lanes, doors and lifts in Cartesian metres
  ground.ply, ground.json       with --with-ground: the surface that can be walked or driven on as a mesh, for no robot in
                                particular; what its numbers mean, its surfaces and where one gets between them
  storeys/<index>-<name>/
    planning.{pgm,yaml}         for global planning: 0 occupied, 254 free, 205 unknown or no floor
    localization.{pgm,yaml}     what a lidar sees of finished structure
    keepout.{pgm,yaml}          Nav2 keep-out mask: 0 drop-offs, work and margins, 205 elsewhere
    elevation.{png,yaml}        where the ground is not level: its height in map, 16 bits, in the yaml's scale
    slope.{png,yaml}            and its slope in radians
    waypoints.yaml              this storey's waypoints for Nav2
    route.geojson               this storey's graph for Nav2's route server, with ways to others
    semantic.png  classes.png   for people; class ids for programs
    waypoints.png               what scans see, the tour and its stops
    probability.{png,pgm,yaml}  with --probability: how probable obstacles are; pgm in per cent
With --date all these are in OUT/<date>/, and OUT/manifest.json lists the dates.

Topics of --mcap (profile ros2; written whole or not at all, the same bytes for the same input):
  /groundplan/map               planning.pgm as nav_msgs/OccupancyGrid
  /groundplan/localization_map  localization.pgm
  /groundplan/keepout_mask      keepout.pgm, with keepout_info for Nav2's costmap filter
  /groundplan/rooms             rooms with names and states, doors, edges of floors, as markers
  /groundplan/waypoints         waypoints with the tour; rooms that are not reached, and why
  /groundplan/route             ways of the route graph
  /groundplan/grid_map          with --grid-map: heights above the floor, slopes and traversability
  /groundplan/elevation         the same, to be coloured in Foxglove
  /groundplan/speed_mask        with --speed-mask: limits of speed, with speed_info for Nav2
Of several storeys each has topics /groundplan/<storey>/map .. and a frame <storey>, which
/tf_static lifts to its floor in the frame map. Stamps are the plan time, as if the site's clock
showed UTC.

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
  groundplan convert house.ifc -o maps --date 2024-04-15 --probability
  groundplan convert house.ifc -o maps --date all --schedule config/schedule.toml
  groundplan convert house.ifc -o maps --world --date 2024-04-15 --barriers
  groundplan convert house.ifc --mcap house.mcap --date all

Exit codes: 0 done, 1 failed, 2 bad usage or configuration. RUST_LOG=debug shows the steps.";
