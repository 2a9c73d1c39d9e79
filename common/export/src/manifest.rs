//! `manifest.json`: contents of an output folder and the inputs that it was made from.

use crate::assumed_rooms::assumed_rooms;
use crate::folders::storey_folder;
use crate::input::{ExportFile, ExportInput, ProbabilityInput};
use crate::site_frame::{MapFromWorld, SiteFrameFile};
use crate::text::text_or_null;
use frames::metres;
use messages::{ContentId, DoorCapability, FloorKind, RobotProfile, ScheduleState, Site};
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;

/// `manifest.json` of an output folder with a folder per change.
#[derive(Debug, Serialize, JsonSchema)]
pub struct DatesManifest {
    /// `groundplan`.
    tool: &'static str,
    /// Version of the program.
    version: &'static str,
    /// The files of the site.
    sources: Vec<Source>,
    /// The schedule files that the plan is from; absent if it is that of the models.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    schedule_sources: Vec<ScheduleSource>,
    /// The folders, by plan time.
    dates: Vec<DatedFolder>,
    /// sha256 of every other file.
    files: BTreeMap<String, String>,
}

/// A folder with the maps of one plan time.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct DatedFolder {
    /// Plan time: the instant of a change.
    pub plan_time: String,
    /// The next change; null behind the last.
    pub valid_until: Option<String>,
    /// The folder.
    pub directory: String,
}

impl DatesManifest {
    pub(crate) fn of(site: &Site<'_>, dates: Vec<DatedFolder>, files: BTreeMap<String, String>) -> Self {
        Self {
            tool: TOOL,
            version: VERSION,
            sources: Source::all(site),
            schedule_sources: ScheduleSource::all(site),
            dates,
            files,
        }
    }
}

/// Files with a manifest that lists them, for output that is not a site's maps: `head` is an object of its other keys.
pub fn with_manifest(head: serde_json::Value, mut files: Vec<ExportFile>) -> Vec<ExportFile> {
    let mut manifest = serde_json::json!({"tool": TOOL, "version": VERSION});
    for (key, value) in head.as_object().into_iter().flatten() {
        manifest[key] = value.clone();
    }
    manifest["files"] = serde_json::json!(crate::folders::sums("", &files));
    files.push(ExportFile::new("manifest.json", format!("{manifest:#}\n")));
    files
}

/// The value that identifies manifests of this program.
pub(crate) const TOOL: &str = "groundplan";
const VERSION: &str = env!("CARGO_PKG_VERSION");

/// What an output folder holds and what it was made from.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Manifest {
    /// `groundplan`.
    tool: &'static str,
    /// Version of the program.
    version: &'static str,
    /// The files of the site.
    sources: Vec<Source>,
    /// The schedule files that the plan is from; absent if it is that of the models.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    schedule_sources: Vec<ScheduleSource>,
    /// Plan time; null if all elements stand regardless of dates.
    plan_time: Option<String>,
    /// End of the period that the maps serve, exclusive; null for an instant. The maps are the union over the period:
    /// blocked if blocked at any instant of it, obstacle if present at any, floor only if floor throughout.
    plan_until: Option<String>,
    /// Last change at or before the plan time.
    valid_from: Option<String>,
    /// Next change after the plan time, or after the period.
    valid_until: Option<String>,
    /// True if the files hold a schedule that this map does not follow.
    schedule_ignored: bool,
    /// What the maps take as certain; null if they follow the planned dates as they are.
    probability: Option<Probability>,
    /// Metres per cell.
    resolution_m: f64,
    /// Bottom and top of the slab above the floor.
    slab_m: [f64; 2],
    /// The robot that the maps are for.
    robot: Robot,
    /// How frames lie to each other.
    frames: Frames,
    /// The storeys that are written, by index.
    storeys: Vec<Storey>,
    /// Indices of the map storeys that were not asked for: other files may name them, and there are no maps of them.
    storeys_left_out: Vec<u32>,
    /// sha256 of every other file.
    files: BTreeMap<String, String>,
}

/// How the states of the maps were decided from simulated schedules.
#[derive(Debug, Serialize, JsonSchema)]
struct Probability {
    /// How often the schedule was simulated.
    runs: u32,
    /// Seed of the drawn durations.
    seed: u32,
    /// An element that is there with a higher probability is an obstacle.
    obstacle_above: f64,
    /// An element that stands with a higher probability carries floor.
    floor_above: f64,
    /// A space that is open with a lower probability is blocked.
    open_above: f64,
}

impl Probability {
    fn of(input: &ProbabilityInput<'_>) -> Self {
        let ProbabilityInput { runs, seed, obstacle_above, floor_above, open_above, there: _ } = *input;
        Self { runs, seed, obstacle_above, floor_above, open_above }
    }
}

