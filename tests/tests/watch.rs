//! `export --watch` and the Nav2 hook script.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

mod support;

use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Instant;
use support::live::{DEADLINE, Live};
use support::{client, contents, root};

fn program(path: &Path, text: &str) {
    std::fs::write(path, text).unwrap();
    std::fs::set_permissions(path, std::fs::Permissions::from_mode(0o755)).unwrap();
}

/// A watch; stopped when dropped.
struct Watch(Child);

impl Watch {
    fn start(live: &Live, out: &Path, on_change: &Path) -> Self {
        let mut command = Command::new(client());
        command.arg("export").arg(out).args(["--watch", "--keep", "2", "--on-change"]).arg(on_change);
        Self(command.arg("--config").arg(live.config()).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap())
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

#[test]
fn the_link_follows_the_maps_and_a_program_runs_for_each() {
    let mut live = Live::start();
    let out = live.home.path().join("maps");
    let (program_path, log) = (live.home.path().join("on-change"), live.home.path().join("changes.log"));
    // It fails, and that stops nothing.
    program(&program_path, &format!("#!/bin/sh\necho \"$1\" >> {}\nexit 3\n", log.display()));
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
    assert_eq!(std::fs::read_dir(out.join("epochs")).unwrap().count(), 2, "older ones are removed");
    watch.stop();

    // A later watch goes on where this one ended.
    let message = std::fs::read_to_string(&log).unwrap();
    let watch = Watch::start(&live, &out, &program_path);
    live.text(&[&"date", &"2024-04-27T12:00:00"]);
    wait_for(&out, "2024-04-27T12:00:00");
    watch.stop();
    let now = std::fs::read_to_string(&log).unwrap();
    assert!(now.lines().count() <= message.lines().count() + 1, "what is there already is not reported again: {now}");
    live.down();
}

#[test]
fn a_watch_deletes_and_replaces_nothing_that_it_did_not_write() {
    let mut live = Live::start();
    let out = live.home.path().join("maps");
    let program_path = live.home.path().join("on-change");
    program(&program_path, "#!/bin/sh\n");
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
    watch.stop();
    assert_eq!(std::fs::read_to_string(first.join("slam.pgm")).unwrap(), "a day of mapping");
    assert_eq!(std::fs::read_to_string(out.join("epochs/0/notes.txt")).unwrap(), "precious");
    assert_eq!(std::fs::read_dir(out.join("epochs")).unwrap().count(), 4, "two that are kept, and two of others");
    live.down();
}

#[test]
fn nav2_is_stopped_before_it_gets_new_maps_and_a_refusal_is_a_failure() {
    let home = tempfile::tempdir().unwrap();
    let storey = home.path().join("out/storeys/01-upper-floor");
    std::fs::create_dir_all(&storey).unwrap();
    let (bin, log) = (home.path().join("bin"), home.path().join("ros2.log"));
    std::fs::create_dir(&bin).unwrap();
    let run = |answer: &str, arguments: &[&str]| {
        let ros2 = format!(
            "#!/bin/sh\necho \"$*\" >> {}\ncase \"$1 $2\" in 'action list') echo /navigate_to_pose;; *) echo '{answer}';; esac\n",
            log.display()
        );
        program(&bin.join("ros2"), &ros2);
        let _ = std::fs::remove_file(&log);
        let path = format!("{}:{}", bin.display(), std::env::var("PATH").unwrap());
        let script = root().join("config/nav2/on-change");
        let output = Command::new(script).args(arguments).env("PATH", path).output().unwrap();
        (output, std::fs::read_to_string(&log).unwrap_or_default())
    };
    let out = home.path().join("out");
    let out = out.to_str().unwrap();
    let (output, log) = run("response: LoadMap_Response(result=0)", &[out, "1"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let place = |what: &str| log.find(what).unwrap_or_else(|| panic!("{what} is missing in {log}"));
    assert!(place("cancel_goal") < place("planning.yaml") && place("planning.yaml") < place("keepout.yaml"));
    assert!(place("keepout.yaml") < place("clear_entirely_global_costmap"));
    assert!(place("clear_entirely_local_costmap") < place("maps_changed"));
    assert!(!log.contains("set_route_graph"), "there is no graph");

    let (output, log) = run("response: LoadMap_Response(result=1)", &[out, "1"]);
    assert!(!output.status.success() && String::from_utf8_lossy(&output.stderr).contains("the robot stands"));
    assert!(!log.contains("maps_changed"), "{log}");
    assert_eq!(run("", &[out, "7"]).0.status.code(), Some(1), "there is no such storey");
    assert_eq!(run("", &[]).0.status.code(), Some(2));
}
