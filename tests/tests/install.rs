//! Installed files and their places.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

mod support;

use std::path::Path;
use std::process::Command;
use support::{client, root};

/// Installs the programs of this build below a folder.
fn install(folder: &Path, built: &Path) -> std::process::Output {
    let script = root().join("scripts/install");
    Command::new(script).arg("--root").arg(folder).arg("--no-build").env("CARGO_TARGET_DIR", built).output().unwrap()
}

#[test]
fn everything_is_put_in_place_and_a_changed_configuration_stays() {
    let home = tempfile::tempdir().unwrap();
    let built = home.path().join("built");
    std::fs::create_dir(&built).unwrap();
    std::os::unix::fs::symlink(client().parent().unwrap(), built.join("release")).unwrap();
    let folder = home.path().join("root");
    let output = install(&folder, &built);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    for file in
        ["usr/local/bin/rasterize", "usr/local/share/man/man1/groundplan-monitor.1", "etc/groundplan/demo/demo.ifc"]
    {
        assert!(folder.join(file).is_file(), "{file}");
    }
    let unit = std::fs::read_to_string(folder.join("etc/systemd/system/groundplan-rasterize.service")).unwrap();
    assert!(unit.contains("ExecStart=/usr/local/bin/rasterize --config /etc/groundplan/site.toml"), "{unit}");

    let config = folder.join("etc/groundplan/site.toml");
    let site: toml::Table = std::fs::read_to_string(&config).unwrap().parse().unwrap();
    let named = [("schedule", "rules"), ("robot", "profile"), ("waypoints", "options"), ("world", "options")];
    for (table, key) in named {
        let file = folder.join("etc/groundplan").join(site[table][key].as_str().unwrap());
        assert!(file.is_file(), "{} is named by site.toml", file.display());
    }
    std::fs::write(&config, "state = \"elsewhere\"\n").unwrap();
    assert!(install(&folder, &built).status.success());
    assert_eq!(std::fs::read_to_string(&config).unwrap(), "state = \"elsewhere\"\n");
    assert!(folder.join("etc/groundplan/site.toml.new").is_file());
}

#[test]
fn units_start_what_is_installed_share_memory_and_one_user() {
    let target = std::fs::read_to_string(root().join("config/systemd/groundplan.target")).unwrap();
    for daemon in ["keeper", "ifc-ingest", "schedule-eval", "rasterize", "waypoint-gen", "slam-align"] {
        let name = format!("groundplan-{daemon}.service");
        assert!(target.contains(&name));
        let unit = std::fs::read_to_string(root().join("config/systemd").join(&name)).unwrap();
        for line in
            ["Type=notify", "User=groundplan", "RuntimeDirectoryPreserve=yes", "Restart=on-failure", "WatchdogSec=10s"]
        {
            assert!(unit.lines().any(|l| l == line), "{name}: {line}");
        }
        for harm in ["PrivateTmp=", "DynamicUser=", "PrivateIPC="] {
            assert!(!unit.lines().any(|l| l.starts_with(harm)), "{name}: {harm}");
        }
    }
}
