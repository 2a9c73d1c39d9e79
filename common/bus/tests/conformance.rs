//! Conformance suite of the bus; each test has a bus of its own in shared memory. What holds without commands, waiting and
//! keepers holds on a bus inside one process too.

#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

mod common;

use bus::{
    Bus, CommandError, Daemon, Domain, DomainError, InProcessBus, Keeper, MAX_HELD, MAX_OPEN, PortError, PublishError,
    ReceiveError, Reply, Waiter, topics,
};
use common::{Attended, DEADLINE, Fixture, Wait, grid, origin, publish, sample_of, schedule_state, until};
use messages::{Activity, ArchiveBuffer, ScheduleState, StatusRecord};
use std::time::Duration;

fn up(fixture: &Fixture) -> (Keeper, &Domain) {
    (Keeper::start(&fixture.domain).unwrap(), &fixture.domain)
}

/// A bus of either kind.
enum Site {
    /// The keeper ends before its files are removed.
    Shared {
        _keeper: Box<Keeper>,
        fixture: Fixture,
    },
    InProcess(InProcessBus),
}

impl Site {
    fn shared() -> Self {
        let fixture = Fixture::shared();
        Self::Shared { _keeper: Box::new(Keeper::start(&fixture.domain).unwrap()), fixture }
    }

    fn join(&self, daemon: Daemon) -> (Bus, Look) {
        match self {
            Self::Shared { fixture, .. } => {
                let (bus, waiter) = Bus::join(&fixture.domain, daemon).unwrap();
                (bus, Look::OnWake(Box::new(waiter)))
            }
            Self::InProcess(bus) => (Bus::in_process(bus, daemon), Look::Once),
        }
    }

    fn attended(&self, daemon: Daemon) -> Attended {
        match self {
            Self::Shared { fixture, .. } => Attended::join(&fixture.domain, daemon),
            Self::InProcess(bus) => Attended::in_process(bus, daemon),
        }
    }
}

/// How a participant finds what comes.
enum Look {
    OnWake(Box<Waiter>),
    /// Everything is there at the first look.
    Once,
}

impl Wait for Look {
    fn wait_for_more(&mut self, at_most: Duration) {
        match self {
            Self::OnWake(waiter) => waiter.wait_for_more(at_most),
            Self::Once => panic!("it is not there at once"),
        }
    }
}

/// Makes of each fact a test on a bus of each kind.
macro_rules! on_both {
    ($($fact:ident)+) => {
        mod in_shared_memory {
            $(#[test]
            fn $fact() {
                super::$fact(&super::Site::shared());
            })+
        }

        mod inside_one_process {
            $(#[test]
            fn $fact() {
                super::$fact(&super::Site::InProcess(bus::InProcessBus::new()));
            })+
        }
    };
}

on_both! {
    a_late_joiner_gets_the_last_sample
    many_late_joiners_of_many_topics_get_their_samples
    samples_in_between_are_left_out
    a_held_sample_stays_as_it_is
    a_larger_loan_than_before_is_possible_and_latched
    the_header_says_where_a_sample_comes_from
    a_topic_has_one_producer_and_one_publisher
    what_is_no_archive_of_the_topic_is_not_published
    epochs_never_fall
    there_is_one_loan_at_a_time
    a_subscriber_may_hold_a_few_samples
    a_publisher_that_comes_again_goes_on
    heartbeats_arrive_in_order_and_the_oldest_give_way
}

fn a_late_joiner_gets_the_last_sample(site: &Site) {
    let producer = site.attended(Daemon::ScheduleEval);
    let publisher = producer.bus.publisher(topics::ScheduleState, 64).unwrap();
    publish(&publisher, 1, 10);
    publish(&publisher, 2, 20);
    let (bus, mut waiter) = site.join(Daemon::Rasterize);
    let late = bus.subscriber(topics::ScheduleState).unwrap();
    let sample = sample_of(&mut waiter, &late, 2);
    assert_eq!(sample.bytes(), schedule_state(20).bytes());
    assert_eq!(sample.bytes().as_ptr() as usize % 64, 0);
    assert_eq!(ScheduleState::open(sample.bytes()).unwrap().n_elements(), 20);
    assert!(late.take().unwrap().is_none(), "a sample is taken once");
}

