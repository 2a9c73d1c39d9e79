//! All files of a small building against one golden text; UPDATE_GOLDEN=1 rewrites it.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

mod support;

use export::ExportFile;
use std::path::Path;
use support::House;

fn files(house: &House) -> Vec<ExportFile> {
    house.with_input(|input| export::files(input, Vec::new()))
}

/// Texts as they are, maps a letter per pixel, pictures by their size.
fn readable(file: &ExportFile) -> String {
    if file.path.ends_with(".pgm") {
        let (width, _, pixels) = grid::decode_pgm(&file.bytes).unwrap();
        let letter = |p: &u8| match *p {
            grid::OCCUPIED => '#',
            grid::FREE => '.',
            _ => '?',
        };
        let rows = pixels.chunks(width).rev().map(|row| row.iter().map(letter).collect::<String>() + "\n");
        rows.collect()
    } else if file.path.ends_with(".png") {
        let picture = decoded(&file.bytes);
        let n_channels = picture.1.len() / (picture.0[0] * picture.0[1]) as usize;
        let rows = picture.1.chunks(picture.0[0] as usize * n_channels);
        let pixel = |p: &[u8]| p.iter().map(|c| format!("{c:02x}")).collect::<String>();
        rows.map(|row| row.chunks(n_channels).map(pixel).collect::<Vec<_>>().join(" ") + "\n").collect()
    } else {
        String::from_utf8(file.bytes.clone()).unwrap()
    }
}

fn decoded(bytes: &[u8]) -> ([u32; 2], Vec<u8>) {
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    ([info.width, info.height], pixels)
}

#[test]
fn files_are_what_they_were() {
    let text: String = files(&support::house()).iter().map(|f| format!("== {}\n{}", f.path, readable(f))).collect();
    let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/files.txt");
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        std::fs::write(&golden, &text).unwrap();
    }
    assert_eq!(text, std::fs::read_to_string(&golden).unwrap_or_default(), "UPDATE_GOLDEN=1 rewrites it");
}

#[test]
fn the_manifest_is_last_and_names_every_other_file() {
    let files = files(&support::house());
    let (manifest, others) = files.split_last().unwrap();
    assert_eq!(manifest.path, "manifest.json");
    let manifest: serde_json::Value = serde_json::from_slice(&manifest.bytes).unwrap();
    let mut named: Vec<&str> = manifest["files"].as_object().unwrap().keys().map(String::as_str).collect();
    let mut written: Vec<&str> = others.iter().map(|f| f.path.as_str()).collect();
    named.sort_unstable();
    written.sort_unstable();
    assert_eq!(named, written);
}

fn json_of(files: &[ExportFile], path: &str) -> serde_json::Value {
    serde_json::from_slice(&files.iter().find(|f| f.path == path).unwrap().bytes).unwrap()
}

#[test]
fn a_door_is_reported_once_on_the_storey_on_which_it_stands() {
    let files = files(&support::house());
    let report = json_of(&files, "report.json");
    let doors = report["doors"].as_array().unwrap();
    assert_eq!((doors.len(), &doors[0]["storey"], &doors[0]["passage"]), (1, &0.into(), &"too_narrow".into()));
    let reasons = serde_json::json!([{
        "code": "too_narrow",
        "text": "clear width 0.50 m, this robot needs 0.70 m",
        "needed_m": 0.7,
        "found_m": 0.5,
    }]);
    assert_eq!(doors[0]["reasons"], reasons);
}

#[test]
fn closed_doors_are_red() {
    let files = files(&support::house());
    let picture = files.iter().find(|f| f.path.ends_with("semantic.png")).unwrap();
    let ([width, height], pixels) = decoded(&picture.bytes);
    let door = 3 * ((height - 1) * width + 1) as usize;
    assert_eq!(pixels[door..door + 3], [255, 0, 0]);
}

#[test]
fn stairs_have_their_way_length_width_and_risers() {
    let files = files(&support::house());
    let graph = json_of(&files, "site-graph.json");
    let stair = graph["edges"].as_array().unwrap().iter().find(|e| e["class"] == "stair").unwrap();
    assert_eq!((&stair["clear_width_m"], &stair["n_risers"]), (&1.1.into(), &12.into()));
    assert_eq!(stair["line_m"], serde_json::json!([[2.25, 1.75], [2.5, 1.5], [2.75, 1.75]]));
    assert_eq!(stair["line_z_m"], serde_json::json!([0.1, 0.28, 0.46]));
    let route = files.iter().find(|f| f.path.ends_with("route.geojson")).unwrap();
    let route: serde_json::Value = serde_json::from_slice(&route.bytes).unwrap();
    let away = route["features"].as_array().unwrap().iter().find(|f| f["geometry"]["type"] == "GeometryCollection");
    let away = away.unwrap();
    let line = serde_json::json!([[2.25, 1.75, 0.1], [2.5, 1.5, 0.28], [2.75, 1.75, 0.46]]);
    assert_eq!(away["geometry"]["geometries"][0]["coordinates"], line);
    let metadata = &away["properties"]["metadata"];
    assert_eq!(
        (&metadata["length_m"], &metadata["clear_width_m"], &metadata["n_risers"]),
        (&0.5.into(), &1.1.into(), &12.into())
    );
}
