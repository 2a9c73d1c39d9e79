//! Clients that send what no client of ours sends, or do not read: what that costs the relay, and that others are served.

use super::*;
use crate::limits::{MAX_CONNECTIONS_OF_USER, TAKE_TIMEOUT};
use crate::names::TopicName;
use crate::relay::feeds::Feeds;
use crate::robot_name::OfRobot;
use rustix::net::{SendAncillaryBuffer, SendAncillaryMessage, SendFlags, sendmsg};
use std::io::{ErrorKind, IoSlice};
use std::mem::MaybeUninit;

const SUBSCRIBE: u32 = 2;
const UNSUBSCRIBE: u32 = 3;
const TAKEN: u32 = 4;
const COMMAND: u32 = 6;
const ASK_REPORT: u32 = 8;
const WELCOME: u32 = 101;
const SAMPLE: u32 = 103;
const REPORT: u32 = 108;

/// Number of the topic that tests publish.
const STATES: u64 = 2;

/// Header of a frame.
fn frame(kind: u32, length: u32, id: u64) -> Vec<u8> {
    [&kind.to_ne_bytes()[..], &length.to_ne_bytes(), &id.to_ne_bytes()].concat()
}

fn hello(version: u32) -> Vec<u8> {
    [&frame(1, 8, 0)[..], b"GPRL", &version.to_ne_bytes()].concat()
}

fn greeting() -> Vec<u8> {
    hello(messages::LAYOUT_VERSION)
}

/// Kind and body of the next frame.
fn read_frame(socket: &mut UnixStream) -> (u32, Vec<u8>) {
    socket.set_read_timeout(Some(DEADLINE)).unwrap();
    let mut header = [0; 16];
    socket.read_exact(&mut header).unwrap();
    let number = |at: usize| u32::from_ne_bytes(header[at..at + 4].try_into().unwrap());
    let mut body = vec![0; number(4) as usize];
    socket.read_exact(&mut body).unwrap();
    (number(0), body)
}

/// Writes as much as the socket takes; bytes that it does not take are left out.
fn write_some(socket: &mut UnixStream, bytes: &[u8]) {
    socket.set_nonblocking(true).unwrap();
    let mut rest = bytes;
    while !rest.is_empty() {
        match socket.write(rest) {
            Ok(written) => rest = &rest[written..],
            Err(error) if error.kind() == ErrorKind::WouldBlock => break,
            Err(error) => panic!("{error}"),
        }
    }
    socket.set_nonblocking(false).unwrap();
}

