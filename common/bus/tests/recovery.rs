//! Recovery after killed or hung processes and after full memory. Each test has its own domain and re-executes this binary as the
//! process that it kills.

#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

mod common;

use bus::{Bus, CommandError, Daemon, Domain, DomainError, Keeper, PortError, PublishError, Wake, topics};
use common::{Attended, DEADLINE, Fixture, eventually, origin, publish, sample_of, schedule_state, until};
use std::io::{BufRead, BufReader, Write};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

/// Samples of the killed processes have this many bytes and more.
const LARGE: usize = 1 << 20;

/// A process that plays a role in a domain; killed when dropped.
struct Actor {
    child: Child,
    lines: std::io::Lines<BufReader<std::process::ChildStdout>>,
}

impl Actor {
    /// Starts the process without waiting for it.
    fn begin(fixture: &Fixture, role: &str) -> Self {
        let mut child = Command::new(std::env::current_exe().unwrap())
            .args(["--exact", "a_process_that_plays_a_role", "--nocapture"])
            .env("BUS_TEST_ROLE", format!("{role}|{}|{}", fixture.prefix(), fixture.root().display()))
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let lines = BufReader::new(child.stdout.take().unwrap()).lines();
        Self { child, lines }
    }

    fn start(fixture: &Fixture, role: &str) -> Self {
        let mut actor = Self::begin(fixture, role);
        actor.says("ready");
        actor
    }

    fn says(&mut self, word: &str) {
        let said = self.lines.by_ref().map(|l| l.unwrap()).find(|l| l.ends_with(word));
        assert!(said.is_some(), "the process ended before it said `{word}`");
    }

    fn signal(&self, signal: &str) {
        let done = Command::new("kill").args([signal, &self.child.id().to_string()]).status().unwrap();
        assert!(done.success());
    }

    fn kill(mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }
}