fn many_late_joiners_of_many_topics_get_their_samples(site: &Site) {
    let producer = site.attended(Daemon::SlamAlign);
    for daemon in [Daemon::IfcIngest, Daemon::Robot, Daemon::Groundplan] {
        let (bus, mut waiter) = site.join(daemon);
        let (early, other) =
            (bus.subscriber(topics::ScheduleState).unwrap(), bus.subscriber(topics::ScheduleState).unwrap());
        let eval = site.attended(Daemon::ScheduleEval);
        let publisher = eval.bus.publisher(topics::ScheduleState, 64).unwrap();
        publish(&publisher, 1, 10);
        let late = producer.bus.subscriber(topics::ScheduleState).unwrap();
        for subscriber in [&early, &other] {
            sample_of(&mut waiter, subscriber, 1);
        }
        let last = bus.subscriber(topics::ScheduleState).unwrap();
        sample_of(&mut waiter, &last, 1);
        drop((late, publisher));
    }
}

fn samples_in_between_are_left_out(site: &Site) {
    let producer = site.attended(Daemon::ScheduleEval);
    let publisher = producer.bus.publisher(topics::ScheduleState, 64).unwrap();
    let (bus, mut waiter) = site.join(Daemon::Rasterize);
    let subscriber = bus.subscriber(topics::ScheduleState).unwrap();
    for epoch in 1..=50 {
        publish(&publisher, epoch, 10);
    }
    let sample = until(&mut waiter, "a sample", || subscriber.take().unwrap());
    assert_eq!(sample.header().epoch, 50);
}

fn a_held_sample_stays_as_it_is(site: &Site) {
    let producer = site.attended(Daemon::ScheduleEval);
    let publisher = producer.bus.publisher(topics::ScheduleState, 4096).unwrap();
    let (bus, mut waiter) = site.join(Daemon::Rasterize);
    let subscriber = bus.subscriber(topics::ScheduleState).unwrap();
    publish(&publisher, 1, 1000);
    let held = sample_of(&mut waiter, &subscriber, 1);
    for epoch in 2..=20 {
        publish(&publisher, epoch, 1000 + epoch as usize);
    }
    let newer = sample_of(&mut waiter, &subscriber, 20);
    drop((publisher, producer, subscriber, bus, waiter));
    assert_eq!(held.bytes(), schedule_state(1000).bytes());
    assert_eq!(newer.bytes(), schedule_state(1020).bytes());
}

fn a_larger_loan_than_before_is_possible_and_latched(site: &Site) {
    let producer = site.attended(Daemon::ScheduleEval);
    let publisher = producer.bus.publisher(topics::ScheduleState, 64).unwrap();
    let (bus, mut waiter) = site.join(Daemon::Rasterize);
    let subscriber = bus.subscriber(topics::ScheduleState).unwrap();
    let mut held = None;
    for (epoch, n) in [(1, 100), (2, 10_000), (3, 1_000_000), (4, 5_000_000)] {
        publish(&publisher, epoch, n);
        let sample = sample_of(&mut waiter, &subscriber, epoch);
        assert!(sample.bytes() == schedule_state(n).bytes(), "epoch {epoch} came whole");
        held.get_or_insert(sample);
    }
    assert_eq!(held.unwrap().bytes(), schedule_state(100).bytes());
    let late = bus.subscriber(topics::ScheduleState).unwrap();
    let sample = sample_of(&mut waiter, &late, 4);
    assert!(sample.bytes() == schedule_state(5_000_000).bytes(), "what was latched has grown too");
}

