//! A LIF document, with the keys of the format.

use serde::Serialize;

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct LifDocument {
    pub(super) meta_information: MetaInformation,
    pub(super) layouts: Vec<Layout>,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct MetaInformation {
    pub(super) project_identification: String,
    pub(super) creator: &'static str,
    pub(super) export_timestamp: String,
    pub(super) lif_version: &'static str,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Layout {
    pub(super) layout_id: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) layout_name: Option<String>,
    pub(super) layout_version: String,
    pub(super) layout_level_id: String,
    pub(super) nodes: Vec<Node>,
    pub(super) edges: Vec<Edge>,
    pub(super) stations: Vec<Station>,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Node {
    pub(super) node_id: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) node_name: Option<String>,
    pub(super) map_id: String,
    pub(super) node_position: Position,
    pub(super) vehicle_type_node_properties: [VehicleNode; 1],
}

#[derive(Debug, Serialize)]
pub(super) struct Position {
    pub(super) x: f64,
    pub(super) y: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) theta: Option<f64>,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct VehicleNode {
    pub(super) vehicle_type_id: String,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Edge {
    pub(super) edge_id: String,
    pub(super) start_node_id: String,
    pub(super) end_node_id: String,
    pub(super) vehicle_type_edge_properties: [VehicleEdge; 1],
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct VehicleEdge {
    pub(super) vehicle_type_id: String,
    /// Ways are clear for the circle around the robot.
    pub(super) rotation_allowed: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) trajectory: Option<Trajectory>,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Trajectory {
    pub(super) degree: u32,
    pub(super) knot_vector: Vec<f64>,
    pub(super) control_points: Vec<ControlPoint>,
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(super) struct ControlPoint {
    pub(super) x: f64,
    pub(super) y: f64,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Station {
    pub(super) station_id: String,
    pub(super) interaction_node_ids: [String; 1],
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) station_name: Option<String>,
    pub(super) station_position: Position,
}