#[derive(Debug, Serialize, JsonSchema)]
struct Source {
    /// Base name.
    file: String,
    /// sha256 of the file.
    sha256: String,
    /// FILE_SCHEMA as written; null if it is empty.
    schema: Option<String>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct ScheduleSource {
    /// Base name.
    file: String,
    /// sha256 of the file.
    sha256: String,
    /// Program that wrote it, as the file says; null if it does not.
    written_by: Option<String>,
}

/// A robot profile; keys as in `config/robots/default.toml`.
#[derive(Debug, Serialize, JsonSchema)]
struct Robot {
    /// Null if the profile has none.
    name: Option<String>,
    height_m: f64,
    clearance_above_m: f64,
    step_height_m: f64,
    radius_m: f64,
    /// Outline in the robot's frame; null if not given.
    footprint_m: Option<Vec<[f64; 2]>>,
    max_slope_rad: f64,
    /// Steepest terrain across the way; null if the profile has none.
    max_cross_slope_rad: Option<f64>,
    climbs_stairs: bool,
    /// Cost of a cell on a stair, per cent of what is lethal; null where stairs are obstacles.
    stair_cost: Option<u32>,
    /// Door operations it manages.
    opens: Vec<&'static str>,
    door_margin_m: f64,
    edge_margin_m: f64,
    work_margin_m: f64,
    lidar_height_m: f64,
    /// Range of the lidar; null if not given.
    lidar_range_m: Option<f64>,
    sensor_height_m: f64,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Frames {
    /// From the IFC world to the frame of all products.
    map_from_world: MapFromWorld,
    /// From the IFC world to the projected system; null if no file has a map conversion.
    earth_from_world: Option<EarthFromWorld>,
    /// Counts changes of the map frame, from 1.
    frame_epoch: u32,
}

/// The place of the IFC world in a projected system, never applied to the maps:
/// `(eastings, northings, height) = (eastings_m, northings_m, orthogonal_height_m) + Rz(yaw_rad) (scale * p_world)`, in metres.
#[derive(Debug, Serialize, JsonSchema)]
struct EarthFromWorld {
    /// Name of the projected system, e.g. `EPSG:25832`; null if the file names none.
    crs: Option<String>,
    /// Unit in which the file writes eastings, northings and height, e.g. `MILLIMETRE`; applied here.
    map_unit: String,
    /// Metres per that unit.
    map_unit_m: f64,
    /// Easting of the world's origin.
    eastings_m: f64,
    /// Northing of the world's origin.
    northings_m: f64,
    /// Height of the world's origin.
    orthogonal_height_m: f64,
    /// Turn from eastings to the world's x axis, counter-clockwise.
    yaw_rad: f64,
    /// The same as a direction of length 1: XAxisAbscissa and XAxisOrdinate.
    x_axis: [f64; 2],
    /// Metres in the projected system per metre of the world, along the world's axes; units are applied.
    scale: [f64; 3],
}

impl EarthFromWorld {
    /// `None` if no file has a map conversion.
    fn of(site: &Site<'_>) -> Option<Self> {
        let head = site.head;
        let [eastings_m, northings_m, orthogonal_height_m] = head.earth_m;
        (head.has_earth == 1).then(|| Self {
            crs: Some(site.text(head.earth_crs).to_owned()).filter(|name| !name.is_empty()),
            map_unit: site.text(head.earth_unit).to_owned(),
            map_unit_m: head.earth_unit_m,
            eastings_m,
            northings_m,
            orthogonal_height_m,
            yaw_rad: libm::atan2(head.earth_x_axis[1], head.earth_x_axis[0]),
            x_axis: head.earth_x_axis,
            scale: head.earth_scale,
        })
    }
}

#[derive(Debug, Serialize, JsonSchema)]
struct Storey {
    /// Place among all map storeys of the site: those of the files from low to high, then their levels.
    index: u32,
    /// Name of the storey it is named after; null if it has none.
    name: Option<String>,
    /// GlobalId of the storey it is named after; null if no storey of the files is.
    global_id: Option<String>,
    /// Height of the finished floor in `map`.
    floor_z_m: f64,
    /// `built`: half of the rooms' area has slabs; else `assumed`.
    floor: &'static str,
    /// GlobalIds of the rooms without a slab whose floor is assumed, from large to small.
    assumed_rooms: Vec<String>,
    /// `ok`; `no_floor_yet`: nothing of it is free at this plan time; or `no_floor`: the model holds no floor, space or wall, and
    /// nothing of it ever is.
    status: &'static str,
    /// Folder of its files.
    directory: String,
    /// Columns and rows of its maps.
    size_cells: [u32; 2],
    /// Lower left corner of its maps in `map`.
    origin_m: [f64; 2],
}

impl Manifest {
    /// Of the inputs of an export.
    pub fn of(input: &ExportInput<'_>, files: BTreeMap<String, String>) -> Self {
        let (site, head) = (input.site, input.site.head);
        let time = |seconds: i64| messages::plan_time(seconds).map(|t| t.to_string());
        let plan_time = input.schedule_state.head.plan_time().map(|t| t.to_string());
        Self {
            tool: TOOL,
            version: VERSION,
            sources: Source::all(site),
            schedule_sources: ScheduleSource::all(site),
            plan_until: input.schedule_state.head.plan_until().map(|t| t.to_string()),
            valid_from: plan_time.as_ref().and_then(|_| time(input.schedule_state.head.valid_from_s)),
            valid_until: plan_time.as_ref().and_then(|_| time(input.schedule_state.head.valid_until_s)),
            schedule_ignored: schedule_ignored(site, input.schedule_state),
            plan_time,
            probability: input.probability.as_ref().map(Probability::of),
            resolution_m: crate::text::rounded(input.resolution_m),
            slab_m: input.index.head.robot.slab_m().map(crate::text::rounded),
            robot: Robot::of(input),
            frames: Frames {
                map_from_world: SiteFrameFile::of(site).map_from_world,
                earth_from_world: EarthFromWorld::of(site),
                frame_epoch: head.frame_epoch,
            },
            storeys: input.grids.each(|grid| Storey::of(input, grid)).collect(),
            storeys_left_out: (0..)
                .zip(site.map_storeys)
                .map(|(index, _)| index)
                .filter(|index| !input.writes(*index))
                .collect(),
            files,
        }
    }
}

impl Source {
    fn all(site: &Site<'_>) -> Vec<Self> {
        let text = |t| site.text(t).to_owned();
        let source = |s: &messages::SourceRecord| Self {
            file: text(s.file),
            sha256: ContentId::from_sha256(s.sha256).to_string(),
            schema: text_or_null(site.text(s.schema)),
        };
        site.sources.iter().map(source).collect()
    }
}

impl ScheduleSource {
    fn all(site: &Site<'_>) -> Vec<Self> {
        let text = |t| site.schedule.text(t);
        let source = |s: &messages::ScheduleSourceRecord| Self {
            file: text(s.file).to_owned(),
            sha256: ContentId::from_sha256(s.sha256).to_string(),
            written_by: text_or_null(text(s.written_by)),
        };
        site.schedule.sources.iter().map(source).collect()
    }
}

impl Storey {
    fn of(input: &ExportInput<'_>, grid: &messages::Grid<'_>) -> Self {
        let index = grid.head.map_storey;
        let record = &input.site.map_storeys[index as usize];
        let rooms = assumed_rooms(input.site).into_iter().map(|space| &input.site.spaces[space as usize]);
        let rooms = rooms.filter(|space| space.map_storey == index);
        Self {
            index,
            name: text_or_null(input.site.text(record.name)),
            global_id: text_or_null(input.site.text(record.global_id)),
            floor_z_m: metres(record.floor_z_tenths),
            floor: record.floor.get().name(),
            assumed_rooms: rooms.map(|s| input.site.text(s.global_id).to_owned()).collect(),
            status: status_of(grid),
            directory: storey_folder(input.site, index, record),
            size_cells: [grid.head.width, grid.head.height],
            origin_m: grid.spec().origin_m(),
        }
    }
}

/// True if the files say when things are built, and these maps show everything built.
pub fn schedule_ignored(site: &Site<'_>, schedule_state: &ScheduleState<'_>) -> bool {
    schedule_state.head.plan_time().is_none() && (site.has_schedule() || schedule_state.head.n_changes > 0)
}

/// Whether a storey can be stood on anywhere.
pub fn status_of(grid: &messages::Grid<'_>) -> &'static str {
    match grid.head.floor.get() {
        _ if grid.floor.iter().any(|&f| f != 0) => "ok",
        FloorKind::Missing => "no_floor",
        _ => "no_floor_yet",
    }
}

impl Robot {
    fn of(input: &ExportInput<'_>) -> Self {
        let RobotProfile {
            height_m,
            clearance_above_m,
            step_height_m,
            radius_m,
            max_slope_rad,
            max_cross_slope_rad,
            door_margin_m,
            edge_margin_m,
            work_margin_m,
            lidar_height_m,
            lidar_range_m,
            sensor_height_m,
            climbs_stairs,
            stair_cost,
            ..
        } = input.index.head.robot;
        Self {
            name: text_or_null(input.index.robot_name),
            height_m,
            clearance_above_m,
            step_height_m,
            radius_m,
            footprint_m: (!input.index.robot_footprint_m.is_empty()).then(|| input.index.robot_footprint_m.to_vec()),
            max_slope_rad,
            max_cross_slope_rad: (max_cross_slope_rad > 0.0).then_some(max_cross_slope_rad),
            climbs_stairs: climbs_stairs == 1,
            stair_cost: (stair_cost > 0).then_some(stair_cost),
            opens: DoorCapability::ALL
                .into_iter()
                .filter(|o| input.index.head.robot.opens(*o))
                .map(DoorCapability::name)
                .collect(),
            door_margin_m,
            edge_margin_m,
            work_margin_m,
            lidar_height_m,
            lidar_range_m: (lidar_range_m > 0.0).then_some(lidar_range_m),
            sensor_height_m,
        }
    }
}
