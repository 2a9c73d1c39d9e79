//! The demo building from file to maps, checked against its generator.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use end_to_end::{FREE, OCCUPIED, Storey, UNKNOWN, convert, demo_model, groundplan, root};
use serde_json::Value;

fn by_name<'a>(map: &'a Value, name: &str) -> &'a Value {
    let all = map.as_object().unwrap().values();
    all.into_iter().find(|v| v["name"] == name).unwrap_or_else(|| panic!("no {name}"))
}

fn waypoint<'a>(waypoints: &'a Value, name: &str) -> &'a Value {
    let all = waypoints["waypoints"].as_array().unwrap();
    all.iter()
        .filter(|w| w["kind"] == "centre")
        .find(|w| w["name"].as_str().unwrap().starts_with(name))
        .unwrap_or_else(|| panic!("no {name}"))
}

#[test]
fn storeys_and_the_dock_are_built_at_their_finished_floors() {
    let maps = convert(&demo_model(), &[]);
    let storeys = maps.manifest["storeys"].as_array().unwrap();
    let facts: Vec<_> =
        storeys.iter().map(|s| (s["name"].as_str(), s["floor_z_m"].as_f64(), s["floor"].as_str())).collect();
    assert_eq!(
        facts,
        [
            (Some("Ground floor"), Some(0.0), Some("built")),
            (Some("Upper floor"), Some(3.2), Some("built")),
            (Some("Ground floor -0.25 m"), Some(-0.25), Some("built")),
            (Some("Site"), Some(-0.2166), Some("ground")),
        ]
    );
    assert_eq!(maps.manifest["schedule_ignored"], true);
    assert_eq!(maps.manifest["frames"]["map_from_world"]["yaw_rad"], 0.0, "true north does not turn the map");
}

#[test]
fn atrium_stair_hole_and_shaft_are_drop_offs() {
    let upper = convert(&demo_model(), &[]).storey(1);
    // Inset by the railings along the holes' edges.
    upper.assert_drop_off([18.80, 0.45, 23.70, 8.30]);
    upper.assert_drop_off([12.55, 8.05, 13.50, 12.20]);
    upper.assert_drop_off([15.05, 12.85, 16.60, 14.55]);
    assert_eq!(upper.planning(17.7, 5.0), FREE, "the gallery beside the atrium");
}

#[test]
fn a_bathroom_three_centimetres_up_is_floor_and_a_dock_below_is_another_level() {
    let maps = convert(&demo_model(), &[]);
    let ground = maps.storey(0);
    assert_eq!(ground.planning(15.5, 3.5), FREE);
    ground.assert_drop_off([0.5, 0.5, 4.0, 1.8]);
    let regions = maps.json("report.json")["regions"].clone();
    assert!(regions.as_array().unwrap().iter().any(|r| r["level_z_m"] == -0.25), "{regions}");
}

#[test]
fn the_dock_is_a_level_of_its_own_that_a_ramp_joins() {
    let maps = convert(&demo_model(), &[]);
    let dock = maps.storey(2);
    assert_eq!((dock.planning(3.5, 1.5), dock.keepout(3.5, 1.5) == OCCUPIED), (FREE, false));
    dock.assert_forbidden([8.0, 1.0, 10.0, 4.0]);
    let graph = maps.json("site-graph.json");
    let ramps: Vec<&Value> = graph["edges"].as_array().unwrap().iter().filter(|e| e["class"] == "ramp").collect();
    assert_eq!(ramps.len(), 1, "{ramps:?}");
    let [rise_m, slope_rad] = ["rise_m", "slope_rad"].map(|key| ramps[0][key].as_f64().unwrap());
    // The places before it are on the ramp, which is free: a little above its foot, and below its head.
    assert!((0.2..0.25).contains(&rise_m.abs()) && (slope_rad - 0.089).abs() < 0.001, "{:?}", ramps[0]);
    assert_eq!(ramps[0]["usable"], true);
    let report = maps.json("report.json");
    let unmapped = report["spaces_not_mapped"].as_array().unwrap().iter();
    let unmapped: Vec<&str> = unmapped.map(|room| room["name"].as_str().unwrap()).collect();
    assert_eq!(unmapped, ["U.11 Atrium void", "G.12 Lift shaft"]);
}

