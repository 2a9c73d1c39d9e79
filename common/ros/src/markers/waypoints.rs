//! Waypoints, the tour through them, and spaces that have none.

use super::drawing::{BLOCKED, CHANGING, Drawing, OPEN, WAY, point};
use crate::msg::builtin_interfaces::Time;
use crate::msg::geometry_msgs::Quaternion;
use crate::msg::std_msgs::ColorRGBA;
use crate::msg::visualization_msgs::MarkerArray;
use messages::{MissionPlan, NoWaypoint, Site, WaypointPurpose, WaypointRecord, WaypointScan};

/// A scan.
const SCAN: ColorRGBA = ColorRGBA { r: 0.75, g: 0.2, b: 0.75, a: 1.0 };
/// Diameter of the ball in a space without a waypoint, in metres.
const BALL_M: f64 = 0.3;
/// How far below the middle of a space the reason stands, in metres: its name and state stand there.
const REASON_BELOW_M: f64 = 0.8;

/// The waypoints of a map storey: arrows in `waypoints` by id, tilted as the ground is, with their place in the tour in `waypoint_order`; centres green,
/// scans violet, scans that only join others orange. `tour` is the way through them. Spaces to which no way leads at this date
/// are red balls in `not_reached`, with the reason in `not_reached_reasons`, by space.
pub fn waypoints(
    site: &Site<'_>,
    mission_plan: &MissionPlan<'_>,
    map_storey: u32,
    frame_id: &str,
    stamp: Time,
) -> MarkerArray {
    let mut drawing = Drawing::new(frame_id, stamp);
    for waypoint in mission_plan.waypoints.iter().filter(|w| w.map_storey == map_storey) {
        let [x, y, _] = waypoint.position_in_map_m;
        let (id, color) = (waypoint.id as usize, colour(waypoint));
        drawing.arrow(("waypoints", id), color, [x, y], Quaternion::of_attitude(&waypoint.attitude()));
        drawing.text(("waypoint_order", id), color, [x, y], waypoint.order.to_string());
    }
    for storey in mission_plan.storeys.iter().filter(|s| s.map_storey == map_storey) {
        let points = mission_plan.tour_of(storey).iter().copied().map(point).collect();
        drawing.line_strip(("tour", 0), WAY, points);
    }
    for (index, space) in site.spaces.iter().enumerate().filter(|(_, s)| s.map_storey == map_storey) {
        if is_not_reached(mission_plan.spaces[index].why.get()) {
            let [x, y] = space.centroid_m;
            drawing.spheres(("not_reached", index), BLOCKED, BALL_M, vec![point([x, y])]);
            let (place, reason) = ([x, y - REASON_BELOW_M], mission_plan.reason(index).to_owned());
            drawing.text(("not_reached_reasons", index), BLOCKED, place, reason);
        }
    }
    drawing.finish()
}

fn colour(waypoint: &WaypointRecord) -> ColorRGBA {
    match waypoint.purpose() {
        WaypointPurpose::Centre => OPEN,
        WaypointPurpose::Scan(WaypointScan { joins: None, .. }) => SCAN,
        WaypointPurpose::Scan(WaypointScan { joins: Some(_), .. }) => CHANGING,
    }
}

/// True for what dates, doors and obstacles do to a space; false for what it is, or was not asked for.
fn is_not_reached(why: NoWaypoint) -> bool {
    use NoWaypoint::*;
    matches!(why, Blocked | Closing | NoFloor | Keepout | TooNarrow | ClosedDoor | Unreachable)
}