fn the_header_says_where_a_sample_comes_from(site: &Site) {
    let producer = site.attended(Daemon::ScheduleEval);
    let publisher = producer.bus.publisher(topics::ScheduleState, 64).unwrap();
    let archive = schedule_state(33);
    // More is lent than is used: the sample has the archive's length.
    let mut loan = publisher.loan(archive.bytes().len() + 100).unwrap();
    loan.bytes_mut()[..archive.bytes().len()].copy_from_slice(archive.bytes());
    loan.publish(origin(9)).unwrap();
    let (bus, mut waiter) = site.join(Daemon::Rasterize);
    let sample = sample_of(&mut waiter, &bus.subscriber(topics::ScheduleState).unwrap(), 9);
    let header = sample.header();
    assert_eq!(header.content_hash, ScheduleState::open(archive.bytes()).unwrap().content_hash());
    assert_eq!((header.payload_length, sample.bytes().len()), (archive.bytes().len() as u64, archive.bytes().len()));
    assert_eq!((header.frame_epoch, header.inputs.site.to_bits()), (1, 5));
    assert!(header.stamp_ns > 0);
}

fn a_topic_has_one_producer_and_one_publisher(site: &Site) {
    let (bus, _waiter) = site.join(Daemon::Rasterize);
    assert!(matches!(bus.publisher(topics::ScheduleState, 64), Err(PortError::NotTheProducer { .. })));
    let first = bus.publisher(grid(63), 64).unwrap();
    let (other, _waiter) = site.join(Daemon::Rasterize);
    assert!(matches!(other.publisher(grid(63), 64), Err(PortError::Taken { .. })));
    let _another_slot = other.publisher(grid(0), 64).unwrap();
    drop(first);
    other.publisher(grid(63), 64).unwrap();
}

#[test]
fn commands_to_a_daemon_have_one_server() {
    let fixture = Fixture::shared();
    let (_keeper, domain) = up(&fixture);
    let (bus, _waiter) = Bus::join(domain, Daemon::Rasterize).unwrap();
    let (other, _waiter) = Bus::join(domain, Daemon::Rasterize).unwrap();
    let _server = bus.command_server().unwrap();
    assert!(matches!(other.command_server(), Err(PortError::Taken { .. })));
}

fn what_is_no_archive_of_the_topic_is_not_published(site: &Site) {
    let producer = site.attended(Daemon::Rasterize);
    let publisher = producer.bus.publisher(topics::Grids, 64).unwrap();
    for bytes in [schedule_state(10), ArchiveBuffer::zeroed(640), ArchiveBuffer::zeroed(0)] {
        let refused = publisher.publish_copy(bytes.bytes(), origin(1));
        assert!(matches!(refused, Err(PublishError::Archive { .. })), "{refused:?}");
    }
    let too_large = publisher.loan(bus::MAX_SAMPLE_BYTES + 1).map(|_| ());
    assert!(matches!(too_large, Err(PublishError::TooLarge { .. })));
}

fn epochs_never_fall(site: &Site) {
    let (bus, mut waiter) = site.join(Daemon::Rasterize);
    let subscriber = bus.subscriber(topics::ScheduleState).unwrap();
    let producer = site.attended(Daemon::ScheduleEval);
    let publisher = producer.bus.publisher(topics::ScheduleState, 64).unwrap();
    publish(&publisher, 7, 10);
    let refused = publisher.publish_copy(schedule_state(10).bytes(), origin(6));
    assert!(matches!(refused, Err(PublishError::EpochFell { epoch: 6, last: 7, .. })), "{refused:?}");
    sample_of(&mut waiter, &subscriber, 7);
    // A producer that lost its count is refused by who has seen more.
    drop(publisher);
    let publisher = producer.bus.publisher(topics::ScheduleState, 64).unwrap();
    publish(&publisher, 3, 10);
    let error = until(&mut waiter, "the refusal", || subscriber.take().err());
    assert!(matches!(error, ReceiveError::EpochFell { epoch: 3, last: 7, .. }), "{error:?}");
    publish(&publisher, 8, 10);
    sample_of(&mut waiter, &subscriber, 8);
}

