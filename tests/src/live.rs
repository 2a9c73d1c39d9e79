//! A site with daemons of its own.

use super::tower::{Tower, published};
use super::{client, demo_model, groundplan};
use serde_json::Value;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

/// The one deadline of every wait: far beyond what any machine needs.
pub const DEADLINE: Duration = Duration::from_secs(120);

/// Interval between two looks at a status.
pub const POLL_INTERVAL: Duration = Duration::from_millis(50);

/// A site with daemons of its own, on a bus of its own.
pub struct Live {
    pub home: tempfile::TempDir,
    /// Folder of the bus; goes with this value.
    pub root: tempfile::TempDir,
    pub prefix: String,
    pub up: Option<Child>,
    /// The server that this site follows, in [`FOLLOWING`] tests.
    server: Option<Box<(Tower, Live)>>,
}

/// With this environment variable sites of tests follow a server that draws for them: what reads their bus, and their files, must not
/// notice.
const FOLLOWING: &str = "GROUNDPLAN_TESTS_FOLLOW";

/// Tables of a site that are for those who draw it.
const OF_DRAWING: [&str; 6] = ["models", "schedule", "robot", "robots", "waypoints", "world"];

/// Daemons that draw, in whose place a robot has one that follows.
const DRAWING: [&str; 4] = ["ifc-ingest", "schedule-eval", "rasterize", "waypoint-gen"];

impl Live {
    /// The demo building before its first slab.
    pub fn start() -> Self {
        Self::of(&demo_model(), "[schedule]\nplan_time = \"2024-03-01\"\n")
    }

    /// A building, with more of its configuration.
    pub fn of(model: &Path, more: &str) -> Self {
        let all = format!("models = [\"demo.ifc\"]\n{more}");
        if std::env::var_os(FOLLOWING).is_some() {
            return Self::following_server(model, &all);
        }
        let mut live = Self::without_models(&all);
        std::fs::copy(model, live.home.path().join("demo.ifc")).unwrap();
        live.up();
        live
    }

    /// A robot that shows what a server draws, with what is not for drawing of this configuration.
    fn following_server(model: &Path, config: &str) -> Self {
        let (drawing, own): (toml::Table, toml::Table) = toml::from_str::<toml::Table>(config)
            .unwrap()
            .into_iter()
            .partition(|(key, _)| OF_DRAWING.contains(&key.as_str()));
        let tower = Tower::with_keys();
        let mut server = Self::without_models(&tower.serve("signing", &drawing.to_string()));
        std::fs::copy(model, server.home.path().join("demo.ifc")).unwrap();
        server.up();
        let mut robot = Self::without_models(&tower.follow(&own.to_string()));
        let first = published(&server, &tower, 0);
        robot.server = Some(Box::new((tower, server)));
        robot.up();
        robot.shows(first);
        robot
    }

    /// Runs what is decided where a site is drawn, and waits until its robot shows the effect.
    fn decide(&self, (tower, server): &(Tower, Live), arguments: &[&dyn AsRef<OsStr>]) -> Output {
        let before = tower.plan_time();
        let output = server.run(arguments);
        if output.status.success() {
            let after = server.status().unwrap()["clock"]["plan_time"].as_str().map(str::to_owned);
            let epoch = if after == before { 0 } else { published(server, tower, 0) };
            self.shows(epoch);
        }
        output
    }

    /// A site that is not up, with this configuration beside its state and its bus.
    pub fn without_models(more: &str) -> Self {
        let home = tempfile::tempdir().unwrap();
        let root = tempfile::Builder::new().prefix("gplive").tempdir_in("/dev/shm").unwrap();
        let prefix = format!("{}_", root.path().file_name().unwrap().to_string_lossy().replace('.', ""));
        let bus = format!("[bus]\nprefix = {prefix:?}\nroot = {:?}\n", root.path());
        std::fs::write(home.path().join("site.toml"), format!("state = \"state\"\n{more}{bus}")).unwrap();
        Self { home, root, prefix, up: None, server: None }
    }

