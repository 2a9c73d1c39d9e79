use super::*;
use crate::tiles::{Layer, TilePlace};
use messages::ContentId;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fs;

/// Two dates of a storey of 3 x 2 cells: an obstacle goes.
pub(crate) fn dated_maps(folder: &Path) {
    dated_maps_with(folder, &[(0, "built"), (254, "removed")]);
}

/// A date for each pixel of the cell in question, and state of the element in it.
fn dated_maps_with(folder: &Path, of_dates: &[(u8, &str)]) {
    let (mut dates, mut sums) = (Vec::new(), BTreeMap::new());
    for (date, (pixel, state)) in of_dates.iter().enumerate() {
        let directory = format!("d{date}");
        let mut write = |name: &str, bytes: &[u8]| {
            let path = format!("{directory}/{name}");
            fs::create_dir_all(folder.join(&path).parent().unwrap()).unwrap();
            fs::write(folder.join(&path), bytes).unwrap();
            sums.insert(path, ContentId::of(bytes).to_string());
        };
        let at = format!("2024-04-0{}T08:00:00", date + 1);
        write("storeys/00-floor/planning.pgm", &[&b"P5\n3 2\n255\n"[..], &[205, *pixel, 254, 254, 254, 254]].concat());
        let element = json!({"schedule": {"state": state, "start": null}, "attributes": {}});
        let documents = [
            ("semantic.json", json!({"elements": {"a": element}, "spaces": {}})),
            ("waypoints.json", json!({"plan_time": at, "waypoints": [], "spaces": {}})),
            ("site-graph.json", json!({"nodes": [], "edges": []})),
            ("report.json", json!({"doors": []})),
        ];
        for (name, value) in documents {
            write(name, value.to_string().as_bytes());
        }
        let manifest = json!({
            "sources": [{"file": "house.ifc"}], "plan_time": at, "valid_until": null,
            "schedule_ignored": false, "resolution_m": 0.5, "robot": {}, "frames": {},
            "storeys": [{"index": 0, "name": "Floor", "floor_z_m": 0.0, "floor": "built", "origin_m": [1.0, 2.0],
                "size_cells": [3, 2], "status": "ok", "directory": "storeys/00-floor"}],
            "files": {},
        });
        write("manifest.json", manifest.to_string().as_bytes());
        dates.push(json!({"directory": directory, "plan_time": at, "valid_until": null}));
    }
    fs::write(folder.join("manifest.json"), json!({"dates": dates, "files": sums}).to_string()).unwrap();
}

fn maps() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    dated_maps(folder.path());
    folder
}

fn value(bytes: &Bytes) -> Value {
    serde_json::from_slice(bytes).unwrap()
}

/// The documents of all dates.
fn dates(source: &SiteOfFiles) -> Vec<Value> {
    let site = value(&source.site().unwrap());
    let keys = site["dates"].as_array().unwrap().iter().map(|date| date["key"].as_str().unwrap());
    keys.map(|key| value(&source.date(key).unwrap().unwrap())).collect()
}

fn planning(date: &Value) -> TileAddress {
    let name = ContentName::parse(date["storeys"][0]["layers"]["planning"].as_str().unwrap()).unwrap();
    TileAddress { storey: 0, layer: Layer::Planning, name, place: TilePlace { level: 0, column: 0, row: 0 } }
}

fn pixel(source: &SiteOfFiles, date: &Value) -> u8 {
    let tile = source.tile(&planning(date)).unwrap().unwrap();
    let mut reader = png::Decoder::new(std::io::Cursor::new(&tile[..])).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut pixels).unwrap();
    pixels[1]
}

#[test]
fn every_date_has_its_own_states_and_pictures() {
    let folder = maps();
    let source = SiteOfFiles::open(folder.path(), None).unwrap();
    let site = value(&source.site().unwrap());
    assert_eq!(site["title"], "house");
    assert_eq!(site["dates"][0]["at"], "2024-04-01T08:00:00");
    assert_eq!(site["tiles"]["origin_m"], json!([1.0, 3.0]));
    let dates = dates(&source);
    assert_eq!(dates.iter().map(|date| pixel(&source, date)).collect::<Vec<u8>>(), [2, 1]);
    assert_eq!((&dates[0]["elements"], &dates[1]["elements"]), (&json!({}), &json!({"a": "removed"})));
    assert_eq!(value(&source.calendar().unwrap())["elements"]["a"], json!([[0, "built"], [1, "removed"]]));
}

