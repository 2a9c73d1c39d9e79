//! Settings of running daemons: which value is in force, what outlives its file, and what is refused before a start.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use end_to_end::groundplan;
use end_to_end::live::{DEADLINE, Live};
use serde_json::Value;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

/// A folder with files that a configuration names, and the configuration of them.
fn files() -> (tempfile::TempDir, String) {
    let home = tempfile::tempdir().unwrap();
    let path = |name: &str| home.path().join(name);
    std::fs::write(path("robot.toml"), "name = \"first\"\nradius_m = 0.25\n").unwrap();
    std::fs::write(path("rules.toml"), "site_zone = \"Europe/Amsterdam\"\n").unwrap();
    std::fs::write(path("waypoints.toml"), "spaces = []\n").unwrap();
    let config = format!(
        "[robot]\nprofile = {:?}\n[waypoints]\noptions = {:?}\n[schedule]\nplan_time = \"2024-06-03\"\nrules = {:?}\n",
        path("robot.toml"),
        path("waypoints.toml"),
        path("rules.toml")
    );
    (home, config)
}

fn robot(live: &Live) -> String {
    live.index()["content"]["robot"].as_str().unwrap_or_default().to_owned()
}

/// A setting of `status --json`.
fn setting(live: &Live, key: &str) -> Value {
    let status = live.status().unwrap();
    let settings = status["settings"].as_array().unwrap();
    settings.iter().find(|setting| setting["key"] == key).unwrap_or_else(|| panic!("{status}")).clone()
}

fn process(live: &Live, daemon: &str) -> u64 {
    live.status().unwrap()["daemons"][daemon]["process_id"].as_u64().unwrap()
}

/// Sends a signal to a daemon.
fn signal(live: &Live, daemon: &str, name: &str) {
    let process = process(live, daemon);
    // A silent daemon has the number 0, and that would be this process and all its relatives.
    assert!(process > 1);
    assert!(Command::new("kill").args([name, &process.to_string()]).status().unwrap().success());
}

fn wait_until(what: &str, live: &Live, mut is_so: impl FnMut(&Value) -> bool) {
    let begun = Instant::now();
    while !live.status().is_some_and(|status| is_so(&status)) {
        assert!(begun.elapsed() < DEADLINE, "{what}: {:?}", live.status());
    }
}

/// Standard error of a command that fails.
fn refused(live: &Live, arguments: &[&dyn AsRef<OsStr>]) -> String {
    let output = live.run(arguments);
    assert_eq!(output.status.code(), Some(1), "{}", String::from_utf8_lossy(&output.stdout));
    String::from_utf8(output.stderr).unwrap()
}

fn state_files(live: &Live) -> Vec<(PathBuf, Vec<u8>)> {
    let mut files = end_to_end::contents(&live.home.path().join("state/settings"));
    let progress = live.home.path().join("state/progress");
    if progress.is_dir() {
        files.extend(end_to_end::contents(&progress));
    }
    files
}

#[test]
fn settings_whose_state_is_damaged_or_removed_stay_in_force_and_that_is_told() {
    let (home, config) = files();
    let mut live = Live::of(&end_to_end::demo_model(), &config);
    let profile = home.path().join("other.toml");
    std::fs::write(&profile, "name = \"second\"\nradius_m = 0.3\n").unwrap();
    live.text(&[&"robot", &profile]);
    assert_eq!(live.text(&[&"date", &"2024-04-29T10:00:00"]), "2024-04-29T10:00:00");
    live.down();
    let settings = live.home.path().join("state/settings");
    let robot_file = settings.join("robot.profile.json");
    let mut bytes = std::fs::read(&robot_file).unwrap();
    let at = bytes.windows(6).rposition(|word| word == b"second").unwrap();
    bytes[at] ^= 1;
    std::fs::write(&robot_file, bytes).unwrap();
    std::fs::remove_file(settings.join("schedule.plan_time.json")).unwrap();
    // A warning stands: the site is not healthy, and is not waited for.
    live.start_up();
    for (daemon, file) in [("rasterize", "robot.profile.json"), ("schedule-eval", "schedule.plan_time.json")] {
        wait_until("it is told", &live, |status| {
            status["daemons"][daemon]["warning"].as_str().is_some_and(|warning| warning.contains(file))
        });
    }
    wait_until("the robot stays", &live, |status| status["grids"]["robot"] == "second");
    assert_eq!(setting(&live, "schedule.plan_time")["value"], "2024-04-29T10:00:00");
}

