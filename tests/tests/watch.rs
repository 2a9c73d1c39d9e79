//! `export --watch` and the Nav2 hook script.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use end_to_end::live::{DEADLINE, Live};
use end_to_end::{client, contents, root, write_program};
use serde_json::Value;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::Instant;

/// A watch; stopped when dropped.
struct Watch(Child);

impl Watch {
    fn start(live: &Live, out: &Path, on_change: &Path) -> Self {
        Self::with(live, out, &["--on-change".as_ref(), on_change.as_os_str()])
    }

    fn with(live: &Live, out: &Path, more: &[&OsStr]) -> Self {
        let mut command = Command::new(client());
        command.arg("export").arg(out).args(["--watch", "--keep", "2"]).args(more).arg("--config").arg(live.config());
        Self(command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap())
    }

    fn stop(mut self) {
        assert!(Command::new("kill").arg(self.0.id().to_string()).status().unwrap().success());
        assert!(self.0.wait().unwrap().success());
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Waits until the link names a folder with this plan time; the folder.
fn wait_for(out: &Path, plan_time: &str) -> PathBuf {
    let begun = Instant::now();
    loop {
        let manifest = std::fs::read_to_string(out.join("current/manifest.json")).unwrap_or_default();
        if manifest.contains(plan_time) {
            return out.join(std::fs::read_link(out.join("current")).unwrap());
        }
        assert!(begun.elapsed() < DEADLINE, "{plan_time} does not come: {manifest}");
    }
}

/// Waits until older epochs are deleted.
fn wait_for_epochs(out: &Path, n_epochs: usize) {
    let begun = Instant::now();
    loop {
        let n_there = std::fs::read_dir(out.join("epochs")).unwrap().count();
        if n_there == n_epochs {
            return;
        }
        assert!(begun.elapsed() < DEADLINE, "{n_there} epochs, not {n_epochs}");
    }
}

#[test]
fn the_link_follows_the_maps_and_a_program_runs_for_each() {
    let mut live = Live::start();
    let out = live.home.path().join("maps");
    let (program_path, log) = (live.home.path().join("on-change"), live.home.path().join("changes.log"));
    // It fails, and that stops nothing.
    write_program(&program_path, &format!("#!/bin/sh\necho \"$1\" >> {}\nexit 3\n", log.display()));
    let watch = Watch::start(&live, &out, &program_path);
    wait_for(&out, "2024-03-01T00:00:00");
    for date in ["2024-04-06T12:00:00", "2024-04-27T12:00:00", "2024-06-03T12:00:00"] {
        live.text(&[&"date", &date]);
        let folder = wait_for(&out, date);
        let begun = Instant::now();
        while !std::fs::read_to_string(&log).unwrap_or_default().contains(&*folder.to_string_lossy()) {
            assert!(begun.elapsed() < DEADLINE, "the hook was not run for {}", folder.display());
        }
    }
    let folder = wait_for(&out, "2024-06-03T12:00:00");
    let exported = live.home.path().join("exported");
    live.text(&[&"export", &exported]);
    assert!(contents(&folder) == contents(&exported), "the same files as of export");
    wait_for_epochs(&out, 2);
    watch.stop();

    // A later watch goes on where this one ended.
    std::fs::remove_file(&log).unwrap();
    let watch = Watch::start(&live, &out, &program_path);
    let begun = Instant::now();
    while !std::fs::read_to_string(&log).unwrap_or_default().contains(&*folder.to_string_lossy()) {
        assert!(begun.elapsed() < DEADLINE, "the hook was not run for the maps that are there");
    }
    live.text(&[&"date", &"2024-04-27T12:00:00"]);
    wait_for(&out, "2024-04-27T12:00:00");
    watch.stop();
    live.down();
}

/// What the file `fresh` says; `Null` if it is not there.
fn fresh(out: &Path) -> Value {
    std::fs::read(out.join("fresh")).map_or(Value::Null, |bytes| serde_json::from_slice(&bytes).unwrap())
}

/// Waits until the file says something.
fn wait_until_fresh_says(out: &Path, what: &str, is_it: impl Fn(&Value) -> bool) -> Value {
    let begun = Instant::now();
    loop {
        let said = fresh(out);
        if is_it(&said) {
            return said;
        }
        assert!(begun.elapsed() < DEADLINE, "fresh does not say {what}: {said}");
    }
}

/// Waits until the last line of a log begins with this.
fn wait_for_last_line(log: &Path, wanted: &str) {
    let begun = Instant::now();
    loop {
        let text = std::fs::read_to_string(log).unwrap_or_default();
        if text.lines().last().is_some_and(|line| line.starts_with(wanted)) {
            return;
        }
        assert!(begun.elapsed() < DEADLINE, "{wanted} does not come: {text}");
    }
}

#[test]
fn maps_are_fresh_only_while_the_daemons_hold_them_and_hooks_hear_of_it() {
    let mut live = Live::start();
    let (home, out) = (live.home.path().to_owned(), live.home.path().join("maps"));
    let log = home.join("log");
    let hook = |name: &str| {
        let path = home.join(name);
        write_program(&path, &format!("#!/bin/sh\necho \"{name} $1\" >> {}\n", log.display()));
        path
    };
    let (on_change, on_stale) = (hook("change"), hook("stale"));
    let options: [&OsStr; 4] = ["--on-change".as_ref(), on_change.as_ref(), "--on-stale".as_ref(), on_stale.as_ref()];
    let is_fresh = |said: &Value| said["state"] == "fresh" && said["outdated_storeys"] == Value::Array(Vec::new());

    let watch = Watch::with(&live, &out, &options);
    let first = wait_until_fresh_says(&out, "fresh", is_fresh);
    assert_eq!(
        (&first["plan_time"], &first["valid_until"]),
        (&"2024-03-01T00:00:00".into(), &"2024-03-04T08:00:00".into())
    );
    let second = wait_until_fresh_says(&out, "a later check", |said| {
        is_fresh(said) && said["checked_at"] != first["checked_at"]
    });
    assert_eq!(second["epoch"], first["epoch"]);
    let date = "2024-04-06T12:00:00";
    live.text(&[&"date", &date]);
    let third = wait_until_fresh_says(&out, "the next date", |said| is_fresh(said) && said["plan_time"] == date);
    assert!(first["epoch"].as_u64() < third["epoch"].as_u64() && third["valid_until"].is_string(), "{third}");
    let folder = wait_for(&out, date);
    assert_eq!(third["epoch"].as_u64().unwrap().to_string(), *folder.file_name().unwrap().to_string_lossy());

    // The daemons leave in order, and come again with the same maps.
    wait_for_last_line(&log, &format!("change {}", folder.display()));
    live.down();
    let stale = wait_until_fresh_says(&out, "stale", |said| said["state"] == "stale");
    let reason = stale["reason"].as_str().unwrap().to_owned();
    wait_for_last_line(&log, &format!("stale {reason}"));
    live.up();
    wait_until_fresh_says(&out, "fresh again", is_fresh);
    wait_for_last_line(&log, "change ");

    // rasterize hangs: its heartbeats do not come.
    let processes = live.status().unwrap()["daemons"]["rasterize"]["process_id"].clone();
    let signal = |signal: &str| {
        assert!(Command::new("kill").args([signal, &processes.to_string()]).status().unwrap().success());
    };
    signal("-STOP");
    let stale = wait_until_fresh_says(&out, "stale", |said| said["state"] == "stale");
    assert_eq!(stale["reason"], "rasterize has missed 3 heartbeats");
    signal("-CONT");
    wait_until_fresh_says(&out, "fresh again", is_fresh);

    // Who stops the watch makes the maps stale; a watch that is killed leaves a file that grows old.
    watch.stop();
    assert_eq!(fresh(&out)["state"], "stale");
    let mut watch = Watch::with(&live, &out, &options);
    wait_until_fresh_says(&out, "fresh", is_fresh);
    watch.0.kill().unwrap();
    watch.0.wait().unwrap();
    let left = fresh(&out);
    live.text(&[&"date", &"2024-04-27T12:00:00"]);
    assert_eq!(fresh(&out), left, "it is not replaced any more");
    live.down();
}

#[test]
fn a_watch_deletes_and_replaces_nothing_that_it_did_not_write() {
    let mut live = Live::start();
    let out = live.home.path().join("maps");
    let program_path = live.home.path().join("on-change");
    write_program(&program_path, "#!/bin/sh\n");
    // Folders with numbers of old epochs, as people name them, and a link that is none.
    std::fs::create_dir_all(out.join("epochs/0")).unwrap();
    std::fs::write(out.join("epochs/0/notes.txt"), "precious").unwrap();
    std::fs::write(out.join("current"), "precious").unwrap();
    let refused = live.run(&[&"export", &out, &"--watch"]);
    assert_eq!(refused.status.code(), Some(2), "{}", String::from_utf8_lossy(&refused.stderr));
    assert_eq!(std::fs::read_to_string(out.join("current")).unwrap(), "precious");
    std::fs::remove_file(out.join("current")).unwrap();

    let watch = Watch::start(&live, &out, &program_path);
    let first = wait_for(&out, "2024-03-01T00:00:00");
    std::fs::write(first.join("slam.pgm"), "a day of mapping").unwrap();
    for date in ["2024-04-06T12:00:00", "2024-04-27T12:00:00", "2024-06-03T12:00:00", "2024-06-04T12:00:00"] {
        live.text(&[&"date", &date]);
        wait_for(&out, date);
    }
    // Two that are kept, and two of others.
    wait_for_epochs(&out, 4);
    watch.stop();
    assert_eq!(std::fs::read_to_string(first.join("slam.pgm")).unwrap(), "a day of mapping");
    assert_eq!(std::fs::read_to_string(out.join("epochs/0/notes.txt")).unwrap(), "precious");
    live.down();
}

/// Nav2 as its scripts see it: a `ros2` that writes down how it is called, and gives one answer to all services.
struct Nav2 {
    home: tempfile::TempDir,
    answer: &'static str,
}

impl Nav2 {
    fn new() -> Self {
        let home = tempfile::tempdir().unwrap();
        std::fs::create_dir(home.path().join("bin")).unwrap();
        Self { home, answer: "response: LoadMap_Response(result=0)" }
    }

    /// An output folder whose planning maps of the two storeys hold these texts.
    fn folder(&self, name: &str, planning: [&str; 2]) -> PathBuf {
        let folder = self.home.path().join(name);
        let mut files = String::new();
        for (storey, text) in ["00-ground-floor", "01-upper-floor"].into_iter().zip(planning) {
            let path = folder.join("storeys").join(storey);
            std::fs::create_dir_all(&path).unwrap();
            let sum = |text: &str| format!("{:064x}", text.len());
            for (file, sum) in [("keepout.pgm", sum("")), ("planning.pgm", sum(text)), ("semantic.png", sum(name))] {
                files += &format!("    \"storeys/{storey}/{file}\": \"{sum}\",\n");
            }
        }
        std::fs::write(folder.join("manifest.json"), format!("{{\n  \"files\": {{\n{files}  }}\n}}\n")).unwrap();
        folder
    }

    /// Runs a script of `config/nav2`; its output, and the calls of `ros2`.
    fn run(&self, script: &str, arguments: &[&OsStr], variables: &[(&str, &OsStr)]) -> (Output, String) {
        let (bin, log) = (self.home.path().join("bin"), self.home.path().join("ros2.log"));
        let ros2 = format!(
            "#!/bin/sh\necho \"$*\" >> {}\ncase \"$1 $2\" in 'action list') echo /navigate_to_pose;; *) echo '{}';; esac\n",
            log.display(),
            self.answer
        );
        write_program(&bin.join("ros2"), &ros2);
        let _ = std::fs::remove_file(&log);
        let path = format!("{}:{}", bin.display(), std::env::var("PATH").unwrap());
        let script = root().join("config/nav2").join(script);
        let mut command = Command::new(script);
        command.args(arguments).env("PATH", path).envs(variables.iter().copied());
        (command.output().unwrap(), std::fs::read_to_string(&log).unwrap_or_default())
    }
}

#[test]
fn nav2_is_stopped_before_it_gets_new_maps_and_a_refusal_is_a_failure() {
    let mut nav2 = Nav2::new();
    let out = nav2.folder("out", ["", ""]);
    let (output, log) = nav2.run("on-change", &[out.as_ref(), "1".as_ref()], &[]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let place = |what: &str| log.find(what).unwrap_or_else(|| panic!("{what} is missing in {log}"));
    assert!(
        place("cancel_goal") < place("01-upper-floor/planning.yaml") && place("planning.yaml") < place("keepout.yaml")
    );
    assert!(place("keepout.yaml") < place("clear_entirely_global_costmap"));
    assert!(place("clear_entirely_local_costmap") < place("maps_changed"));
    assert!(!log.contains("set_route_graph"), "there is no graph");

    nav2.answer = "response: LoadMap_Response(result=1)";
    let (output, log) = nav2.run("on-change", &[out.as_ref(), "1".as_ref()], &[]);
    assert!(!output.status.success() && String::from_utf8_lossy(&output.stderr).contains("the robot stands"));
    assert!(!log.contains("maps_changed"), "{log}");
    assert_eq!(
        nav2.run("on-change", &[out.as_ref(), "7".as_ref()], &[]).0.status.code(),
        Some(1),
        "there is no such storey"
    );
    assert_eq!(nav2.run("on-change", &[], &[]).0.status.code(), Some(2));
}

#[test]
fn a_change_on_another_storey_leaves_the_robot_its_goal() {
    let nav2 = Nav2::new();
    let [before, upper, both] =
        [["a", "b"], ["a", "other"], ["new", "other"]].map(|maps| nav2.folder(&maps.concat(), maps));
    let run = |folder: &Path, previous: &Path, stale: &str, storey: &str| {
        let variables: [(&str, &OsStr); 3] = [
            ("GROUNDPLAN_PREVIOUS", previous.as_ref()),
            ("GROUNDPLAN_STALE_STOREYS", stale.as_ref()),
            ("GROUNDPLAN_STOREY", storey.as_ref()),
        ];
        let (output, log) = nav2.run("on-change", &[folder.as_ref()], &variables);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        log
    };
    assert_eq!(run(&upper, &before, "", "0"), "", "nothing of Nav2 is touched");
    assert_eq!(run(&upper, &before, "1", "0"), "");
    assert!(run(&upper, &before, "", "1").contains("cancel_goal"));
    assert!(run(&both, &upper, "", "0").contains("cancel_goal"));
    // What stopped the robot lets it go on, although nothing of its storey changed.
    assert!(run(&upper, &before, "all", "0").contains("maps_changed"));
    assert!(run(&upper, &before, "0 1", "0").contains("maps_changed"));
    assert!(run(&upper, Path::new(""), "", "0").contains("maps_changed"), "it is unknown what Nav2 has");
    assert!(run(&upper, Path::new("/is/gone"), "", "0").contains("maps_changed"));
}

#[test]
fn stale_maps_stop_the_robots_whose_storey_they_show() {
    let nav2 = Nav2::new();
    let run = |stale: &str, storey: &str| {
        let variables: [(&str, &OsStr); 2] =
            [("GROUNDPLAN_STALE_STOREYS", stale.as_ref()), ("GROUNDPLAN_STOREY", storey.as_ref())];
        let (output, log) = nav2.run("on-stale", &["it's \"gone\"".as_ref()], &variables);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        log
    };
    let log = run("all", "0");
    assert!(log.contains("/navigate_to_pose/_action/cancel_goal"), "{log}");
    assert!(
        log.contains("topic pub --once /groundplan/maps_stale std_msgs/msg/String {data: 'it''s \"gone\"'}"),
        "{log}"
    );
    assert!(run("0 12", "12").contains("maps_stale"));
    assert_eq!(run("0 12", "1"), "");
    let (output, log) = nav2.run("on-stale", &["groundplan export has ended".as_ref()], &[]);
    assert!(output.status.success() && log.contains("cancel_goal"), "without variables, as from ExecStopPost=: {log}");
}
