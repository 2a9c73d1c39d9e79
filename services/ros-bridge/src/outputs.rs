//! The messages of a set of maps, of an alignment and of the processes of a site.

use bus::SiteViews;
use daemon::{Report, RosConfig, SiteProcess, StatusBoard};
use messages::{Alignment, AlignmentVerdict, PoseValidity, ScheduleStateHead, plan_time};
use ros::maps::{keepout_info, keepout_mask, localization, planning};
use ros::markers::{doors, drop_offs, rooms, route, together, waypoints};
use ros::msg::builtin_interfaces::Time;
use ros::msg::diagnostic_msgs::{DiagnosticArray, DiagnosticStatus, KeyValue};
use ros::msg::nav_msgs::OccupancyGrid;
use ros::msg::nav2_msgs::CostmapFilterInfo;
use ros::msg::std_msgs::{self, Header};
use ros::msg::tf2_msgs::TFMessage;
use ros::msg::visualization_msgs::MarkerArray;
use serde::de::IgnoredAny;
use serde_json::json;
use std::time::Duration;

/// A process that has not reported for this time is stale.
const STALE: Duration = Duration::from_secs(3);

/// The messages of a set of maps, for one storey; all of them have its frame and one stamp.
pub(crate) struct Outputs {
    pub(crate) map: OccupancyGrid,
    pub(crate) localization_map: OccupancyGrid,
    pub(crate) keepout_mask: OccupancyGrid,
    pub(crate) keepout_info: CostmapFilterInfo,
    pub(crate) rooms: MarkerArray,
    pub(crate) waypoints: MarkerArray,
    pub(crate) route: MarkerArray,
    pub(crate) changed: std_msgs::String,
}

/// The messages of the storey at this place of the index.
pub(crate) fn outputs_of(
    views: &SiteViews<'_>,
    storey: usize,
    epoch: u64,
    config: &RosConfig,
    mask_topic: &str,
    stamp: Time,
) -> Outputs {
    let SiteViews { site, state, index, grids, mission_plan } = views;
    let (grid, frame) = (&grids[storey], config.frame.as_str());
    let map_storey = grid.head.map_storey;
    let empty = || together([]);
    let plan = mission_plan.as_ref();
    Outputs {
        map: planning(grid, frame, stamp),
        localization_map: localization(grid, frame, stamp),
        keepout_mask: keepout_mask(grid, frame, stamp),
        keepout_info: keepout_info(mask_topic, frame, stamp),
        rooms: together([
            rooms(site, state, map_storey, frame, stamp),
            doors(site, index, map_storey, frame, stamp),
            drop_offs(grid, frame, stamp),
        ]),
        waypoints: plan.map_or_else(empty, |plan| waypoints(site, plan, map_storey, frame, stamp)),
        route: plan.map_or_else(empty, |plan| route(site, plan, map_storey, frame, stamp)),
        changed: changed(state.head, map_storey, epoch),
    }
}

/// What a robot has to know of new maps: epoch, storey, plan time and until when they are valid.
fn changed(state: &ScheduleStateHead, map_storey: u32, epoch: u64) -> std_msgs::String {
    let time = |seconds: i64| plan_time(seconds).map(|time| time.to_string());
    let document = json!({
        "epoch": epoch,
        "storey": map_storey,
        "plan_time": time(state.plan_time_s),
        "valid_until": time(state.valid_until_s),
    });
    std_msgs::String { data: document.to_string() }
}

/// How the model's map lies in the robot's; `None` unless the pose may be used and the newest search accepted one.
pub(crate) fn transform_of(alignment: &Alignment<'_>, slam_frame: &str, frame: &str, stamp: Time) -> Option<TFMessage> {
    let may_be_used =
        alignment.validity() == PoseValidity::Effective && alignment.verdict() == AlignmentVerdict::Accepted;
    let pose = alignment.pose().filter(|_| may_be_used)?;
    Some(TFMessage { transforms: vec![ros::transforms::site_map_from_map(pose, slam_frame, frame, stamp)] })
}

/// How the processes of a site are.
pub(crate) fn diagnostics(
    board: &StatusBoard,
    processes: impl Iterator<Item = SiteProcess>,
    stamp: Time,
) -> DiagnosticArray {
    let status = processes.map(|process| status_of(process, board.is_alive(process), board.report(process)));
    DiagnosticArray { header: Header { stamp, frame_id: String::new() }, status: status.collect() }
}

fn status_of(process: SiteProcess, is_alive: bool, report: Option<Report<IgnoredAny>>) -> DiagnosticStatus {
    let name = format!("groundplan: {process}");
    let Some(report) = report.filter(|_| is_alive) else {
        let message = "it does not run".to_owned();
        return DiagnosticStatus { level: DiagnosticStatus::ERROR, name, message, ..DiagnosticStatus::default() };
    };
    let age = report.age();
    let (level, message) = match (&report.error, &report.warning) {
        _ if age >= STALE => (DiagnosticStatus::STALE, "it hangs"),
        (Some(error), _) => (DiagnosticStatus::ERROR, error.as_str()),
        (None, Some(warning)) => (DiagnosticStatus::WARN, warning.as_str()),
        (None, None) => (DiagnosticStatus::OK, report.activity.as_str()),
    };
    let value = |key: &str, value: String| KeyValue { key: key.to_owned(), value };
    let values = vec![
        value("process_id", report.process_id.to_string()),
        value("restarts", report.restarts.to_string()),
        value("memory_bytes", report.memory_bytes.to_string()),
        value("age_s", format!("{:.1}", age.as_secs_f64())),
    ];
    DiagnosticStatus { level, name, message: message.to_owned(), values, ..DiagnosticStatus::default() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bus::Daemon;

    fn report(error: Option<&str>, warning: Option<&str>) -> Report<IgnoredAny> {
        Report {
            process_id: 7,
            restarts: 1,
            stamp_ns: bus::Stamp::now().0,
            activity: "published".to_owned(),
            memory_bytes: 5,
            error: error.map(str::to_owned),
            warning: warning.map(str::to_owned),
            epochs: Default::default(),
            output_stamp_ns: None,
            latency_s: None,
            facts: IgnoredAny,
        }
    }

    #[test]
    fn the_level_is_that_of_what_is_worst() {
        let of = |is_alive, report| {
            let status = status_of(Daemon::Rasterize.into(), is_alive, report);
            (status.level, status.message)
        };
        assert_eq!(of(true, Some(report(None, None))), (DiagnosticStatus::OK, "published".to_owned()));
        assert_eq!(of(true, Some(report(None, Some("look")))), (DiagnosticStatus::WARN, "look".to_owned()));
        assert_eq!(of(true, Some(report(Some("bad"), Some("look")))), (DiagnosticStatus::ERROR, "bad".to_owned()));
        let hangs = Report { stamp_ns: 0, ..report(None, None) };
        assert_eq!(of(true, Some(hangs)).0, DiagnosticStatus::STALE);
        assert_eq!(of(false, Some(report(None, None))).0, DiagnosticStatus::ERROR);
        assert_eq!(of(true, None).0, DiagnosticStatus::ERROR);
    }
}