#[test]
fn bytes_that_are_no_conversation_are_cut_off_and_others_served() {
    let fixture = Fixture::start();
    let (bus, _waiter) = fixture.client();
    let attempts: [(&str, Vec<u8>); 9] = [
        (CONTROL_SOCKET, b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n".to_vec()),
        (CONTROL_SOCKET, vec![0xff; 1 << 20]),
        (CONTROL_SOCKET, frame(SUBSCRIBE, 0, 0)),
        (CONTROL_SOCKET, [greeting(), frame(SUBSCRIBE, 0, 4711)].concat()),
        (CONTROL_SOCKET, [greeting(), frame(COMMAND, u32::MAX, 1)].concat()),
        (CONTROL_SOCKET, [greeting(), frame(COMMAND, 4, 1), 99u32.to_ne_bytes().to_vec()].concat()),
        (CONTROL_SOCKET, [greeting(), greeting()].concat()),
        (CONTROL_SOCKET, [greeting(), frame(103, 0, 0)].concat()),
        (VIEW_SOCKET, [greeting(), frame(COMMAND, 8, 1), vec![0; 8]].concat()),
    ];
    let n_attempts = attempts.len();
    for (socket, bytes) in attempts {
        let mut raw = fixture.raw(socket);
        // It may be cut off while it still writes.
        let _ = raw.write_all(&bytes);
        let mut rest = Vec::new();
        // The end of the stream, or its reset.
        let _ = raw.read_to_end(&mut rest);
    }
    until("the log", || {
        let events = fixture.events.lock().unwrap();
        (events.iter().filter(|event| event.starts_with("CutOff")).count() == n_attempts).then_some(())
    });
    let mut other_version = fixture.raw(VIEW_SOCKET);
    other_version.write_all(&hello(77)).unwrap();
    let mut answer = Vec::new();
    other_version.read_to_end(&mut answer).unwrap();
    assert!(answer[..4] == 102u32.to_ne_bytes() && answer[16..20] == messages::LAYOUT_VERSION.to_ne_bytes());
    let sites = bus.subscriber(topics::Site).unwrap();
    assert!(sites.take().unwrap().is_none() && bus.subscriber(topics::Grids).unwrap().take().is_ok());
}

#[test]
fn what_has_come_is_handled_before_more_is_read() {
    let fixture = Fixture::start();
    let (bus, _waiter) = Bus::join_as_owner(&fixture.domain, Daemon::Groundplan).unwrap();
    let (near, mut far) = UnixStream::pair().unwrap();
    let mut connection = Connection::new(near, own(), false);
    let (mut feeds, mut report) = (Feeds::default(), Reports::new(Box::new(|_| vec![1; 64 << 10])));
    far.write_all(&greeting()).unwrap();
    let requests = frame(ASK_REPORT, 0, 0).repeat(16 << 10);
    let mut n_ready = 0;
    for round in 0..200 {
        write_some(&mut far, &requests);
        connection.receive().unwrap();
        let welcome = FromRelay::Welcome { generation: 1, may_command: false, control_group: String::new() };
        connection.handle(welcome, &bus, &mut feeds, &mut report, &mut |_| {}).unwrap();
        connection.send(None).unwrap();
        let n_bytes = connection.n_unhandled_bytes();
        assert!(n_bytes <= 128 << 10, "{n_bytes} bytes wait after {round} answers");
        n_ready += usize::from(connection.has_request());
        assert!(!connection.has_request() || !connection.interest().contains(PollFlags::IN));
        let (kind, _) = read_frame(&mut far);
        assert_eq!(kind, if round == 0 { WELCOME } else { REPORT });
    }
    assert!(n_ready > 0, "what is left over is handled at once, and not at the next event");
}

#[test]
fn all_of_many_requests_are_answered_and_the_report_is_made_rarely() {
    const N_REQUESTS: usize = 5000;
    let fixture = Fixture::start();
    let begun = Instant::now();
    let mut raw = fixture.raw(VIEW_SOCKET);
    let mut writing = raw.try_clone().unwrap();
    let bytes = [greeting(), frame(ASK_REPORT, 0, 0).repeat(N_REQUESTS)].concat();
    let writer =
        std::thread::Builder::new().name("writer".to_owned()).spawn(move || writing.write_all(&bytes).unwrap());
    assert_eq!(read_frame(&mut raw).0, WELCOME);
    for _ in 0..N_REQUESTS {
        assert_eq!(read_frame(&mut raw), (REPORT, b"Status".to_vec()));
    }
    writer.unwrap().join().unwrap();
    let (n_reports, n_periods) = (fixture.n_reports.load(Ordering::Relaxed), begun.elapsed().as_millis() / 200);
    assert!(u128::from(n_reports) <= n_periods + 2, "{n_reports} reports in {n_periods} periods");
}

#[test]
fn a_client_that_does_not_read_and_one_that_says_half_hold_up_no_other() {
    let fixture = Fixture::start();
    let producer = Attended::join(&fixture.domain, Daemon::ScheduleEval);
    let publisher = producer.bus.publisher(topics::ScheduleState, 4096).unwrap();
    let mut deaf = fixture.raw(VIEW_SOCKET);
    write_some(&mut deaf, &[greeting(), frame(SUBSCRIBE, 0, STATES), frame(ASK_REPORT, 0, 0).repeat(1 << 16)].concat());
    let mut slow = fixture.raw(VIEW_SOCKET);
    let said = [greeting(), frame(ASK_REPORT, 0, 0)].concat();
    let (first, rest) = said.split_at(29);
    slow.write_all(first).unwrap();
    let (bus, _waiter) = fixture.client();
    let samples = bus.subscriber(topics::ScheduleState).unwrap();
    for epoch in 1..50 {
        publish(&publisher, epoch);
        until("each sample", || samples.take().unwrap().filter(|sample| sample.header().epoch == epoch));
    }
    let command = bus.command_client(Daemon::IfcIngest).unwrap().send(b"load").unwrap();
    until("an answer", || command.take().err());
    assert_eq!(read_frame(&mut slow).0, WELCOME);
    slow.write_all(rest).unwrap();
    assert_eq!(read_frame(&mut slow).0, REPORT);
}

#[test]
fn descriptors_that_a_client_attaches_are_closed() {
    let fixture = Fixture::start();
    let mut raw = fixture.raw(VIEW_SOCKET);
    raw.write_all(&greeting()).unwrap();
    assert_eq!(read_frame(&mut raw).0, WELCOME);
    let (attached, mut other_end) = UnixStream::pair().unwrap();
    let descriptors = [attached.as_fd()];
    let mut space = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(1))];
    let mut control = SendAncillaryBuffer::new(&mut space);
    assert!(control.push(SendAncillaryMessage::ScmRights(&descriptors)));
    // Half a frame: nothing follows it.
    sendmsg(&raw, &[IoSlice::new(&frame(ASK_REPORT, 0, 0)[..5])], &mut control, SendFlags::empty()).unwrap();
    drop(attached);
    other_end.set_read_timeout(Some(DEADLINE)).unwrap();
    assert_eq!(other_end.read(&mut [0]).unwrap(), 0, "nobody has the other end open");
}

