//! The route graph of a storey.

use super::drawing::{BLOCKED, Drawing, WAY, point};
use crate::msg::builtin_interfaces::Time;
use crate::msg::geometry_msgs::Point;
use crate::msg::visualization_msgs::MarkerArray;
use messages::{MissionPlan, RouteEdgeRecord, Site};

/// Diameter of a node in metres.
const NODE_M: f64 = 0.15;

/// The route graph of a map storey: ways in `route`, 0 those that the robot can take (blue) and 1 those that it cannot (red);
/// `route_nodes` are its places. Ways to other storeys are in `portals`, by edge of the mission plan, with kind and storey in
/// `portal_names`.
pub fn route(
    site: &Site<'_>,
    mission_plan: &MissionPlan<'_>,
    map_storey: u32,
    frame_id: &str,
    stamp: Time,
) -> MarkerArray {
    let mut drawing = Drawing::new(frame_id, stamp);
    let storey_of = |node: u32| mission_plan.nodes[node as usize].map_storey;
    let is_here = |edge: &&RouteEdgeRecord| edge.nodes.iter().all(|&node| storey_of(node) == map_storey);
    for (id, usable, color) in [(0, 1, WAY), (1, 0, BLOCKED)] {
        let edges = mission_plan.edges.iter().filter(is_here).filter(|edge| edge.usable == usable);
        let points = edges.flat_map(|edge| line(mission_plan, edge).windows(2).flatten().copied().collect::<Vec<_>>());
        drawing.line_list(("route", id), color, points.collect());
    }
    let nodes = mission_plan.nodes.iter().filter(|node| node.map_storey == map_storey);
    let places = nodes.map(|node| point([node.position_in_map_m[0], node.position_in_map_m[1]]));
    drawing.spheres(("route_nodes", 0), WAY, NODE_M, places.collect());
    for (id, edge) in mission_plan.edges.iter().enumerate().filter(|(_, edge)| !is_here(edge)) {
        let [from, to] = edge.nodes;
        let (node, other) = match [storey_of(from), storey_of(to)] {
            [here, other] if here == map_storey => (from, other),
            [other, here] if here == map_storey => (to, other),
            _ => continue,
        };
        let color = if edge.usable == 1 { WAY } else { BLOCKED };
        drawing.line_strip(("portals", id), color, line(mission_plan, edge));
        let [x, y, _] = mission_plan.nodes[node as usize].position_in_map_m;
        let storey = site.map_storeys.get(other as usize).map_or("", |storey| site.text(storey.name));
        drawing.text(("portal_names", id), color, [x, y], format!("{} to {storey}", edge.kind.get().name()));
    }
    drawing.finish()
}

/// The way of an edge in the plane.
fn line(mission_plan: &MissionPlan<'_>, edge: &RouteEdgeRecord) -> Vec<Point> {
    mission_plan.points_of(edge).iter().map(|&[x, y, _]| point([x, y])).collect()
}
