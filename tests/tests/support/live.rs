//! A site with daemons of its own.

use super::{client, demo_model, groundplan};
use serde_json::Value;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

/// The one deadline of every wait: far beyond what any machine needs.
pub(crate) const DEADLINE: Duration = Duration::from_secs(120);

/// Interval between two looks at a status.
pub(crate) const POLL_INTERVAL: Duration = Duration::from_millis(50);

/// A site with daemons of its own, on a bus of its own.
pub(crate) struct Live {
    pub(crate) home: tempfile::TempDir,
    /// Folder of the bus; goes with this value.
    pub(crate) root: tempfile::TempDir,
    pub(crate) prefix: String,
    pub(crate) up: Option<Child>,
}

impl Live {
    /// The demo building before its first slab.
    pub(crate) fn start() -> Self {
        Self::of(&demo_model(), "[schedule]\nplan_time = \"2024-03-01\"\n")
    }

    /// A building, with more of its configuration.
    pub(crate) fn of(model: &Path, more: &str) -> Self {
        let mut live = Self::without_models(&format!("models = [\"demo.ifc\"]\n{more}"));
        std::fs::copy(model, live.home.path().join("demo.ifc")).unwrap();
        live.up();
        live
    }

    /// A site that is not up, with this configuration beside its state and its bus.
    pub(crate) fn without_models(more: &str) -> Self {
        let home = tempfile::tempdir().unwrap();
        let root = tempfile::Builder::new().prefix("gplive").tempdir_in("/dev/shm").unwrap();
        let prefix = format!("{}_", root.path().file_name().unwrap().to_string_lossy().replace('.', ""));
        let bus = format!("[bus]\nprefix = {prefix:?}\nroot = {:?}\n", root.path());
        std::fs::write(home.path().join("site.toml"), format!("state = \"state\"\n{more}{bus}")).unwrap();
        Self { home, root, prefix, up: None }
    }

    pub(crate) fn config(&self) -> PathBuf {
        self.home.path().join("site.toml")
    }

    pub(crate) fn up(&mut self) {
        let child = Command::new(client()).arg("up").arg("--config").arg(self.config()).stderr(Stdio::null()).spawn();
        self.up = Some(child.unwrap());
        self.wait_until_healthy();
    }

    pub(crate) fn down(&mut self) {
        assert!(self.run(&[&"down"]).status.success());
        assert!(self.up.take().unwrap().wait().unwrap().success());
    }

    pub(crate) fn run(&self, arguments: &[&dyn AsRef<OsStr>]) -> Output {
        let config = self.config();
        let more: [&dyn AsRef<OsStr>; 2] = [&"--config", &config];
        groundplan(&arguments.iter().copied().chain(more).collect::<Vec<_>>())
    }

    pub(crate) fn text(&self, arguments: &[&dyn AsRef<OsStr>]) -> String {
        let output = self.run(arguments);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap().trim().to_owned()
    }

    pub(crate) fn status(&self) -> Option<Value> {
        serde_json::from_slice(&self.run(&[&"status", &"--json"]).stdout).ok()
    }

    /// The status once it is as it should be.
    pub(crate) fn wait_for_status(&self, what: &str, is_so: impl Fn(&Value) -> bool) -> Value {
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

    pub(crate) fn wait_until_healthy(&self) {
        let begun = Instant::now();
        while self.status().is_none_or(|status| status["healthy"] != true) {
            assert!(begun.elapsed() < DEADLINE, "{:?}", self.status());
            std::thread::sleep(POLL_INTERVAL);
        }
    }

    pub(crate) fn index(&self) -> Value {
        serde_json::from_str(&self.text(&[&"topic", &"echo", &"grids"])).unwrap()
    }

    /// Kills a daemon and waits for its successor.
    pub(crate) fn kill(&self, daemon: &str) {
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

    pub(crate) fn segments(&self) -> usize {
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
