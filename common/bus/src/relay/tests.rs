//! A relay and its clients in one process, by the same user.

mod hostile_clients;

use super::*;
use crate::bus::Bus;
use crate::command::Reply;
use crate::error::{CommandError, PortError};
use crate::keeper::Keeper;
use crate::latched::Origin;
use crate::limits::MAX_CLIENTS;
use crate::names::{Daemon, TopicName};
use crate::relay_protocol::{CONTROL_SOCKET, VIEW_SOCKET};
use crate::robot_name::RobotName;
use crate::topics;
use crate::waiter::{Waiter, Wake};
use messages::{ContentHash, GridsBuilder, GridsHead, InputHashes, RobotProfile, ScheduleStateBuilder};
use std::io::{Read, Write};
use std::os::unix::net::UnixStream;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;

/// The one deadline of every wait.
const DEADLINE: Duration = Duration::from_secs(60);

/// A domain with a keeper and a relay that serves in a thread.
pub(super) struct Fixture {
    pub(super) domain: Domain,
    keeper: Option<Keeper>,
    events: Arc<Mutex<Vec<String>>>,
    /// How often the report was made.
    n_reports: Arc<AtomicU32>,
    stop: Option<UnixStream>,
    thread: Option<JoinHandle<()>>,
    prefix: String,
    /// Holds the folders of bus and relay; goes with this value.
    _folder: tempfile::TempDir,
}

fn own() -> u32 {
    rustix::process::geteuid().as_raw()
}

impl Fixture {
    pub(super) fn start() -> Self {
        Self::with_robots(&[])
    }

    /// Of a site with these named robots.
    fn with_robots(robots: &[RobotName]) -> Self {
        static COUNTER: AtomicU32 = AtomicU32::new(0);
        let prefix = format!("gr{:x}x{:x}_", std::process::id(), COUNTER.fetch_add(1, Ordering::Relaxed));
        let folder = tempfile::Builder::new().prefix("rel").tempdir_in("/dev/shm").unwrap();
        let domain = Domain::shared(&prefix, folder.path().join("bus")).unwrap();
        let domain = domain.with_robots(robots.iter().copied()).unwrap();
        let keeper = Some(Keeper::start(&domain).unwrap());
        let (stop, stopped) = UnixStream::pair().unwrap();
        let events: Arc<Mutex<Vec<String>>> = Arc::default();
        let n_reports: Arc<AtomicU32> = Arc::default();
        let counter = Arc::clone(&n_reports);
        let report: Box<dyn Fn(ReportKind) -> Vec<u8> + Send> = Box::new(move |kind| {
            counter.fetch_add(1, Ordering::Relaxed);
            format!("{kind:?}").into_bytes()
        });
        let options = RelayOptions { view_group: None, control_group: Some("no such group".to_owned()), report };
        let (mut relay, notes) = Relay::open(&domain, options).unwrap();
        assert!(notes.len() == 1 && notes[0].contains("no such group"), "{notes:?}");
        relay.stop_on(stopped.into());
        let log = Arc::clone(&events);
        let serve = move || {
            let mut on_event = |event: RelayEvent<'_>| log.lock().unwrap().push(format!("{event:?}"));
            while !relay.serve(Duration::from_millis(50), &mut on_event).unwrap() {}
        };
        let thread = Some(std::thread::Builder::new().name("relay".to_owned()).spawn(serve).unwrap());
        Self { domain, keeper, events, n_reports, stop: Some(stop), thread, prefix, _folder: folder }
    }

    fn client(&self) -> (Bus, Waiter) {
        Self::client_of(&self.domain)
    }

    fn client_of(domain: &Domain) -> (Bus, Waiter) {
        until("the relay", || Bus::join_by_relay(domain, Daemon::Groundplan, own()).ok())
    }

    /// A connection to a socket that says nothing by itself.
    fn raw(&self, socket: &str) -> UnixStream {
        until("the socket", || UnixStream::connect(self.domain.relay_folder().join(socket)).ok())
    }

    fn n_events(&self, words: &str) -> usize {
        self.events.lock().unwrap().iter().filter(|event| event.contains(words)).count()
    }

    fn wait_for_event(&self, words: &str) {
        until(words, || (self.n_events(words) > 0).then_some(()));
    }
}

impl Drop for Fixture {
    fn drop(&mut self) {
        drop(self.stop.take());
        if let Some(thread) = self.thread.take() {
            thread.join().unwrap();
        }
        drop(self.keeper.take());
        if !std::thread::panicking() {
            assert!(
                !self.domain.relay_folder().join(VIEW_SOCKET).exists(),
                "a relay that ends takes its sockets along"
            );
            let left = crate::segments::segments(&self.prefix).unwrap();
            assert!(left.is_empty(), "{left:?}");
        }
    }
}

