//! Installed files and their places; what systemd says of the units.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use end_to_end::{announce, client, contents, files_in, root, write_program};
use std::io::{BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};

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
        "usr/local/share/groundplan/demo/robot-map.yaml",
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

/// The installed client, where there is no clone and nothing else is found.
fn installed(folder: &Path, home: &Path) -> Command {
    let mut command = Command::new(folder.join("usr/local/bin/groundplan"));
    command.current_dir(home).env_clear().env("PATH", "/usr/bin:/bin").stdin(Stdio::null());
    command
}

#[test]
fn the_demo_needs_nothing_but_what_is_installed_and_its_maps_are_those_of_a_conversion() {
    let (system, home) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    install(system.path(), "/usr/local");
    let run = |arguments: &[&str]| {
        let output = installed(system.path(), home.path()).args(arguments).output().unwrap();
        assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    let said = run(&["demo", "--out", "maps"]);
    let lines: Vec<&str> = said.lines().collect();
    assert!(lines.len() <= 30, "{said}");
    assert_eq!(lines.iter().filter(|line| line.contains(" ms from the command to the new maps")).count(), 4, "{said}");
    for word in [
        "; closed: U.04",
        "; no longer closed: U.04",
        "180 of 180 elements stand",
        "Upper floor: x 8.",
        "nothing of them is left",
    ] {
        assert!(said.contains(word), "{word}: {said}");
    }
    let demo = system.path().join("usr/local/share/groundplan/demo");
    let file = |name: &str| demo.join(name).display().to_string();
    let (model, plan, progress) = (file("demo.ifc"), file("demo-schedule.xer"), file("progress.csv"));
    let date = "2024-06-20T00:00:00";
    let schedule = ["--date", date, "--schedule-file", &plan, "--actuals", &progress];
    run(&[&["convert", &model, "-o", "converted"], &schedule[..]].concat());
    let (shown, converted) = (contents(&home.path().join("maps")), contents(&home.path().join("converted")));
    assert!(shown.len() > 20 && shown.len() == converted.len());
    for (one, other) in shown.iter().zip(&converted) {
        assert!(one == other, "{} differs", one.0.display());
    }
    std::fs::write(home.path().join("maps/notes.txt"), "mine").unwrap();
    let refused = installed(system.path(), home.path()).args(["demo", "--out", "maps"]).output().unwrap();
    assert_eq!((refused.status.code(), refused.stdout.len()), (Some(2), 0), "before anything is started");
    assert!(String::from_utf8_lossy(&refused.stderr).contains("notes.txt"), "{refused:?}");
}

/// A demo that stays; killed if a test fails before it has ended it.
struct Staying(Child);

impl Staying {
    fn start() -> (Self, impl Iterator<Item = String>) {
        let mut demo = Command::new(client());
        let mut demo = demo.args(["demo", "--stay"]).stdin(Stdio::null()).stdout(Stdio::piped()).spawn().unwrap();
        let lines = BufReader::new(demo.stdout.take().unwrap()).lines().map(Result::unwrap);
        (Self(demo), lines)
    }
}

impl Drop for Staying {
    fn drop(&mut self) {
        // It has ended already where all went well.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[test]
fn a_demo_that_stays_serves_its_page_and_leaves_with_what_it_started() {
    let (mut demo, mut lines) = Staying::start();
    let page = lines.find_map(|line| line.split_once("the page: ").map(|(_, url)| url.to_owned())).unwrap();
    let config = lines.find_map(|line| line.split_once("--config ").map(|(_, file)| file.to_owned())).unwrap();
    let address = page.strip_prefix("http://").and_then(|rest| rest.strip_suffix('/')).unwrap();
    let mut browser = std::net::TcpStream::connect(address).unwrap();
    write!(browser, "GET / HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n\r\n").unwrap();
    let mut response = String::new();
    browser.read_to_string(&mut response).unwrap();
    assert!(response.starts_with("HTTP/1.1 200"), "{response}");
    let status = Command::new(client()).args(["status", "--config", &config]).output().unwrap();
    let status = String::from_utf8_lossy(&status.stdout);
    assert!(status.contains("4 storeys at 2024-06-20T00:00:00"), "{status}");
    let own = rustix::process::Pid::from_child(&demo.0);
    rustix::process::kill_process(own, rustix::process::Signal::TERM).unwrap();
    assert!(lines.any(|line| line.contains("nothing of them is left")));
    assert!(demo.0.wait().unwrap().success());
    assert!(!Path::new(&config).exists());
}

#[test]
fn daemons_of_a_demo_that_is_killed_leave_too() {
    let (demo, mut lines) = Staying::start();
    let config = lines.find_map(|line| line.split_once("--config ").map(|(_, file)| file.to_owned())).unwrap();
    let text = std::fs::read_to_string(&config).unwrap();
    drop(demo);
    let begun = std::time::Instant::now();
    let is_of_demo = |process: std::fs::DirEntry| {
        let line = std::fs::read(process.path().join("cmdline")).unwrap_or_default();
        String::from_utf8_lossy(&line).contains(&format!("--config\0{config}"))
    };
    while std::fs::read_dir("/proc").unwrap().flatten().any(is_of_demo) {
        assert!(begun.elapsed() < end_to_end::live::DEADLINE, "a daemon is left");
        std::thread::sleep(end_to_end::live::POLL_INTERVAL);
    }
    // What a killed process cannot remove.
    let site: toml::Table = text.parse().unwrap();
    std::fs::remove_dir_all(Path::new(site["bus"]["root"].as_str().unwrap()).parent().unwrap()).unwrap();
    std::fs::remove_dir_all(Path::new(&config).parent().unwrap()).unwrap();
}

/// Packages whose programs are installed.
const PACKAGES: [&str; 11] = [
    "groundplan",
    "ifc-ingest",
    "schedule-eval",
    "rasterize",
    "waypoint-gen",
    "slam-align",
    "ros-bridge",
    "site-server",
    "site-follow",
    "web",
    "ask",
];

#[test]
fn the_bill_of_materials_is_valid_and_names_what_is_linked() {
    let validator = "cyclonedx-python-lib[json-validation]==11.12.0";
    if !Command::new(root().join("scripts/python-env")).arg(validator).output().unwrap().status.success() {
        announce("SKIPPED: the bill of materials: cyclonedx-python-lib could not be installed");
        return;
    }
    let run = |program: &Path, arguments: &[&Path]| {
        let output = Command::new(program).args(arguments).args(PACKAGES).current_dir(root()).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        output.stdout
    };
    let notices = root().join("scripts/notices");
    let bill = run(&notices, &[Path::new("--cyclonedx")]);
    assert!(bill == run(&notices, &[Path::new("--cyclonedx")]), "the same tree gives the same bytes");
    let home = tempfile::tempdir().unwrap();
    let file = home.path().join("groundplan.cdx.json");
    std::fs::write(&file, bill).unwrap();
    let said = run(&root().join("target/venv/bin/python"), &[&root().join("scripts/check_sbom.py"), &file]);
    assert!(String::from_utf8_lossy(&said).contains("valid by CycloneDX 1.6"));
}

/// The tree that is packed, without what git does not know, in another folder.
fn copy_of_tree(folder: &Path) {
    let copy = "git ls-files -z | tar --create --null --files-from - | tar --extract --directory \"$0\"";
    std::fs::create_dir(folder).unwrap();
    let copied = Command::new("sh").args(["-c", copy]).arg(folder).current_dir(root()).status().unwrap();
    assert!(copied.success());
}

#[test]
fn packages_of_the_same_programs_are_the_same_bytes_wherever_and_whenever_they_are_packed() {
    if Command::new("dpkg-deb").arg("--version").output().is_err() {
        announce("SKIPPED: packages: dpkg-deb is not installed (apt-get install dpkg-dev)");
        return;
    }
    let home = tempfile::tempdir().unwrap();
    let built = home.path().join("built");
    std::fs::create_dir(&built).unwrap();
    std::os::unix::fs::symlink(client(), built.join("groundplan")).unwrap();
    // Any programs: what is packed is not run.
    for name in
        PACKAGES.map(|name| if ["web", "ask"].contains(&name) { format!("groundplan-{name}") } else { name.to_owned() })
    {
        if name != "groundplan" {
            std::fs::copy("/bin/true", built.join(name)).unwrap();
        }
    }
    // Neither the rights that new files get nor the language count.
    let packed =
        [("one", "077", "C"), ("another/folder/of/another/depth", "002", "C.UTF-8")].map(|(place, umask, language)| {
            let (tree, out) = (home.path().join(place), home.path().join(place).join("target/package"));
            std::fs::create_dir_all(tree.parent().unwrap()).unwrap();
            copy_of_tree(&tree);
            let mut shell = Command::new("sh");
            shell.args(["-c", &format!("umask {umask}; exec \"$0\" \"$@\"")]).arg(tree.join("scripts/package"));
            shell.arg("--built").arg(&built).args(["--version", "1.2.3"]);
            shell.env("DPKG_DEB_COMPRESSOR_TYPE", "none").env("LANG", language).env_remove("SOURCE_DATE_EPOCH");
            let output = shell.output().unwrap();
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
            contents(&out)
        });
    let names: Vec<String> = packed[0].iter().map(|(path, _)| path.display().to_string()).collect();
    let [tarball, deb] = names.as_slice() else { panic!("{names:?}") };
    assert!(deb.starts_with("groundplan_1.2.3_") && tarball.starts_with("groundplan-1.2.3-linux-"), "{names:?}");
    for (one, other) in packed[0].iter().zip(&packed[1]) {
        assert!(one == other, "{} differs", one.0.display());
    }
    let file = home.path().join("one/target/package").join(tarball);
    let list =
        Command::new("tar").args(["--list", "--verbose", "--numeric-owner", "--file"]).arg(file).output().unwrap();
    let list = String::from_utf8(list.stdout).unwrap();
    let folder = tarball.strip_suffix(".tar.gz").unwrap();
    for file in [
        "bin/groundplan-web",
        "share/groundplan/demo/demo-schedule.xer",
        "share/doc/groundplan/groundplan.cdx.json",
        "config/site.toml",
    ] {
        let line = list.lines().find(|line| line.ends_with(&format!(" {folder}/{file}"))).expect(file);
        assert!(line.contains(" 0/0 ") && (line.starts_with("-rwxr-xr-x") || line.starts_with("-rw-r--r--")), "{line}");
    }
    assert!(!list.contains("systemd"), "{list}");
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
