//! A relay whose process has no descriptor left. A test binary of its own: the limit is that of the whole process.

#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

mod common;

use bus::{Keeper, Relay, RelayEvent, RelayOptions};
use common::{DEADLINE, Fixture, eventually};
use rustix::net::{AddressFamily, SocketAddrUnix, SocketType, connect, socket};
use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
use rustix::time::{ClockId, clock_gettime};
use std::io::{Read, Write};
use std::os::fd::{AsRawFd, OwnedFd};
use std::os::unix::net::UnixStream;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// What the relay did, as its thread sees it.
#[derive(Default)]
struct Log {
    events: Vec<String>,
    n_ticks: u32,
    processor_time: Duration,
}

/// Ends the relay's thread, also when the test fails.
struct Ends<'a>(&'a AtomicBool);

impl Drop for Ends<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// Says which version it is, and waits until it is welcome.
fn greet(socket: OwnedFd) {
    let mut socket = UnixStream::from(socket);
    let numbers = [1, 8, 0, 0, u32::from_le_bytes(*b"GPRL"), messages::LAYOUT_VERSION];
    socket.write_all(&numbers.map(u32::to_ne_bytes).concat()).unwrap();
    socket.set_read_timeout(Some(DEADLINE)).unwrap();
    let mut kind = [0; 4];
    socket.read_exact(&mut kind).unwrap();
    assert_eq!(u32::from_ne_bytes(kind), 101);
}

#[test]
fn clients_wait_while_there_is_no_descriptor_and_the_relay_rests() {
    let fixture = Fixture::shared();
    let _keeper = Keeper::start(&fixture.domain).unwrap();
    let options = RelayOptions { view_group: None, control_group: None, report: Box::new(|_| Vec::new()) };
    let (mut relay, _) = Relay::open(&fixture.domain, options).unwrap();
    let address = SocketAddrUnix::new(relay.folder().join("view.sock")).unwrap();
    let (log, ends) = (Mutex::new(Log::default()), AtomicBool::new(false));
    std::thread::scope(|scope| {
        scope.spawn(|| {
            while !ends.load(Ordering::Relaxed) {
                let mut on_event = |event: RelayEvent<'_>| log.lock().unwrap().events.push(format!("{event:?}"));
                relay.serve(Duration::from_millis(50), &mut on_event).unwrap();
                let used = Duration::try_from(clock_gettime(ClockId::ThreadCPUTime)).unwrap();
                let mut log = log.lock().unwrap();
                (log.n_ticks, log.processor_time) = (log.n_ticks + 1, used);
            }
        });
        let _ends = Ends(&ends);
        let [first, second] = [0; 2].map(|_| socket(AddressFamily::UNIX, SocketType::STREAM, None).unwrap());
        connect(&first, &address).unwrap();
        greet(first);

        let usual = getrlimit(Resource::Nofile);
        let lowest_free = std::fs::File::open("/dev/null").unwrap().as_raw_fd();
        setrlimit(Resource::Nofile, Rlimit { current: Some(lowest_free as u64), ..usual }).unwrap();
        // A descriptor that the relay gave back since is taken, too.
        let taken: Vec<_> = std::iter::from_fn(|| std::fs::File::open("/dev/null").ok()).collect();
        connect(&second, &address).unwrap();
        let n_events = || log.lock().unwrap().events.iter().filter(|event| event.contains("NotAccepting")).count();
        eventually("the shortage", || (n_events() > 0).then_some(()));
        let look = || {
            let log = log.lock().unwrap();
            (log.n_ticks, log.processor_time)
        };
        let (begun, (ticks, used)) = (Instant::now(), look());
        let later = eventually("twenty ticks", || Some(look().1).filter(|_| look().0 > ticks + 20));
        assert!(later - used < begun.elapsed() / 2, "it does not turn round and round");
        assert_eq!(n_events(), 1, "it is told once");

        setrlimit(Resource::Nofile, usual).unwrap();
        drop(taken);
        greet(second);
    });
}