pub(super) fn until<T>(what: &str, mut look: impl FnMut() -> Option<T>) -> T {
    let begun = Instant::now();
    loop {
        if let Some(found) = look() {
            return found;
        }
        assert!(begun.elapsed() < DEADLINE, "waited in vain for {what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// A participant whose waiter runs in a thread, as a daemon's does.
pub(super) struct Attended {
    pub(super) bus: Bus,
    stopper: crate::Stopper,
    thread: Option<JoinHandle<()>>,
}

impl Attended {
    pub(super) fn join(domain: &Domain, daemon: Daemon) -> Self {
        let (bus, mut waiter) = Bus::join(domain, daemon).unwrap();
        let stopper = waiter.stopper();
        let wait = move || while !waiter.wait(DEADLINE).unwrap().stopped {};
        let thread = Some(std::thread::Builder::new().name("attended".to_owned()).spawn(wait).unwrap());
        Self { bus, stopper, thread }
    }
}

impl Drop for Attended {
    fn drop(&mut self) {
        self.stopper.stop();
        if let Some(thread) = self.thread.take() {
            thread.join().unwrap();
        }
    }
}

pub(super) fn publish(publisher: &crate::Publisher<topics::ScheduleState>, epoch: u64) {
    let origin = Origin { epoch, frame_epoch: 1, inputs: InputHashes::default() };
    publisher
        .publish(&ScheduleStateBuilder::everything_built(ContentHash::from_bits(epoch), 3 * epoch as usize, 1), origin)
        .unwrap();
}

#[test]
fn samples_come_as_they_were_published_and_late_joiners_get_the_last() {
    let fixture = Fixture::start();
    let producer = Attended::join(&fixture.domain, Daemon::ScheduleEval);
    let publisher = producer.bus.publisher(topics::ScheduleState, 4096).unwrap();
    publish(&publisher, 1);
    let (bus, mut waiter) = fixture.client();
    assert_eq!(bus.generation(), producer.bus.generation());
    let first = bus.subscriber(topics::ScheduleState).unwrap();
    let mut next = |epoch: u64| {
        let sample = until("a sample", || {
            waiter.wait(Duration::from_millis(100)).unwrap();
            first.take().unwrap()
        });
        assert_eq!(sample.header().epoch, epoch);
        let checked = sample.check().unwrap();
        assert_eq!(checked.view().n_elements(), 3 * epoch as usize);
    };
    next(1);
    publish(&publisher, 2);
    next(2);
    let second = bus.subscriber(topics::ScheduleState).unwrap();
    assert_eq!(second.take().unwrap().unwrap().header().epoch, 2, "who comes second gets the last one");
    assert!(first.take().unwrap().is_none());
    drop((first, second));
    let again = bus.subscriber(topics::ScheduleState).unwrap();
    assert_eq!(until("the last one", || again.take().unwrap()).header().epoch, 2);
}

#[test]
fn clients_get_what_is_of_the_robot_that_they_mean() {
    let robots: [RobotName; 2] = ["lift", "scan"].map(|name| name.parse().unwrap());
    let fixture = Fixture::with_robots(&robots);
    let domains = robots.map(|robot| fixture.domain.clone().of_robot(robot).unwrap());
    let daemons = domains.each_ref().map(|domain| Attended::join(domain, Daemon::Rasterize));
    let evaluation = Attended::join(&fixture.domain, Daemon::ScheduleEval);
    let states = evaluation.bus.publisher(topics::ScheduleState, 4096).unwrap();
    publish(&states, 5);
    let publishers = daemons.each_ref().map(|daemon| daemon.bus.publisher(topics::Grids, 4096).unwrap());
    for (publisher, epoch) in publishers.iter().zip([1, 2]) {
        let head = GridsHead {
            site_hash: ContentHash::from_bits(3),
            schedule_state_hash: ContentHash::from_bits(4),
            plan_time_s: 0,
            robot: RobotProfile::DEFAULT,
        };
        let index = GridsBuilder::of(head, &[], "r");
        publisher.publish(&index, Origin { epoch, frame_epoch: 1, inputs: InputHashes::default() }).unwrap();
    }
    let clients = domains.each_ref().map(Fixture::client_of);
    for ((bus, _waiter), epoch) in clients.iter().zip([1, 2]) {
        let indices = bus.raw_subscriber(TopicName::Grids).unwrap();
        assert_eq!(until("the index", || indices.take().unwrap()).header().epoch, epoch);
        let states = bus.subscriber(topics::ScheduleState).unwrap();
        assert_eq!(until("the state", || states.take().unwrap()).header().epoch, 5);
    }
    // Heartbeats of the other robot do not come.
    let readers = clients.each_ref().map(|(bus, _)| bus.status_reader().unwrap());
    let heartbeat = || bytemuck::Zeroable::zeroed();
    let of_scan = daemons[1].bus.status_writer().unwrap();
    let of_site = evaluation.bus.status_writer().unwrap();
    until("a heartbeat of its own", || {
        assert!(of_scan.send(heartbeat()));
        readers[1].take().unwrap().filter(|record| record.daemon == Daemon::Rasterize as u32)
    });
    until("a heartbeat of the site", || {
        assert!(of_site.send(heartbeat()));
        let record = readers[0].take().unwrap()?;
        assert_eq!(record.daemon, Daemon::ScheduleEval as u32, "no other robot's");
        Some(())
    });
    // Commands, and their robot in the log.
    let server = daemons[1].bus.command_server().unwrap();
    let open = clients[1].0.command_client(Daemon::Rasterize).unwrap().send(b"draw").unwrap();
    until("the command", || server.take().unwrap()).done(b"").unwrap();
    until("the reply", || open.take().unwrap());
    fixture.wait_for_event("robot: Some(\"scan\")");
    // Who means no robot has what is the site's, and one that there is not is refused with those that there are.
    let (site, _waiter) = fixture.client();
    let refused = site.raw_subscriber(TopicName::Grids).map(drop).unwrap_err().to_string();
    assert!(refused.contains("it has lift, scan"), "{refused}");
    let crane: RobotName = "crane".parse().unwrap();
    let elsewhere = fixture.domain.clone().with_robots([crane]).unwrap().of_robot(crane).unwrap();
    let refused = Bus::join_by_relay(&elsewhere, Daemon::Groundplan, own()).map(drop).unwrap_err().to_string();
    assert!(refused.contains("no robot `crane`: it has lift, scan"), "{refused}");
}

#[test]
fn a_slow_client_gets_the_newest_sample_and_holds_up_no_other() {
    let fixture = Fixture::start();
    let producer = Attended::join(&fixture.domain, Daemon::ScheduleEval);
    let publisher = producer.bus.publisher(topics::ScheduleState, 4096).unwrap();
    publish(&publisher, 1);
    let ((slow, mut slow_waiter), (quick, _quick_waiter)) = (fixture.client(), fixture.client());
    let of_slow = slow.subscriber(topics::ScheduleState).unwrap();
    let of_quick = quick.subscriber(topics::ScheduleState).unwrap();
    for epoch in 2..200 {
        publish(&publisher, epoch);
        until("each sample", || of_quick.take().unwrap().filter(|sample| sample.header().epoch == epoch));
    }
    let mut taken = Vec::new();
    until("the newest", || {
        slow_waiter.wait(Duration::from_millis(10)).unwrap();
        taken.extend(of_slow.take().unwrap().map(|sample| sample.header().epoch));
        taken.contains(&199).then_some(())
    });
    assert!(taken.len() <= 3, "those in between are left out: {taken:?}");
}

#[test]
fn commands_carry_the_user_whom_the_system_names() {
    let fixture = Fixture::start();
    let (bus, mut waiter) = fixture.client();
    let client = bus.command_client(Daemon::IfcIngest).unwrap();
    let open = client.send(b"load").unwrap();
    let error = until("the error", || open.take().err());
    assert!(matches!(error, CommandError::NotServed { daemon: Daemon::IfcIngest }), "{error}");
    let (server_bus, mut server_waiter) = Bus::join(&fixture.domain, Daemon::IfcIngest).unwrap();
    let server = server_bus.command_server().unwrap();
    let long = vec![7u8; 3 << 20];
    let open = client.send(&long).unwrap();
    let command = until("the command", || {
        server_waiter.wait(Duration::from_millis(50)).unwrap();
        server.take().unwrap()
    });
    assert!(command.bytes() == long && command.caller_uid() == own());
    command.progress(b"half").unwrap();
    command.done(&long).unwrap();
    let mut replies = Vec::new();
    until("the replies", || {
        waiter.wait(Duration::from_millis(50)).unwrap();
        replies.extend(open.take().unwrap());
        replies.last().is_some_and(Reply::is_final).then_some(())
    });
    assert!(replies[0] == Reply::Progress(b"half".to_vec()) && replies[1] == Reply::Done(long));
    fixture.wait_for_event(&format!("Command {{ uid: {}, daemon: IfcIngest", own()));
    // A client that gives up is told to the daemon.
    let open = client.send(b"again").unwrap();
    let command = until("the command", || server.take().unwrap());
    drop(open);
    until("the end", || command.is_cancelled().then_some(()));
}

#[test]
fn heartbeats_come_and_what_is_for_the_owner_is_refused() {
    let fixture = Fixture::start();
    let producer = Attended::join(&fixture.domain, Daemon::ScheduleEval);
    let (bus, mut waiter) = fixture.client();
    let reader = bus.status_reader().unwrap();
    let writer = producer.bus.status_writer().unwrap();
    let record = until("a heartbeat", || {
        writer.send(bytemuck::Zeroable::zeroed());
        waiter.wait(Duration::from_millis(20)).unwrap();
        reader.take().unwrap()
    });
    assert_eq!((record.daemon, record.process_id), (Daemon::ScheduleEval as u32, std::process::id()));
    assert!(matches!(bus.status_writer().map(drop), Err(PortError::OwnerOnly { .. })));
    assert!(matches!(bus.command_server().map(drop), Err(PortError::OwnerOnly { .. })));
    let (robot, _waiter) = Bus::join_by_relay(&fixture.domain, Daemon::Robot, own()).unwrap();
    assert!(matches!(robot.publisher(topics::SlamMap, 64).map(drop), Err(PortError::OwnerOnly { .. })));
}

#[test]
fn a_new_generation_ends_the_conversation_and_is_joined() {
    let mut fixture = Fixture::start();
    let (bus, mut waiter) = fixture.client();
    drop(fixture.keeper.take());
    let ended = until("the end", || Some(waiter.wait(DEADLINE).unwrap()).filter(|wake: &Wake| wake.superseded));
    assert!(!ended.stopped);
    let refused = Bus::join_by_relay(&fixture.domain, Daemon::Groundplan, own()).map(drop).unwrap_err();
    assert!(matches!(refused, DomainError::NoKeeper { .. }), "{refused}");
    fixture.keeper = Some(Keeper::start(&fixture.domain).unwrap());
    let (again, _waiter) = fixture.client();
    drop(bus);
    assert!(again.subscriber(topics::Site).is_ok());
}

#[test]
fn why_the_bus_cannot_be_joined_is_told_to_clients_and_to_the_log_once() {
    let mut fixture = Fixture::start();
    let (_bus, mut waiter) = fixture.client();
    drop(fixture.keeper.take());
    until("the end", || Some(waiter.wait(DEADLINE).unwrap()).filter(|wake| wake.superseded));
    let file = fixture.domain.place.current_path();
    // Renamed into place, as keepers do it: the relay may look at any moment.
    let beside = file.with_extension("new");
    std::fs::write(&beside, "generation=1\nlayout=4711\nlibrary=other\n").unwrap();
    std::fs::rename(&beside, &file).unwrap();
    fixture.wait_for_event("CannotJoin");
    for _ in 0..5 {
        let refused = Bus::join_by_relay(&fixture.domain, Daemon::Groundplan, own()).map(drop).unwrap_err();
        assert!(refused.to_string().contains("layout version 4711"), "{refused}");
    }
    assert_eq!(fixture.n_events("CannotJoin"), 1);
    std::fs::remove_file(&file).unwrap();
    fixture.keeper = Some(Keeper::start(&fixture.domain).unwrap());
    fixture.client();
}

#[test]
fn a_command_that_is_refused_takes_no_place_of_its_daemon() {
    let fixture = Fixture::start();
    let (bus, _waiter) = fixture.client();
    let refused = bus.command_client(Daemon::IfcIngest).unwrap().send(b"load").unwrap();
    until("the refusal", || refused.take().err());
    let (owner, _waiter) = Bus::join_as_owner(&fixture.domain, Daemon::Groundplan).unwrap();
    let clients: Vec<_> = (0..MAX_CLIENTS).map(|_| owner.command_client(Daemon::IfcIngest).unwrap()).collect();
    assert!(owner.command_client(Daemon::IfcIngest).is_err(), "{} are all", clients.len());
}

#[test]
fn there_is_one_relay_and_a_deleted_socket_is_made_again() {
    let fixture = Fixture::start();
    let options = || RelayOptions { view_group: None, control_group: None, report: Box::new(|_| Vec::new()) };
    assert!(matches!(Relay::open(&fixture.domain, options()).map(drop), Err(DomainError::RelayRuns { .. })));
    fixture.client();
    std::fs::remove_file(fixture.domain.relay_folder().join(CONTROL_SOCKET)).unwrap();
    fixture.client();
}
