//! A participant in a generation of a domain.

use super::bell::Bell;
use super::node::{check_memory, node, refused, require_memory};
use super::{memory, services};
use crate::bell::{BellName, Ring};
use crate::error::{DomainError, PortError};
use crate::generation::{CURRENT, Lock, Place};
use crate::names::Daemon;
use crate::signal::Signal;
use iceoryx2::node::Node;
use iceoryx2::service::ipc_threadsafe::Service;
use rustix::fs::inotify;
use std::collections::BTreeMap;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError, Weak};

/// How often a participant starts again because the generation changed while it joined.
const MAX_JOIN_ATTEMPTS: usize = 8;

/// A publishing end, which gives newcomers its last sample.
pub(super) trait Latches: Send + Sync {
    /// Puts the last sample into the queues of subscribers that have come since.
    fn serve_newcomers(&self);
    /// The bell of its daemon.
    fn bell(&self) -> Arc<Bell>;
}

/// A participant in a generation of a domain.
pub(crate) struct Membership {
    pub(super) node: Node<Service>,
    place: Place,
    generation: u64,
    bells: Mutex<BTreeMap<BellName, Arc<Bell>>>,
    pub(super) writers: Mutex<Vec<Weak<dyn Latches>>>,
    more_bells: Signal,
    changes: OwnedFd,
    superseded: AtomicBool,
    /// Last, so that it outlives all of the above: a generation is removed when nobody holds this.
    _life: Lock,
}

impl Membership {
    /// Joins the current generation.
    pub(crate) fn join(place: &Place, daemon: Daemon) -> Result<Arc<Self>, DomainError> {
        require_memory()?;
        let no_keeper = || DomainError::NoKeeper { root: place.root().display().to_string() };
        if !place.root().exists() {
            return Err(no_keeper());
        }
        // Before the first look at the generation: a change in between is then seen as one.
        let changes = watch(place)?;
        let more_bells = Signal::new().map_err(|source| DomainError::File { path: place.root().to_owned(), source })?;
        for _ in 0..MAX_JOIN_ATTEMPTS {
            let generation = place.current()?.ok_or_else(no_keeper)?;
            let life = place.live_in(generation)?;
            if place.current()? != Some(generation) {
                continue;
            }
            let node = node(place, generation, daemon.name())?;
            let membership = Self {
                node,
                place: place.clone(),
                generation,
                bells: Mutex::default(),
                writers: Mutex::default(),
                more_bells,
                changes,
                superseded: AtomicBool::new(false),
                _life: life,
            };
            // One service tells whether the keeper's are there at all.
            let own = services::bell(&membership.node, daemon.name()).open();
            return match own {
                Ok(_) => Ok(Arc::new(membership)),
                Err(iceoryx2::service::builder::event::EventOpenError::DoesNotExist) => Err(no_keeper()),
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

    /// Raised when a bell was opened: whoever waits must listen to it too.
    pub(crate) fn more_bells(&self) -> &Signal {
        &self.more_bells
    }

    /// Readable when the domain's folder changed.
    pub(crate) fn changes(&self) -> BorrowedFd<'_> {
        self.changes.as_fd()
    }

    /// Looks what changed; true if this generation was the current one until now.
    pub(crate) fn look_at_changes(&self) -> bool {
        let mut buffer = [0u8; 4096];
        while rustix::io::read(&self.changes, &mut buffer).is_ok_and(|n| n > 0) {}
        // A file that cannot be read is no news: the keeper's next change rings again.
        let gone = self.place.current().is_ok_and(|now| now != Some(self.generation));
        gone && !self.superseded.swap(true, Ordering::Relaxed)
    }

    /// The bell of a daemon, opened once.
    pub(crate) fn bell(&self, name: BellName) -> Result<Arc<Bell>, PortError> {
        let mut bells = self.bells.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(bell) = bells.get(&name) {
            return Ok(Arc::clone(bell));
        }
        check_memory()?;
        let bell = Arc::new(Bell::open(&self.node, name)?);
        bells.insert(name, Arc::clone(&bell));
        self.more_bells.raise();
        Ok(bell)
    }

    /// All bells that are open.
    pub(crate) fn bells(&self) -> Vec<(BellName, Arc<Bell>)> {
        let bells = self.bells.lock().unwrap_or_else(PoisonError::into_inner);
        bells.iter().map(|(name, bell)| (*name, Arc::clone(bell))).collect()
    }

    /// Gives newcomers the last samples of this participant's topics.
    pub(crate) fn serve_newcomers(&self) {
        // In a full memory the connection of a newcomer cannot be made; it is served with the next sample or newcomer.
        if memory::free_bytes() < memory::RESERVE_BYTES / 2 {
            return;
        }
        let mut writers = self.writers.lock().unwrap_or_else(PoisonError::into_inner);
        writers.retain(|w| w.strong_count() > 0);
        let mut bell = None;
        for writer in writers.iter().filter_map(Weak::upgrade) {
            writer.serve_newcomers();
            bell = Some(writer.bell());
        }
        if let Some(bell) = bell {
            bell.ring(Ring::Data);
        }
    }
}

fn watch(place: &Place) -> Result<OwnedFd, DomainError> {
    let failed = |e: rustix::io::Errno| DomainError::File { path: place.root().join(CURRENT), source: e.into() };
    let changes = inotify::init(inotify::CreateFlags::CLOEXEC | inotify::CreateFlags::NONBLOCK).map_err(failed)?;
    let what = inotify::WatchFlags::MOVED_TO | inotify::WatchFlags::DELETE;
    inotify::add_watch(&changes, place.root(), what).map_err(failed)?;
    Ok(changes)
}
