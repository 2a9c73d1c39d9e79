//! `NAME.building.yaml`: the format of the traffic editor, in Cartesian metres.

use crate::building::{Building, Level, Vertex};
use crate::doors::{Door, DoorKind, Swing};
use crate::lifts::{Lift, Side};
use crate::yaml;
use serde_json::{Map, Value, json};
use std::f64::consts::FRAC_PI_2;

/// A text as the traffic editor writes parameters: 1 for texts, 2 for whole numbers, 3 for numbers, 4 for truth values.
fn text(value: &str) -> Value {
    json!([1, value])
}

/// The file.
pub(crate) fn bytes(building: &Building) -> Vec<u8> {
    let levels: Map<String, Value> =
        building.levels.iter().map(|level| (level.name.clone(), level_of(building, level))).collect();
    let lifts: Map<String, Value> =
        building.lifts.iter().map(|lift| (lift.name.clone(), lift_of(building, lift))).collect();
    let value = json!({
        "coordinate_system": "cartesian_meters",
        "levels": levels,
        "lifts": lifts,
        "name": building.name,
        "parameters": {},
    });
    yaml::text(&comments(building), &value)
}

/// What is not in the file although it is there.
fn comments(building: &Building) -> Vec<String> {
    let ways: Vec<String> = building.left_out.iter().map(|(class, n)| format!("{n} by {class}")).collect();
    let sentence =
        || format!("Ways between levels that are not here, because Open-RMF has lifts alone: {}", ways.join(", "));
    let n_walls = building.n_walls_left_out;
    let walls =
        (n_walls > 0).then(|| format!("Pieces of walls that are not here, because they are not straight: {n_walls}"));
    (!ways.is_empty()).then(sentence).into_iter().chain(walls).collect()
}

fn level_of(building: &Building, level: &Level) -> Value {
    let mut vertices: Vec<Value> = level.vertices.iter().map(|vertex| vertex_of(building, vertex)).collect();
    let mut doors = Vec::new();
    for door in &level.doors {
        let first = vertices.len();
        vertices.extend(door.ends_m.iter().map(|[x, y]| json!([x, y, 0.0, "", {}])));
        doors.push(json!([first, first + 1, door_of(door)]));
    }
    let mut walls = Vec::new();
    for ends_m in &level.walls {
        let first = vertices.len();
        vertices.extend(ends_m.iter().map(|[x, y]| json!([x, y, 0.0, "", {}])));
        walls.push(json!([first, first + 1, {"alpha": [3, 1.0], "texture_name": text("default")}]));
    }
    let lane = json!({"bidirectional": [4, true], "graph_idx": [2, 0], "orientation": [1, ""]});
    let lanes: Vec<Value> = level.lanes.iter().map(|of| json!([of.ends[0], of.ends[1], lane])).collect();
    json!({"doors": doors, "elevation": level.elevation_m, "lanes": lanes, "vertices": vertices, "walls": walls})
}

fn vertex_of(building: &Building, vertex: &Vertex) -> Value {
    let mut parameters = Map::new();
    parameters.extend(vertex.global_id.iter().map(|id| ("ifc_guid".to_owned(), text(id))));
    parameters.extend(vertex.lift.map(|lift| ("lift_cabin".to_owned(), text(&building.lifts[lift].name))));
    let [x, y] = vertex.at_m;
    json!([x, y, 0.0, vertex.name, parameters])
}

fn door_of(door: &Door) -> Value {
    let (kind, swing, ratio) = match door.kind {
        DoorKind::Hinged(swing) => ("hinged", swing, 1.0),
        DoorKind::DoubleHinged(swing, ratio) => ("double_hinged", swing, ratio),
        DoorKind::Sliding => ("sliding", Swing::Forward, 1.0),
        DoorKind::DoubleSliding(ratio) => ("double_sliding", Swing::Forward, ratio),
    };
    json!({
        "ifc_guid": text(&door.global_id),
        "ifc_operation": text(&door.operation),
        "motion_axis": text("start"),
        "motion_degrees": [3, 90.0],
        // A leaf that turns about its first end counter-clockwise has the direction -1.
        "motion_direction": [2, if swing == Swing::Backward { 1 } else { -1 }],
        "name": text(&door.name),
        "plugin": text("normal"),
        "right_left_ratio": [3, 1.0 / ratio],
        "type": text(kind),
    })
}

fn lift_of(building: &Building, lift: &Lift) -> Value {
    let level_name = |level: &usize| building.levels[*level].name.as_str();
    let door = |door: &crate::lifts::LiftDoor| {
        let [out, along] = door.side.axes();
        let at = |k: usize| out[k] * lift.half_m[k] + along[k] * door.along_m;
        let turn = if matches!(door.side, Side::Front | Side::Back) { FRAC_PI_2 } else { 0.0 };
        let value = json!({
            "door_type": 2, "motion_axis_orientation": turn, "width": door.width_m, "x": at(0), "y": at(1),
        });
        (door.name.clone(), value)
    };
    let doors_at = |level: &usize| {
        let here = lift.doors.iter().filter(|door| door.levels.contains(level));
        (level_name(level).to_owned(), here.map(|door| door.name.as_str()).collect())
    };
    let (lowest, highest) = (level_name(&lift.levels[0]), level_name(&lift.levels[lift.levels.len() - 1]));
    json!({
        "depth": 2.0 * lift.half_m[1],
        "doors": lift.doors.iter().map(door).collect::<Map<String, Value>>(),
        "highest_floor": highest,
        "initial_floor_name": lowest,
        "level_doors": lift.levels.iter().map(doors_at).collect::<Map<String, Value>>(),
        "lowest_floor": lowest,
        "plugins": true,
        "reference_floor_name": lowest,
        "width": 2.0 * lift.half_m[0],
        "x": lift.centre_m[0],
        "y": lift.centre_m[1],
        "yaw": lift.yaw_rad,
    })
}
