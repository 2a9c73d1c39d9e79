//! The messages of a set of maps, of an alignment and of the processes of a site.

use daemon::{RosConfig, SiteProcess, StatusBoard};
use export::{ExportInput, nav2_route_file};
use grid::GridSpecError;
use messages::{ContentHash, Grid, ProcessHealth, RobotProfile, ScheduleStateHead, SeenProcess, SlamFrame, plan_time};
use ros::maps::{keepout_info, keepout_mask, localization, planning, speed_info, speed_mask};
use ros::markers::{doors, drop_offs, rooms, route, together, waypoints};
use ros::msg::builtin_interfaces::Time;
use ros::msg::diagnostic_msgs::{DiagnosticArray, DiagnosticStatus, KeyValue};
use ros::msg::foxglove_msgs::Grid as FoxgloveGrid;
use ros::msg::grid_map_msgs::GridMap;
use ros::msg::nav_msgs::OccupancyGrid;
use ros::msg::nav2_msgs::CostmapFilterInfo;
use ros::msg::std_msgs::{self, Header};
use ros::msg::visualization_msgs::MarkerArray;
use ros::relief::{foxglove_grid, grid_map};
use ros::{Layers, Relief};
use safety::{SafetyInput, speed_step_m_s};
use serde_json::json;
use site_view::{MapState, MapsInUse, SiteViews, Staleness, Storeys};

/// A message that is not larger than this reaches a reader for sure; larger ones are lost now and then (8 MB, less a header).
const MAX_CELLS: usize = 8_000_000 - 1024;

/// What the grids of a storey are made of: the same key, the same grids.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct GridsKey {
    /// Index of the map storey.
    pub(crate) storey: u32,
    content_hash: ContentHash,
    /// Number of the robot's frame, if they lie in it.
    slam_frame: Option<u64>,
    /// Hash of the mask of speeds, if there is one.
    speed: Option<ContentHash>,
    /// Steepest ground of the robot, if there are heights: traversability depends on it.
    max_slope_rad: Option<f64>,
}

/// The grids of a storey; all have one frame and one stamp.
pub(crate) struct GridMessages {
    pub(crate) map: OccupancyGrid,
    pub(crate) localization_map: OccupancyGrid,
    pub(crate) keepout_mask: OccupancyGrid,
    pub(crate) keepout_info: CostmapFilterInfo,
    /// Limits of speed and what they mean, if the site wants them.
    pub(crate) speed: Option<(OccupancyGrid, CostmapFilterInfo)>,
    /// Heights, slopes and traversability, if the site wants them.
    pub(crate) grid_map: Option<GridMap>,
    /// The same for Foxglove, if it is served.
    pub(crate) elevation: Option<FoxgloveGrid>,
    /// Metres per cell; more than those of the daemons where a message would be too large.
    pub(crate) resolution_m: f64,
}

/// The messages of a set of maps, for one storey.
pub(crate) struct Outputs {
    pub(crate) key: GridsKey,
    pub(crate) grids: GridMessages,
    pub(crate) rooms: MarkerArray,
    pub(crate) waypoints: MarkerArray,
    pub(crate) route: MarkerArray,
    /// The route graph as Nav2's route server reads it; `None` before there is one.
    pub(crate) route_graph: Option<Vec<u8>>,
    pub(crate) changed: std_msgs::String,
    /// The maps that these are.
    pub(crate) maps: MapsInUse,
}

/// Where the messages belong.
#[derive(Clone, Copy)]
pub(crate) struct Target<'a> {
    pub(crate) config: &'a RosConfig,
    /// Name of the mask's topic.
    pub(crate) mask_topic: &'a str,
    /// Name of the topic of the mask of speeds.
    pub(crate) speed_topic: &'a str,
    /// The robot's frame that grids are moved into, with its number; `None` to leave them in the model's.
    pub(crate) slam_frame: Option<(u64, &'a SlamFrame)>,
    pub(crate) stamp: Time,
}