#[test]
fn state_that_is_removed_in_both_forms_is_told_and_epochs_still_rise() {
    let (home, config) = files();
    let mut live = Live::of(&end_to_end::demo_model(), &config);
    let profile = home.path().join("other.toml");
    std::fs::write(&profile, "name = \"second\"\nradius_m = 0.3\n").unwrap();
    live.text(&[&"robot", &profile]);
    let late = live.home.path().join("late.csv");
    std::fs::write(&late, "id,start,finish\n36bpPbojzVJhkO4eHcxkTd,2024-05-20,\n").unwrap();
    live.text(&[&"actuals", &late]);
    let epoch = live.index()["epoch"].as_u64().unwrap();
    live.down();
    let state = live.home.path().join("state");
    let removed = [
        ("rasterize", "settings/robot.profile.json"),
        ("schedule-eval", "progress/00000001.csv"),
        ("ifc-ingest", "site-frame.json"),
        ("rasterize", "rasterize-epochs.json"),
    ];
    for (_, file) in removed {
        for name in [file.to_owned(), format!("{file}.sealed")] {
            std::fs::remove_file(state.join(&name)).unwrap_or_else(|why| panic!("{name}: {why}"));
        }
    }
    live.start_up();
    for (daemon, file) in &removed[..3] {
        wait_until("it is told", &live, |status| {
            let warning = status["daemons"][daemon]["warning"].as_str();
            warning.is_some_and(|warning| {
                warning.contains(file) && warning.contains("removed") && warning.contains("lost")
            })
        });
    }
    wait_until("the robot is that of the site", &live, |status| status["grids"]["robot"] == "first");
    assert!(live.index()["epoch"].as_u64().unwrap() > epoch);
    assert_eq!(live.status().unwrap()["healthy"], false);
}

#[test]
fn settings_outlive_their_files_and_edits_of_the_site_win_over_commands() {
    let (home, config) = files();
    let mut live = Live::of(&end_to_end::demo_model(), &config);
    let path = |name: &str| home.path().join(name);
    assert_eq!(robot(&live), "first");
    assert_eq!(setting(&live, "robot.profile")["source"], "site_toml");
    assert_eq!(setting(&live, "models")["source"], "site_toml");

    // A command counts, with its content.
    std::fs::write(path("other.toml"), "name = \"second\"\nradius_m = 0.3\nclimbs_stairs = true\n").unwrap();
    let text = live.text(&[&"robot", &path("other.toml")]);
    assert!(text.starts_with("robot second: ") && text.contains("climbs stairs") && text.contains("epoch"), "{text}");
    let json: Value = serde_json::from_str(&live.text(&[&"robot", &path("other.toml"), &"--json"])).unwrap();
    assert_eq!((&json["robot"]["name"], &json["setting"]["source"]), (&"second".into(), &"command".into()));
    assert_eq!(robot(&live), "second");
    let options = path("options.toml");
    std::fs::write(&options, "spaces = [\"*\"]\n").unwrap();
    let text = live.text(&[&"waypoints", &options]);
    assert!(text.contains("options.toml") && text.contains("scans on"), "{text}");
    assert_eq!(live.text(&[&"date", &"2024-04-29T10:00:00"]), "2024-04-29T10:00:00");

    // All files are removed, and all daemons that read them die.
    for name in ["robot.toml", "rules.toml", "waypoints.toml", "other.toml", "options.toml"] {
        std::fs::remove_file(path(name)).unwrap();
    }
    for daemon in ["rasterize", "waypoint-gen", "schedule-eval"] {
        let before = process(&live, daemon);
        signal(&live, daemon, "-9");
        wait_until("it comes back and warns", &live, |status| {
            let daemon = &status["daemons"][daemon];
            daemon["process_id"] != before && daemon["warning"].as_str().is_some_and(|w| w.contains("stays"))
        });
    }
    wait_until("there are waypoints of these maps", &live, |status| status["plan"]["is_current"] == true);
    assert_eq!(robot(&live), "second");
    assert!(setting(&live, "waypoints.options")["value"].as_str().unwrap().ends_with("options.toml"));
    let rules = setting(&live, "schedule.rules");
    assert!(rules["value"].as_str().unwrap().ends_with("rules.toml") && rules["source"] == "site_toml", "{rules}");
    assert_eq!(setting(&live, "schedule.plan_time")["source"], "command");
    assert!(live.text(&[&"date", &"--wall"]).contains("wall clock"), "the zone of the rules is known");

    // The file of the site is edited: it wins, without a restart.
    std::fs::write(path("robot.toml"), "name = \"third\"\n").unwrap();
    signal(&live, "rasterize", "-HUP");
    wait_until("the edit counts", &live, |status| status["grids"]["robot"] == "third");
    assert_eq!(setting(&live, "robot.profile")["source"], "site_toml");

    // An edit that cannot be used is refused until it is mended, and changes nothing.
    let site = std::fs::read_to_string(live.config()).unwrap();
    std::fs::write(live.config(), site.replace("[robot]\n", "[robot]\nresolution_m = 0.0\n")).unwrap();
    signal(&live, "rasterize", "-HUP");
    wait_until("the error stands", &live, |status| {
        status["daemons"]["rasterize"]["error"].as_str().is_some_and(|error| error.contains("robot.resolution_m"))
    });
    assert_eq!(robot(&live), "third");
    std::fs::write(live.config(), site.replace("[robot]\n", "[robot]\nresolution_m = 0.1\n")).unwrap();
    signal(&live, "rasterize", "-HUP");
    wait_until("the edit counts", &live, |status| {
        status["grids"]["resolution_m"] == 0.1 && status["daemons"]["rasterize"]["error"].is_null()
    });
    live.down();
}

