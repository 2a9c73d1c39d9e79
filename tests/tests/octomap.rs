//! The demo building as an octree: what is occupied at a date, and arguments that no octree can have.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use end_to_end::{Maps, convert, demo_model, groundplan};
use serde_json::Value;
use std::ffi::OsStr;

fn made(more: &[&str]) -> (Maps, Value) {
    let maps = convert(&demo_model(), &[&["--octomap", "--resolution", "0.2"], more].concat());
    let document = maps.json("octomap/structure.json");
    (maps, document)
}

fn number(document: &Value, key: &str) -> f64 {
    document[key].as_f64().unwrap()
}

#[test]
fn structure_occupies_more_once_it_is_built_and_the_file_says_how_many_nodes_it_has() {
    let (whole, all) = made(&["--octomap-resolution", "0.2"]);
    let (_, early) = made(&["--octomap-resolution", "0.2", "--date", "2024-04-06T00:00:00"]);
    assert!(number(&early, "occupied_m3") < number(&all, "occupied_m3"), "{early} {all}");
    assert_eq!(early["plan_time"], "2024-04-06T00:00:00");
    assert!(number(&all, "free_m3") > 1_000.0, "the rooms are 24 x 15 m on two floors: {all}");
    let bytes = std::fs::read(whole.path().join("octomap/structure.bt")).unwrap();
    let header = format!("# Octomap OcTree binary file\nid OcTree\nsize {}\nres 0.2\ndata\n", all["nodes"]);
    assert!(bytes.starts_with(header.as_bytes()));
    assert!(whole.manifest["files"]["octomap/structure.bt"].is_string());
}

#[test]
fn a_box_holds_its_cells_alone_and_classes_are_those_of_the_cloud() {
    // Within the open-plan office: it is all free but for its furniture, which is not known.
    let (_, room) = made(&["--octomap-box", "9,8,1.5,11,9,2"]);
    assert_eq!((number(&room, "occupied_m3"), number(&room, "free_m3"), number(&room, "unknown_m3")), (0.0, 1.0, 0.0));
    // A piece of the wall to the north, 30 cm thick, below a window.
    let wall = ["--octomap-box", "9,14.7,0.1,9.5,15,0.6"];
    assert_eq!(number(&made(&wall).1, "occupied_m3"), 0.075);
    let (_, columns) = made(&[&wall[..], &["--cloud-classes", "column"]].concat());
    assert_eq!((number(&columns, "occupied_m3"), number(&columns, "unknown_m3")), (0.0, 0.075));
}

#[test]
fn what_no_octree_can_be_is_refused() {
    let refused = |arguments: &[&str], code: i32| {
        let home = tempfile::tempdir().unwrap();
        let (out, model) = (home.path().join("maps"), demo_model());
        let mut words: Vec<&dyn AsRef<OsStr>> = vec![&"convert", &model, &"-o", &out];
        words.extend(arguments.iter().map(|word| word as &dyn AsRef<OsStr>));
        let output = groundplan(&words);
        assert!(output.status.code() == Some(code) && !out.exists());
        String::from_utf8(output.stderr).unwrap()
    };
    assert!(refused(&["--octomap", "--octomap-resolution", "0"], 2).contains("0.01 to 5 m is meant"));
    assert!(refused(&["--octomap", "--octomap-box", "0,0,0,1,1"], 2).contains("a lower and an upper corner"));
    assert!(refused(&["--octomap-resolution", "0.1"], 2).contains("--octomap"));
    let far = refused(&["--octomap", "--octomap-box=-4000,0,0,1,1,1"], 1);
    assert!(far.contains("reach 4000 m from the origin") && far.contains("larger resolution"), "{far}");
}
