//! Revisions of a running site: each takes effect as a whole or not at all, and those that an operator has to see first wait.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use bus::{Bus, Daemon, Domain};
use daemon::{IngestAnswer, IngestRequest, RequestTimeouts, RevisionEffect};
use end_to_end::house::{House, PLAIN};
use end_to_end::live::{DEADLINE, Live};
use serde_json::Value;
use std::io::{Seek, SeekFrom, Write};
use std::path::Path;
use std::process::{Command, Output};
use std::time::{Duration, Instant};

/// Two rooms of a house with walls and a slab; `n_before` records before them give everything other GlobalIds.
fn house(n_before: usize) -> House {
    let mut house = House::new("IFC4");
    (0..n_before).for_each(|_| house.add_unused());
    house.add("IFCSLAB", "Slab", PLAIN, [[-0.2, -0.2, -0.2], [8.2, 4.2, 0.0]]);
    house.add_walls([0.0, 0.0, 8.0, 4.0], [0.0, 3.0]);
    house.add_room("Hall", [[0.0, 0.0, 0.0], [8.0, 4.0, 3.0]]);
    house
}

/// A house with a partition wall of this construction date.
fn dated_house(date: &str) -> House {
    let mut house = house(0);
    let wall = house.add("IFCWALL", "Partition", PLAIN, [[4.0, 0.0, 0.0], [4.2, 2.5, 3.0]]);
    house.add_text_property(wall, "Wall Schedule", "ConstructionDate", date);
    house
}

/// A file of the state as a person puts it there, who seals none.
fn write_unsealed(path: &Path, text: &str) {
    remove_state(path);
    std::fs::write(path, text).unwrap();
}

fn remove_state(path: &Path) {
    let state = path.ancestors().find(|folder| folder.ends_with("state")).unwrap();
    let record = state.join("kept").join(path.strip_prefix(state).unwrap());
    for path in [path.to_owned(), format!("{}.sealed", path.display()).into(), record] {
        if path.exists() {
            std::fs::remove_file(path).unwrap();
        }
    }
}

fn write(house: &House, path: &Path) {
    let folder = tempfile::tempdir().unwrap();
    std::fs::copy(house.write(folder.path()), path).unwrap();
}

/// A site of a house, with empty rules in a folder of their own.
fn start(house: &House) -> (Live, tempfile::TempDir) {
    let folder = tempfile::tempdir().unwrap();
    let rules = folder.path().join("schedule.toml");
    std::fs::write(&rules, "").unwrap();
    let more = format!("[schedule]\nplan_time = \"2024-03-01\"\nrules = {rules:?}\n");
    (Live::of(&house.write(folder.path()), &more), folder)
}