fn there_is_one_loan_at_a_time(site: &Site) {
    let producer = site.attended(Daemon::ScheduleEval);
    let publisher = producer.bus.publisher(topics::ScheduleState, 64).unwrap();
    publish(&publisher, 1, 10);
    let loan = publisher.loan(100).unwrap();
    assert!(matches!(publisher.loan(100).map(|_| ()), Err(PublishError::LoanedOut { .. })));
    drop(loan);
    let mut loan = publisher.loan(100).unwrap();
    loan.bytes_mut().fill(1);
    assert!(loan.publish(origin(2)).is_err());
    // What was not published changed nothing.
    let (bus, mut waiter) = site.join(Daemon::Rasterize);
    sample_of(&mut waiter, &bus.subscriber(topics::ScheduleState).unwrap(), 1);
    publish(&publisher, 2, 10);
}

fn a_subscriber_may_hold_a_few_samples(site: &Site) {
    let producer = site.attended(Daemon::ScheduleEval);
    let publisher = producer.bus.publisher(topics::ScheduleState, 64).unwrap();
    let (bus, mut waiter) = site.join(Daemon::Rasterize);
    let subscriber = bus.subscriber(topics::ScheduleState).unwrap();
    let mut held = Vec::new();
    for epoch in 1..=MAX_HELD as u64 {
        publish(&publisher, epoch, epoch as usize);
        held.push(sample_of(&mut waiter, &subscriber, epoch));
    }
    publish(&publisher, 100, 100);
    assert!(matches!(subscriber.take(), Err(ReceiveError::TooManyHeld { held: MAX_HELD, .. })));
    held.remove(0);
    held.push(sample_of(&mut waiter, &subscriber, 100));
    assert_eq!(held[0].bytes(), schedule_state(2).bytes());
}

fn a_publisher_that_comes_again_goes_on(site: &Site) {
    let (bus, mut waiter) = site.join(Daemon::Rasterize);
    let subscriber = bus.subscriber(topics::ScheduleState).unwrap();
    let mut held = None;
    for epoch in [4, 4, 5] {
        let producer = site.attended(Daemon::ScheduleEval);
        let publisher = producer.bus.publisher(topics::ScheduleState, 64).unwrap();
        publish(&publisher, epoch, epoch as usize);
        held = Some(sample_of(&mut waiter, &subscriber, epoch));
    }
    let late = bus.subscriber(topics::ScheduleState).unwrap();
    assert!(late.take().unwrap().is_none(), "the last sample goes with its publisher");
    assert_eq!(held.unwrap().bytes(), schedule_state(5).bytes());
}

fn heartbeats_arrive_in_order_and_the_oldest_give_way(site: &Site) {
    let (bus, mut waiter) = site.join(Daemon::Groundplan);
    let reader = bus.status_reader().unwrap();
    let record = StatusRecord { activity: Activity::Writing.into(), memory_bytes: 5, ..bytemuck::Zeroable::zeroed() };
    let (other, _waiter) = site.join(Daemon::Rasterize);
    let writer = other.status_writer().unwrap();
    assert!(writer.send(record) && writer.send(record));
    for sequence in 1..=2 {
        let seen = until(&mut waiter, "a heartbeat", || reader.take().unwrap());
        assert_eq!((seen.sequence, seen.activity.get(), seen.memory_bytes), (sequence, Activity::Writing, 5));
        assert_eq!((Daemon::from_id(seen.daemon), seen.process_id), (Some(Daemon::Rasterize), std::process::id()));
    }
    for _ in 0..1000 {
        assert!(writer.send(record));
    }
    let mut sequences = Vec::new();
    while let Some(seen) = reader.take().unwrap() {
        sequences.push(seen.sequence);
    }
    assert_eq!(sequences.last(), Some(&1002));
    assert!(sequences.is_sorted() && sequences.len() < 1000);
}