impl Drop for Actor {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Prints why a test did not run; the test harness does not capture it.
fn skipped(why: &str) {
    std::io::stderr().write_all(format!("\n** SKIPPED: {why}\n").as_bytes()).unwrap();
}

fn say(word: &str) {
    // A line of its own, after output of the test runner.
    #[expect(clippy::print_stdout, reason = "the test that started this process reads it")]
    {
        println!("\n{word}");
    }
}

/// Not a test by itself: the processes of the other tests.
#[test]
fn a_process_that_plays_a_role() {
    let Ok(cast) = std::env::var("BUS_TEST_ROLE") else { return };
    let [role, prefix, root] = cast.split('|').collect::<Vec<_>>().try_into().unwrap();
    let domain = Domain::shared(prefix, root).unwrap();
    match role {
        "keeper" => {
            let keeper = Keeper::start(&domain).unwrap();
            say("ready");
            loop {
                keeper.tick().unwrap();
                std::thread::sleep(Duration::from_millis(20));
            }
        }
        "publisher" | "dies in a loan" => {
            let producer = Attended::join(&domain, Daemon::ScheduleEval);
            let publisher = producer.bus.publisher(topics::ScheduleState, LARGE).unwrap();
            publish(&publisher, 1, LARGE);
            let mut loan = (role != "publisher").then(|| publisher.loan(2 * LARGE).unwrap());
            if let Some(loan) = &mut loan {
                loan.bytes_mut()[..LARGE].fill(0xee);
            }
            say("ready");
            park();
        }
        "subscriber" => {
            let (bus, mut waiter) = Bus::join(&domain, Daemon::Robot).unwrap();
            let subscriber = bus.subscriber(topics::ScheduleState).unwrap();
            let _held = until(&mut waiter, "a sample", || subscriber.take().unwrap());
            say("ready");
            park();
        }
        "server" => {
            let (bus, mut waiter) = Bus::join(&domain, Daemon::IfcIngest).unwrap();
            let server = bus.command_server().unwrap();
            say("ready");
            let _command = until(&mut waiter, "a command", || server.take().unwrap());
            say("taken");
            park();
        }
        "full memory" => full_memory(&domain),
        role => panic!("no such role: {role}"),
    }
}

fn park() -> ! {
    loop {
        std::thread::park();
    }
}

#[test]
fn a_killed_publisher_is_replaced_and_its_sample_stays() {
    let fixture = Fixture::shared();
    let keeper = Keeper::start(&fixture.domain).unwrap();
    let (bus, mut waiter) = Bus::join(&fixture.domain, Daemon::Rasterize).unwrap();
    let subscriber = bus.subscriber(topics::ScheduleState).unwrap();
    let actor = Actor::start(&fixture, "publisher");
    let held = sample_of(&mut waiter, &subscriber, 1);
    actor.kill();
    eventually("the keeper to clean up", || (keeper.tick().unwrap() > 0).then_some(()));
    assert!(held.bytes() == schedule_state(LARGE).bytes());
    let next = Attended::join(&fixture.domain, Daemon::ScheduleEval);
    let publisher = next.bus.publisher(topics::ScheduleState, LARGE).unwrap();
    publish(&publisher, 2, LARGE + 1);
    let newer = sample_of(&mut waiter, &subscriber, 2);
    assert!(newer.bytes() == schedule_state(LARGE + 1).bytes() && held.bytes() == schedule_state(LARGE).bytes());
}

#[test]
fn a_successor_needs_no_keeper_to_clean_up() {
    let fixture = Fixture::shared();
    let _keeper = Keeper::start(&fixture.domain).unwrap();
    for _ in 0..3 {
        Actor::start(&fixture, "publisher").kill();
    }
    let next = Attended::join(&fixture.domain, Daemon::ScheduleEval);
    let _publisher = next.bus.publisher(topics::ScheduleState, LARGE).unwrap();
}

#[test]
fn what_a_killed_publisher_had_half_written_is_never_seen() {
    let fixture = Fixture::shared();
    let keeper = Keeper::start(&fixture.domain).unwrap();
    let (bus, mut waiter) = Bus::join(&fixture.domain, Daemon::Rasterize).unwrap();
    let subscriber = bus.subscriber(topics::ScheduleState).unwrap();
    let actor = Actor::start(&fixture, "dies in a loan");
    let late = bus.subscriber(topics::ScheduleState).unwrap();
    let held = sample_of(&mut waiter, &subscriber, 1);
    sample_of(&mut waiter, &late, 1);
    actor.kill();
    eventually("the keeper to clean up", || (keeper.tick().unwrap() > 0).then_some(()));
    assert!(subscriber.take().unwrap().is_none() && late.take().unwrap().is_none());
    assert!(held.bytes() == schedule_state(LARGE).bytes());
    let next = Attended::join(&fixture.domain, Daemon::ScheduleEval);
    let publisher = next.bus.publisher(topics::ScheduleState, 64).unwrap();
    publish(&publisher, 2, 10);
    sample_of(&mut waiter, &subscriber, 2);
}

#[test]
fn a_subscriber_that_hangs_or_dies_does_not_stop_the_publisher() {
    let fixture = Fixture::shared();
    let keeper = Keeper::start(&fixture.domain).unwrap();
    let producer = Attended::join(&fixture.domain, Daemon::ScheduleEval);
    let publisher = producer.bus.publisher(topics::ScheduleState, 4096).unwrap();
    publish(&publisher, 1, 1000);
    let actor = Actor::start(&fixture, "subscriber");
    actor.signal("-STOP");
    let (bus, mut waiter) = Bus::join(&fixture.domain, Daemon::Rasterize).unwrap();
    let subscriber = bus.subscriber(topics::ScheduleState).unwrap();
    for epoch in 2..=3000 {
        publish(&publisher, epoch, 1000);
    }
    sample_of(&mut waiter, &subscriber, 3000);
    actor.kill();
    eventually("the keeper to clean up", || (keeper.tick().unwrap() > 0).then_some(()));
    publish(&publisher, 3001, 1000);
    sample_of(&mut waiter, &subscriber, 3001);
}

#[test]
fn a_command_to_a_daemon_that_is_killed_is_lost() {
    let fixture = Fixture::shared();
    let keeper = Keeper::start(&fixture.domain).unwrap();
    let mut actor = Actor::start(&fixture, "server");
    let (bus, _waiter) = Bus::join(&fixture.domain, Daemon::Groundplan).unwrap();
    let client = bus.command_client(Daemon::IfcIngest).unwrap();
    let open = client.send(b"load").unwrap();
    actor.says("taken");
    assert!(open.take().unwrap().is_none());
    actor.kill();
    let lost = eventually("the loss", || {
        keeper.tick().unwrap();
        open.take().err()
    });
    assert!(matches!(lost, CommandError::Lost { daemon: Daemon::IfcIngest }), "{lost:?}");
    assert!(matches!(client.send(b"load").map(|_| ()), Err(CommandError::NotServed { .. })));
}

#[test]
fn a_keeper_that_is_killed_is_replaced_under_the_participants() {
    let fixture = Fixture::shared();
    let keeper = Actor::start(&fixture, "keeper");
    let producer = Attended::join(&fixture.domain, Daemon::ScheduleEval);
    let publisher = producer.bus.publisher(topics::ScheduleState, 4096).unwrap();
    publish(&publisher, 1, 1000);
    keeper.kill();
    publish(&publisher, 2, 1000);
    let keeper = Keeper::start(&fixture.domain).unwrap();
    assert_eq!(keeper.generation(), producer.bus.generation());
    let (bus, mut waiter) = Bus::join(&fixture.domain, Daemon::Rasterize).unwrap();
    sample_of(&mut waiter, &bus.subscriber(topics::ScheduleState).unwrap(), 2);
}

/// What a kill in the middle of a creation leaves: files that keep the mode by which others see that they are not finished.
fn leave_half_created(fixture: &Fixture, generation: u64, suffix: &str, mode: u32) {
    use std::os::unix::fs::PermissionsExt;
    let mut folders = vec![fixture.root().join(generation.to_string())];
    let mut n_files = 0;
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap().map(|e| e.unwrap()) {
            let path = entry.path();
            if entry.file_type().unwrap().is_dir() {
                folders.push(path);
            } else if path.to_string_lossy().ends_with(suffix) {
                std::fs::set_permissions(&path, std::fs::Permissions::from_mode(mode)).unwrap();
                n_files += 1;
            }
        }
    }
    for segment in fixture.segments().into_iter().filter(|s| s.to_string_lossy().ends_with(suffix)) {
        std::fs::set_permissions(&segment, std::fs::Permissions::from_mode(mode)).unwrap();
        n_files += 1;
    }
    assert!(n_files > 0, "there are files `*{suffix}`");
}

