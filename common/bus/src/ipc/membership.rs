//! A participant in a generation of a domain.

use super::event_port::EventPort;
use super::node::{check_memory, node, refused, require_memory};
use super::{memory, services};
use crate::error::{DomainError, PortError};
use crate::file_lock::{FileIdentity, Lock};
use crate::generation::Place;
use crate::limits::MAX_NODES;
use crate::names::Daemon;
use crate::robot_name::OfRobot;
use crate::signal::Signal;
use crate::wakeup::{EventService, Wakeup};
use iceoryx2::node::Node;
use iceoryx2::service::builder::event::EventOpenError;
use iceoryx2::service::ipc_threadsafe::Service;
use rustix::fs::inotify;
use std::collections::BTreeMap;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError, Weak};
use std::time::{Duration, Instant};

/// Interval at which a participant looks whether its generation is still there.
const LOOK_INTERVAL: Duration = Duration::from_secs(1);

/// How often a participant starts again because the generation changed while it joined.
const MAX_JOIN_ATTEMPTS: usize = 8;

/// A publisher that delivers its last sample to late joiners.
pub(super) trait Latches: Send + Sync {
    /// Puts the last sample into the queues of subscribers that have come since.
    fn serve_late_joiners(&self);
    /// The event port of its daemon.
    fn event_port(&self) -> Arc<EventPort>;
    /// The segment that it lends samples from.
    fn segment(&self) -> &Path;
}

/// A participant in a generation of a domain.
pub(crate) struct Membership {
    pub(super) node: Node<Service>,
    place: Place,
    generation: u64,
    /// True for a robot's program, which leaves places to daemons and commands.
    pub(super) is_guest: bool,
    event_ports: Mutex<BTreeMap<EventService, Arc<EventPort>>>,
    pub(super) writers: Mutex<Vec<Weak<dyn Latches>>>,
    event_ports_added: Signal,
    changes: OwnedFd,
    superseded: AtomicBool,
    last_look: Mutex<Instant>,
    /// Last, so that it outlives all of the above: a generation without holders of this lock is removed.
    member_lock: Lock,
}

impl Membership {
    /// Joins the current generation.
    pub(crate) fn join(place: &Place, daemon: OfRobot<Daemon>) -> Result<Arc<Self>, DomainError> {
        require_memory()?;
        let no_keeper = || DomainError::NoKeeper { root: place.root().display().to_string() };
        if !place.root().exists() {
            return Err(no_keeper());
        }
        // Before the first look at the generation: a change in between is then seen as one.
        let changes = watch(place)?;
        let event_ports_added =
            Signal::new().map_err(|source| DomainError::File { path: place.root().to_owned(), source })?;
        for _ in 0..MAX_JOIN_ATTEMPTS {
            let generation = place.current()?.ok_or_else(no_keeper)?;
            if daemon.what != Daemon::Robot {
                place.require_own_build()?;
            }
            let member_lock = place.join_members(generation)?;
            if place.current()? != Some(generation) {
                continue;
            }
            let node = node(place, generation, daemon.what.name())?;
            let membership = Self {
                node,
                place: place.clone(),
                generation,
                is_guest: daemon.what == Daemon::Robot,
                event_ports: Mutex::default(),
                writers: Mutex::default(),
                event_ports_added,
                changes,
                superseded: AtomicBool::new(false),
                last_look: Mutex::new(Instant::now()),
                member_lock,
            };
            // One service tells whether the keeper's are there at all.
            let own = services::event(&membership.node, EventService::Of(daemon)).open();
            return match own {
                Ok(_) => Ok(Arc::new(membership)),
                Err(EventOpenError::DoesNotExist) => Err(no_keeper()),
                Err(EventOpenError::ExceedsMaxNumberOfNodes) => Err(DomainError::Full { max: MAX_NODES }),
                Err(e) => Err(refused("bus", e)),
            };
        }
        Err(refused("bus", "the generation changes without end"))
    }

    pub(crate) fn generation(&self) -> u64 {
        self.generation
    }

    /// True from the moment that another generation is current.
    pub(crate) fn is_superseded(&self) -> bool {
        self.superseded.load(Ordering::Relaxed)
    }

    /// The segment from which a publisher of this participant, by its number, lends samples.
    pub(super) fn segment_of(&self, publisher: u128) -> Result<PathBuf, DomainError> {
        let suffix = format!("_{publisher}__mgmt.data");
        let found = self.place.segments_of(self.generation, &suffix)?.pop();
        found.ok_or_else(|| refused("segment of a publisher", "it was deleted as soon as it was made"))
    }