fn errors_of(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn daemon(live: &Live, name: &str) -> Value {
    live.status().unwrap()["daemons"][name].clone()
}

/// What `status` says of a daemon under this key.
fn says(live: &Live, name: &str, key: &str) -> String {
    daemon(live, name)[key].as_str().unwrap_or_default().to_owned()
}

fn wait_until(live: &Live, is_so: impl Fn(&Live) -> bool) {
    let begun = Instant::now();
    while !is_so(live) {
        assert!(begun.elapsed() < DEADLINE, "{:?}", live.status());
    }
}

fn signal(live: &Live, name: &str, signal: &str) -> u64 {
    let process = daemon(live, name)["process_id"].as_u64().unwrap();
    // A silent daemon has the number 0, and that would be this process and all its relatives.
    assert!(process > 1);
    assert!(Command::new("kill").args([signal, &process.to_string()]).status().unwrap().success());
    process
}

fn reload(live: &Live, name: &str) {
    signal(live, name, "-HUP");
}

/// Kills a daemon, and waits for its successor, healthy or not.
fn kill(live: &Live, name: &str) {
    let before = signal(live, name, "-9");
    wait_until(live, |live| {
        let daemon = daemon(live, name);
        daemon["alive"] == true && daemon["process_id"] != before
    });
}

/// Epoch and content hash of the site that is published.
fn site(live: &Live) -> (u64, String) {
    let echo: Value = serde_json::from_str(&live.text(&[&"topic", &"echo", &"site"])).unwrap();
    (echo["epoch"].as_u64().unwrap(), echo["content_hash"].as_str().unwrap().to_owned())
}

/// Starts the daemons of a site that is not healthy.
fn up(live: &mut Live) {
    live.start_up();
    // A daemon reports before there is a bus to ask it on.
    wait_until(live, |live| live.run(&[&"date"]).status.success());
}

/// Yaw and epoch of the frame that is kept.
fn frame(live: &Live) -> (f64, u64) {
    let bytes = std::fs::read(live.home.path().join("state/site-frame.json")).unwrap();
    let frame: Value = serde_json::from_slice(&bytes).unwrap();
    (frame["map_from_world"]["yaw_rad"].as_f64().unwrap(), frame["frame_epoch"].as_u64().unwrap())
}

fn ask(live: &Live, request: &IngestRequest) -> Result<IngestAnswer, String> {
    let domain = Domain::shared(&live.prefix, live.root.path()).unwrap();
    let (bus, mut waiter) = Bus::join(&domain, Daemon::Groundplan).unwrap();
    let timeouts = RequestTimeouts { starting: DEADLINE, answer: DEADLINE };
    let pause = || waiter.wait(Duration::from_millis(20)).map(drop).map_err(Into::into);
    daemon::ask(&bus, request, timeouts, |_| {}, pause).map_err(|why| why.to_string())
}

#[test]
fn a_revision_whose_schedule_is_unusable_changes_nothing_until_the_rules_are_corrected() {
    let (mut live, folder) = start(&dated_house("2024-04-08"));
    let before = site(&live);
    let model = live.home.path().join("demo.ifc");
    write(&dated_house("08/04/2024"), &model);
    let refused = live.run(&[&"load"]);
    assert_eq!(refused.status.code(), Some(1));
    let why = errors_of(&refused);
    assert!(why.contains("date_format") && why.contains("the site of demo.ifc stays in force"), "{why}");
    // Nothing hangs, the plan time moves along the schedule in force, and what is wrong stands.
    assert_eq!(live.text(&[&"date", &"--next"]), "2024-04-09T00:00:00");
    assert_eq!(live.text(&[&"date", &"2024-03-05"]), "2024-03-05T00:00:00");
    live.text(&[&"date"]);
    wait_until(&live, |live| says(live, "ifc-ingest", "error").contains("date_format"));
    assert_eq!(site(&live), before);

    // The daemon that reads models hears of the corrected rules first, and judges by none of its own.
    std::fs::write(folder.path().join("schedule.toml"), "date_format = \"mdy\"\n").unwrap();
    reload(&live, "ifc-ingest");
    let_them_look(&live);
    assert!(says(&live, "ifc-ingest", "error").contains("date_format"));
    assert_eq!(site(&live), before);
    reload(&live, "schedule-eval");
    wait_until(&live, |live| site(live) != before);
    live.wait_until_healthy();
    assert_eq!(live.text(&[&"date", &"--next"]), "2024-08-05T00:00:00");
    live.down();
}

#[test]
fn another_building_waits_for_an_operator_also_across_restarts() {
    let (mut live, _folder) = start(&house(0));
    let before = site(&live);
    let other = live.home.path().join("other.ifc");
    write(&house(1), &other);
    let compared = live.text(&[&"load", &"--dry-run", &other]);
    assert!(compared.contains("it shares 0 of 5 elements") && compared.contains("would wait"), "{compared}");
    assert_eq!(ask(&live, &IngestRequest::GetRevision).unwrap().effect, RevisionEffect::InForce, "nothing waits");
    let waits = live.run(&[&"load", &other, &"--json"]);
    assert_eq!(waits.status.code(), Some(1));
    let document: Value = serde_json::from_slice(&waits.stdout).unwrap();
    assert_eq!(document["effect"], "waits");
    assert_eq!(document["revision"]["comparison"]["elements"]["shared"], 0);
    wait_until(&live, |live| says(live, "ifc-ingest", "warning").contains("other.ifc"));
    kill(&live, "ifc-ingest");
    wait_until(&live, |live| says(live, "ifc-ingest", "warning").contains("groundplan confirm"));
    assert_eq!(site(&live).1, before.1);
    // The files in force are read again, which is no reason to forget the one that waits.
    let model = live.home.path().join("demo.ifc");
    std::fs::copy(&model, live.home.path().join("copy.ifc")).unwrap();
    std::fs::rename(live.home.path().join("copy.ifc"), &model).unwrap();
    let epoch = site(&live).0;
    wait_until(&live, |live| site(live).0 > epoch);
    assert!(says(&live, "ifc-ingest", "warning").contains("groundplan confirm"));

    // What was compared is confirmed, and nothing else.
    write(&house(2), &other);
    let confirm = |live: &Live| {
        let seen = ask(live, &IngestRequest::GetRevision).unwrap().revision.unwrap().sha256;
        (IngestRequest::Confirm { sha256: seen.clone() }, seen)
    };
    let (request, first) = confirm(&live);
    let answer = ask(&live, &request).unwrap();
    assert_eq!(answer.effect, RevisionEffect::Waits, "its file has changed since");
    assert_ne!(confirm(&live).1, first);
    assert!(ask(&live, &request).unwrap_err().contains("another revision waits by now, other.ifc"));
    assert!(live.text(&[&"confirm", &"--list"]).contains("it shares 0 of 5 elements"));
    let confirmed = live.text(&[&"confirm"]);
    assert!(confirmed.contains("in force, epoch"), "{confirmed}");
    live.wait_until_healthy();
    assert_eq!(frame(&live).1, 2, "another building has another frame");
    assert!(ask(&live, &request).unwrap_err().contains("no revision waits"), "another one is in force");

    // A file that is replaced is guarded as well, and what was discarded does not come back by itself.
    write(&house(0), &other);
    wait_until(&live, |live| says(live, "ifc-ingest", "warning").contains("groundplan confirm"));
    let now = site(&live);
    live.text(&[&"load", &"--discard"]);
    kill(&live, "ifc-ingest");
    assert_eq!(says(&live, "ifc-ingest", "warning"), "");
    assert_eq!(site(&live).1, now.1);
    live.text(&[&"load", &"--force"]);
    assert_eq!(frame(&live).1, 3);
    let history = std::fs::read_dir(live.home.path().join("state/history")).unwrap();
    let history: String = history.map(|month| std::fs::read_to_string(month.unwrap().path()).unwrap()).collect();
    for event in ["other.ifc waits", "other.ifc confirmed", "other.ifc discarded", "another map frame, epoch 3"] {
        assert!(history.contains(event), "{event}: {history}");
    }
    live.down();
}

#[test]
fn a_revision_that_was_refused_is_read_again_after_a_restart_and_when_its_files_change() {
    let (mut live, folder) = start(&dated_house("2024-04-08"));
    let before = site(&live);
    write(&dated_house("08/04/2024"), &live.home.path().join("demo.ifc"));
    assert_eq!(live.run(&[&"load"]).status.code(), Some(1));
    live.down();
    std::fs::write(folder.path().join("schedule.toml"), "date_format = \"dmy\"\n").unwrap();
    live.up();
    let cured = site(&live);
    assert_ne!(cured.1, before.1, "the rules were corrected while nothing ran");

    let model = live.home.path().join("demo.ifc");
    std::fs::write(&model, "no IFC file at all").unwrap();
    wait_until(&live, |live| says(live, "ifc-ingest", "error").contains("demo.ifc"));
    write(&dated_house("09/04/2024"), &model);
    wait_until(&live, |live| site(live).1 != cured.1);
    live.wait_until_healthy();
    live.down();
}

#[test]
fn rules_that_the_site_cannot_be_evaluated_with_leave_its_maps_also_across_a_restart() {
    let folder = tempfile::tempdir().unwrap();
    let rules = folder.path().join("schedule.toml");
    std::fs::write(&rules, "date_format = \"dmy\"\n").unwrap();
    let more = format!("[schedule]\nplan_time = \"2024-03-01\"\nrules = {rules:?}\n");
    let mut live = Live::of(&dated_house("08/04/2024").write(folder.path()), &more);
    // The order of day and month is not told any more.
    std::fs::write(&rules, "").unwrap();
    reload(&live, "schedule-eval");
    wait_until(&live, |live| says(live, "schedule-eval", "error").contains("date_format"));
    for _ in 0..2 {
        assert_eq!(live.text(&[&"date", &"2024-04-07"]), "2024-04-07T00:00:00");
        assert_eq!(live.text(&[&"date", &"--next"]), "2024-04-09T00:00:00");
        kill(&live, "schedule-eval");
        wait_until(&live, |live| says(live, "schedule-eval", "error").contains("date_format"));
    }
    live.down();
}

/// Lines of the history that hold this.
fn events(live: &Live, words: &str) -> usize {
    let months = std::fs::read_dir(live.home.path().join("state/history")).unwrap();
    let text: String = months.map(|month| std::fs::read_to_string(month.unwrap().path()).unwrap()).collect();
    text.lines().filter(|line| line.contains(words)).count()
}

/// Waits until the daemons have had the time to take what is on disk, if they were to.
fn let_them_look(live: &Live) {
    let begun = Instant::now();
    wait_until(live, |_| begun.elapsed() > Duration::from_secs(4));
}

#[test]
fn a_revision_that_is_written_over_the_model_in_place_is_in_force_once_and_whole() {
    let (mut live, _folder) = start(&dated_house("2024-04-08"));
    let before = site(&live);
    let n_before = events(&live, "in force");
    let model = live.home.path().join("demo.ifc");
    let folder = tempfile::tempdir().unwrap();
    let mut larger = dated_house("2024-05-08");
    larger.add("IFCWALL", "More", PLAIN, [[6.0, 0.0, 0.0], [6.2, 2.5, 3.0]]);
    let bytes = std::fs::read(larger.write(folder.path())).unwrap();
    for (k, block) in bytes.chunks(bytes.len() / 6).enumerate() {
        let mut file = std::fs::OpenOptions::new().write(true).open(&model).unwrap();
        file.seek(SeekFrom::Start((k * (bytes.len() / 6)) as u64)).unwrap();
        file.write_all(block).unwrap();
        let written = Instant::now();
        while written.elapsed() < Duration::from_millis(600) {
            assert!(k > 4 || site(&live).1 == before.1, "after {k} blocks another site is published");
        }
    }
    wait_until(&live, |live| site(live).1 != before.1);
    live.wait_until_healthy();
    assert_eq!((site(&live).0, events(&live, "in force"), events(&live, "refused")), (before.0 + 1, n_before + 1, 0));
    live.down();
}

#[test]
fn a_file_of_two_versions_waits_for_an_operator_and_a_cut_one_is_refused_once() {
    let (mut live, _folder) = start(&house(0));
    let before = site(&live);
    let model = live.home.path().join("demo.ifc");
    let folder = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string(house(0).write(folder.path())).unwrap();
    // The slab's solid is of a version that has it under another id.
    let solid = text.lines().find(|line| line.contains("IFCEXTRUDEDAREASOLID")).unwrap();
    let (id, rest) = solid.split_once('=').unwrap();
    let mixed = text.replace(solid, &format!("#9999={rest}"));
    assert!(mixed.contains(&format!("({id})")));
    std::fs::write(&model, &mixed).unwrap();
    wait_until(&live, |live| says(live, "ifc-ingest", "warning").contains("groundplan confirm"));
    let warning = says(&live, "ifc-ingest", "warning");
    assert!(warning.contains("refer to what is not there"), "{warning}");
    assert_eq!(site(&live), before);

    let refused = |live: &Live| events(live, "demo.ifc refused");
    for n_bytes in [text.len() / 2, text.len() / 2 - 1, text.len() / 2 - 2] {
        std::fs::write(&model, &text[..n_bytes]).unwrap();
        let_them_look(&live);
        assert_eq!((site(&live), refused(&live)), (before.clone(), 1));
    }
    assert_eq!(live.status().unwrap()["healthy"], false, "the file in force is spoilt");
    std::fs::write(&model, &text).unwrap();
    live.wait_until_healthy();
    assert_eq!(site(&live).1, before.1);
    live.down();
}

#[test]
fn a_refused_request_is_an_answer_and_the_site_stays_healthy() {
    let (mut live, _folder) = start(&house(0));
    live.wait_until_healthy();
    let robot = live.home.path().join("robot.toml");
    std::fs::write(&robot, "name = \"x\"\nradius_m = -1.0\n").unwrap();
    let missing = live.home.path().join("missing.ifc");
    let requests: [&[&dyn AsRef<std::ffi::OsStr>]; 4] = [
        &[&"load", &missing],
        &[&"robot", &robot],
        &[&"date", &"--next"],
        &[&"waypoints", &"--space", &"no such room"],
    ];
    for request in requests {
        let refused = live.run(request);
        assert!(!refused.status.success() && !refused.stderr.is_empty());
        // A report later than the answer.
        let asked = Instant::now();
        wait_until(&live, |_| asked.elapsed() > Duration::from_millis(1_200));
        let status = live.status().unwrap();
        assert_eq!(status["healthy"], true, "{status}");
    }
    live.down();
}

#[test]
fn a_failed_load_is_answered_and_keeps_the_site_and_its_time_stamps() {
    let (mut live, _folder) = start(&house(0));
    let before = site(&live);
    let broken = live.home.path().join("broken.ifc");
    std::fs::write(&broken, "no IFC file at all").unwrap();
    let failed = live.run(&[&"load", &broken]);
    assert_eq!(failed.status.code(), Some(1));
    let why = errors_of(&failed);
    assert!(why.contains("broken.ifc") && why.contains("the site of demo.ifc stays in force"), "{why}");
    live.text(&[&"date", &"2024-05-01"]);
    assert_eq!(says(&live, "ifc-ingest", "error"), "");
    // The files in force are not taken for changed after a restart.
    kill(&live, "ifc-ingest");
    let heartbeats = Instant::now();
    wait_until(&live, |_| heartbeats.elapsed() > Duration::from_millis(2_500));
    assert_eq!(site(&live).1, before.1);
    let epoch = site(&live).0;
    wait_until(&live, |_| heartbeats.elapsed() > Duration::from_secs(4));
    assert_eq!(site(&live).0, epoch, "nothing is read again");
    // The model in force is watched as before; its next revision cures.
    let mut revision = house(0);
    revision.add("IFCCOLUMN", "Column", PLAIN, [[2.0, 2.0, 0.0], [2.3, 2.3, 3.0]]);
    write(&revision, &live.home.path().join("demo.ifc"));
    live.wait_until_healthy();
    wait_until(&live, |live| site(live).1 != before.1);
    assert_eq!(says(&live, "ifc-ingest", "error"), "");
    live.down();
}

#[test]
fn the_map_frame_survives_its_cache_and_another_file_name_and_every_change_raises_its_epoch() {
    let (mut live, _folder) = start(&house(0));
    let state = live.home.path().join("state");
    assert_eq!(frame(&live), (0.0, 1));
    live.down();
    remove_state(&state.join("site-frame.json"));
    live.up();
    assert_eq!(frame(&live), (0.0, 1), "it was taken from the cache");
    live.down();
    // Without the cache nothing tells the frame, and a new one is not taken for it.
    std::fs::remove_file(state.join("site.gpar")).unwrap();
    remove_state(&state.join("site-frame.json"));
    remove_state(&state.join("site-outline.json"));
    live.up();
    assert!(frame(&live).1 > 1, "{:?}", frame(&live));
    live.down();
    // A frame of an earlier model, and no cache: as after an update of the programs.
    let epoch = frame(&live).1 + 1;
    let kept = format!(r#"{{"map_from_world":{{"x_m":0.0,"y_m":0.0,"z_m":0.0,"yaw_rad":0.4}},"frame_epoch":{epoch}}}"#);
    write_unsealed(&state.join("site-frame.json"), &kept);
    std::fs::remove_file(state.join("site.gpar")).unwrap();
    live.up();
    assert_eq!(frame(&live), (0.4, epoch));
    let renamed = live.home.path().join("renamed.ifc");
    write(&dated_house("2024-04-08"), &renamed);
    live.text(&[&"load", &renamed]);
    assert_eq!(frame(&live), (0.4, epoch), "it is the same building");
    let exported = live.home.path().join("exported");
    live.text(&[&"export", &exported]);
    let written: Value = serde_json::from_slice(&std::fs::read(exported.join("site-frame.json")).unwrap()).unwrap();
    assert_eq!(written["map_from_world"]["yaw_rad"], 0.4);

    // A frame that is damaged, and of which nothing is sealed, is an error, and never another frame.
    write_unsealed(&state.join("site-frame.json"), "{");
    let refused = live.run(&[&"load"]);
    assert!(errors_of(&refused).contains("site-frame.json"), "{}", errors_of(&refused));
    kill(&live, "ifc-ingest");
    wait_until(&live, |live| says(live, "ifc-ingest", "error").contains("site-frame.json"));
    assert_eq!(std::fs::read(state.join("site-frame.json")).unwrap(), b"{");
    remove_state(&state.join("site-frame.json"));
    reload(&live, "ifc-ingest");
    live.wait_until_healthy();
    live.text(&[&"load"]);
    assert_eq!(frame(&live), (0.4, epoch), "that of the site in force");
    let other = live.home.path().join("other.ifc");
    write(&house(1), &other);
    live.text(&[&"load", &other, &"--force"]);
    assert_eq!(frame(&live), (0.0, epoch + 1));
    live.down();
}

#[test]
fn a_machine_clock_that_went_ahead_waits_for_an_operator() {
    let (mut live, folder) = start(&house(0));
    std::fs::write(folder.path().join("schedule.toml"), "site_zone = \"Europe/Amsterdam\"\n").unwrap();
    reload(&live, "schedule-eval");
    let begun = Instant::now();
    while !live.run(&[&"date", &"--wall"]).status.success() {
        assert!(begun.elapsed() < DEADLINE, "the zone is not taken");
    }
    live.down();
    let path = live.home.path().join("state/settings/schedule.plan_time.json");
    let mut setting: Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
    let reached = &mut setting["command"]["value"]["clock"]["wall"]["reached"];
    // It was that the machine was read last 40 days ago, in another boot.
    let days = 40;
    reached["plan_s"] = (reached["plan_s"].as_i64().unwrap() - days * 86_400).into();
    reached["wall_ms"] = (reached["wall_ms"].as_i64().unwrap() - days * 86_400_000).into();
    reached["boot"] = 1.into();
    let stands_s = reached["plan_s"].as_i64().unwrap();
    write_unsealed(&path, &setting.to_string());
    up(&mut live);
    wait_until(&live, |live| says(live, "schedule-eval", "warning").contains("clock_untrusted"));
    let stands = frames::PlanTime::from_civil_seconds(stands_s).unwrap().to_string();
    assert!(live.text(&[&"date"]).starts_with(&stands));
    live.text(&[&"date", &"--wall"]);
    assert!(!live.text(&[&"date"]).starts_with(&stands), "the operator took it");
    assert_eq!(says(&live, "schedule-eval", "warning"), "");
    live.down();
}

/// What of the meshes of the files that were read last was known, and what was made.
fn meshes(live: &Live) -> (u64, u64) {
    let meshes = live.status().unwrap()["site"]["meshes"].clone();
    (meshes["found"].as_u64().unwrap(), meshes["made"].as_u64().unwrap())
}

#[test]
fn a_revision_of_one_wall_takes_the_meshes_of_the_others_also_after_a_restart() {
    let with_partition = |x: f64| {
        let mut house = house(0);
        house.add("IFCWALL", "Partition", PLAIN, [[x, 0.0, 0.0], [x + 0.2, 2.5, 3.0]]);
        house
    };
    let (mut live, _folder) = start(&with_partition(4.0));
    let model = live.home.path().join("demo.ifc");
    let (found, n_bodies) = meshes(&live);
    assert!(found == 0 && n_bodies > 4, "{n_bodies}");
    let first = site(&live).1;
    write(&with_partition(5.0), &model);
    live.text(&[&"load"]);
    assert_eq!(meshes(&live), (n_bodies - 1, 1));

    live.down();
    live.up();
    write(&with_partition(4.0), &model);
    live.text(&[&"load"]);
    assert_eq!((meshes(&live), site(&live).1), ((n_bodies - 1, 1), first.clone()));

    let file = live.home.path().join("state/meshes.gpmesh");
    let mut bytes = std::fs::read(&file).unwrap();
    *bytes.last_mut().unwrap() ^= 1;
    std::fs::write(&file, bytes).unwrap();
    write(&with_partition(5.0), &model);
    live.text(&[&"load"]);
    assert_eq!(meshes(&live), (0, n_bodies), "it is damaged");
    write(&with_partition(4.0), &model);
    live.text(&[&"load"]);
    assert_eq!((meshes(&live), site(&live).1), ((n_bodies - 1, 1), first));
    live.wait_until_healthy();
    live.down();
}