#[test]
fn other_maps_in_the_folder_are_read_again_and_those_before_are_refused() {
    let folder = maps();
    let source = SiteOfFiles::open(folder.path(), None).unwrap();
    let before = dates(&source);
    assert_eq!(pixel(&source, &before[0]), 2);
    dated_maps_with(folder.path(), &[(254, "removed"), (0, "built"), (205, "built")]);
    let key = before[0]["key"].as_str().unwrap();
    let refused = source.date(key).unwrap_err().to_string();
    assert!(refused.ends_with("have changed since: load the page again"), "{refused}");
    let now = dates(&source);
    assert_eq!(now.iter().map(|date| pixel(&source, date)).collect::<Vec<u8>>(), [1, 2, 0]);
    assert_eq!(now[0]["elements"], json!({"a": "removed"}));
    assert_eq!(value(&source.calendar().unwrap())["elements"]["a"], json!([[0, "removed"], [1, "built"]]));
    // The same pixels have the same name, and others another one, whatever the date.
    assert_eq!(planning(&before[0]).name, planning(&now[1]).name);
    assert_ne!(planning(&before[0]).name, planning(&now[0]).name);
}

#[test]
fn a_folder_that_was_swapped_is_read_again() {
    let home = tempfile::tempdir().unwrap();
    let [shown, other, gone] = ["maps", "other", "gone"].map(|name| home.path().join(name));
    dated_maps(&shown);
    dated_maps_with(&other, &[(205, "built")]);
    let source = SiteOfFiles::open(&shown, None).unwrap();
    fs::rename(&shown, gone).unwrap();
    fs::rename(other, &shown).unwrap();
    let dates = dates(&source);
    assert_eq!(dates.iter().map(|date| pixel(&source, date)).collect::<Vec<u8>>(), [0]);
}

#[test]
fn a_file_that_is_not_the_listed_one_is_refused() {
    let folder = maps();
    let other = fs::read(folder.path().join("d1/storeys/00-floor/planning.pgm")).unwrap();
    let source = SiteOfFiles::open(folder.path(), None).unwrap();
    let dates = dates(&source);
    fs::write(folder.path().join("d0/storeys/00-floor/planning.pgm"), other).unwrap();
    let refused = source.tile(&planning(&dates[0])).unwrap_err().to_string();
    assert!(
        refused.contains("planning.pgm is not the file that manifest.json lists: write the maps anew"),
        "{refused}"
    );
    assert_eq!(pixel(&source, &dates[1]), 1, "the other date is as it was");
    fs::remove_file(folder.path().join("d1/report.json")).unwrap();
    let anew = SiteOfFiles::open(folder.path(), None).unwrap();
    assert!(matches!(anew.date(dates[1]["key"].as_str().unwrap()), Err(SourceError::Io { .. })));
}

#[test]
fn maps_of_another_date_are_not_shown() {
    let folder = maps();
    let manifest = fs::read(folder.path().join("d1/manifest.json")).unwrap();
    fs::write(folder.path().join("d0/manifest.json"), &manifest).unwrap();
    assert!(matches!(SiteOfFiles::open(folder.path(), None), Err(SourceError::Altered { .. })));
    // Also where the sums say that it belongs there.
    let path = folder.path().join("manifest.json");
    let mut list: Value = serde_json::from_slice(&fs::read(&path).unwrap()).unwrap();
    list["files"]["d0/manifest.json"] = json!(ContentId::of(&manifest).to_string());
    fs::write(&path, list.to_string()).unwrap();
    let refused = SiteOfFiles::open(folder.path(), None).map(drop).unwrap_err().to_string();
    assert!(refused.contains("is of 2024-04-02T08:00:00, and is listed as of 2024-04-01T08:00:00"), "{refused}");
}