    /// Raised when an event port was opened: a waiting thread must listen to it too.
    pub(crate) fn event_ports_added(&self) -> &Signal {
        &self.event_ports_added
    }

    /// Readable when the domain's folder changed.
    pub(crate) fn changes(&self) -> BorrowedFd<'_> {
        self.changes.as_fd()
    }

    /// Looks what changed; true if this generation was the current one until now.
    pub(crate) fn read_changes(&self) -> bool {
        let mut buffer = [0u8; 4096];
        while rustix::io::read(&self.changes, &mut buffer).is_ok_and(|n| n > 0) {}
        self.look()
    }

    /// As [`Membership::read_changes`], at most once a second: what was deleted may have taken the watch with it. Asks for
    /// another generation when a segment of this participant was deleted.
    pub(crate) fn look_at_times(&self) -> bool {
        let mut last_look = self.last_look.lock().unwrap_or_else(PoisonError::into_inner);
        if last_look.elapsed() < LOOK_INTERVAL {
            return false;
        }
        *last_look = Instant::now();
        let writers = self.writers.lock().unwrap_or_else(PoisonError::into_inner);
        for writer in writers.iter().filter_map(Weak::upgrade) {
            if FileIdentity::at(writer.segment()).is_ok_and(|found| found.is_none()) {
                // What cannot be asked now is asked at the next look.
                let _ = self.place.ask_for_renewal(self.generation, writer.segment());
                break;
            }
        }
        drop(writers);
        self.look()
    }

    /// True if this generation was the current one until now.
    fn look(&self) -> bool {
        // A file that cannot be read is no news: the keeper's next change rings again.
        let is_other = self.place.current().is_ok_and(|now| now != Some(self.generation));
        // A folder that was deleted and made again counts generations anew; this one's lock is then another.
        let lock = self.member_lock.identity().ok();
        let is_lost = FileIdentity::at(&self.place.lock_path(self.generation)).is_ok_and(|found| found != lock);
        (is_other || is_lost) && !self.superseded.swap(true, Ordering::Relaxed)
    }

    /// The event port of a service, opened once.
    pub(crate) fn event_port(&self, name: EventService) -> Result<Arc<EventPort>, PortError> {
        let mut event_ports = self.event_ports.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(event_port) = event_ports.get(&name) {
            return Ok(Arc::clone(event_port));
        }
        check_memory()?;
        let event_port = Arc::new(EventPort::open(&self.node, name, self.is_guest)?);
        event_ports.insert(name, Arc::clone(&event_port));
        self.event_ports_added.raise();
        Ok(event_port)
    }

    /// All bells that are open.
    pub(crate) fn event_ports(&self) -> Vec<(EventService, Arc<EventPort>)> {
        let event_ports = self.event_ports.lock().unwrap_or_else(PoisonError::into_inner);
        event_ports.iter().map(|(name, event_port)| (*name, Arc::clone(event_port))).collect()
    }

    /// Delivers the last samples of this participant's topics to late joiners, who asked for them on these event ports.
    pub(crate) fn serve_late_joiners(&self, asked_on: &[Arc<EventPort>]) {
        // In a full memory a late joiner cannot be connected; it is served with the next sample or late joiner.
        if memory::free_bytes() < memory::RESERVE_BYTES / 2 {
            return;
        }
        let mut writers = self.writers.lock().unwrap_or_else(PoisonError::into_inner);
        writers.retain(|w| w.strong_count() > 0);
        let live: Vec<Arc<dyn Latches>> = writers.iter().filter_map(Weak::upgrade).collect();
        for event_port in asked_on {
            let mut told = live.iter().filter(|writer| Arc::ptr_eq(&writer.event_port(), event_port)).peekable();
            if told.peek().is_some() {
                told.for_each(|writer| writer.serve_late_joiners());
                event_port.notify(Wakeup::Data);
            }
        }
    }
}

fn watch(place: &Place) -> Result<OwnedFd, DomainError> {
    let failed = |e: rustix::io::Errno| DomainError::File { path: place.current_path(), source: e.into() };
    let changes = inotify::init(inotify::CreateFlags::CLOEXEC | inotify::CreateFlags::NONBLOCK).map_err(failed)?;
    let what = inotify::WatchFlags::MOVED_TO
        | inotify::WatchFlags::DELETE
        | inotify::WatchFlags::DELETE_SELF
        | inotify::WatchFlags::MOVE_SELF;
    inotify::add_watch(&changes, place.root(), what).map_err(failed)?;
    Ok(changes)
}
