//! The route graph: GeoJSON per storey for Nav2's route server, and `site-graph.json` for all storeys.

use crate::input::ExportInput;
use crate::text::{rounded, text_or_null};
use crate::waypoints::{space_id, space_name};
use messages::{EdgeKind, JOULES_PER_WH, NONE, NodeKind, RouteEdgeRecord, RouteNodeRecord, WayCost};
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::{Map, Value, json};

/// `site-graph.json`: the route graph of all storeys.
#[derive(Debug, Serialize, JsonSchema)]
pub struct SiteGraph {
    /// `map`.
    frame: &'static str,
    /// Epoch of the map frame.
    frame_epoch: u32,
    /// Plan time; null if all elements stand regardless of dates.
    plan_time: Option<String>,
    /// Places.
    nodes: Vec<Node>,
    /// Ways between them, each in both directions.
    edges: Vec<Edge>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Node {
    /// Number, the same as in the storeys' `route.geojson`.
    id: u32,
    /// `space`, `door`, `junction`, or `staging`: before a door, stair, ramp, lift or step.
    kind: &'static str,
    /// Index of the map storey.
    storey: u32,
    /// In `map`.
    x_m: f64,
    /// In `map`.
    y_m: f64,
    /// Height of the floor in `map`.
    z_m: f64,
    /// Distance to the middle of the nearest cell that is not free.
    clearance_m: f64,
    /// GlobalId of the space, door, stair, ramp or lift, or of the floor above a step; null for a junction.
    of: Option<String>,
    /// Name of that, for a space with its long name; null for a junction, or if it has none.
    name: Option<String>,
    /// GlobalId of the space that it lies in; null outside of spaces.
    space: Option<String>,
    /// Name and long name of that space; null outside of spaces, or if it has none.
    space_name: Option<String>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Edge {
    /// Number, another than that of any node.
    id: u32,
    /// Node at one end.
    from: u32,
    /// Node at the other end.
    to: u32,
    /// `floor`, `door`, and between storeys `stair`, `ramp`, `lift`, `escalator`, `step`, or `ground`: one place on the map of a storey
    /// and on that of the ground outdoors.
    class: &'static str,
    /// Length of the way, as walked, up the slope.
    length_m: f64,
    /// Least distance to the middle of a cell that is not free; null between storeys.
    clearance_m: Option<f64>,
    /// GlobalId of the door, stair, ramp or lift, or of the floor above a step.
    of: Option<String>,
    /// Clear width of the door, with the leaves that count together, or of the stair where its flights are narrowest; null
    /// elsewhere and where it is unknown.
    clear_width_m: Option<f64>,
    /// How much higher the second end is than the first; null on level floor.
    rise_m: Option<f64>,
    /// How steep a ramp, or the ground under the way, is where it is steepest; null for everything else.
    slope_rad: Option<f64>,
    /// Time from the first end to the second and back, where the way leads over slopes, or the options of the waypoints tell what
    /// climbing takes.
    #[serde(skip_serializing_if = "Option::is_none")]
    duration_s: Option<[f64; 2]>,
    /// Energy there and back in watt-hours, if the options of the waypoints tell the mass of the robot.
    #[serde(skip_serializing_if = "Option::is_none")]
    energy_wh: Option<[f64; 2]>,
    /// Number of risers of the stair; null elsewhere and where it is unknown.
    n_risers: Option<u32>,
    /// True if this robot can take it.
    usable: bool,
    /// The way from one end to the other, in `map`; of a stair over its treads and landings.
    line_m: Vec<[f64; 2]>,
    /// Heights of the points of the line in `map`; null on level floor.
    line_z_m: Option<Vec<f64>>,
}

impl SiteGraph {
    /// Of the inputs of an export.
    pub fn of(input: &ExportInput<'_>) -> Self {
        let nodes = input.mission_plan.nodes.iter().zip(0..).map(|(node, id)| {
            let [x_m, y_m, z_m] = node.position_in_map_m.map(rounded);
            Node {
                id,
                kind: node.kind.get().name(),
                storey: node.map_storey,
                x_m,
                y_m,
                z_m,
                clearance_m: rounded(node.clearance_m),
                of: node_of(input, node),
                name: node_name(input, node),
                space: space_id(input, node.space),
                space_name: space_name(input.site, node.space),
            }
        });
        let edges = input.mission_plan.edges.iter().enumerate().map(|(at, edge)| {
            let class = edge.kind.get();
            let is_level = matches!(class, EdgeKind::Floor | EdgeKind::Door);
            let is_flat =
                is_level && input.mission_plan.points_of(edge).windows(2).all(|pair| pair[0][2] == pair[1][2]);
            Edge {
                id: edge_id(input, at),
                from: edge.nodes[0],
                to: edge.nodes[1],
                class: class.name(),
                length_m: rounded(edge.length_m),
                clearance_m: is_level.then(|| rounded(edge.clearance_m)),
                of: edge_of(input, edge),
                clear_width_m: clear_width_m(input, edge),
                rise_m: (!is_flat).then(|| rise_m(input, edge)),
                slope_rad: (class == EdgeKind::Ramp || edge.slope_rad > 0.0).then(|| rounded(edge.slope_rad)),
                duration_s: duration_s(input, edge),
                energy_wh: energy_wh(input, edge),
                n_risers: n_risers(edge),
                usable: edge.usable == 1,
                line_m: plan_of(input, edge),
                line_z_m: (!is_flat)
                    .then(|| input.mission_plan.points_of(edge).iter().map(|p| rounded(p[2])).collect()),
            }
        });
        Self {
            frame: "map",
            frame_epoch: input.site.head.frame_epoch,
            plan_time: input.schedule_state.head.plan_time().map(|t| t.to_string()),
            nodes: nodes.collect(),
            edges: edges.collect(),
        }
    }
}

/// The graph of a storey as Nav2's route server reads it, GeoJSON in a frame: edges in both directions, ids that no two features
/// share, and no null anywhere.
pub fn nav2_route_file(input: &ExportInput<'_>, map_storey: u32, frame_id: &str) -> Vec<u8> {
    crate::json::text(&nav2_route(input, map_storey, frame_id))
}

fn nav2_route(input: &ExportInput<'_>, map_storey: u32, frame_id: &str) -> Value {
    let mission_plan = input.mission_plan;
    let mut features = Vec::new();
    for (id, node) in mission_plan.nodes.iter().enumerate().filter(|(_, n)| n.map_storey == map_storey) {
        let [x, y, _] = node.position_in_map_m.map(rounded);
        let mut metadata = Map::new();
        metadata.insert("class".to_owned(), json!(node.kind.get().name()));
        metadata.insert("clearance_m".to_owned(), json!(rounded(node.clearance_m)));
        metadata.extend(node_of(input, node).map(|guid| ("ifc_guid".to_owned(), json!(guid))));
        metadata.extend(node_name(input, node).map(|name| ("name".to_owned(), json!(name))));
        metadata.extend(space_id(input, node.space).map(|guid| ("space".to_owned(), json!(guid))));
        metadata.extend(space_name(input.site, node.space).map(|name| ("space_name".to_owned(), json!(name))));
        features.push(json!({
            "type": "Feature",
            "geometry": {"type": "Point", "coordinates": [x, y]},
            "properties": {"id": id, "frame": frame_id, "metadata": metadata, "operations": {}},
        }));
    }
    let is_here =
        |e: &RouteEdgeRecord| e.nodes.iter().all(|&n| mission_plan.nodes[n as usize].map_storey == map_storey);
    for (at, edge) in mission_plan.edges.iter().enumerate().filter(|(_, e)| is_here(e) && e.usable == 1) {
        let mut metadata = Map::new();
        metadata.insert("class".to_owned(), json!(edge.kind.get().name()));
        metadata.insert("length_m".to_owned(), json!(rounded(edge.length_m)));
        metadata.insert("clearance_m".to_owned(), json!(rounded(edge.clearance_m)));
        metadata.extend(edge_of(input, edge).map(|guid| ("ifc_guid".to_owned(), json!(guid))));
        metadata.extend(clear_width_m(input, edge).map(|width| ("clear_width_m".to_owned(), json!(width))));
        let mut line = plan_of(input, edge);
        let [a, b] = edge.nodes;
        let costs = nav2_costs(input, edge);
        for (back, [from, to]) in [(0, [a, b]), (1, [b, a])] {
            features.push(json!({
                "type": "Feature",
                "geometry": {"type": "MultiLineString", "coordinates": [line]},
                "properties": {
                    "id": edge_id(input, at) + back, "startid": from, "endid": to, "cost": costs[back as usize],
                    "overridable": true, "metadata": metadata, "operations": {},
                },
            }));
            line.reverse();
        }
    }
    let leads_away = |e: &RouteEdgeRecord| {
        !is_here(e) && e.nodes.iter().any(|&n| mission_plan.nodes[n as usize].map_storey == map_storey)
    };
    features.extend(
        mission_plan
            .edges
            .iter()
            .enumerate()
            .filter(|(_, e)| leads_away(e))
            .map(|(at, e)| way_up(input, at, e, frame_id)),
    );
    json!({"type": "FeatureCollection", "name": "route", "features": features})
}

/// A connection to another storey, for readers of the file. It is a collection of one line, because Nav2 takes every
/// line for an edge of its graph, and the other end of this one is in another storey's graph.
fn way_up(input: &ExportInput<'_>, at: usize, edge: &RouteEdgeRecord, frame_id: &str) -> Value {
    let storey_of = |node: u32| input.mission_plan.nodes[node as usize].map_storey;
    let [from, to] = edge.nodes;
    let mut metadata = Map::new();
    metadata.insert("class".to_owned(), json!(edge.kind.get().name()));
    metadata.insert("length_m".to_owned(), json!(rounded(edge.length_m)));
    metadata.insert("storeys".to_owned(), json!([storey_of(from), storey_of(to)]));
    metadata.insert("nodes".to_owned(), json!([from, to]));
    metadata.insert("usable".to_owned(), json!(edge.usable == 1));
    metadata.extend(edge_of(input, edge).map(|guid| ("ifc_guid".to_owned(), json!(guid))));
    metadata.extend(clear_width_m(input, edge).map(|width| ("clear_width_m".to_owned(), json!(width))));
    metadata.extend(n_risers(edge).map(|n| ("n_risers".to_owned(), json!(n))));
    let line: Vec<[f64; 3]> = input.mission_plan.points_of(edge).iter().map(|p| p.map(rounded)).collect();
    json!({
        "type": "Feature",
        "geometry": {"type": "GeometryCollection", "geometries": [{"type": "LineString", "coordinates": line}]},
        "properties": {"id": edge_id(input, at), "frame": frame_id, "metadata": metadata},
    })
}

fn plan_of(input: &ExportInput<'_>, edge: &RouteEdgeRecord) -> Vec<[f64; 2]> {
    input.mission_plan.points_of(edge).iter().map(|[x, y, _]| [*x, *y].map(rounded)).collect()
}

/// Where it is told: over slopes, and where slopes were asked for.
fn duration_s(input: &ExportInput<'_>, edge: &RouteEdgeRecord) -> Option<[f64; 2]> {
    let is_told = edge.slope_rad > 0.0 || input.mission_plan.head.drive.is_asked_for();
    is_told.then(|| edge.duration_s.map(rounded))
}

fn energy_wh(input: &ExportInput<'_>, edge: &RouteEdgeRecord) -> Option<[f64; 2]> {
    let is_told = input.mission_plan.head.drive.has_energy();
    is_told.then(|| edge.energy_j.map(|energy_j| rounded(energy_j / JOULES_PER_WH)))
}

/// What the edge costs Nav2's route server there and back: metres, seconds or watt-hours.
fn nav2_costs(input: &ExportInput<'_>, edge: &RouteEdgeRecord) -> [f64; 2] {
    match input.mission_plan.head.drive.cost.get() {
        WayCost::Length => [rounded(edge.length_m); 2],
        WayCost::Time => edge.duration_s.map(rounded),
        WayCost::Energy => edge.energy_j.map(|energy_j| rounded(energy_j / JOULES_PER_WH)),
    }
}

fn n_risers(edge: &RouteEdgeRecord) -> Option<u32> {
    (edge.n_risers != NONE).then_some(edge.n_risers)
}

/// Behind the numbers of all nodes, one for either direction.
fn edge_id(input: &ExportInput<'_>, at: usize) -> u32 {
    (input.mission_plan.nodes.len() + 2 * at) as u32
}

fn element_id(input: &ExportInput<'_>, element: u32) -> Option<String> {
    input.site.elements.get(element as usize).map(|e| input.site.text(e.global_id).to_owned())
}

fn node_of(input: &ExportInput<'_>, node: &RouteNodeRecord) -> Option<String> {
    match node.kind.get() {
        NodeKind::Junction => None,
        NodeKind::Space => space_id(input, node.of),
        NodeKind::Door => input.site.doors.get(node.of as usize).and_then(|d| element_id(input, d.element)),
        NodeKind::Staging => element_id(input, node.of),
    }
}

fn element_name(input: &ExportInput<'_>, element: u32) -> Option<String> {
    input.site.elements.get(element as usize).and_then(|e| text_or_null(input.site.text(e.name)))
}

/// Name of what a node is.
fn node_name(input: &ExportInput<'_>, node: &RouteNodeRecord) -> Option<String> {
    match node.kind.get() {
        NodeKind::Junction => None,
        NodeKind::Space => space_name(input.site, node.of),
        NodeKind::Door => input.site.doors.get(node.of as usize).and_then(|d| element_name(input, d.element)),
        NodeKind::Staging => element_name(input, node.of),
    }
}

fn edge_of(input: &ExportInput<'_>, edge: &RouteEdgeRecord) -> Option<String> {
    match edge.kind.get() {
        EdgeKind::Floor => None,
        EdgeKind::Door => input.site.doors.get(edge.of as usize).and_then(|d| element_id(input, d.element)),
        _ => element_id(input, edge.of),
    }
}

fn rise_m(input: &ExportInput<'_>, edge: &RouteEdgeRecord) -> f64 {
    let [from, to] = edge.nodes.map(|n| input.mission_plan.nodes[n as usize].position_in_map_m[2]);
    rounded(to - from)
}

/// Clear width of a door with the leaves that count together, or of a flight of stairs.
fn clear_width_m(input: &ExportInput<'_>, edge: &RouteEdgeRecord) -> Option<f64> {
    let width_m = match edge.kind.get() {
        EdgeKind::Door => {
            let found = input.index.doors.iter().find(|d| d.door == edge.of).map(|d| d.clear_width_m);
            found.or_else(|| input.site.doors.get(edge.of as usize).map(|d| d.clear_width_m))
        }
        _ => Some(edge.clear_width_m).filter(|width| *width > 0.0),
    };
    width_m.map(rounded)
}
