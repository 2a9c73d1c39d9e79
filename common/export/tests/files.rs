//! All files of a small building against one golden text; UPDATE_GOLDEN=1 rewrites it.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

mod support;

use export::{ExportFile, ExportInput};
use messages::{Grid, Grids, Phase, Plan, Site};
use std::path::Path;
use support::House;

fn files(house: &House) -> Vec<ExportFile> {
    let site = Site::open(house.site.bytes()).unwrap();
    let phase = Phase::open(house.phase.bytes()).unwrap();
    let grid = Grid::open(house.grid.bytes()).unwrap();
    export::files(&ExportInput {
        site: &site,
        phase: &phase,
        index: &Grids::open(house.index.bytes()).unwrap(),
        grids: &[grid],
        plan: &Plan::open(house.plan.bytes()).unwrap(),
        footprints: &[&house.footprints],
        resolution_m: 0.5,
        robot_footprint_m: &[],
        with_geometry: true,
        world: None,
    })
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
