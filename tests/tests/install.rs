//! Installed files and their places; what systemd says of the units.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

mod support;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use support::{announce, client, files_in, root, write_program};

/// Exposure, in tenths, that `systemd-analyze security` may find in a unit: all are on the bus only.
const EXPOSURE_MAX: &str = "15";
/// The same for a unit that takes part in a network.
const NETWORK_EXPOSURE_MAX: &str = "20";

/// Installs the programs of this build below a folder.
fn install(folder: &Path, prefix: &str) {
    let mut script = Command::new(root().join("scripts/install"));
    script.arg("--root").arg(folder).args(["--prefix", prefix, "--built"]).arg(client().parent().unwrap());
    let output = script.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

/// Unit files of all services.
fn services(folder: &Path) -> Vec<PathBuf> {
    files_in(folder).into_iter().filter(|path| path.extension().is_some_and(|e| e == "service")).collect()
}

/// Runs `systemd-analyze` in a folder of units; `None`, and a loud word, where there is none.
fn systemd_analyze(folder: &Path, arguments: &[&str], units: &[PathBuf]) -> Option<Output> {
    let mut command = Command::new("systemd-analyze");
    match command.args(arguments).args(units).current_dir(folder).output() {
        Ok(output) => Some(output),
        Err(_) => {
            announce(&format!("SKIPPED: systemd-analyze {} of the units: it is not installed", arguments[0]));
            None
        }
    }
}

#[test]
fn everything_is_put_in_place_and_a_changed_configuration_stays() {
    let home = tempfile::tempdir().unwrap();
    let folder = home.path();
    install(folder, "/usr/local");
    for file in [
        "usr/local/bin/rasterize",
        "usr/local/share/man/man1/groundplan-monitor.1",
        "usr/local/share/bash-completion/completions/groundplan",
        "usr/local/share/groundplan/schemas/site.schema.json",
        "usr/local/share/groundplan/nav2/on-stale",
        "etc/groundplan/demo/demo.ifc",
        "etc/sysusers.d/groundplan.conf",
        "etc/tmpfiles.d/groundplan.conf",
        "etc/systemd/system/groundplan-.service.d/10-common.conf",
    ] {
        assert!(folder.join(file).is_file(), "{file}");
    }
    let unit = std::fs::read_to_string(folder.join("etc/systemd/system/groundplan-rasterize.service")).unwrap();
    assert!(unit.contains("ExecStart=/usr/local/bin/rasterize --config /etc/groundplan/site.toml"), "{unit}");
    let notices = std::fs::read_to_string(folder.join("usr/local/share/doc/groundplan/NOTICES")).unwrap();
    for part in [
        "ifc-lite-core 28",
        "its source is https://crates.io/crates/ifc-lite-core/",
        "Mozilla Public License",
        "leaflet 1.9.4",
        "three.js",
    ] {
        assert!(notices.contains(part), "{part}");
    }

    let config = folder.join("etc/groundplan/site.toml");
    let site: toml::Table = std::fs::read_to_string(&config).unwrap().parse().unwrap();
    let named = [("schedule", "rules"), ("robot", "profile"), ("waypoints", "options"), ("world", "options")];
    for (table, key) in named {
        let file = folder.join("etc/groundplan").join(site[table][key].as_str().unwrap());
        assert!(file.is_file(), "{} is named by site.toml", file.display());
    }
    std::fs::write(&config, "state = \"elsewhere\"\n").unwrap();
    install(folder, "/usr/local");
    assert_eq!(std::fs::read_to_string(&config).unwrap(), "state = \"elsewhere\"\n");
    assert!(folder.join("etc/groundplan/site.toml.new").is_file());
}

#[test]
fn units_start_what_is_installed_share_memory_and_one_user() {
    let folder = root().join("config/systemd");
    let target = std::fs::read_to_string(folder.join("groundplan.target")).unwrap();
    for daemon in ["keeper", "ifc-ingest", "schedule-eval", "rasterize", "waypoint-gen", "slam-align", "relay"] {
        let name = format!("groundplan-{daemon}.service");
        assert!(target.contains(&name));
        assert!(services(&folder).contains(&folder.join(&name)), "{name}");
    }
    let common = std::fs::read_to_string(folder.join("groundplan-.service.d/10-common.conf")).unwrap();
    for line in [
        "Type=notify",
        "User=groundplan",
        "RuntimeDirectoryPreserve=yes",
        "Restart=on-failure",
        "RestartPreventExitStatus=2",
        "StartLimitIntervalSec=0",
        "WatchdogSec=10s",
    ] {
        assert!(common.lines().any(|l| l == line), "{line}");
    }
    for path in services(&folder) {
        let unit = std::fs::read_to_string(&path).unwrap() + &common;
        for harm in ["PrivateTmp=", "DynamicUser=", "PrivateIPC="] {
            assert!(!unit.lines().any(|l| l.starts_with(harm)), "{}: {harm}", path.display());
        }
    }
}

#[test]
fn systemd_finds_no_fault_in_the_units_and_little_exposure() {
    let home = tempfile::tempdir().unwrap();
    install(home.path(), "/usr");
    let folder = home.path().join("usr/lib/systemd/system");
    let units = services(&folder);
    for unit in &units {
        // The programs lie below the folder.
        let text = std::fs::read_to_string(unit).unwrap();
        let bin = format!("={}/usr/bin/", home.path().display());
        std::fs::write(unit, text.replace("=/usr/bin/", &bin)).unwrap();
    }
    let Some(verified) = systemd_analyze(&folder, &["verify"], &units) else { return };
    let said = String::from_utf8_lossy(&verified.stderr);
    let faults: Vec<&str> = said.lines().filter(|line| line.contains("groundplan")).collect();
    assert!(faults.is_empty(), "{faults:#?}");
    for unit in units {
        let is_on_network = [
            "groundplan-ros-bridge.service",
            "groundplan-ros-bridge@.service",
            "groundplan-site-follow.service",
            "groundplan-site-server.service",
            "groundplan-web.service",
            "groundplan-ask.service",
        ]
        .iter()
        .any(|u| unit.ends_with(u));
        let most = if is_on_network { NETWORK_EXPOSURE_MAX } else { EXPOSURE_MAX };
        let arguments = ["security", "--no-pager", "--offline=yes", "--threshold", most];
        let judged = systemd_analyze(&folder, &arguments, std::slice::from_ref(&unit)).unwrap();
        assert!(judged.status.success(), "{}", String::from_utf8_lossy(&judged.stdout));
    }
}

#[test]
fn with_sudo_the_cargo_of_the_calling_user_builds_as_that_user() {
    let home = tempfile::tempdir().unwrap();
    let (system, log) = (home.path().join("system"), home.path().join("log"));
    let program = |path: &str, text: &str| {
        let path = home.path().join(path);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        write_program(&path, &format!("#!/bin/sh\n{text}\n"));
    };
    program("system/id", "echo 0");
    program("system/getent", &format!("echo \"$2:x:1000:1000::{}:/bin/sh\"", home.path().join("rust").display()));
    program("system/runuser", &format!("echo \"as $2\" >>{}; shift 3; exec \"$@\"", log.display()));
    program("rust/.cargo/bin/cargo", &format!("echo \"cargo $*\" >>{}", log.display()));

    let output = Command::new(root().join("scripts/install"))
        .args(["--root", "unused"])
        .env("SUDO_USER", "builder")
        .env("CARGO_TARGET_DIR", home.path().join("empty"))
        .env("PATH", format!("{}:/usr/bin:/bin", system.display()))
        .output()
        .unwrap();
    assert!(String::from_utf8_lossy(&output.stderr).contains("is not built"), "nothing was built: {output:?}");
    let lines = std::fs::read_to_string(&log).unwrap();
    assert!(lines.contains("as builder\ncargo build --release --locked -p groundplan"), "{lines}");
}
