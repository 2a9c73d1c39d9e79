//! `nav_graphs/0.yaml`: the lanes as fleet adapters read them, as `building_map_generator` makes them of the building.

use crate::building::{Building, Level};
use crate::yaml;
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;

/// The file.
pub(crate) fn bytes(building: &Building) -> Vec<u8> {
    let levels: Map<String, Value> =
        building.levels.iter().map(|level| (level.name.clone(), level_of(building, level))).collect();
    let doors = building.levels.iter().flat_map(|level| level.doors.iter().map(move |door| (level, door)));
    let doors: Map<String, Value> =
        doors.map(|(level, door)| (door.name.clone(), json!({"endpoints": door.ends_m, "map": level.name}))).collect();
    let lift = |lift: &crate::lifts::Lift| {
        let ([x, y], [width, depth]) = (lift.centre_m, lift.half_m.map(|half| 2.0 * half));
        (lift.name.clone(), json!({"dims": [width, depth], "position": [x, y, lift.yaw_rad]}))
    };
    let value = json!({
        "building_name": building.name,
        "doors": doors,
        "levels": levels,
        "lifts": building.lifts.iter().map(lift).collect::<Map<String, Value>>(),
        "offset": [0.0, 0.0],
    });
    yaml::text(&[], &value)
}

/// Vertices with lanes alone, in the order in which lanes name them, and a lane for each direction.
fn level_of(building: &Building, level: &Level) -> Value {
    let mut number: BTreeMap<usize, usize> = BTreeMap::new();
    let mut vertices = Vec::new();
    let mut lanes = Vec::new();
    for lane in &level.lanes {
        let ends = lane.ends.map(|end| {
            *number.entry(end).or_insert_with(|| {
                let vertex = &level.vertices[end];
                let mut facts = Map::new();
                facts.insert("name".to_owned(), json!(vertex.name));
                facts.extend(vertex.global_id.iter().map(|id| ("ifc_guid".to_owned(), json!(id))));
                let lift = vertex.lift.map(|lift| &building.lifts[lift].name);
                facts.extend(lift.map(|lift| ("lift".to_owned(), json!(lift))));
                vertices.push(json!([vertex.at_m[0], vertex.at_m[1], facts]));
                vertices.len() - 1
            })
        });
        let facts: Map<String, Value> = lane.door.iter().map(|door| ("door_name".to_owned(), json!(door))).collect();
        lanes.push(json!([ends[0], ends[1], facts]));
        lanes.push(json!([ends[1], ends[0], facts]));
    }
    json!({"lanes": lanes, "vertices": vertices})
}