/// Grids that cannot be messages.
#[derive(Debug, thiserror::Error)]
pub(crate) enum OutputFault {
    #[error("the maps cannot be moved into the robot's frame")]
    Moved(#[source] GridSpecError),
    #[error("the maps of storey {storey} are too large for messages, also in cells of a metre")]
    TooLarge { storey: u32 },
}

/// The messages of the storey at this place of the index.
///
/// # Errors
/// Grids that cannot be messages.
pub(crate) fn outputs_of(
    views: &SiteViews<'_>,
    storey: usize,
    epoch: u64,
    target: Target<'_>,
) -> Result<Outputs, OutputFault> {
    let SiteViews { site, state, index, grids, mission_plan } = views;
    let (grid, frame, stamp) = (&grids[storey], target.config.frame.as_str(), target.stamp);
    let map_storey = grid.head.map_storey;
    let safety_input = SafetyInput { site, schedule_state: state, index };
    let speed = target.config.speed_mask.then(|| safety::speed_mask(safety_input, grid));
    let key = GridsKey {
        storey: map_storey,
        content_hash: index.slots[storey].content_hash,
        slam_frame: target.slam_frame.map(|(number, _)| number),
        speed: speed
            .as_deref()
            .map(|mask| ContentHash::of(&mask.iter().map(|steps| steps.unsigned_abs()).collect::<Vec<u8>>())),
        max_slope_rad: target.config.grid_map.then_some(index.head.robot.max_slope_rad),
    };
    let speed = speed.map(|mask| (mask, speed_step_m_s(index.safety_rules)));
    let messages = grid_messages(grid, speed, &index.head.robot, target)?;
    let empty = || together([]);
    let plan = mission_plan.as_ref();
    let route_graph = plan.and_then(|mission_plan| {
        let input = ExportInput::of_maps(site, state, index, grids, mission_plan)?;
        Some(nav2_route_file(&input, map_storey, frame))
    });
    Ok(Outputs {
        key,
        rooms: together([
            rooms(site, state, map_storey, frame, stamp),
            doors(site, index, map_storey, frame, stamp),
            drop_offs(grid, frame, stamp),
        ]),
        waypoints: plan.map_or_else(empty, |plan| waypoints(site, plan, map_storey, frame, stamp)),
        route: plan.map_or_else(empty, |plan| route(site, plan, map_storey, frame, stamp)),
        route_graph,
        changed: changed(state.head, map_storey, epoch, messages.resolution_m),
        grids: messages,
        maps: MapsInUse { epoch, site_hash: index.head.site_hash, grids: index.slots.to_vec() },
    })
}

/// The grids of a storey for a robot, with a mask of speeds in steps of metres per second if there is one.
fn grid_messages(
    grid: &Grid<'_>,
    speed: Option<(Vec<i8>, f64)>,
    robot: &RobotProfile,
    target: Target<'_>,
) -> Result<GridMessages, OutputFault> {
    let Target { config, mask_topic, speed_topic, slam_frame, stamp } = target;
    let frame = if slam_frame.is_some() { &config.slam_frame } else { &config.frame };
    let mut layers = Layers::of(grid);
    let mut step_m_s = 0.0;
    if let Some((mask, step)) = speed {
        (layers, step_m_s) = (layers.with_speed(mask), step);
    }
    if let Some((_, slam_frame)) = slam_frame {
        layers = layers.moved(slam_frame).map_err(OutputFault::Moved)?;
    }
    let layers = layers.within(MAX_CELLS).ok_or(OutputFault::TooLarge { storey: grid.head.map_storey })?;
    let relief = config.grid_map.then(|| relief_of(grid, robot, slam_frame)).transpose()?;
    let relief = relief.as_ref();
    Ok(GridMessages {
        map: planning(&layers, frame, stamp),
        localization_map: localization(&layers, frame, stamp),
        keepout_mask: keepout_mask(&layers, frame, stamp),
        keepout_info: keepout_info(mask_topic, frame, stamp),
        speed: speed_mask(&layers, frame, stamp).map(|mask| (mask, speed_info(speed_topic, step_m_s, frame, stamp))),
        grid_map: relief.map(|relief| grid_map(relief, frame, stamp)),
        elevation: relief.filter(|_| config.foxglove.is_some()).map(|relief| foxglove_grid(relief, frame, stamp)),
        resolution_m: layers.spec.resolution_m(),
    })
}

/// Heights of a storey, small enough for a message; in the robot's frame if there is one.
fn relief_of(
    grid: &Grid<'_>,
    robot: &RobotProfile,
    slam_frame: Option<(u64, &SlamFrame)>,
) -> Result<Relief, OutputFault> {
    let mut relief = Relief::of(grid, robot);
    if let Some((_, slam_frame)) = slam_frame {
        relief = relief.moved(slam_frame).map_err(OutputFault::Moved)?;
    }
    relief.within(MAX_CELLS / Relief::CELL_BYTES).ok_or(OutputFault::TooLarge { storey: grid.head.map_storey })
}

/// What a robot has to know of new maps: epoch, storey, plan time and until when they are valid, size of their cells.
fn changed(state: &ScheduleStateHead, map_storey: u32, epoch: u64, resolution_m: f64) -> std_msgs::String {
    let document = json!({
        "epoch": epoch,
        "storey": map_storey,
        "plan_time": time_text(state.plan_time_s),
        "valid_until": time_text(state.valid_until_s),
        "resolution_m": resolution_m,
    });
    std_msgs::String { data: document.to_string() }
}

/// What counts for a robot on a storey: maps of it whose successors were not passed on for too long are stale.
pub(crate) fn state_on(storey: Option<u32>, state: MapState, late: Option<Staleness>) -> MapState {
    let is_here = |late: &Staleness| storey.is_some_and(|s| late.storeys.contains(&Storeys::Only([s].into())));
    match late.filter(is_here) {
        Some(Staleness { reason, .. }) => MapState::Stale { reason },
        None => state,
    }
}

/// Once a second: whether the maps may be used, and if not, why.
pub(crate) fn heartbeat(
    state: &MapState,
    maps: Option<&MapsInUse>,
    schedule_state: Option<&ScheduleStateHead>,
    storey: Option<u32>,
) -> std_msgs::String {
    let outdated = match (state, storey) {
        (MapState::Fresh { outdated_storeys }, Some(storey)) => outdated_storeys.contains(&storey),
        _ => false,
    };
    let reason = match state {
        MapState::Fresh { .. } if outdated => Some("new maps of the storey are on their way"),
        MapState::Fresh { .. } => None,
        MapState::Unknown => Some("it is not known yet whether the maps are those of the daemons"),
        MapState::Stale { reason } => Some(reason.as_str()),
    };
    let is_usable = maps.is_some() && storey.is_some() && !matches!(state, MapState::Stale { .. });
    let document = json!({
        "state": if is_usable { "fresh" } else { "stale" },
        "reason": reason,
        "epoch": maps.map(|maps| maps.epoch),
        "storey": storey,
        "plan_time": schedule_state.and_then(|head| time_text(head.plan_time_s)),
        "valid_until": schedule_state.and_then(|head| time_text(head.valid_until_s)),
    });
    std_msgs::String { data: document.to_string() }
}

fn time_text(seconds: i64) -> Option<String> {
    plan_time(seconds).map(|time| time.to_string())
}

/// How the processes of a site are.
pub(crate) fn diagnostics(
    board: &StatusBoard,
    processes: impl Iterator<Item = SiteProcess>,
    stamp: Time,
) -> DiagnosticArray {
    let status = processes.map(|process| status_of(&board.seen(process)));
    DiagnosticArray { header: Header { stamp, frame_id: String::new() }, status: status.collect() }
}

fn status_of(process: &SeenProcess) -> DiagnosticStatus {
    let name = format!("groundplan: {}", process.name);
    let (health, wrong) = process.health();
    let level = match health {
        ProcessHealth::Down | ProcessHealth::Error => DiagnosticStatus::ERROR,
        ProcessHealth::Hangs => DiagnosticStatus::STALE,
        ProcessHealth::Warning => DiagnosticStatus::WARN,
        ProcessHealth::Ok => DiagnosticStatus::OK,
    };
    let report = process.report.as_ref().filter(|_| health != ProcessHealth::Down);
    let message = wrong.or(report.map(|report| report.activity.as_str())).unwrap_or_default().to_owned();
    let value = |key: &str, value: String| KeyValue { key: key.to_owned(), value };
    let values = report.map_or_else(Vec::new, |report| {
        vec![
            value("process_id", report.process_id.to_string()),
            value("restarts", report.restarts.to_string()),
            value("memory_bytes", report.memory_bytes.to_string()),
            value("age_s", format!("{:.1}", report.age.as_secs_f64())),
        ]
    });
    DiagnosticStatus { level, name, message, values, ..DiagnosticStatus::default() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::SeenReport;
    use std::time::Duration;

    #[test]
    fn late_maps_of_the_robots_storey_are_stale_and_those_of_others_are_not() {
        let storeys = std::collections::BTreeSet::from([2]);
        let late = || Some(Staleness { reason: "no pose".to_owned(), storeys: Storeys::Only(storeys.clone()) });
        let fresh = || MapState::Fresh { outdated_storeys: storeys.clone() };
        let maps = MapsInUse { epoch: 1, site_hash: ContentHash::NONE, grids: Vec::new() };
        let told = |storey: Option<u32>, late: Option<Staleness>| {
            let said = heartbeat(&state_on(storey, fresh(), late), Some(&maps), None, storey).data;
            let said: serde_json::Value = serde_json::from_str(&said).unwrap();
            (said["state"].as_str().unwrap().to_owned(), said["reason"].as_str().map(str::to_owned))
        };
        assert_eq!(told(Some(2), late()), ("stale".to_owned(), Some("no pose".to_owned())));
        assert_eq!(told(Some(1), late()), ("fresh".to_owned(), None));
        assert_eq!(told(Some(2), None).0, "fresh", "for a moment they are used");
    }

    #[test]
    fn the_level_is_that_of_what_is_worst() {
        let of = |is_alive, report| {
            let status = status_of(&SeenProcess { name: "rasterize".to_owned(), is_alive, report });
            assert_eq!(status.name, "groundplan: rasterize");
            (status.level, status.message, status.values.len())
        };
        let report = SeenReport {
            age: Duration::from_millis(1_240),
            is_overdue: false,
            process_id: 7,
            restarts: 1,
            memory_bytes: 5,
            activity: "published".to_owned(),
            error: None,
            warning: None,
            busy: None,
        };
        let [bad, look] = ["bad", "look"].map(|text| Some(text.to_owned()));
        let warning = SeenReport { warning: look, ..report.clone() };
        assert_eq!(of(true, Some(report.clone())), (DiagnosticStatus::OK, "published".to_owned(), 4));
        assert_eq!(of(true, Some(warning.clone())), (DiagnosticStatus::WARN, "look".to_owned(), 4));
        let error = SeenReport { error: bad, ..warning };
        assert_eq!(of(true, Some(error)), (DiagnosticStatus::ERROR, "bad".to_owned(), 4));
        let hangs = SeenReport { is_overdue: true, ..report.clone() };
        assert_eq!(of(true, Some(hangs)), (DiagnosticStatus::STALE, "it hangs".to_owned(), 4));
        assert_eq!(of(false, Some(report)), (DiagnosticStatus::ERROR, "it does not run".to_owned(), 0));
        assert_eq!(of(true, None), (DiagnosticStatus::ERROR, "it does not run".to_owned(), 0));
    }
}
