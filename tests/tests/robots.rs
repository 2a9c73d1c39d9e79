//! A site with two robots of different measures: each has maps of its own, and the death of one robot's daemons is none of the
//! other's business.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use bus::{Bus, Daemon};
use daemon::{ActualsSource, FileText, RequestTimeouts, ScheduleAnswer, ScheduleRequest, SiteConfig};
use end_to_end::live::{DEADLINE, Live, POLL_INTERVAL};
use end_to_end::{contents, demo_model, groundplan};
use serde_json::Value;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

const LOW: &str = "name = \"low\"\nheight_m = 0.4\nradius_m = 0.2\n";
const TALL: &str = "name = \"tall\"\nheight_m = 1.9\nradius_m = 0.45\n";

/// Profiles of both robots, and the tables that name them.
fn robots(home: &Path) -> String {
    for (name, text) in [("lift.toml", TALL), ("scan.toml", LOW)] {
        std::fs::write(home.join(name), text).unwrap();
    }
    let profile = |name: &str| home.join(name);
    format!(
        "[schedule]\nplan_time = \"2024-03-01\"\n\
         [[robots]]\nname = \"lift\"\nprofile = {:?}\n[[robots]]\nname = \"scan\"\nprofile = {:?}\nresolution_m = 0.1\n",
        profile("lift.toml"),
        profile("scan.toml")
    )
}

fn start() -> (Live, tempfile::TempDir) {
    let profiles = tempfile::tempdir().unwrap();
    let live = Live::of(&demo_model(), &robots(profiles.path()));
    (live, profiles)
}

fn of_robot(live: &Live, robot: &str, arguments: &[&dyn AsRef<OsStr>]) -> std::process::Output {
    let more: [&dyn AsRef<OsStr>; 2] = [&"--robot-name", &robot];
    live.run(&arguments.iter().copied().chain(more).collect::<Vec<_>>())
}

