//! The daemons of a site as real processes: started, asked, killed, stopped.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

mod support;

use serde_json::Value;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};
use support::{demo_model, files_in, groundplan};

/// The one deadline of every wait: far beyond what any machine needs.
const DEADLINE: Duration = Duration::from_secs(120);

/// A site with daemons of its own, on a bus of its own.
struct Live {
    home: tempfile::TempDir,
    /// Folder of the bus; goes with this value.
    _root: tempfile::TempDir,
    prefix: String,
    up: Option<Child>,
}

impl Live {
    /// The demo building before its first slab.
    fn start() -> Self {
        let home = tempfile::tempdir().unwrap();
        let root = tempfile::Builder::new().prefix("gplive").tempdir_in("/dev/shm").unwrap();
        let prefix = format!("{}_", root.path().file_name().unwrap().to_string_lossy().replace('.', ""));
        std::fs::copy(demo_model(), home.path().join("demo.ifc")).unwrap();
        let site = format!(
            "state = \"state\"\nmodels = [\"demo.ifc\"]\n[schedule]\nplan_time = \"2024-03-01\"\n[bus]\nprefix = {prefix:?}\nroot = {:?}\n",
            root.path()
        );
        std::fs::write(home.path().join("site.toml"), site).unwrap();
        let mut live = Self { home, _root: root, prefix, up: None };
        live.up();
        live
    }

    fn config(&self) -> PathBuf {
        self.home.path().join("site.toml")
    }

    fn up(&mut self) {
        let client = std::env::current_exe().unwrap().parent().unwrap().parent().unwrap().join("groundplan");
        let child = Command::new(client).arg("up").arg("--config").arg(self.config()).stderr(Stdio::null()).spawn();
        self.up = Some(child.unwrap());
        self.wait_until_healthy();
    }

    fn down(&mut self) {
        assert!(self.run(&[&"down"]).status.success());
        assert!(self.up.take().unwrap().wait().unwrap().success());
    }

    fn run(&self, arguments: &[&dyn AsRef<OsStr>]) -> Output {
        let config = self.config();
        let more: [&dyn AsRef<OsStr>; 2] = [&"--config", &config];
        groundplan(&arguments.iter().copied().chain(more).collect::<Vec<_>>())
    }

    fn text(&self, arguments: &[&dyn AsRef<OsStr>]) -> String {
        let output = self.run(arguments);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap().trim().to_owned()
    }

    fn status(&self) -> Option<Value> {
        serde_json::from_slice(&self.run(&[&"status", &"--json"]).stdout).ok()
    }

    fn wait_until_healthy(&self) {
        let begun = Instant::now();
        while self.status().is_none_or(|status| status["healthy"] != true) {
            assert!(begun.elapsed() < DEADLINE, "{:?}", self.status());
        }
    }

    fn index(&self) -> Value {
        serde_json::from_str(&self.text(&[&"topic", &"echo", &"grids"])).unwrap()
    }

    /// Kills a daemon and waits for its successor.
    fn kill(&self, daemon: &str) {
        self.wait_until_healthy();
        let before = self.status().unwrap()["daemons"][daemon]["process_id"].clone();
        // A silent daemon has the number 0, and that would be this process and all its relatives.
        assert!(before.as_u64().unwrap() > 1);
        assert!(Command::new("kill").args(["-9", &before.to_string()]).status().unwrap().success());
        let begun = Instant::now();
        loop {
            let status = self.status();
            let is_new = |s: &Value| s["healthy"] == true && s["daemons"][daemon]["process_id"] != before;
            if status.as_ref().is_some_and(is_new) {
                return;
            }
            assert!(begun.elapsed() < DEADLINE, "{daemon} does not come back: {status:?}");
        }
    }

    fn segments(&self) -> usize {
        let names = std::fs::read_dir("/dev/shm").unwrap().map(|e| e.unwrap().file_name());
        names.filter(|name| name.to_string_lossy().starts_with(&self.prefix)).count()
    }
}