#[test]
fn one_client_too_many_is_told_so() {
    let fixture = Fixture::start();
    let clients: Vec<_> = (0..MAX_CONNECTIONS_OF_USER).map(|_| fixture.client()).collect();
    let refused = Bus::join_by_relay(&fixture.domain, Daemon::Groundplan, own()).map(drop).unwrap_err();
    assert!(refused.to_string().contains("serves 16 clients of this user already"), "{refused}");
    fixture.wait_for_event("TurnedAway");
    drop(clients);
    fixture.client();
}

#[test]
fn one_sample_of_a_topic_is_on_its_way_whatever_a_client_says() {
    let fixture = Fixture::start();
    let producer = Attended::join(&fixture.domain, Daemon::ScheduleEval);
    let publisher = producer.bus.publisher(topics::ScheduleState, 4096).unwrap();
    publish(&publisher, 1);
    let mut raw = fixture.raw(VIEW_SOCKET);
    raw.write_all(&[greeting(), frame(SUBSCRIBE, 0, STATES)].concat()).unwrap();
    assert_eq!((read_frame(&mut raw).0, read_frame(&mut raw).0), (WELCOME, SAMPLE));
    let (bus, _waiter) = fixture.client();
    let samples = bus.subscriber(topics::ScheduleState).unwrap();
    publish(&publisher, 2);
    until("the second", || samples.take().unwrap().filter(|sample| sample.header().epoch == 2));
    let again = [frame(UNSUBSCRIBE, 0, STATES), frame(SUBSCRIBE, 0, STATES), frame(ASK_REPORT, 0, 0)].concat();
    for _ in 0..3 {
        // The first sample is not taken, so that after each answer no other one comes.
        raw.write_all(&again).unwrap();
        assert_eq!(read_frame(&mut raw).0, REPORT);
    }
    raw.write_all(&frame(TAKEN, 0, STATES)).unwrap();
    let (kind, header) = read_frame(&mut raw);
    let header: messages::SampleHeader = bytemuck::pod_read_unaligned(&header);
    assert_eq!((kind, header.epoch), (SAMPLE, 2));
}

#[test]
fn outdated_samples_count_while_a_client_does_not_take_them() {
    let fixture = Fixture::start();
    let producer = Attended::join(&fixture.domain, Daemon::ScheduleEval);
    let publisher = producer.bus.publisher(topics::ScheduleState, 4096).unwrap();
    let (bus, _waiter) = Bus::join_as_owner(&fixture.domain, Daemon::Groundplan).unwrap();
    let (near, mut far) = UnixStream::pair().unwrap();
    let mut connection = Connection::new(near, own(), false);
    let (mut feeds, mut report) = (Feeds::default(), Reports::new(Box::new(|_| Vec::new())));
    let mut say = |connection: &mut Connection, feeds: &mut Feeds, bytes: &[u8]| {
        far.write_all(bytes).unwrap();
        connection.receive().unwrap();
        let welcome = FromRelay::Welcome { generation: 1, may_command: false, control_group: String::new() };
        connection.handle(welcome, &bus, feeds, &mut report, &mut |_| {}).unwrap();
    };
    let take_beyond = |feeds: &mut Feeds, last: u64| {
        until("a sample", || {
            feeds.take(|_| true, Instant::now(), &mut |event| panic!("{event:?}"));
            feeds.newer(OfRobot::new(None, TopicName::ScheduleState), last)
        })
    };
    say(&mut connection, &mut feeds, &[greeting(), frame(SUBSCRIBE, 0, STATES)].concat());
    publish(&publisher, 1);
    let (first, _) = take_beyond(&mut feeds, 0);
    connection.send(Some(&feeds)).unwrap();
    let (now, later) = (Instant::now(), Instant::now() + 2 * TAKE_TIMEOUT);
    assert_eq!(connection.outdated(&feeds, later).count(), 0, "the relay has the newest one itself");
    publish(&publisher, 2);
    take_beyond(&mut feeds, first);
    assert_eq!(connection.outdated(&feeds, now).count(), 0, "it may take a moment");
    let say_nothing_of_it = [frame(UNSUBSCRIBE, 0, STATES), frame(SUBSCRIBE, 0, STATES)].concat();
    say(&mut connection, &mut feeds, &say_nothing_of_it);
    let outdated: Vec<_> = connection.outdated(&feeds, later).collect();
    assert!(matches!(outdated[..], [((TopicName::ScheduleState, number), 1..)] if number == first), "{outdated:?}");
    say(&mut connection, &mut feeds, &frame(TAKEN, 0, STATES));
    assert_eq!(connection.outdated(&feeds, later).count(), 0);
}