#[test]
fn a_command_has_progress_and_an_end() {
    let fixture = Fixture::shared();
    let (_keeper, domain) = up(&fixture);
    let (daemon, mut at_daemon) = Bus::join(domain, Daemon::IfcIngest).unwrap();
    let server = daemon.command_server().unwrap();
    let (client, mut at_client) = Bus::join(domain, Daemon::Groundplan).unwrap();
    let to_daemon = client.command_client(Daemon::IfcIngest).unwrap();
    for fails in [false, true] {
        let open = to_daemon.send(b"load").unwrap();
        assert!(open.take().unwrap().is_none());
        let command = until(&mut at_daemon, "the command", || server.take().unwrap());
        assert_eq!((command.bytes(), command.is_cancelled()), (&b"load"[..], false));
        command.progress(b"half").unwrap();
        let reply = until(&mut at_client, "progress", || open.take().unwrap());
        assert_eq!(reply, Reply::Progress(b"half".to_vec()));
        assert!(!reply.is_final());
        let end = if fails { command.failed(b"no") } else { command.done(b"yes") };
        end.unwrap();
        let reply = until(&mut at_client, "the end", || open.take().unwrap());
        assert_eq!(reply, if fails { Reply::Failed(b"no".to_vec()) } else { Reply::Done(b"yes".to_vec()) });
    }
    // A client that does not look gets the end all the same.
    let open = to_daemon.send(b"load").unwrap();
    let command = until(&mut at_daemon, "the command", || server.take().unwrap());
    for _ in 0..1000 {
        command.progress(b"more").unwrap();
    }
    command.done(b"yes").unwrap();
    let end = until(&mut at_client, "the end", || std::iter::from_fn(|| open.take().unwrap()).find(Reply::is_final));
    assert_eq!(end, Reply::Done(b"yes".to_vec()));
}

#[test]
fn a_command_may_be_large_or_empty() {
    let fixture = Fixture::shared();
    let (_keeper, domain) = up(&fixture);
    let (daemon, mut at_daemon) = Bus::join(domain, Daemon::ScheduleEval).unwrap();
    let server = daemon.command_server().unwrap();
    let (client, mut at_client) = Bus::join(domain, Daemon::Groundplan).unwrap();
    let to_daemon = client.command_client(Daemon::ScheduleEval).unwrap();
    for length in [0, 1, 5000, 3 << 20] {
        let text: Vec<u8> = (0..length).map(|i: usize| i as u8).collect();
        let open = to_daemon.send(&text).unwrap();
        let command = until(&mut at_daemon, "the command", || server.take().unwrap());
        assert!(command.bytes() == text, "{length} bytes came");
        command.done(&text).unwrap();
        let reply = until(&mut at_client, "the end", || open.take().unwrap());
        assert!(reply == Reply::Done(text), "{length} bytes came back");
    }
    let refused = to_daemon.send(&vec![0; bus::MAX_COMMAND_BYTES + 1]).map(|_| ());
    assert!(matches!(refused, Err(CommandError::TooLarge { .. })));
}

#[test]
fn a_command_that_nobody_serves_fails_at_once() {
    let fixture = Fixture::shared();
    let (_keeper, domain) = up(&fixture);
    let (client, _waiter) = Bus::join(domain, Daemon::Groundplan).unwrap();
    let to_daemon = client.command_client(Daemon::ScheduleEval).unwrap();
    let refused = to_daemon.send(b"date").map(|_| ());
    assert!(matches!(refused, Err(CommandError::NotServed { daemon: Daemon::ScheduleEval })), "{refused:?}");
    // It works as soon as a process serves it.
    let (daemon, _waiter) = Bus::join(domain, Daemon::ScheduleEval).unwrap();
    let _server = daemon.command_server().unwrap();
    to_daemon.send(b"date").unwrap();
}