fn a_stuck_generation_is_left_behind(suffix: &str, mode: u32) {
    let fixture = Fixture::shared();
    let keeper = Actor::start(&fixture, "keeper");
    let (old, mut waiter) = Bus::join(&fixture.domain, Daemon::ScheduleEval).unwrap();
    let publisher = old.publisher(topics::ScheduleState, 4096).unwrap();
    publish(&publisher, 1, 1000);
    keeper.kill();
    leave_half_created(&fixture, old.generation(), suffix, mode);
    let keeper = Keeper::start(&fixture.domain).unwrap();
    assert!(keeper.generation() > old.generation(), "a new generation");
    let wake = eventually("the news", || Some(waiter.wait(DEADLINE).unwrap()).filter(|w: &Wake| w.superseded));
    assert!(!wake.stopped);
    // Everything works in the new one, while the old one is still inhabited.
    let producer = Attended::join(&fixture.domain, Daemon::ScheduleEval);
    assert_eq!(producer.bus.generation(), keeper.generation());
    let again = producer.bus.publisher(topics::ScheduleState, 4096).unwrap();
    publish(&again, 2, 1000);
    let (bus, mut at_consumer) = Bus::join(&fixture.domain, Daemon::Rasterize).unwrap();
    let sample = sample_of(&mut at_consumer, &bus.subscriber(topics::ScheduleState).unwrap(), 2);
    let old_folder = fixture.root().join(old.generation().to_string());
    keeper.tick().unwrap();
    assert!(old_folder.exists());
    drop((old, publisher, waiter));
    keeper.tick().unwrap();
    assert!(!old_folder.exists());
    assert_eq!(sample.bytes(), schedule_state(1000).bytes());
}