#[test]
fn clearance_footprint_terrain_and_virtual_elements_are_never_drawn() {
    let ground = convert(&demo_model(), &[]).storey(0);
    assert_eq!(ground.planning(9.0, 6.3), FREE, "in front of the door with a Clearance body");
    assert_eq!(ground.planning(18.65, 4.0), FREE, "the virtual element between foyer and atrium");
    assert_eq!(ground.planning(-0.8, 7.0), UNKNOWN, "the terrain");
}

#[test]
fn doors_are_free_for_a_robot_that_fits_and_can_open_them() {
    let maps = convert(&demo_model(), &[]);
    let ground = maps.storey(0);
    for (x, y, what) in [(12.4, 4.86, "sliding"), (9.0, 6.78, "swing"), (16.79, 5.82, "double")] {
        assert_eq!(ground.planning(x, y), FREE, "{what}");
    }
    assert_eq!(ground.planning(8.06, 12.0), OCCUPIED, "0.70 m is too narrow");
    assert_eq!(maps.storey(2).planning(0.15, 2.55), OCCUPIED, "rolls up");
    assert_eq!(ground.planning(0.15, 2.55), UNKNOWN, "the gate of the dock has no floor on this level");
    let semantic = maps.json("semantic.json");
    let elements = &semantic["elements"];
    let mirrored = &by_name(elements, "G.D04 plant room")["attributes"];
    assert_eq!(mirrored["operation_type"], "SINGLE_SWING_RIGHT", "the type says left, the placement mirrors it");
    assert_eq!(mirrored["clear_width_m"], 0.76);
    let low = convert(
        &demo_model(),
        &["--robot", end_to_end::root().join("config/robots/wheeled-low.toml").to_str().unwrap()],
    );
    assert_eq!(low.storey(0).planning(9.0, 6.78), OCCUPIED, "a base that opens nothing");
    assert_eq!(low.storey(0).planning(14.8, 6.78), FREE, "an opening without a door");
}

#[test]
fn a_door_without_floor_beyond_stays_free_and_beyond_is_forbidden() {
    let ground = convert(&demo_model(), &[]).storey(0);
    assert_eq!(ground.planning(1.2, 14.85), FREE);
    assert_eq!((ground.planning(1.2, 15.12), ground.keepout(1.2, 15.12)), (UNKNOWN, OCCUPIED));
}

#[test]
fn the_keep_out_filter_makes_no_unknown_cell_free() {
    let maps = convert(&demo_model(), &[]);
    for storey in [0, 1] {
        maps.storey(storey).assert_filter_frees_nothing();
    }
}

#[test]
fn the_nav2_parameters_keep_off_unknown_cells_and_let_a_robot_leave_keep_out() {
    let text = std::fs::read_to_string(root().join("config/nav2/params.yaml")).unwrap();
    let keys = || text.lines().filter_map(|line| line.split('#').next()).map(str::trim);
    let count = |key: &str| keys().filter(|k| *k == key).count();
    assert_eq!((count("allow_unknown: false"), count("track_unknown_space: true")), (1, 1));
    assert_eq!((count("filters: [\"keepout_filter\"]"), count("override_lethal_cost: true")), (2, 2));
}

#[test]
fn centres_are_centroids_unless_these_are_blocked() {
    let waypoints = convert(&demo_model(), &[]).json("waypoints.json");
    let at = |w: &Value| [w["x_m"].as_f64().unwrap(), w["y_m"].as_f64().unwrap()];
    assert_eq!(at(waypoint(&waypoints, "G.02")), [6.36, 2.55]);
    for (name, centroid) in [("G.08", [4.21, 12.4]), ("G.10", [10.21, 10.77]), ("G.06", [6.1212, 7.4193])] {
        let w = waypoint(&waypoints, name);
        let kept = [0, 1].map(|k| w["centroid_m"][k].as_f64().unwrap());
        assert!((kept[0] - centroid[0]).abs() < 0.01 && (kept[1] - centroid[1]).abs() < 0.01, "{name} {kept:?}");
        assert_ne!(at(w), kept, "{name} is blocked or outside");
        assert!(w["clearance_m"].as_f64().unwrap() >= 0.3);
    }
    let outcome = |gid: &str| waypoints["spaces"][gid]["reason"].clone();
    let semantic = convert(&demo_model(), &[]).json("semantic.json");
    let spaces = semantic["spaces"].as_object().unwrap();
    let (void, _) = spaces.iter().find(|(_, s)| s["name"] == "U.11").unwrap();
    assert!(outcome(void).as_str().unwrap().contains("no floor"), "a space is no floor");
}