#[test]
fn a_command_that_is_dropped_is_lost() {
    let fixture = Fixture::shared();
    let (_keeper, domain) = up(&fixture);
    let (daemon, mut at_daemon) = Bus::join(domain, Daemon::ScheduleEval).unwrap();
    let server = daemon.command_server().unwrap();
    let (client, mut at_client) = Bus::join(domain, Daemon::Groundplan).unwrap();
    let to_daemon = client.command_client(Daemon::ScheduleEval).unwrap();
    let open = to_daemon.send(b"date").unwrap();
    let command = until(&mut at_daemon, "the command", || server.take().unwrap());
    command.progress(b"half").unwrap();
    drop(command);
    assert_eq!(until(&mut at_client, "progress", || open.take().unwrap()), Reply::Progress(b"half".to_vec()));
    let lost = until(&mut at_client, "the loss", || open.take().err());
    assert!(matches!(lost, CommandError::Lost { daemon: Daemon::ScheduleEval }), "{lost:?}");
}

#[test]
fn a_command_whose_client_leaves_is_cancelled() {
    let fixture = Fixture::shared();
    let (_keeper, domain) = up(&fixture);
    let (daemon, mut at_daemon) = Bus::join(domain, Daemon::ScheduleEval).unwrap();
    let server = daemon.command_server().unwrap();
    let (client, _at_client) = Bus::join(domain, Daemon::Groundplan).unwrap();
    let open = client.command_client(Daemon::ScheduleEval).unwrap().send(b"date").unwrap();
    let command = until(&mut at_daemon, "the command", || server.take().unwrap());
    assert!(!command.is_cancelled());
    drop(open);
    assert!(command.is_cancelled());
    command.progress(b"into the void").unwrap();
    command.done(b"into the void").unwrap();
}

#[test]
fn a_client_has_few_open_commands() {
    let fixture = Fixture::shared();
    let (_keeper, domain) = up(&fixture);
    let (daemon, _at_daemon) = Bus::join(domain, Daemon::ScheduleEval).unwrap();
    let server = daemon.command_server().unwrap();
    let (client, _at_client) = Bus::join(domain, Daemon::Groundplan).unwrap();
    let to_daemon = client.command_client(Daemon::ScheduleEval).unwrap();
    let mut open: Vec<_> = (0..MAX_OPEN).map(|_| to_daemon.send(b"date").unwrap()).collect();
    let refused = to_daemon.send(b"date").map(|_| ());
    assert!(matches!(refused, Err(CommandError::TooMany { .. })), "{refused:?}");
    open.pop();
    // A cancelled command counts until the daemon has looked at it.
    while server.take().unwrap().is_some() {}
    to_daemon.send(b"date").unwrap();
}

#[test]
fn waiting_ends_for_a_stop_a_nudge_and_the_time() {
    let fixture = Fixture::shared();
    let (_keeper, domain) = up(&fixture);
    let (bus, mut waiter) = Bus::join(domain, Daemon::Rasterize).unwrap();
    let _subscriber = bus.subscriber(topics::Site).unwrap();
    while !waiter.wait(Duration::from_millis(1)).unwrap().timed_out() {}
    let waker = waiter.waker();
    let thread = std::thread::spawn(move || waker.wake_up());
    assert!(waiter.wait(DEADLINE).unwrap().woken);
    thread.join().unwrap();
    assert!(waiter.wait(Duration::ZERO).unwrap().timed_out(), "a nudge wakes once");
    let (reader, writer) = std::io::pipe().unwrap();
    waiter.stop_on(reader.into());
    assert!(!waiter.wait(Duration::ZERO).unwrap().stopped);
    drop(writer);
    assert!(waiter.wait(DEADLINE).unwrap().stopped && waiter.wait(DEADLINE).unwrap().stopped);
    let (_bus, mut waiter) = Bus::join(domain, Daemon::Rasterize).unwrap();
    waiter.stopper().stop();
    assert!(waiter.wait(DEADLINE).unwrap().stopped && waiter.wait(DEADLINE).unwrap().stopped);
}