#[test]
fn a_service_that_was_never_finished_leads_to_a_new_generation() {
    a_stuck_generation_is_left_behind(".service", 0o600);
}

#[test]
fn a_domain_that_was_never_finished_leads_to_a_new_generation() {
    a_stuck_generation_is_left_behind(".global_mgmt", 0o200);
}

#[test]
fn a_segment_that_never_got_a_size_stops_nobody() {
    let fixture = Fixture::shared();
    let keeper = Actor::start(&fixture, "keeper");
    let inhabitant = Attended::join(&fixture.domain, Daemon::IfcIngest);
    keeper.kill();
    let registries = fixture.segments().into_iter().filter(|s| s.to_string_lossy().ends_with(".dynamic"));
    for segment in registries {
        // A new file: those that are mapped stay as they are.
        std::fs::remove_file(&segment).unwrap();
        std::fs::File::create(&segment).unwrap();
    }
    a_new_keeper_works(&fixture);
    drop(inhabitant);
}

/// Starts a keeper and kills it when the domain's segments have changed this often, or no more.
fn kill_a_keeper_after(fixture: &Fixture, n_changes: usize) {
    let actor = Actor::begin(fixture, "keeper");
    let (mut seen, mut last) = (0, fixture.segments());
    for _ in 0..1000 {
        if seen >= n_changes {
            break;
        }
        let now = fixture.segments();
        seen += usize::from(now != last);
        last = now;
    }
    actor.kill();
}

fn a_new_keeper_works(fixture: &Fixture) {
    let keeper = Keeper::start(&fixture.domain).unwrap();
    let producer = Attended::join(&fixture.domain, Daemon::ScheduleEval);
    assert_eq!(producer.bus.generation(), keeper.generation());
    let publisher = producer.bus.publisher(topics::ScheduleState, 4096).unwrap();
    publish(&publisher, 1, 1000);
    let (bus, mut waiter) = Bus::join(&fixture.domain, Daemon::Rasterize).unwrap();
    sample_of(&mut waiter, &bus.subscriber(topics::ScheduleState).unwrap(), 1);
}

#[test]
fn a_keeper_killed_at_any_point_of_its_start_is_replaced() {
    let fixture = Fixture::shared();
    for round in 0..24 {
        kill_a_keeper_after(&fixture, round * 5);
    }
    a_new_keeper_works(&fixture);
    assert_eq!(fixture.segments(), Vec::<std::path::PathBuf>::new(), "and nothing is left of the killed ones");
}

#[test]
fn a_keeper_killed_at_any_point_of_its_taking_over_is_replaced() {
    let fixture = Fixture::shared();
    let first = Actor::start(&fixture, "keeper");
    let inhabitant = Attended::join(&fixture.domain, Daemon::IfcIngest);
    let publisher = inhabitant.bus.publisher(topics::Site, 4096).unwrap();
    first.kill();
    for round in 0..24 {
        kill_a_keeper_after(&fixture, round * 5);
    }
    a_new_keeper_works(&fixture);
    drop((publisher, inhabitant));
    drop(Keeper::start(&fixture.domain).unwrap());
    assert_eq!(fixture.segments(), Vec::<std::path::PathBuf>::new());
}

