//! Users: the bus is its user's alone, and others use the site through the relay, each as far as a group allows.
//!
//! The users are numbers that the machine knows nothing of; only root can be several of them.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use end_to_end::live::DEADLINE;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs::{self, File, Permissions};
use std::io::{BufRead, BufReader};
use std::os::unix::fs::{MetadataExt, PermissionsExt, chown};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

/// Who runs the daemons, and who asks: a number, and the groups that it is in.
#[derive(Clone, Copy)]
struct User(u32, &'static [u32]);

const CONTROL: u32 = 13001;
const VIEW: u32 = 13002;

const SERVICE: User = User(12001, &[CONTROL, VIEW]);
const VIEWER: User = User(12002, &[VIEW]);
const OPERATOR: User = User(12003, &[CONTROL]);
const STRANGER: User = User(12004, &[]);
const ROOT: User = User(0, &[]);

/// A site of [`SERVICE`], whose programs and files all users can reach.
struct Site {
    home: tempfile::TempDir,
    /// Holds the folders of bus and relay; goes with this value.
    memory: tempfile::TempDir,
    prefix: String,
    up: Option<Child>,
}

impl Site {
    fn start() -> Self {
        let home = tempfile::tempdir().unwrap();
        let memory = tempfile::Builder::new().prefix("gpuser").tempdir_in("/dev/shm").unwrap();
        let prefix = format!("{}_", memory.path().file_name().unwrap().to_string_lossy().replace('.', ""));
        for folder in [home.path(), memory.path()] {
            fs::set_permissions(folder, Permissions::from_mode(0o755)).unwrap();
            chown(folder, Some(SERVICE.0), Some(SERVICE.0)).unwrap();
        }
        let site = Self { home, memory, prefix, up: None };
        site.copy_programs();
        fs::copy(end_to_end::demo_model(), site.home.path().join("demo.ifc")).unwrap();
        let config = format!(
            "state = \"state\"\nmodels = [\"demo.ifc\"]\n[schedule]\nplan_time = \"2024-03-01\"\n\
             [bus]\nprefix = {:?}\nroot = {:?}\n\
             [relay]\nfolder = {:?}\nview_group = \"{VIEW}\"\ncontrol_group = \"{CONTROL}\"\n",
            site.prefix,
            site.root(),
            site.memory.path().join("relay"),
        );
        fs::write(site.home.path().join("site.toml"), config).unwrap();
        site.up()
    }

    /// The programs may lie where only root can go.
    fn copy_programs(&self) {
        let client = end_to_end::client();
        let bin = self.home.path().join("bin");
        fs::create_dir(&bin).unwrap();
        let daemons = bus::Daemon::ALL.into_iter().filter(|daemon| daemon.is_of_site()).map(bus::Daemon::name);
        for name in daemons.chain(["groundplan"]) {
            let (from, to) = (client.with_file_name(name), bin.join(name));
            if fs::hard_link(&from, &to).is_err() {
                fs::copy(&from, &to).unwrap();
            }
        }
        for path in end_to_end::files_in(&bin).into_iter().chain([bin]) {
            let others_too = fs::metadata(&path).unwrap().permissions().mode() | 0o055;
            fs::set_permissions(&path, Permissions::from_mode(others_too)).unwrap();
        }
    }

    fn up(mut self) -> Self {
        let log = File::create(self.log_path()).unwrap();
        self.up = Some(self.command(SERVICE, &["up"]).stderr(log).spawn().unwrap());
        let begun = Instant::now();
        while !self.run(SERVICE, &["status"]).status.success() {
            assert!(begun.elapsed() < DEADLINE, "{}", self.log());
            std::thread::sleep(Duration::from_millis(200));
        }
        self
    }

    fn root(&self) -> PathBuf {
        self.memory.path().join("bus")
    }

    fn log_path(&self) -> PathBuf {
        self.home.path().join("up.log")
    }

    fn log(&self) -> String {
        fs::read_to_string(self.log_path()).unwrap()
    }

    /// A command of the client by a user.
    fn command(&self, user: User, arguments: &[&str]) -> Command {
        let mut command = Command::new("setpriv");
        let User(uid, groups) = user;
        command.args([format!("--reuid={uid}"), format!("--regid={uid}")]);
        match groups {
            [] => command.arg("--clear-groups"),
            groups => {
                let groups: Vec<String> = groups.iter().map(u32::to_string).collect();
                command.arg(format!("--groups={}", groups.join(",")))
            }
        };
        command.arg(self.home.path().join("bin/groundplan")).args(arguments);
        command.arg("--config").arg(self.home.path().join("site.toml"));
        command.current_dir("/").stdin(Stdio::null());
        command
    }

    fn run(&self, user: User, arguments: &[&str]) -> Output {
        self.command(user, arguments).output().unwrap()
    }

    /// Standard output of a command that succeeds.
    fn text(&self, user: User, arguments: &[&str]) -> String {
        let output = self.run(user, arguments);
        let words = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{arguments:?} of {}: {words}\n{}", user.0, self.log());
        String::from_utf8(output.stdout).unwrap()
    }

    /// Words of a command that fails.
    fn refusal(&self, user: User, arguments: &[&str]) -> String {
        let output = self.run(user, arguments);
        assert_eq!(output.status.code(), Some(1), "{arguments:?} of {}", user.0);
        String::from_utf8(output.stderr).unwrap()
    }

    /// Owner and mode of everything that the bus has in memory.
    fn owners(&self) -> BTreeMap<PathBuf, (u32, u32)> {
        let mut todo = vec![self.root()];
        let segments = end_to_end::files_in(Path::new("/dev/shm"));
        todo.extend(segments.into_iter().filter(|path| path.to_string_lossy().contains(&format!("/{}", self.prefix))));
        let mut found = BTreeMap::new();
        while let Some(path) = todo.pop() {
            // What goes at this moment is nobody's.
            let Ok(metadata) = fs::symlink_metadata(&path) else { continue };
            if metadata.is_dir() {
                todo.extend(end_to_end::files_in(&path));
            }
            found.insert(path, (metadata.uid(), metadata.mode() & 0o7777));
        }
        found
    }

    fn assert_only_the_service_has_files(&self) {
        let owners = self.owners();
        let segments = owners.keys().filter(|path| path.to_string_lossy().contains(&self.prefix)).count();
        assert!(segments > 50, "the bus is looked at: {segments} segments");
        for (path, (uid, mode)) in owners {
            assert_eq!(uid, SERVICE.0, "{}", path.display());
            let is_segment = path.parent() == Some(Path::new("/dev/shm"));
            assert!(!is_segment || mode & 0o077 == 0, "{} has mode {mode:o}", path.display());
        }
        assert_eq!(fs::metadata(self.root()).unwrap().mode() & 0o777, 0o700);
        let lock = self.memory.path().join("relay/relay.lock");
        assert_eq!(fs::metadata(lock).unwrap().mode() & 0o777, 0o600, "who may open it may lock it");
    }
}

impl Drop for Site {
    fn drop(&mut self) {
        if let Some(mut up) = self.up.take() {
            let _ = Command::new("kill").arg(up.id().to_string()).status();
            let _ = up.wait();
        }
        for path in end_to_end::files_in(Path::new("/dev/shm")) {
            if path.to_string_lossy().contains(&format!("/{}", self.prefix)) {
                let _ = fs::remove_file(path);
            }
        }
    }
}

/// A site; `None`, and a loud word, for a user who cannot be others.
fn site() -> Option<Site> {
    if rustix::process::getuid().is_root() && Command::new("setpriv").arg("--version").output().is_ok() {
        return Some(Site::start());
    }
    end_to_end::announce("SKIPPED: only root with setpriv can test several users");
    None
}

#[test]
fn each_user_does_what_a_group_allows_and_leaves_no_file() {
    let Some(site) = site() else { return };
    site.assert_only_the_service_has_files();
    // Members of the view group look.
    assert!(site.text(VIEWER, &["status"]).contains("storeys at 2024-03-01"));
    assert!(site.text(VIEWER, &["topic", "list"]).contains("grid/00"));
    let out = site.home.path().join("out-of-the-viewer");
    fs::create_dir(&out).unwrap();
    chown(&out, Some(VIEWER.0), Some(VIEWER.0)).unwrap();
    let maps = out.join("maps");
    site.text(VIEWER, &["export", maps.to_str().unwrap()]);
    let manifest = fs::metadata(maps.join("manifest.json")).unwrap();
    assert_eq!(manifest.uid(), VIEWER.0);
    let lines = site.text(VIEWER, &["monitor", "--json", "--for", "2"]);
    let shown: Value = serde_json::from_str(lines.lines().last().unwrap()).unwrap();
    assert!(shown["storeys"].as_array().is_some_and(|storeys| !storeys.is_empty()), "{shown}");
    for command in [&["date", "--next"][..], &["load"]] {
        let words = site.refusal(VIEWER, command);
        assert!(words.contains(&format!("group {CONTROL}")) && words.contains("uid 12001"), "{words}");
    }
    // Members of the control group command, and the log knows who it was.
    let date = site.text(OPERATOR, &["date", "--next"]);
    assert!(site.text(VIEWER, &["topic", "echo", "schedule-state", "--json"]).contains(date.trim()));
    let log = site.log();
    let line = log.lines().find(|line| line.contains("next_change")).unwrap_or_else(|| panic!("{log}"));
    assert!(line.contains("12003") && line.contains("schedule-eval"), "{line}");
    let history = site.text(VIEWER, &["log", "--json"]);
    assert!(history.contains("\"uid\":12003") && history.contains("plan time"), "{history}");
    assert!(site.text(VIEWER, &["metrics"]).contains("groundplan_up{daemon=\"rasterize\"} 1"));
    assert!(site.text(VIEWER, &["doctor"]).contains("it serves this user"));
    // Nobody else does anything.
    for command in [&["status"][..], &["date", "--next"], &["topic", "list"], &["log"], &["metrics"]] {
        let words = site.refusal(STRANGER, command);
        assert!(words.contains("none of the groups") && words.contains("13001"), "{words}");
    }
    // Root does everything, and leaves nothing behind.
    site.text(ROOT, &["status"]);
    site.text(ROOT, &["topic", "echo", "grids"]);
    assert_ne!(site.text(ROOT, &["date", "--next"]), date);
    assert!(site.refusal(ROOT, &["keeper"]).contains("uid 12001"));
    site.assert_only_the_service_has_files();
}

#[test]
fn a_relay_that_is_killed_is_started_again_and_a_monitor_goes_on() {
    let Some(site) = site() else { return };
    let mut monitor = site.command(VIEWER, &["monitor", "--json"]).stdout(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(monitor.stdout.take().unwrap()).lines();
    let mut wait_for_line = |what: &str, wanted: &dyn Fn(&Value) -> bool| {
        let begun = Instant::now();
        loop {
            let line = lines.next().unwrap_or_else(|| panic!("the monitor ended")).unwrap();
            let shown: Value = serde_json::from_str(&line).unwrap();
            if wanted(&shown) {
                return;
            }
            assert!(begun.elapsed() < DEADLINE, "{what}: {line}");
        }
    };
    let has_maps = |shown: &Value| {
        shown["bus_generation"].is_u64() && shown["storeys"].as_array().is_some_and(|storeys| !storeys.is_empty())
    };
    wait_for_line("maps", &has_maps);
    let relays = || site.log().lines().filter(|line| line.contains("serves other users")).count();
    let before = relays();
    let log = site.log();
    let started = log.lines().rfind(|line| line.contains("started") && line.contains("relay")).unwrap();
    let pid = started.rsplit('=').next().unwrap().trim();
    assert!(pid.parse::<u32>().is_ok_and(|pid| pid > 1), "{started}");
    assert!(Command::new("kill").args(["-9", pid]).status().unwrap().success());
    wait_for_line("the loss", &|shown| shown["bus_generation"].is_null());
    wait_for_line("maps again", &has_maps);
    assert!(before < relays());
    site.text(VIEWER, &["status"]);
    monitor.kill().unwrap();
    monitor.wait().unwrap();
}
