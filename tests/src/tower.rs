//! The keys and the store of a site that a server gives to robots, and robots that follow it.

use super::live::Live;
use super::{client, contents, groundplan};
use serde_json::Value;
use std::path::PathBuf;
use std::process::Command;

/// The date of a site at its start.
pub const FIRST: &str = "[schedule]\nplan_time = \"2024-04-15\"\n";

/// Keys of a site and its store, in a folder.
pub struct Tower {
    pub home: tempfile::TempDir,
}

impl Tower {
    pub fn with_keys() -> Self {
        let tower = Self { home: tempfile::tempdir().unwrap() };
        tower.key("root");
        tower.key("signing");
        tower.list(1, &["signing"]);
        tower
    }

    pub fn at(&self, name: &str) -> PathBuf {
        self.home.path().join(name)
    }

    pub fn key(&self, name: &str) {
        let output = groundplan(&[&"key", &"new", &self.at(&format!("{name}.pem"))]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }

    pub fn public(&self, name: &str) -> String {
        let output = groundplan(&[&"key", &"show", &self.at(&format!("{name}.pem"))]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap().trim().to_owned()
    }

    /// Signs a list of keys.
    pub fn list(&self, number: u32, names: &[&str]) {
        let mut command = Command::new(client());
        command.args(["key", "list", "--site", "tower", "--number", &number.to_string()]);
        command.arg("--root").arg(self.at("root.pem")).arg("-o").arg(self.at("keys.jsonl"));
        for name in names {
            command.args(["--key", &self.public(name)]);
        }
        assert!(command.status().unwrap().success());
    }

    pub fn store(&self) -> PathBuf {
        self.at("store")
    }

    /// The index that is the newest.
    pub fn current(&self) -> PathBuf {
        self.at("store/tower/current.jsonl")
    }

    /// What a server has in its configuration, with the name of the key that signs.
    pub fn serve(&self, key: &str, more: &str) -> String {
        let [store, key, keys] = [self.store(), self.at(&format!("{key}.pem")), self.at("keys.jsonl")];
        format!("{more}[serve]\nstore = {store:?}\nsite = \"tower\"\nkey = {key:?}\nkeys = {keys:?}\n")
    }

    /// What a robot has in its configuration.
    pub fn follow(&self, more: &str) -> String {
        self.follow_at(self.store().to_str().unwrap(), more)
    }

    pub fn follow_at(&self, store: &str, more: &str) -> String {
        let root = self.public("root");
        format!("[follow]\nstore = {store:?}\nsite = \"tower\"\nroots = [{root:?}]\npoll_s = 1\n{more}")
    }

    /// The plan time of the first set of the newest index, once its mission plan is in it.
    pub fn plan_time(&self) -> Option<String> {
        let text = std::fs::read_to_string(self.current()).unwrap();
        let index: Value = serde_json::from_str(text.lines().nth(2)?).ok()?;
        let set = &index["sets"][0];
        let has_plans = set["robots"].as_object()?.values().all(|maps| !maps["mission_plan"].is_null());
        messages::plan_time(set["plan_time_s"].as_i64().filter(|_| has_plans)?).map(|at| at.to_string())
    }

    /// Epoch of the newest index.
    pub fn epoch(&self) -> u64 {
        self.index()["epoch"].as_u64().unwrap()
    }

    /// The newest index.
    pub fn index(&self) -> Value {
        let text = std::fs::read_to_string(self.current()).unwrap();
        serde_json::from_str(text.lines().nth(2).unwrap()).unwrap()
    }
}

impl Live {
    /// A robot without models.
    pub fn following(config: &str) -> Self {
        let mut robot = Self::without_models(config);
        robot.start_up();
        robot
    }

    /// The status of a robot that shows an index of at least this epoch, whole.
    pub fn shows(&self, epoch: u64) -> Value {
        self.wait_for_status("the index is shown", |status| {
            status["follower"]["epoch"].as_u64().is_some_and(|shown| shown >= epoch) && status["healthy"] == true
        })
    }

    /// What site-follow says is wrong, once it says something with these words.
    pub fn says(&self, words: &str) -> String {
        self.daemon_says("site-follow", words)
    }

    pub fn daemon_says(&self, name: &str, words: &str) -> String {
        let text = |status: &Value| {
            let daemon = &status["daemons"][name];
            format!("{} {}", daemon["error"].as_str().unwrap_or(""), daemon["warning"].as_str().unwrap_or(""))
        };
        text(&self.wait_for_status(words, |status| text(status).contains(words)))
    }

    pub fn exported(&self, name: &str) -> Vec<(PathBuf, Vec<u8>)> {
        let out = self.home.path().join(name);
        self.text(&[&"export", &out, &"--force"]);
        contents(&out)
    }
}

/// The server has published what it draws now.
pub fn published(server: &Live, tower: &Tower, after: u64) -> u64 {
    server.wait_for_status("it is published", |status| {
        let is_drawn = status["healthy"] == true;
        let shown = status["clock"]["plan_time"].as_str().map(str::to_owned);
        is_drawn && tower.current().is_file() && tower.epoch() > after && tower.plan_time() == shown
    });
    tower.epoch()
}