#[test]
fn nothing_is_left_when_the_keeper_goes_down() {
    let fixture = Fixture::shared();
    let keeper = Keeper::start(&fixture.domain).unwrap();
    let killed = Actor::start(&fixture, "publisher");
    let producer = Attended::join(&fixture.domain, Daemon::IfcIngest);
    assert!(!fixture.segments().is_empty());
    killed.kill();
    drop((producer, keeper));
    assert_eq!(fixture.segments(), Vec::<std::path::PathBuf>::new());
    let left: Vec<_> = std::fs::read_dir(fixture.root()).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert_eq!(left, ["keeper.lock"]);
}

#[test]
fn what_outlives_the_keeper_is_removed_by_the_next_one() {
    let fixture = Fixture::shared();
    let keeper = Actor::start(&fixture, "keeper");
    let publisher = Actor::start(&fixture, "publisher");
    keeper.kill();
    publisher.kill();
    assert!(!fixture.segments().is_empty());
    let keeper = Keeper::start(&fixture.domain).unwrap();
    let old = format!("{}{}_", fixture.prefix(), keeper.generation() - 1);
    assert!(fixture.segments().iter().all(|s| !s.file_name().unwrap().to_string_lossy().starts_with(&old)));
}

#[test]
fn daemons_of_another_version_are_refused_in_words() {
    let fixture = Fixture::shared();
    let keeper = Keeper::start(&fixture.domain).unwrap();
    let file = fixture.root().join("generation");
    let text = std::fs::read_to_string(&file).unwrap();
    let layout = format!("layout={}", messages::LAYOUT_VERSION);
    std::fs::write(&file, text.replace(&layout, "layout=4711")).unwrap();
    let error = Bus::join(&fixture.domain, Daemon::Robot).map(|_| ()).unwrap_err();
    assert!(matches!(error, DomainError::Version { found: 4711 }));
    let words = error.to_string();
    assert!(words.contains("4711") && words.contains(&messages::LAYOUT_VERSION.to_string()), "{words}");
    drop(keeper);
    // The next keeper makes the domain its own.
    std::fs::write(&file, text.replace(&layout, "layout=4711")).unwrap();
    let _keeper = Keeper::start(&fixture.domain).unwrap();
    Bus::join(&fixture.domain, Daemon::Robot).unwrap();
}

#[test]
fn a_full_memory_is_an_error_and_the_last_sample_stays() {
    // Real shared memory, small and private: in a mount namespace of its own.
    let fixture = Fixture::shared();
    let script = "mount -t tmpfs -o size=64m tmpfs /dev/shm || exit 77; exec \"$0\" \"$@\"";
    let ran = Command::new("unshare")
        .args(["--mount", "--propagation", "private", "sh", "-c", script])
        .arg(std::env::current_exe().unwrap())
        .args(["--exact", "a_process_that_plays_a_role", "--nocapture"])
        .env("BUS_TEST_ROLE", format!("full memory|{}|{}", fixture.prefix(), fixture.root().display()))
        .output();
    let Ok(ran) = ran.inspect_err(|e| skipped(&format!("no `unshare` on this machine: {e}"))) else { return };
    let words = String::from_utf8_lossy(&ran.stderr);
    if ran.status.code() == Some(77) || words.contains("unshare: unshare failed") {
        skipped(&format!("this machine allows no private mount: {words}"));
        return;
    }
    assert!(ran.status.success(), "{:?}\n{}\n{words}", ran.status, String::from_utf8_lossy(&ran.stdout));
}

