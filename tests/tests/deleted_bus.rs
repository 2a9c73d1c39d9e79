//! Files of the bus are deleted under running daemons: by hand, or by a login manager that removes a user's shared memory.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use end_to_end::live::{DEADLINE, Live};
use end_to_end::{convert, demo_model, turned_map};
use serde_json::Value;
use std::fs;
use std::io::ErrorKind;
use std::process::{Command, Stdio};
use std::time::Instant;

/// The current generation of the bus; 0 if there is none.
fn generation(live: &Live) -> u64 {
    let text = fs::read_to_string(live.root.path().join("generation")).unwrap_or_default();
    let number = text.lines().find_map(|line| line.strip_prefix("generation="));
    number.map_or(0, |number| number.parse().unwrap())
}

fn delete_segments(live: &Live) {
    for path in end_to_end::files_in("/dev/shm".as_ref()) {
        if path.to_string_lossy().contains(&format!("/{}", live.prefix)) {
            // One that goes at this moment is gone too.
            let _ = fs::remove_file(path);
        }
    }
}

/// As `rm -rf` until it succeeds: daemons write into the folder meanwhile.
fn delete_folder(live: &Live) {
    while let Err(error) = fs::remove_dir_all(live.root.path()) {
        match error.kind() {
            ErrorKind::DirectoryNotEmpty => {}
            ErrorKind::NotFound => return,
            _ => panic!("{error}"),
        }
    }
}

/// Does harm to a running site, and expects its maps on a new bus without anybody's help.
fn maps_come_back_after(what: &str, live: &Live, harm: impl Fn(&Live)) {
    live.wait_until_healthy();
    let (generation_before, index_before) = (generation(live), live.index());
    harm(live);
    let begun = Instant::now();
    while generation(live) <= generation_before {
        assert!(begun.elapsed() < DEADLINE, "{what}: there is no new bus");
        std::thread::sleep(std::time::Duration::from_millis(50));
    }
    live.wait_until_healthy();
    let index = live.index();
    assert!(index["epoch"].as_u64() >= index_before["epoch"].as_u64(), "{what}: {index} after {index_before}");
    assert_eq!(index["content_hash"], index_before["content_hash"], "{what}");
    live.text(&[&"date", &"--next"]);
    assert!(live.index()["epoch"].as_u64() > index_before["epoch"].as_u64(), "{what}");
}

#[test]
fn maps_come_back_after_segments_or_folder_of_the_bus_were_deleted() {
    let mut live = Live::start();
    maps_come_back_after("segments", &live, delete_segments);
    maps_come_back_after("the folder", &live, delete_folder);
    maps_come_back_after("both", &live, |live| {
        delete_segments(live);
        delete_folder(live);
    });
    live.down();
    assert_eq!(live.segments(), 0, "nothing is left of any of the buses");
}

#[test]
fn a_search_goes_on_when_the_bus_is_replaced() {
    let maps = convert(&demo_model(), &[]);
    let mut live = Live::of(&demo_model(), "");
    let robot = turned_map(&maps, 0, live.home.path());
    let mut asked = Command::new(end_to_end::client());
    let asked = asked.arg("slam-map").arg(robot).arg("--config").arg(live.config()).stdout(Stdio::null());
    let mut asked = asked.stderr(Stdio::null()).spawn().unwrap();
    wait_until(&live, "it searches", |status| status["daemons"]["slam-align"]["stage"] == "reading");
    let before = generation(&live);
    delete_segments(&live);
    wait_until(&live, "the pose is found", |status| {
        generation(&live) > before && status["alignment"]["validity"] == "effective"
    });
    // Who asked is told that the bus is gone, or the result.
    let _ = asked.wait().unwrap();
    live.wait_until_healthy();
    live.text(&[&"deviations"]);
    live.down();
}

fn wait_until(live: &Live, what: &str, is_so: impl Fn(&Value) -> bool) {
    let begun = Instant::now();
    while !live.status().is_some_and(|status| is_so(&status)) {
        assert!(begun.elapsed() < DEADLINE, "{what}: {:?}", live.status());
    }
}
