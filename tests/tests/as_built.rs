//! `groundplan as-built` of a running site: the new model gives without observations the maps that the site has with them.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use end_to_end::live::{DEADLINE, Live};
use end_to_end::mapping_robot::{MappingRobot, planning_at};
use end_to_end::{convert, demo_model};
use serde_json::Value;
use std::path::Path;
use std::time::Instant;

/// Map files of an output folder, by their paths.
fn maps_of(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let manifest: Value = serde_json::from_slice(&std::fs::read(folder.join("manifest.json")).unwrap()).unwrap();
    let files = manifest["files"].as_object().unwrap().keys().filter(|path| path.ends_with(".pgm"));
    files.map(|path| (path.clone(), std::fs::read(folder.join(path)).unwrap())).collect()
}

#[test]
fn an_as_built_model_gives_the_maps_that_the_site_has_with_its_observations() {
    let maps = convert(&demo_model(), &[]);
    let plan_time = "2024-04-18T00:00:00";
    let settings = format!("[schedule]\nplan_time = \"{plan_time}\"\n[align]\napply = true\n");
    let mut live = Live::of(&demo_model(), &settings);
    let new = live.home.path().join("new.ifc");
    let nothing = live.run(&[&"as-built", &demo_model(), &"-o", &new]);
    let why = String::from_utf8_lossy(&nothing.stderr).into_owned();
    assert!(nothing.status.code() == Some(1) && why.contains("nothing was written") && !new.exists(), "{why}");
    // The partition between meeting room and store was never built, the walls of the lift stand before their time.
    let (wall, in_wall) = ("0T8xbPmeHQFhEy1wPGGLbq", [6.25, 12.0]);
    let (lift, in_lift) = ("1ghCNJDIzNKO1u55gceO4K", [14.85, 13.7]);
    let mut robot = MappingRobot::of(&live, &maps, "localization.pgm");
    robot.sees_through(&maps, [5.7, 10.2, 6.8, 14.6]);
    robot.publish(2.0);
    let wait_for = |place, pixel| {
        let begun = Instant::now();
        while planning_at(&live, place) != pixel {
            assert!(begun.elapsed() < DEADLINE, "what was observed is not on the map");
        }
    };
    wait_for(in_lift, grid::OCCUPIED);
    let unconfirmed: Value =
        serde_json::from_str(&live.text(&[&"as-built", &demo_model(), &"-o", &new, &"--json"])).unwrap();
    let reason = |list: &Value| {
        let all = list["not_written"].as_array().unwrap().iter();
        all.clone().find(|one| one["id"] == wall).map(|one| one["reason"].as_str().unwrap().to_owned())
    };
    assert!(reason(&unconfirmed).unwrap().contains("nobody confirmed"), "{unconfirmed}");
    live.text(&[&"confirm", &wall]);
    wait_for(in_wall, grid::FREE);
    let refused = live.run(&[&"as-built", &demo_model(), &"-o", &new]);
    assert_eq!(refused.status.code(), Some(2), "the file is there already");
    let written = live.text(&[&"as-built", &demo_model(), &"-o", &new, &"--force", &"--json"]);
    let written: Value = serde_json::from_str(&written).unwrap();
    let kind = |id: &str| {
        let all = written["observations"].as_array().unwrap().iter();
        all.clone().find(|one| one["global_id"] == id).map(|one| one["kind"].as_str().unwrap().to_owned())
    };
    assert_eq!((kind(wall).as_deref(), kind(lift).as_deref()), (Some("absent"), Some("built")), "{written}");
    assert_eq!(reason(&written), None);
    let observer = written["observations"].as_array().unwrap().iter().find(|one| one["global_id"] == wall).unwrap();
    assert!(observer["observer"].as_str().unwrap().contains("confirmed by user"), "{observer}");
    let of_site = live.home.path().join("site");
    live.text(&[&"export", &of_site]);
    let [of_model, of_plan] = [&new, &demo_model()].map(|model| convert(model, &["--date", plan_time]));
    let (site, model) = (maps_of(&of_site), maps_of(&of_model.path()));
    assert!(site.len() >= 6 && site != maps_of(&of_plan.path()), "observations change the maps");
    for (expected, found) in site.iter().zip(&model) {
        assert!(expected == found, "{} differs from {}", found.0, expected.0);
    }
    assert_eq!(site.len(), model.len());
    live.down();
}
