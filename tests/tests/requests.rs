//! Requests to running daemons: progress that reaches the client, and bytes that are no request.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use bus::{Bus, CommandError, Daemon, Domain, OpenCommand, Reply, Waiter};
use daemon::{Answer, Client, ClientError, FileText, IngestRequest, RasterizeRequest, ScheduleRequest};
use end_to_end::live::{DEADLINE, Live};
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

fn join(live: &Live) -> (Bus, Waiter) {
    Bus::join(&Domain::shared(&live.prefix, live.root.path()).unwrap(), Daemon::Groundplan).unwrap()
}

/// Waits until there is one.
fn wait_for<T>(waiter: &mut Waiter, mut look: impl FnMut() -> Option<T>) -> T {
    let begun = Instant::now();
    loop {
        if let Some(found) = look() {
            return found;
        }
        assert!(begun.elapsed() < DEADLINE, "it does not come");
        waiter.wait(Duration::from_millis(100)).unwrap();
    }
}

/// Percent and words of the lines that `load` wrote.
fn lines_of(stderr: &[u8]) -> Vec<(u8, String)> {
    let text = String::from_utf8(stderr.to_vec()).unwrap();
    let line = |line: &str| {
        let (percent, doing) = line.split_once(" %  ").unwrap_or_else(|| panic!("{text}"));
        (percent.trim().parse().unwrap(), doing.to_owned())
    };
    text.lines().map(line).collect()
}

#[test]
fn a_load_reports_progress_that_rises_to_its_end() {
    let mut live = Live::start();
    let output = live.run(&[&"load"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let lines = lines_of(&output.stderr);
    let percents: Vec<u8> = lines.iter().map(|(percent, _)| *percent).collect();
    assert!(percents.is_sorted() && percents.last() == Some(&100), "{lines:?}");
    let between = percents.iter().filter(|percent| (1..100).contains(*percent)).count();
    assert!(between >= 2, "there is something between begin and end: {lines:?}");
    // The newest is printed: which words come through is not certain.
    assert!(lines.iter().any(|(_, doing)| doing.contains(" demo.ifc")), "{lines:?}");
    live.down();
}

#[test]
fn a_load_goes_on_when_its_client_dies() {
    let mut live = Live::start();
    let (bus, mut waiter) = join(&live);
    let sites = bus.subscriber(bus::topics::Site).unwrap();
    let before = wait_for(&mut waiter, || sites.take().unwrap()).header().epoch;
    let mut load = Command::new(end_to_end::client());
    load.args(["load", "--config"]).arg(live.config()).stderr(Stdio::piped());
    let mut load = load.spawn().unwrap();
    let mut line = String::new();
    BufReader::new(load.stderr.take().unwrap()).read_line(&mut line).unwrap();
    assert_eq!(lines_of(line.as_bytes()).len(), 1);
    load.kill().unwrap();
    load.wait().unwrap();
    wait_for(&mut waiter, || sites.take().unwrap().filter(|site| site.header().epoch > before));
    live.wait_until_healthy();
    drop((sites, bus, waiter));
    live.down();
}

#[test]
fn bytes_that_are_no_request_of_a_daemon_get_an_error_with_its_name_and_it_lives() {
    let mut live = Live::start();
    let process = |daemon: &str| live.status().unwrap()["daemons"][daemon]["process_id"].clone();
    let before = Daemon::SUPERVISED.map(|daemon| process(daemon.name()));
    let (bus, mut waiter) = join(&live);
    let profile = FileText { path: "/r.toml".into(), text: "name = \"x\"\n".to_owned() };
    let of_rasterize = serde_json::to_vec(&RasterizeRequest::SetRobot { profile }).unwrap();
    let of_ingest =
        serde_json::to_vec(&IngestRequest::Load { models: vec!["/m.ifc".into()], dry_run: false, force: false })
            .unwrap();
    for daemon in Daemon::SUPERVISED {
        let foreign = if daemon == Daemon::IfcIngest { &of_rasterize } else { &of_ingest };
        let port = bus.command_client(daemon).unwrap();
        for bytes in [foreign.as_slice(), b"\xff\x00\x01", b"", b"{\"load\"", &[b'['; 1 << 20]] {
            let open: OpenCommand = wait_for(&mut waiter, || match port.send(bytes) {
                Ok(open) => Some(open),
                // The daemon has not thrown the last one away yet.
                Err(CommandError::TooMany { .. }) => None,
                Err(why) => panic!("{why}"),
            });
            let reply = wait_for(&mut waiter, || open.take().unwrap());
            let Reply::Failed(text) = reply else { panic!("{daemon} takes {bytes:?}: {reply:?}") };
            let text = String::from_utf8(text).unwrap();
            assert!(text.starts_with(&format!("this is no request of {daemon}: ")), "{text}");
        }
    }
    let client = Client::<ScheduleRequest>::of(&bus).unwrap();
    let open = client.send(&ScheduleRequest::GetPlanTime).unwrap();
    let answer = wait_for(&mut waiter, || open.take().unwrap());
    assert!(matches!(&answer, Answer::Done(answer) if answer.clock == "fixed" && answer.state.epoch > 0), "{answer:?}");
    let open = client.send(&ScheduleRequest::Simulate { rate: -1.0, from_s: None }).unwrap();
    let refused = wait_for(&mut waiter, || open.take().err());
    assert!(matches!(&refused, ClientError::Refused { daemon: Daemon::ScheduleEval, .. }), "{refused}");
    assert_eq!(before, Daemon::SUPERVISED.map(|daemon| process(daemon.name())));
    drop((open, client, bus, waiter));
    live.down();
}

#[test]
fn pipes_devices_and_folders_are_refused_and_no_daemon_waits_for_them() {
    let mut live = Live::start();
    let pipe = live.home.path().join("pipe");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let (zero, folder) = (Path::new("/dev/zero"), live.home.path().to_owned());
    for command in ["robot", "actuals", "waypoints", "slam-map", "load"] {
        for (path, what) in [(pipe.as_path(), "a pipe"), (zero, "a device"), (&folder, "a folder")] {
            let output = live.run(&[&command, &path]);
            let said = String::from_utf8_lossy(&output.stderr).into_owned();
            assert!(!output.status.success() && said.contains(what), "{command} {}: {said}", path.display());
        }
    }
    live.wait_until_healthy();
    live.down();
}
