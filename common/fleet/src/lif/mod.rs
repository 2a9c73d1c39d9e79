//! The route graph as layouts of LIF 1.0.0, one for each map storey.

mod document;
mod names;

use crate::ids::{id_of, map_id};
use document::{
    ControlPoint, Edge, Layout, LifDocument, MetaInformation, Node, Position, Station, Trajectory, VehicleEdge,
    VehicleNode,
};
use export::{ExportFile, ExportInput, json_text, rounded, space_name, text_or_null};
use messages::{ContentId, NodeKind, RouteEdgeRecord, WaypointPurpose, WaypointRecord};
use names::Names;

/// The file, in `fleet/lif/`.
pub fn files(input: &ExportInput<'_>) -> Vec<ExportFile> {
    vec![ExportFile::new("fleet/lif/site.lif.json", json_text(&document(input)))]
}

fn document(input: &ExportInput<'_>) -> LifDocument {
    let names = Names::of(input);
    let storeys = input.grids.heads().map(|head| head.map_storey);
    let project: Vec<&str> = input.site.sources.iter().map(|source| input.site.text(source.file)).collect();
    LifDocument {
        meta_information: MetaInformation {
            project_identification: project.join(", "),
            creator: "groundplan",
            export_timestamp: input
                .schedule_state
                .head
                .plan_time()
                .map_or_else(|| "1970-01-01T00:00:00Z".to_owned(), |time| format!("{time}Z")),
            lif_version: "1.0.0",
        },
        layouts: storeys.map(|map_storey| layout(input, &names, map_storey)).collect(),
    }
}

fn layout(input: &ExportInput<'_>, names: &Names, map_storey: u32) -> Layout {
    let map_id = map_id(input.site, map_storey);
    let plan = input.mission_plan;
    let vehicle = vehicle_type(input);
    let nodes = (0..).zip(plan.nodes).filter(|(_, node)| node.map_storey == map_storey).map(|(number, node)| {
        let [x, y, _] = node.position_in_map_m.map(rounded);
        Node {
            node_id: names.node(number).to_owned(),
            node_name: (node.kind == NodeKind::Space).then(|| space_name(input.site, node.of)).flatten(),
            map_id: map_id.clone(),
            node_position: Position { x, y, theta: None },
            vehicle_type_node_properties: [VehicleNode { vehicle_type_id: vehicle.clone() }],
        }
    });
    let edges =
        names.edges().iter().filter(|edge| plan.nodes[edge.from as usize].map_storey == map_storey).map(|edge| Edge {
            edge_id: edge.id.clone(),
            start_node_id: names.node(edge.from).to_owned(),
            end_node_id: names.node(edge.to).to_owned(),
            vehicle_type_edge_properties: [VehicleEdge {
                vehicle_type_id: vehicle.clone(),
                rotation_allowed: true,
                trajectory: trajectory(input, &plan.edges[edge.edge as usize], edge.is_back),
            }],
        });
    let waypoints = plan.waypoints.iter().filter(|waypoint| waypoint.map_storey == map_storey);
    let mut layout = Layout {
        layout_id: map_id.clone(),
        layout_name: text_or_null(input.site.text(input.site.map_storeys[map_storey as usize].name)),
        layout_version: String::new(),
        layout_level_id: map_id.clone(),
        nodes: nodes.collect(),
        edges: edges.collect(),
        stations: waypoints.filter_map(|waypoint| station(input, names, waypoint)).collect(),
    };
    // Of all that it says: the same version is the same layout.
    layout.layout_version = ContentId::of(&json_text(&layout)).short().to_string();
    layout
}

/// The robot, by the name of its profile.
fn vehicle_type(input: &ExportInput<'_>) -> String {
    match input.index.robot_name {
        "" => "robot".to_owned(),
        name => id_of(name),
    }
}

/// The way of an edge as a curve of degree 1 through its points; `None` for a straight one.
fn trajectory(input: &ExportInput<'_>, edge: &RouteEdgeRecord, is_back: bool) -> Option<Trajectory> {
    let mut control_points: Vec<ControlPoint> = input
        .mission_plan
        .points_of(edge)
        .iter()
        .map(|[x, y, _]| ControlPoint { x: rounded(*x), y: rounded(*y) })
        .collect();
    control_points.dedup();
    if is_back {
        control_points.reverse();
    }
    let last = control_points.len().checked_sub(1).filter(|&last| last > 1)?;
    let inner = (0..=last).map(|k| k as f64 / last as f64);
    let knot_vector = [0.0].into_iter().chain(inner).chain([1.0]).collect();
    Some(Trajectory { degree: 1, knot_vector, control_points })
}

/// The centre of a room, where one comes to it; `None` for other waypoints, and where the graph has no node for the room.
fn station(input: &ExportInput<'_>, names: &Names, waypoint: &WaypointRecord) -> Option<Station> {
    match waypoint.purpose() {
        WaypointPurpose::Centre => {}
        WaypointPurpose::Scan(_) => return None,
    }
    let is_there = |node: &messages::RouteNodeRecord| {
        node.kind == NodeKind::Space && node.of == waypoint.space && node.map_storey == waypoint.map_storey
    };
    let node = input.mission_plan.nodes.iter().position(is_there)?;
    let [x, y, _] = waypoint.position_in_map_m.map(rounded);
    let space = &input.site.spaces[waypoint.space as usize];
    Some(Station {
        station_id: format!("centre:{}:{}", id_of(input.site.text(space.global_id)), waypoint.map_storey),
        interaction_node_ids: [names.node(node as u32).to_owned()],
        station_name: space_name(input.site, waypoint.space),
        station_position: Position { x, y, theta: Some(rounded(waypoint.yaw_rad)) },
    })
}