#[test]
fn there_is_one_keeper_and_nobody_joins_without() {
    let fixture = Fixture::shared();
    let join = || Bus::join(&fixture.domain, Daemon::Robot).map(|_| ());
    assert!(matches!(join(), Err(DomainError::NoKeeper { .. })));
    let (keeper, domain) = up(&fixture);
    assert!(matches!(Keeper::start(domain), Err(DomainError::KeeperRuns { .. })));
    join().unwrap();
    assert_eq!(keeper.tick().unwrap(), 0);
    drop(keeper);
    assert!(matches!(join(), Err(DomainError::NoKeeper { .. })));
    let _keeper = Keeper::start(domain).unwrap();
    join().unwrap();
}

#[test]
fn participants_hear_that_the_keeper_went_down() {
    let fixture = Fixture::shared();
    let (keeper, domain) = up(&fixture);
    let (bus, mut waiter) = Bus::join(domain, Daemon::Robot).unwrap();
    assert_eq!(bus.generation(), keeper.generation());
    let thread = std::thread::spawn(move || drop(keeper));
    let wake = waiter.wait(DEADLINE).unwrap();
    assert!(wake.superseded && !wake.stopped);
    thread.join().unwrap();
    assert!(waiter.wait(Duration::ZERO).unwrap().superseded, "it stays true");
    // They follow the next one.
    let keeper = Keeper::start(domain).unwrap();
    assert!(keeper.generation() > bus.generation());
    let (again, _waiter) = Bus::join(domain, Daemon::Robot).unwrap();
    assert_eq!(again.generation(), keeper.generation());
}

#[test]
fn a_worker_publishes_while_the_loop_waits() {
    let fixture = Fixture::shared();
    let (_keeper, domain) = up(&fixture);
    let producer = Attended::join(domain, Daemon::ScheduleEval);
    let publisher = producer.bus.publisher(topics::ScheduleState, 64).unwrap();
    let worker = std::thread::spawn(move || {
        for epoch in 1..=200 {
            publish(&publisher, epoch, 50);
        }
        publisher
    });
    // Late joiners are served by the loop at the same time.
    let (bus, mut waiter) = Bus::join(domain, Daemon::Rasterize).unwrap();
    let subscribers: Vec<_> = (0..8).map(|_| bus.subscriber(topics::ScheduleState).unwrap()).collect();
    for subscriber in &subscribers {
        sample_of(&mut waiter, subscriber, 200);
    }
    worker.join().unwrap();
}

#[test]
fn ends_and_samples_go_to_other_threads() {
    fn is_send<T: Send>() {}
    fn is_shared<T: Send + Sync>() {}
    is_shared::<(
        Bus,
        bus::Publisher<topics::ScheduleState>,
        bus::Subscriber<topics::ScheduleState>,
        bus::StatusWriter,
        bus::Waker,
        bus::Stopper,
    )>();
    is_send::<(Keeper, bus::Sample<topics::ScheduleState>, bus::Waiter, bus::Loan<'static, topics::ScheduleState>)>();
    is_send::<(bus::CommandServer, bus::Command, bus::CommandClient, bus::OpenCommand, bus::StatusReader)>();
}

#[test]
fn one_subscriber_too_many_is_told_so() {
    let fixture = Fixture::shared();
    let (_keeper, domain) = up(&fixture);
    let (bus, _waiter) = Bus::join(domain, Daemon::Robot).unwrap();
    // A robot's program is a guest, which leaves places to daemons and commands.
    let subscribers: Vec<_> = (0..28).map(|_| bus.subscriber(topics::Site).unwrap()).collect();
    let refused = bus.subscriber(topics::Site).map(drop).unwrap_err();
    let words = refused.to_string();
    assert!(words.contains("`site` has 28 participants") && words.contains("stop one"), "{words}");
    drop(subscribers);
    bus.subscriber(topics::Site).unwrap();
}