#[test]
fn symbolic_links_and_pipes_are_refused() {
    let folder = maps();
    let outside = tempfile::tempdir().unwrap();
    dated_maps(outside.path());
    let pgm = folder.path().join("d0/storeys/00-floor/planning.pgm");
    fs::remove_file(&pgm).unwrap();
    std::os::unix::fs::symlink(outside.path().join("d0/storeys/00-floor/planning.pgm"), &pgm).unwrap();
    let source = SiteOfFiles::open(folder.path(), None).unwrap();
    let dates = dates(&source);
    let refused = |source: &SiteOfFiles| source.tile(&planning(&dates[0])).unwrap_err().to_string();
    assert!(
        refused(&source).contains("planning.pgm is a symbolic link, which is not followed"),
        "{}",
        refused(&source)
    );
    fs::remove_file(&pgm).unwrap();
    rustix::fs::mknodat(rustix::fs::CWD, &pgm, rustix::fs::FileType::Fifo, rustix::fs::Mode::from_raw_mode(0o600), 0)
        .unwrap();
    assert!(refused(&source).contains("is no regular file"), "{}", refused(&source));
    fs::remove_dir_all(folder.path().join("d1")).unwrap();
    std::os::unix::fs::symlink(outside.path().join("d1"), folder.path().join("d1")).unwrap();
    let refused = SiteOfFiles::open(folder.path(), None).map(drop).unwrap_err().to_string();
    assert!(refused.contains("d1 is a symbolic link"), "{refused}");
    // The folder itself is where its user says.
    let link = folder.path().join("link");
    std::os::unix::fs::symlink(outside.path(), &link).unwrap();
    assert_eq!(pixel(&SiteOfFiles::open(&link, None).unwrap(), &dates[0]), 2);
}

#[test]
fn what_is_not_listed_is_not_served() {
    let folder = maps();
    let source = SiteOfFiles::open(folder.path(), None).unwrap();
    let key = dates(&source)[1]["key"].as_str().unwrap().to_owned();
    for key in ["2", "-1", "../d0", "", "d0", &key.replacen('1', "2", 1), &format!("{key}/")] {
        assert!(!matches!(source.date(key), Ok(Some(_))), "{key}");
    }
    let name = ContentName::parse("0123456789abcdef0123456789abcdef").unwrap();
    let place = TilePlace { level: 0, column: 0, row: 0 };
    assert!(source.tile(&TileAddress { storey: 0, layer: Layer::Planning, name, place }).unwrap().is_none());
    for hash in ["../../etc/passwd", "0123", "0123456789abcdef", "0123456789ABCDEF0123456789ABCDEF"] {
        assert_eq!(ContentName::parse(hash), None);
    }
}

#[test]
fn a_manifest_cannot_lead_out_of_its_folder() {
    let home = tempfile::tempdir().unwrap();
    dated_maps(home.path());
    let folder = home.path().join("inner");
    fs::create_dir(&folder).unwrap();
    let sum = ContentId::of(&fs::read(home.path().join("d0/manifest.json")).unwrap()).to_string();
    for directory in ["../d0", home.path().join("d0").to_str().unwrap()] {
        let date = json!({"directory": directory, "plan_time": "2024-04-01T08:00:00", "valid_until": null});
        let manifest = json!({"dates": [date], "files": {format!("{directory}/manifest.json"): sum}});
        fs::write(folder.join("manifest.json"), manifest.to_string()).unwrap();
        assert!(matches!(SiteOfFiles::open(&folder, None), Err(SourceError::Altered { .. })), "{directory}");
    }
}

#[test]
fn a_folder_without_maps_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let error = SiteOfFiles::open(folder.path(), None).map(drop).unwrap_err().to_string();
    assert!(error.contains("groundplan convert"), "{error}");
    fs::write(folder.path().join("manifest.json"), "{").unwrap();
    assert!(matches!(SiteOfFiles::open(folder.path(), None), Err(SourceError::Json { .. })));
}