    pub fn config(&self) -> PathBuf {
        self.home.path().join("site.toml")
    }

    pub fn up(&mut self) {
        self.start_up();
        self.wait_until_healthy();
    }

    /// Starts the site, which may have something to tell.
    pub fn start_up(&mut self) {
        let child = Command::new(client()).arg("up").arg("--config").arg(self.config()).stderr(Stdio::null()).spawn();
        self.up = Some(child.unwrap());
    }

    pub fn down(&mut self) {
        assert!(self.run(&[&"down"]).status.success());
        assert!(self.up.take().unwrap().wait().unwrap().success());
    }

    pub fn run(&self, arguments: &[&dyn AsRef<OsStr>]) -> Output {
        let sets_date = arguments.len() > 1 && arguments[0].as_ref() == "date";
        if let Some(server) = self.server.as_deref().filter(|_| sets_date) {
            return self.decide(server, arguments);
        }
        let config = self.config();
        let more: [&dyn AsRef<OsStr>; 2] = [&"--config", &config];
        groundplan(&arguments.iter().copied().chain(more).collect::<Vec<_>>())
    }

    pub fn text(&self, arguments: &[&dyn AsRef<OsStr>]) -> String {
        let output = self.run(arguments);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap().trim().to_owned()
    }

    pub fn status(&self) -> Option<Value> {
        serde_json::from_slice(&self.run(&[&"status", &"--json"]).stdout).ok()
    }

    /// The status once it is as it should be.
    pub fn wait_for_status(&self, what: &str, is_so: impl Fn(&Value) -> bool) -> Value {
        let begun = Instant::now();
        loop {
            let status = self.status();
            if let Some(status) = status.as_ref().filter(|status| is_so(status)) {
                return status.clone();
            }
            assert!(begun.elapsed() < DEADLINE, "{what}: {status:?}");
            std::thread::sleep(POLL_INTERVAL);
        }
    }

    pub fn wait_until_settled(&self, what: &str, is_so: impl Fn(&Self) -> bool) {
        let begun = Instant::now();
        while self.status().is_none_or(|status| status["daemons"].get("schedule-eval").is_none()) || !is_so(self) {
            assert!(begun.elapsed() < DEADLINE, "{what}: {:?}", self.status());
            std::thread::sleep(POLL_INTERVAL);
        }
    }

    pub fn wait_until_healthy(&self) {
        let begun = Instant::now();
        while self.status().is_none_or(|status| status["healthy"] != true) {
            assert!(begun.elapsed() < DEADLINE, "{:?}", self.status());
            std::thread::sleep(POLL_INTERVAL);
        }
    }

    pub fn index(&self) -> Value {
        serde_json::from_str(&self.text(&[&"topic", &"echo", &"grids"])).unwrap()
    }

    /// Kills a daemon and waits for its successor.
    pub fn kill(&self, daemon: &str) {
        let daemon = if self.server.is_some() && DRAWING.contains(&daemon) { "site-follow" } else { daemon };
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
            std::thread::sleep(POLL_INTERVAL);
        }
    }

    pub fn segments(&self) -> usize {
        let names = std::fs::read_dir("/dev/shm").unwrap().map(|e| e.unwrap().file_name());
        names.filter(|name| name.to_string_lossy().starts_with(&self.prefix)).count()
    }
}

impl Drop for Live {
    fn drop(&mut self) {
        // The relay's folder is beside that of the bus; without a relay there is none.
        let _ = std::fs::remove_dir_all(format!("{}-relay", self.root.path().display()));
        if let Some(mut up) = self.up.take() {
            // After a failure: its children leave with it.
            let _ = up.kill();
            let _ = up.wait();
        }
        // After a failure, and what a participant in the test itself was the last to hold.
        for entry in std::fs::read_dir("/dev/shm").into_iter().flatten().flatten() {
            if entry.file_name().to_string_lossy().starts_with(&self.prefix) {
                let _ = std::fs::remove_file(entry.path());
            }
        }
    }
}