/// Runs with 64 MiB of shared memory.
fn full_memory(domain: &Domain) {
    let keeper = Keeper::start(domain).unwrap();
    let producer = Attended::join(domain, Daemon::ScheduleEval);
    let publisher = producer.bus.publisher(topics::ScheduleState, 64).unwrap();
    publish(&publisher, 1, 1000);
    for megabytes in [128, 60, 2000, 57] {
        let refused = publisher.loan(megabytes << 20).map(|_| ());
        assert!(matches!(refused, Err(PublishError::NoMemory { .. })), "{megabytes} MB: {refused:?}");
    }
    // What was tried and refused is given back: others can start and get the last sample.
    let (bus, mut waiter) = Bus::join(domain, Daemon::Rasterize).unwrap();
    sample_of(&mut waiter, &bus.subscriber(topics::ScheduleState).unwrap(), 1);
    publish(&publisher, 2, 5 << 20);
    sample_of(&mut waiter, &bus.subscriber(topics::ScheduleState).unwrap(), 2);
    // Others fill it to the last page.
    let filler = "/dev/shm/filler";
    let mut file = std::fs::File::create(filler).unwrap();
    while std::io::Write::write_all(&mut file, &[1; 4096]).is_ok() {}
    drop(file);
    let refused = publisher.loan(100).map(|_| ());
    assert!(matches!(refused, Err(PublishError::NoMemory { .. })), "{refused:?}");
    let refused = Bus::join(domain, Daemon::Robot).map(|_| ());
    assert!(matches!(refused, Err(DomainError::SharedMemoryFull { .. })), "{refused:?}");
    assert!(bus.subscriber(topics::Site).is_err());
    assert!(!bus.status_writer().is_ok_and(|w| w.send(bytemuck::Zeroable::zeroed())));
    keeper.tick().unwrap();
    std::fs::remove_file(filler).unwrap();
    publisher.publish_copy(schedule_state(2000).bytes(), origin(3)).unwrap();
    sample_of(&mut waiter, &bus.subscriber(topics::ScheduleState).unwrap(), 3);
}

#[test]
fn what_goes_with_a_dead_keeper_is_missing_until_its_successor_makes_it() {
    let fixture = Fixture::shared();
    let keeper = Actor::start(&fixture, "keeper");
    let (bus, _waiter) = Bus::join(&fixture.domain, Daemon::Groundplan).unwrap();
    keeper.kill();
    // The next one who joins removes what the dead one alone had.
    let other = Bus::join(&fixture.domain, Daemon::WaypointGen);
    assert!(other.is_err() || other.is_ok_and(|(other, _)| is_missing(&other.command_server())));
    assert!(is_missing(&bus.command_client(Daemon::SlamAlign)));
    assert!(is_missing(&bus.subscriber(topics::Site)));
    let _keeper = Keeper::start(&fixture.domain).unwrap();
    let (bus, _waiter) = Bus::join(&fixture.domain, Daemon::Groundplan).unwrap();
    bus.command_client(Daemon::SlamAlign).unwrap();
    bus.subscriber(topics::Site).unwrap();
}

fn is_missing<T>(opened: &Result<T, PortError>) -> bool {
    matches!(opened, Err(PortError::Missing { .. }))
}

#[test]
fn guests_leave_places_to_daemons_and_commands() {
    let fixture = Fixture::shared();
    let _keeper = Keeper::start(&fixture.domain).unwrap();
    let mut guests = Vec::new();
    let refused = loop {
        let (guest, _waiter) = Bus::join(&fixture.domain, Daemon::Robot).unwrap();
        match guest.subscriber(topics::Grids) {
            Ok(subscriber) => guests.push((subscriber, guest)),
            Err(why) => break why,
        }
        assert!(guests.len() < 100, "there is no end");
    };
    assert!(guests.len() >= 20 && refused.to_string().starts_with("`grids` has "), "{}: {refused}", guests.len());
    let (bus, _waiter) = Bus::join(&fixture.domain, Daemon::Groundplan).unwrap();
    let kept: Vec<_> = (0..12).map(|_| bus.subscriber(topics::Grids).unwrap()).collect();
    assert!(matches!(bus.subscriber(topics::Grids), Err(PortError::Full { .. })), "{} are all", kept.len());
}
