//! Conventions of all JSON documents: units in keys, null for absent values.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

#[path = "../../export/tests/support/mod.rs"]
mod support;

use export::ExportInput;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;
use world::WorldOptions;

/// The JSON documents of the smallest building, by path.
fn documents() -> BTreeMap<String, Value> {
    let made = |input: &ExportInput<'_>| export::files(input, world::files(input, &WorldOptions::default()).files);
    let files = support::house().with_input(made);
    let json = files.iter().filter(|f| f.path.ends_with("json"));
    json.map(|f| (f.path.clone(), serde_json::from_slice(&f.bytes).unwrap())).collect()
}

/// Paths of empty texts in a document.
fn empty_texts(at: &str, value: &Value, found: &mut Vec<String>) {
    match value {
        Value::String(text) if text.is_empty() => found.push(at.to_owned()),
        Value::Array(items) => items.iter().enumerate().for_each(|(k, v)| empty_texts(&format!("{at}[{k}]"), v, found)),
        Value::Object(map) => map.iter().for_each(|(key, v)| empty_texts(&format!("{at}.{key}"), v, found)),
        _ => {}
    }
}

#[test]
fn there_is_null_where_there_is_nothing_and_never_an_empty_text() {
    let documents = documents();
    assert!(documents.len() > 8, "{:?}", documents.keys());
    let mut found = Vec::new();
    documents.iter().for_each(|(path, document)| empty_texts(path, document, &mut found));
    assert_eq!(found, Vec::<String>::new());
    let semantic = &documents["semantic.json"];
    assert!(semantic["elements"]["wall-0"]["name"].is_null());
    assert!(semantic["spaces"]["space-0"]["long_name"].is_null());
}

#[test]
fn the_semantic_document_says_its_frame() {
    let semantic = &documents()["semantic.json"];
    assert_eq!((&semantic["frame"], &semantic["frame_epoch"]), (&"map".into(), &1.into()));
}

#[test]
fn nodes_of_the_site_graph_have_the_names_and_ids_of_rooms() {
    let documents = documents();
    let node = &documents["site-graph.json"]["nodes"][0];
    assert_eq!(
        (&node["kind"], &node["of"], &node["name"]),
        (&"space".into(), &"space-0".into(), &"Küche, \"0.1\"".into())
    );
    assert_eq!((&node["space"], &node["space_name"]), (&"space-0".into(), &"Küche, \"0.1\"".into()));
    let route = documents.iter().find(|(path, _)| path.ends_with("route.geojson")).unwrap().1;
    assert_eq!(route["features"][1]["properties"]["metadata"]["space_name"], "Küche, \"0.1\"");
}

/// Ends of keys that say a unit.
const UNITS: [&str; 13] = ["_bits", "_m", "_m2", "_m3", "_rad", "_s", "_ms", "_h", "_hz", "_cells", "_kg", "_w", "_wh"];

/// Numbers without one: shares, ratios and probabilities, directions, coordinates of contracts that others fixed (GeoJSON, meshes, IFC).
const WITHOUT: [&str; 24] = [
    "coverage",
    "coverage_goal",
    "overlap",
    "overlap_goal",
    "registration_overlap",
    "joins_overlap_without",
    "completion",
    "share_of_walls",
    "share_of_floor",
    "unknown_share_of_floor",
    // Probabilities.
    "obstacle_above",
    "floor_above",
    "open_above",
    "confirmed",
    "drive_efficiency",
    "rolling_resistance",
    "axis",
    "up",
    "footprints",
    "vertices",
    "x_axis",
    "scale",
    // Corners of `aabb_m`.
    "min",
    "max",
];

/// True if a schema's value is a number that is no count, or lists of such.
fn is_measure(schema: &Value) -> bool {
    let has_type = |name: &str| match &schema["type"] {
        Value::String(one) => one == name,
        Value::Array(several) => several.iter().any(|t| t == name),
        _ => false,
    };
    has_type("number")
        || has_type("array") && (is_measure(&schema["items"]) || is_any_measure(&schema["prefixItems"]))
        || has_type("object") && is_measure(&schema["additionalProperties"])
}

fn is_any_measure(schemas: &Value) -> bool {
    schemas.as_array().is_some_and(|all| all.iter().any(is_measure))
}

fn keys_without_unit(name: &str, schema: &Value, found: &mut Vec<String>) {
    if let Some(properties) = schema["properties"].as_object() {
        for (key, property) in properties {
            let is_told = UNITS.iter().any(|unit| key.ends_with(unit)) || WITHOUT.contains(&key.as_str());
            if is_measure(property) && !is_told {
                found.push(format!("{name}: {key}"));
            }
        }
    }
    schema["$defs"].as_object().into_iter().flatten().for_each(|(_, inner)| keys_without_unit(name, inner, found));
}

#[test]
fn every_measure_has_its_unit_in_its_key() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/schemas");
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        // Configuration is read, not written.
        if name != "site.schema.json" {
            let schema: Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
            keys_without_unit(&name, &schema, &mut found);
        }
    }
    found.sort();
    assert_eq!(found, Vec::<String>::new());
}