#[test]
fn a_lidar_sees_walls_and_neither_glass_nor_furniture() {
    let ground = convert(&demo_model(), &[]).storey(0);
    assert_eq!(ground.localization(10.0, 0.27), OCCUPIED, "the inner face of the south wall");
    assert_eq!(ground.localization(4.2, 12.4), UNKNOWN, "a table");
    let glazed: Vec<u8> = (10..75).map(|k| ground.localization(23.9, f64::from(k) * 0.1)).collect();
    assert!(glazed.iter().filter(|&&p| p == OCCUPIED).count() < glazed.len() / 4, "panes are not seen, mullions are");
}

#[test]
fn the_same_input_gives_the_same_bytes_on_any_number_of_threads() {
    let one = convert(&demo_model(), &["--threads", "1"]).contents();
    let two = convert(&demo_model(), &["--threads", "2"]).contents();
    let again = convert(&demo_model(), &["--threads", "2"]).contents();
    assert!(one.len() > 20);
    assert_eq!(one, two);
    assert_eq!(two, again);
}

#[test]
fn the_map_is_the_same_building_at_another_resolution() {
    let (fine, coarse) = (convert(&demo_model(), &[]), convert(&demo_model(), &["--resolution", "0.1"]));
    let centres: Vec<[f64; 2]> = fine.json("waypoints.json")["waypoints"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|w| w["storey"] == 0)
        .map(|w| [w["x_m"].as_f64().unwrap(), w["y_m"].as_f64().unwrap()])
        .collect();
    let coarse: Storey = coarse.storey(0);
    assert!(centres.iter().all(|&[x, y]| coarse.planning(x, y) == FREE));
}

#[test]
fn a_frame_is_kept_by_a_second_run_and_changed_on_demand() {
    let maps = convert(&demo_model(), &[]);
    let out = maps.path();
    let frame = out.join("site-frame.json");
    let moved = r#"{"map_from_world": {"x_m": 100.0, "y_m": 0.0, "z_m": 0.0, "yaw_rad": 0.0}, "frame_epoch": 3}"#;
    let elsewhere = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(&elsewhere, moved).unwrap();
    let given = elsewhere.path().to_str().unwrap().to_owned();
    let again = |more: &[&str]| {
        let model = demo_model();
        let mut arguments: Vec<&dyn AsRef<std::ffi::OsStr>> = vec![&"convert", &model, &"-o", &out];
        arguments.extend(more.iter().map(|a| a as &dyn AsRef<std::ffi::OsStr>));
        assert!(end_to_end::groundplan(&arguments).status.success());
        let text: Value = serde_json::from_slice(&std::fs::read(&frame).unwrap()).unwrap();
        (text["map_from_world"]["x_m"].as_f64().unwrap(), text["frame_epoch"].as_u64().unwrap())
    };
    assert_eq!(again(&["--frame", &given]), (100.0, 3));
    assert_eq!(again(&[]), (100.0, 3), "a map must not jump under a localised robot");
    let report = maps.json("report.json")["diagnostics"].to_string();
    assert!(report.contains("frame_kept"), "and a frame that is not the site's own is not kept in silence: {report}");
    assert_eq!(again(&["--new-frame"]), (0.0, 4));
}