#[test]
fn a_command_that_fails_leaves_nothing_and_progress_is_taken_back_step_by_step() {
    let mut live = Live::start();
    live.text(&[&"date", &"2024-04-29T10:00:00"]);
    let home = live.home.path().to_owned();
    let write = |name: &str, text: &str| {
        std::fs::write(home.join(name), text).unwrap();
        home.join(name)
    };
    let before = state_files(&live);
    let near = refused(&live, &[&"waypoints", &"--space", &"Nonexist*"]);
    assert!(near.contains("\"Nonexist*\" matches no space of the model; "), "{near}");
    let robot = write("robot.toml", "name = \"x\"\nradius_m = -1.0\n");
    assert!(refused(&live, &[&"robot", &robot]).contains("radius_m"));
    let [empty, header, other] =
        [("a.csv", ""), ("b.csv", "id,start,finish\n"), ("c.csv", "guid,start\nx,2024-01-01\n")]
            .map(|(name, text)| write(name, text));
    assert!(refused(&live, &[&"actuals", &empty]).contains("the columns id, start and finish"));
    assert!(refused(&live, &[&"actuals", &header]).contains("--clear` takes reported progress back"));
    assert!(refused(&live, &[&"actuals", &other]).contains("guid,start"));
    assert_eq!(state_files(&live), before);

    let planned = live.index();
    let late = write("late.csv", "id,start,finish\n36bpPbojzVJhkO4eHcxkTd,2024-05-20,\n");
    let text = live.text(&[&"actuals", &late]);
    assert!(text.starts_with("progress in force: 1 reported row; schedule state epoch "), "{text}");
    let reported = live.index();
    assert_ne!(reported["content"]["grids"], planned["content"]["grids"]);
    let json: Value = serde_json::from_str(&live.text(&[&"actuals", &"--clear", &"--json"])).unwrap();
    assert_eq!(json["progress"]["reported"], 0);
    assert_eq!(live.index()["content"]["grids"], planned["content"]["grids"]);
    live.kill("schedule-eval");
    live.text(&[&"undo", &"progress"]);
    assert_eq!(live.index()["content"]["grids"], reported["content"]["grids"], "the table before is in force again");
    live.text(&[&"undo", &"progress"]);
    assert_eq!(live.index()["content"]["grids"], planned["content"]["grids"]);
    assert!(refused(&live, &[&"undo", &"progress"]).contains("no progress was reported"));
    live.down();
}

#[test]
fn a_configuration_that_cannot_be_used_starts_nothing() {
    let home = tempfile::tempdir().unwrap();
    let config = home.path().join("site.toml");
    let up = |more: &str| {
        let root = home.path().join("bus");
        let text = format!("state = \"state\"\n{more}\n[bus]\nprefix = \"gpnone_\"\nroot = {root:?}\n");
        std::fs::write(&config, text).unwrap();
        let output = groundplan(&[&"up", &"--config", &config]);
        assert_eq!(output.status.code(), Some(2), "{more}");
        String::from_utf8(output.stderr).unwrap()
    };
    std::fs::write(home.path().join("rules.toml"), "date_fromat = \"dmy\"\n").unwrap();
    for (more, words) in [
        ("models = [\"none.ifc\"]", ["line 2: models: ", "none.ifc cannot be read"]),
        (
            "[robot]\nprofile = \"none.toml\"\nresolution_m = 0.0",
            ["line 4: robot.resolution_m: ", "line 3: robot.profile: "],
        ),
        ("[schedule]\nrules = \"rules.toml\"", ["line 3: schedule.rules: ", "date_fromat"]),
        ("[schedule]\nplan_time = \"tomorrow\"", ["line 3: schedule.plan_time: ", "tomorrow"]),
        ("[robot]\nprofil = \"x\"", ["line 3", "profil"]),
    ] {
        let error = up(more);
        assert!(words.iter().all(|word| error.contains(word)), "{more}: {error}");
        assert!(!is_there(home.path(), "state") && !is_there(home.path(), "bus"), "{more}");
    }
}

fn is_there(home: &Path, name: &str) -> bool {
    home.join(name).exists()
}
