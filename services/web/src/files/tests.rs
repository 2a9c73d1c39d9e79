use super::*;
use crate::tiles::{Layer, TilePlace};
use serde_json::{Value, json};
use std::fs;

/// Two dates of a storey of 3 x 2 cells: an obstacle goes.
pub(crate) fn dated_maps(folder: &Path) {
    let mut dates = Vec::new();
    for (date, (pixel, state)) in [(0_u8, "built"), (254, "removed")].into_iter().enumerate() {
        let directory = format!("d{date}");
        let storey = folder.join(&directory).join("storeys/00-floor");
        fs::create_dir_all(&storey).unwrap();
        let pgm = [&b"P5\n3 2\n255\n"[..], &[205, pixel, 254, 254, 254, 254]].concat();
        fs::write(storey.join("planning.pgm"), &pgm).unwrap();
        let write = |name: &str, value: Value| {
            fs::write(folder.join(&directory).join(name), value.to_string()).unwrap();
        };
        let schedule = json!({"state": state, "start": null});
        write("semantic.json", json!({"elements": {"a": {"schedule": schedule, "attributes": {}}}, "spaces": {}}));
        write("waypoints.json", json!({"waypoints": [], "spaces": {}}));
        write("site-graph.json", json!({"nodes": [], "edges": []}));
        write("report.json", json!({"doors": []}));
        let hash = format!("{date}").repeat(64);
        let manifest = json!({
            "sources": [{"file": "house.ifc"}], "plan_time": format!("2024-04-0{}T08:00:00", date + 1), "valid_until": null,
            "schedule_ignored": false, "resolution_m": 0.5, "robot": {}, "frames": {},
            "storeys": [{"index": 0, "name": "Floor", "floor_z_m": 0.0, "floor": "built", "origin_m": [1.0, 2.0],
                "size_cells": [3, 2], "status": "ok", "directory": "storeys/00-floor"}],
            "files": {"storeys/00-floor/planning.pgm": hash},
        });
        write("manifest.json", manifest);
        dates.push(json!({"directory": directory}));
    }
    fs::write(folder.join("manifest.json"), json!({"dates": dates}).to_string()).unwrap();
}

fn value(bytes: &Bytes) -> Value {
    serde_json::from_slice(bytes).unwrap()
}

fn pixel(source: &SiteOfFiles, date: &Value) -> u8 {
    let name = ContentName::of_hash(date["storeys"][0]["layers"]["planning"].as_str().unwrap()).unwrap();
    let place = TilePlace { level: 0, column: 0, row: 0 };
    let tile = source.tile(&TileAddress { storey: 0, layer: Layer::Planning, name, place }).unwrap().unwrap();
    let mut reader = png::Decoder::new(std::io::Cursor::new(&tile[..])).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut pixels).unwrap();
    pixels[1]
}

#[test]
fn every_date_has_its_own_states_and_pictures() {
    let folder = tempfile::tempdir().unwrap();
    dated_maps(folder.path());
    let source = SiteOfFiles::open(folder.path()).unwrap();
    let site = value(&source.site().unwrap());
    assert_eq!((&site["title"], &site["dates"][1]["key"]), (&json!("house"), &json!("1")));
    assert_eq!(site["dates"][0]["at"], "2024-04-01T08:00:00");
    assert_eq!(site["tiles"]["origin_m"], json!([1.0, 3.0]));
    let dates = ["0", "1"].map(|key| value(&source.date(key).unwrap().unwrap()));
    assert_eq!(dates.each_ref().map(|date| pixel(&source, date)), [2, 1]);
    assert_eq!((&dates[0]["elements"], &dates[1]["elements"]), (&json!({}), &json!({"a": "removed"})));
    assert_eq!(value(&source.calendar().unwrap())["elements"]["a"], json!([[0, "built"], [1, "removed"]]));
}

#[test]
fn what_is_not_listed_is_not_served() {
    let folder = tempfile::tempdir().unwrap();
    dated_maps(folder.path());
    let source = SiteOfFiles::open(folder.path()).unwrap();
    for key in ["2", "-1", "../d0", "", "d0"] {
        assert!(source.date(key).unwrap().is_none(), "{key}");
    }
    let name = ContentName::of_hash("0123456789abcdef").unwrap();
    let place = TilePlace { level: 0, column: 0, row: 0 };
    assert!(source.tile(&TileAddress { storey: 0, layer: Layer::Planning, name, place }).unwrap().is_none());
    for hash in ["../../etc/passwd", "0123", "0123456789ABCDEF"] {
        assert_eq!(ContentName::of_hash(hash), None);
    }
}

#[test]
fn a_manifest_cannot_lead_out_of_its_folder() {
    let folder = tempfile::tempdir().unwrap();
    let manifest = json!({"dates": [{"directory": "../elsewhere"}]});
    fs::write(folder.path().join("manifest.json"), manifest.to_string()).unwrap();
    assert!(matches!(SiteOfFiles::open(folder.path()), Err(SourceError::NoMaps { .. })));
}

#[test]
fn a_folder_without_maps_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let error = SiteOfFiles::open(folder.path()).map(drop).unwrap_err().to_string();
    assert!(error.contains("groundplan convert"), "{error}");
    fs::write(folder.path().join("manifest.json"), "{").unwrap();
    assert!(matches!(SiteOfFiles::open(folder.path()), Err(SourceError::Json { .. })));
}

#[test]
fn the_newest_are_kept_up_to_a_size() {
    let mut kept = Kept::of(10);
    for (key, size) in [("a", 4), ("b", 4), ("c", 4), ("d", 11)] {
        kept.insert(key, size, size);
    }
    assert_eq!(["a", "b", "c", "d"].map(|key| kept.get(&key)), [None, Some(4), Some(4), None]);
}