#[test]
fn chosen_storeys_alone_are_written_and_keep_their_index() {
    let (all, upper) = (convert(&demo_model(), &[]), convert(&demo_model(), &["--storeys", "Upper*"]));
    let storeys = upper.manifest["storeys"].as_array().unwrap();
    assert_eq!(storeys.len(), 1);
    assert_eq!(
        (&storeys[0], &upper.manifest["storeys_left_out"]),
        (&all.manifest["storeys"][1], &serde_json::json!([0, 2, 3]))
    );
    assert_eq!(all.manifest["storeys_left_out"], serde_json::json!([]));
    let folder = storeys[0]["directory"].as_str().unwrap();
    let (all, upper_files) = (all.contents(), upper.contents());
    for map in ["planning", "keepout", "localization"] {
        let path = std::path::Path::new(folder).join(format!("{map}.pgm"));
        assert!(all[&path] == upper_files[&path], "{map} is that of the whole building");
    }
    assert!(upper_files.keys().filter(|p| p.starts_with("storeys")).all(|p| p.starts_with(folder)));
    let waypoints = upper.json("waypoints.json");
    let orders: Vec<u64> =
        waypoints["waypoints"].as_array().unwrap().iter().map(|w| w["order"].as_u64().unwrap()).collect();
    assert!(!orders.is_empty() && orders.iter().copied().eq(0..orders.len() as u64));
    assert!(waypoints["waypoints"].as_array().unwrap().iter().all(|w| w["storey"] == 1));
    let graph = upper.json("site-graph.json");
    assert!(graph["nodes"].as_array().unwrap().iter().all(|n| n["storey"] == 1));
    let nodes: Vec<u64> = graph["nodes"].as_array().unwrap().iter().map(|n| n["id"].as_u64().unwrap()).collect();
    let edges = graph["edges"].as_array().unwrap();
    assert!(edges.iter().flat_map(|e| [&e["from"], &e["to"]]).all(|n| nodes.contains(&n.as_u64().unwrap())));
}

/// Standard error of a conversion that is refused as bad usage.
fn refused(more: &[&dyn AsRef<std::ffi::OsStr>]) -> String {
    let home = tempfile::tempdir().unwrap();
    let (model, out) = (demo_model(), home.path().join("out"));
    let mut arguments: Vec<&dyn AsRef<std::ffi::OsStr>> = vec![&"convert", &model, &"-o", &out];
    arguments.extend(more);
    let output = groundplan(&arguments);
    let output_text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!((output.status.code(), out.exists()), (Some(2), false), "{output_text}");
    output_text
}

#[test]
fn names_that_match_nothing_and_a_start_off_the_floor_are_refused_with_what_is_near() {
    let output_text = refused(&[&"--storeys", &"Uper floor"]);
    assert!(output_text.contains("nearest: \"Upper floor\""), "{output_text}");
    let home = tempfile::tempdir().unwrap();
    let options = home.path().join("options.toml");
    std::fs::write(&options, "spaces = [\"Plnat room\"]\n").unwrap();
    let output_text = refused(&[&"--waypoints", &options]);
    assert!(
        output_text.contains("\"Plnat room\" matches no space") && output_text.contains("\"Plant room\""),
        "{output_text}"
    );
    std::fs::write(&options, "[tour]\nstart = { storey = 0, x_m = -5.0, y_m = 3.0 }\n").unwrap();
    let output_text = refused(&[&"--waypoints", &options]);
    assert!(
        output_text.contains("[tour] start") && output_text.contains("nearest place where it can is x"),
        "{output_text}"
    );
    let output_text = refused(&[&"--waypoints", &options, &"--date", &"all"]);
    assert!(output_text.contains("[tour] start"), "{output_text}");
}

#[test]
fn the_terminal_and_the_report_tell_what_is_reached_of_each_storey() {
    let maps = convert(&demo_model(), &[]);
    let report = maps.json("report.json");
    let waypoints = maps.json("waypoints.json");
    for (entry, outcome) in report["storeys"].as_array().unwrap().iter().zip(waypoints["storeys"].as_array().unwrap()) {
        assert_eq!(entry["reach"]["reached_m2"], outcome["reached_m2"]);
        let parts = entry["reach"]["parts"].as_array().unwrap();
        assert!(parts.iter().any(|p| p["reached"] == true && p["has_way_in"] == true), "{parts:?}");
    }
    let home = tempfile::tempdir().unwrap();
    let (model, out) = (demo_model(), home.path().join("out"));
    let output = groundplan(&[
        &"convert",
        &model,
        &"-o",
        &out,
        &"--robot",
        &end_to_end::root().join("config/robots/wheeled-low.toml"),
    ]);
    let output_text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output_text.starts_with("map: the model neither turned nor shifted\n"), "{output_text}");
    // A base that opens nothing is shut in.
    let line = output_text.lines().find(|l| l.starts_with("storey  0")).unwrap();
    assert!(line.contains(" m2 reached, ") && line.ends_with(" parts"), "{line}");
}