fn index(live: &Live, robot: &str) -> Value {
    let output = of_robot(live, robot, &[&"topic", &"echo", &"grids"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// The export of a robot, once its mission plan is of the newest grids.
fn export(live: &Live, robot: &str) -> PathBuf {
    let out = live.home.path().join(format!("export-{robot}"));
    let output = of_robot(live, robot, &[&"export", &out, &"--force"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    out
}

fn convert(live: &Live, profile: &Path, resolution_m: &str, date: &str) -> PathBuf {
    let out = live.home.path().join(format!("convert-{}", profile.file_stem().unwrap().display()));
    let model = live.home.path().join("demo.ifc");
    let output = groundplan(&[
        &"convert",
        &model,
        &"-o",
        &out,
        &"--robot",
        &profile,
        &"--resolution",
        &resolution_m,
        &"--date",
        &date,
        &"--force",
    ]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    out
}

#[test]
fn each_robot_has_the_maps_of_its_own_profile_at_every_date() {
    let (mut live, profiles) = start();
    for date in ["2024-04-15T08:00:00", "2024-06-03T12:00:00"] {
        live.text(&[&"date", &date]);
        // The command has waited for both.
        for robot in ["lift", "scan"] {
            assert_eq!(index(&live, robot)["content"]["plan_time"], date, "{robot}");
        }
        for (robot, profile, resolution_m) in [("lift", "lift.toml", "0.05"), ("scan", "scan.toml", "0.1")] {
            let exported = contents(&export(&live, robot));
            let converted = contents(&convert(&live, &profiles.path().join(profile), resolution_m, date));
            let names = |files: &[(PathBuf, Vec<u8>)]| files.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>();
            assert_eq!(names(&exported), names(&converted));
            for ((name, a), (_, b)) in exported.iter().zip(&converted) {
                assert!(a == b, "{} of {robot} at {date} differs", name.display());
            }
        }
    }
    assert_ne!(contents(&live.home.path().join("export-lift")), contents(&live.home.path().join("export-scan")));

    // Another robot for one of them is none for the other.
    let other = profiles.path().join("other.toml");
    std::fs::write(&other, "name = \"other\"\nheight_m = 1.0\nradius_m = 0.25\n").unwrap();
    let before = index(&live, "lift");
    let set = of_robot(&live, "scan", &[&"robot", &other]);
    assert!(set.status.success(), "{}", String::from_utf8_lossy(&set.stderr));
    assert_eq!((&index(&live, "lift"), index(&live, "scan")["content"]["robot"].as_str()), (&before, Some("other")));

    // What each has lies in a folder of its own, and is there after a restart.
    live.down();
    assert!(live.home.path().join("state/robots/scan/settings/robot.profile.json").exists());
    live.up();
    assert_eq!(index(&live, "scan")["content"]["robot"], "other");
    let log = live.text(&[&"log", &"--kind", &"robot"]);
    assert!(log.contains(" scan: ") && !log.contains(" lift: "), "{log}");
}

#[test]
fn the_death_of_one_robots_daemon_is_none_of_the_others_business() {
    let (live, _profiles) = start();
    live.text(&[&"date", &"2024-04-15T08:00:00"]);
    let usable = |robot: &str| of_robot(&live, robot, &[&"findings", &"--json"]).status.code();
    live.wait_until_healthy();
    let (lift, scan) = (index(&live, "lift"), index(&live, "scan"));
    let of = |process: &str| live.status().unwrap()["daemons"][process]["process_id"].as_u64().unwrap();
    let (before, other) = (of("rasterize@scan"), of("rasterize@lift"));
    assert!(before > 1 && other > 1);
    assert!(Command::new("kill").args(["-9", &before.to_string()]).status().unwrap().success());
    let begun = Instant::now();
    loop {
        assert_eq!(usable("lift"), Some(0), "the maps of lift may be used all the time");
        assert_eq!(index(&live, "lift"), lift);
        let status = live.status().unwrap();
        let now = &status["daemons"]["rasterize@scan"];
        if status["healthy"] == true && now["process_id"] != before {
            break;
        }
        assert!(begun.elapsed() < DEADLINE, "{status}");
        std::thread::sleep(POLL_INTERVAL);
    }
    assert_eq!(of("rasterize@lift"), other);
    assert_eq!(index(&live, "scan")["content"]["grids"], scan["content"]["grids"], "the same maps are there again");
    // Both follow the next date.
    live.text(&[&"date", &"2024-06-03T12:00:00"]);
    for robot in ["lift", "scan"] {
        assert_eq!(index(&live, robot)["content"]["plan_time"], "2024-06-03T12:00:00", "{robot}");
    }
}

#[test]
fn commands_of_a_robot_need_its_name_and_those_of_the_site_do_not() {
    let (live, _profiles) = start();
    for arguments in [
        &["robot", "/none.toml"][..],
        &["topic", "echo", "grids"],
        &["findings"],
        &["waypoints"],
        &["monitor", "--json", "--for", "1"],
        &["confirm", "pose"],
        &["align"],
    ] {
        let arguments: Vec<&dyn AsRef<OsStr>> = arguments.iter().map(|a| a as &dyn AsRef<OsStr>).collect();
        let refused = live.run(&arguments);
        let words = String::from_utf8_lossy(&refused.stderr).into_owned();
        let is_named = words.contains("--robot-name") && words.contains("lift, scan");
        // A file that is not there may be told first.
        assert!(is_named && refused.status.code() == Some(2) || words.contains("/none.toml"), "{words}");
    }
    let unknown = of_robot(&live, "crane", &[&"findings"]);
    assert_eq!(unknown.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&unknown.stderr).contains("no robot `crane`: it has lift, scan"));

    assert!(live.text(&[&"date"]).starts_with("2024-03-01T00:00:00"));
    let topics = live.text(&[&"topic", &"list"]);
    for topic in ["site ", "schedule-state ", "robots/lift/grids ", "robots/scan/grid/00 ", "robots/scan/mission-plan "]
    {
        assert!(topics.lines().any(|line| line.starts_with(topic)), "{topic}: {topics}");
    }
    assert!(!topics.lines().any(|line| line.starts_with("grids")), "{topics}");
    let status = live.status().unwrap();
    let daemons: Vec<&String> = status["daemons"].as_object().unwrap().keys().collect();
    for daemon in ["ifc-ingest", "schedule-eval", "rasterize@lift", "slam-align@lift", "waypoint-gen@scan"] {
        assert!(daemons.iter().any(|name| *name == daemon), "{daemons:?}");
    }
    assert!(!daemons.iter().any(|name| *name == "rasterize"), "{daemons:?}");
    assert_eq!(
        [&status["robots"]["lift"]["grids"]["robot"], &status["robots"]["scan"]["grids"]["robot"]],
        ["tall", "low"]
    );
    let doctor = String::from_utf8(live.run(&[&"doctor"]).stdout).unwrap();
    assert!(doctor.contains("lift: tall") && doctor.contains("scan: low"), "{doctor}");
}

#[test]
fn a_site_whose_robot_gets_a_name_says_what_becomes_of_the_state_before() {
    let mut live = Live::start();
    let before = live.index();
    live.down();
    let site = std::fs::read_to_string(live.config()).unwrap();
    std::fs::write(live.config(), format!("{site}[[robots]]\nname = \"lift\"\n")).unwrap();
    let doctor = String::from_utf8(live.run(&[&"doctor"]).stdout).unwrap();
    assert!(doctor.contains("robot without a name") && doctor.contains("not used"), "{doctor}");
    live.up();
    // Of one robot the name may be left out.
    assert_eq!(live.index()["content"]["grids"], before["content"]["grids"]);
    assert_eq!(index(&live, "lift")["content"]["grids"], before["content"]["grids"]);
    assert!(live.home.path().join("state/robots/lift/rasterize-epochs.json").exists());
    live.down();
    std::fs::write(live.config(), site).unwrap();
    let doctor = String::from_utf8(live.run(&[&"doctor"]).stdout).unwrap();
    assert!(doctor.contains("the robot lift") && doctor.contains("not used"), "{doctor}");
    live.up();
    assert_eq!(live.index()["content"]["grids"], before["content"]["grids"]);
}

/// Gives schedule-eval what a robot observed, as its slam-align does.
fn observe(live: &Live, robot: Option<&str>, rows: &str) -> Result<ScheduleAnswer, String> {
    let config = SiteConfig::read(&live.config()).unwrap();
    let (bus, mut waiter) = Bus::join(&config.domain().unwrap(), Daemon::Groundplan).unwrap();
    let file = FileText { path: "/observed.csv".into(), text: format!("id,start,finish\n{rows}") };
    let robot = robot.map(str::to_owned);
    let request = ScheduleRequest::SetActuals { file: Some(file), source: ActualsSource::Observed, robot };
    let timeouts = RequestTimeouts { starting: DEADLINE, answer: DEADLINE };
    let pause = || waiter.wait(POLL_INTERVAL).map(drop).map_err(Into::into);
    daemon::ask(&bus, &request, timeouts, |_| {}, pause).map_err(|why| daemon::chain(&why))
}

#[test]
fn of_what_robots_observe_the_newest_look_counts_and_a_conflict_names_both() {
    let mut live = start().0;
    live.text(&[&"date", &"2024-04-15T08:00:00"]);
    let states: Value = serde_json::from_slice(
        &groundplan(&[&"states", &demo_model(), &"--date", &"2024-04-15T08:00:00", &"--json"]).stdout,
    )
    .unwrap();
    let elements = states["elements"].as_object().unwrap();
    let (wall, _) = elements.iter().find(|(_, element)| *element == "built").unwrap();
    let conflicts = |live: &Live| {
        let status = live.status().unwrap();
        status["daemons"]["schedule-eval"]["warning"].as_str().unwrap_or_default().to_owned()
    };
    let seen = format!("{wall},,2024-04-10T08:00:00\n");
    let absent = format!("{wall},absent,\n");
    let refused = observe(&live, None, &absent).unwrap_err();
    assert!(refused.contains("none is named: it has lift, scan"), "{refused}");
    let refused = observe(&live, Some("crane"), &absent).unwrap_err();
    assert!(refused.contains("no robot \"crane\""), "{refused}");

    let answer = observe(&live, Some("lift"), &absent).unwrap();
    assert_eq!(answer.progress.observed, 1);
    live.wait_until_settled("lift is alone", |live| conflicts(live).is_empty());
    observe(&live, Some("scan"), &seen).unwrap();
    let is_told = |words: String, counts: &str| {
        [wall.as_str(), &format!("{counts}, which counts"), "lift", "scan"].iter().all(|word| words.contains(word))
    };
    live.wait_until_settled("scan counts", |live| is_told(conflicts(live), "was seen by robot scan"));
    // The same look once more is no newer one, also after a restart.
    observe(&live, Some("lift"), &absent).unwrap();
    live.down();
    live.start_up();
    live.wait_until_settled("scan still counts", |live| is_told(conflicts(live), "was seen by robot scan"));
    assert_eq!(observe(&live, Some("scan"), &seen).unwrap().progress.observed, 1);
    // Taken back and seen again it is.
    observe(&live, Some("lift"), "").unwrap();
    live.wait_until_settled("no conflict is left", |live| conflicts(live).is_empty());
    observe(&live, Some("lift"), &absent).unwrap();
    live.wait_until_settled("lift counts", |live| is_told(conflicts(live), "is absent by robot lift"));
    for robot in ["lift", "scan"] {
        let found = String::from_utf8(of_robot(&live, robot, &[&"findings", &"--json"]).stdout).unwrap();
        assert!(found.contains("observation_conflict"), "{robot}: {found}");
    }
}
