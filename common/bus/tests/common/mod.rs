//! Private domains and waiting for conditions, for the tests of the bus.

#![allow(dead_code, reason = "each test file takes what it needs")]

use bus::{
    Bus, Daemon, Domain, GridSlot, InProcessBus, Origin, Publisher, Sample, Stopper, Subscriber, Topic, Waiter, topics,
};
use messages::{ArchiveBuffer, ContentHash, InputHashes, ScheduleStateBuilder};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// The one deadline of every wait: far beyond what any machine needs.
pub(crate) const DEADLINE: Duration = Duration::from_secs(60);

/// A domain of its own in shared memory.
pub(crate) struct Fixture {
    pub(crate) domain: Domain,
    prefix: String,
    folder: tempfile::TempDir,
}

impl Fixture {
    pub(crate) fn shared() -> Self {
        static COUNTER: AtomicU32 = AtomicU32::new(0);
        let prefix = format!("gt{:x}x{:x}_", std::process::id(), COUNTER.fetch_add(1, Ordering::Relaxed));
        // In memory, as `/run` is: the bus library syncs each of its files, and a keeper creates hundreds.
        let folder = tempfile::Builder::new().prefix("bus").tempdir_in("/dev/shm").unwrap();
        let domain = Domain::shared(&prefix, folder.path()).unwrap();
        Self { domain, prefix, folder }
    }

    pub(crate) fn root(&self) -> &Path {
        self.folder.path()
    }

    pub(crate) fn prefix(&self) -> &str {
        &self.prefix
    }

    /// Segments of this domain in shared memory.
    pub(crate) fn segments(&self) -> Vec<PathBuf> {
        let entries = std::fs::read_dir("/dev/shm").unwrap().map(|e| e.unwrap());
        entries.filter(|e| e.file_name().to_string_lossy().starts_with(&self.prefix)).map(|e| e.path()).collect()
    }
}

impl Drop for Fixture {
    fn drop(&mut self) {
        // Without a relay there is none.
        let _ = std::fs::remove_dir_all(self.domain.relay_folder());
        for segment in self.segments() {
            let _ = std::fs::remove_file(segment);
        }
    }
}

/// A participant whose waiter runs in a thread, as a daemon's does; stopped when dropped. Inside one process it needs none.
pub(crate) struct Attended {
    pub(crate) bus: Bus,
    waiting: Option<(Stopper, JoinHandle<()>)>,
}

impl Attended {
    pub(crate) fn join(domain: &Domain, daemon: Daemon) -> Self {
        let (bus, mut waiter) = Bus::join(domain, daemon).unwrap();
        let stopper = waiter.stopper();
        let thread = std::thread::spawn(move || while !waiter.wait(DEADLINE).unwrap().stopped {});
        Self { bus, waiting: Some((stopper, thread)) }
    }

    pub(crate) fn in_process(bus: &InProcessBus, daemon: Daemon) -> Self {
        Self { bus: Bus::in_process(bus, daemon), waiting: None }
    }
}

impl Drop for Attended {
    fn drop(&mut self) {
        if let Some((stopper, thread)) = self.waiting.take() {
            stopper.stop();
            thread.join().unwrap();
        }
    }
}

/// Waits for what is not there yet.
pub(crate) trait Wait {
    /// Returns when something may have come, or after this time.
    fn wait_for_more(&mut self, at_most: Duration);
}

impl Wait for Waiter {
    fn wait_for_more(&mut self, at_most: Duration) {
        self.wait(at_most).unwrap();
    }
}

/// Sleeps on the waiter until there is something.
pub(crate) fn until<T>(waiter: &mut impl Wait, what: &str, mut take: impl FnMut() -> Option<T>) -> T {
    let deadline = Instant::now() + DEADLINE;
    loop {
        if let Some(found) = take() {
            return found;
        }
        let left = deadline.saturating_duration_since(Instant::now());
        assert!(!left.is_zero(), "waited in vain for {what}");
        waiter.wait_for_more(left);
    }
}

/// Asks again and again, where nothing rings.
pub(crate) fn eventually<T>(what: &str, mut take: impl FnMut() -> Option<T>) -> T {
    let deadline = Instant::now() + DEADLINE;
    loop {
        if let Some(found) = take() {
            return found;
        }
        assert!(Instant::now() < deadline, "waited in vain for {what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// The next sample with this epoch.
pub(crate) fn sample_of<T: Topic>(waiter: &mut impl Wait, subscriber: &Subscriber<T>, epoch: u64) -> Sample<T> {
    until(waiter, &format!("epoch {epoch} of {}", subscriber.topic().name()), || {
        subscriber.take().unwrap().filter(|s| s.header().epoch == epoch)
    })
}

/// An archive of about `2 * n` bytes.
pub(crate) fn schedule_state(n: usize) -> ArchiveBuffer {
    ScheduleStateBuilder::everything_built(ContentHash::from_bits(n as u64), n, 1).finish()
}

pub(crate) fn origin(epoch: u64) -> Origin {
    Origin { epoch, frame_epoch: 1, inputs: InputHashes { site: ContentHash::from_bits(5), ..InputHashes::default() } }
}

pub(crate) fn publish(publisher: &Publisher<topics::ScheduleState>, epoch: u64, n: usize) {
    publisher.publish_copy(schedule_state(n).bytes(), origin(epoch)).unwrap();
}

pub(crate) fn grid(index: usize) -> topics::Grid {
    topics::Grid(GridSlot::new(index).unwrap())
}