impl Drop for Live {
    fn drop(&mut self) {
        if let Some(mut up) = self.up.take() {
            // After a failure: its children leave with it.
            let _ = up.kill();
            let _ = up.wait();
        }
    }
}

/// Every file of an output folder with its content.
fn contents(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let (mut todo, mut found) = (vec![folder.to_owned()], Vec::new());
    while let Some(at) = todo.pop() {
        for path in files_in(&at) {
            if path.is_dir() {
                todo.push(path);
            } else {
                found.push((path.strip_prefix(folder).unwrap().to_owned(), std::fs::read(path).unwrap()));
            }
        }
    }
    found.sort();
    found
}

#[test]
fn the_next_date_changes_the_maps_and_export_writes_what_convert_writes() {
    let mut live = Live::start();
    assert_eq!(live.index()["content"]["plan_time"], "2024-03-01T00:00:00");
    let before = live.index();
    assert_eq!(live.text(&[&"date", &"--next"]), "2024-03-04T08:00:00");
    assert_ne!(live.index()["content_hash"], before["content_hash"], "it returned when the new index was out");
    for date in ["2024-04-29T10:00:00", "2024-03-20T00:00:00", "2024-06-03T12:00:00"] {
        live.text(&[&"date", &date]);
        let (exported, converted) = (live.home.path().join("exported"), live.home.path().join("converted"));
        live.text(&[&"export", &exported]);
        let model = live.home.path().join("demo.ifc");
        assert!(groundplan(&[&"convert", &model, &"-o", &converted, &"--date", &date]).status.success());
        let (exported, converted) = (contents(&exported), contents(&converted));
        assert!(exported.len() > 20);
        for (one, other) in exported.iter().zip(&converted) {
            assert!(one == other, "{} differs at {date}", one.0.display());
        }
        assert_eq!(exported.len(), converted.len());
    }
    live.down();
    assert_eq!(live.segments(), 0, "nothing is left in shared memory");
}

#[test]
fn what_was_set_survives_the_death_of_every_process() {
    let mut live = Live::start();
    live.text(&[&"date", &"2024-04-29T10:00:00"]);
    live.text(&[&"robot", &support::root().join("config/robots/legged.toml")]);
    let check = |live: &Live| {
        let content = &live.index()["content"];
        assert_eq!((&content["plan_time"], &content["robot"]), (&"2024-04-29T10:00:00".into(), &"legged".into()));
    };
    let mut epoch = live.index()["epoch"].as_u64().unwrap();
    for daemon in ["ifc-ingest", "schedule-eval", "rasterize"] {
        live.kill(daemon);
        check(&live);
        let now = live.index()["epoch"].as_u64().unwrap();
        assert!(epoch <= now, "epochs never fall");
        epoch = now;
    }
    live.down();
    live.up();
    check(&live);
    assert!(epoch <= live.index()["epoch"].as_u64().unwrap());
    live.down();
}

#[test]
fn a_broken_file_leaves_the_last_good_map_and_says_why() {
    let mut live = Live::start();
    let before = live.index();
    let model = live.home.path().join("demo.ifc");
    let whole = std::fs::read(&model).unwrap();
    std::fs::write(&model, "no IFC file at all").unwrap();
    let output = live.run(&[&"load"]);
    assert!(!output.status.success());
    assert!(String::from_utf8_lossy(&output.stderr).contains("demo.ifc"));
    assert_eq!(live.index()["content_hash"], before["content_hash"]);
    let says_why = |s: &Value| s["daemons"]["ifc-ingest"]["error"].as_str().is_some_and(|e| e.contains("demo.ifc"));
    let begun = Instant::now();
    while !live.status().is_some_and(|status| status["healthy"] == false && says_why(&status)) {
        assert!(begun.elapsed() < DEADLINE, "{:?}", live.status());
    }
    // It is noticed on disk as soon as it is whole again.
    std::fs::write(&model, whole).unwrap();
    live.wait_until_healthy();
    live.down();
}

#[test]
fn a_bus_without_a_keeper_is_an_error_that_says_what_to_do() {
    let mut live = Live::start();
    live.down();
    let output = live.run(&[&"status"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("groundplan up"));
}
