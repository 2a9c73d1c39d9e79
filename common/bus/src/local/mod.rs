//! The double of the bus inside one process: heap memory instead of shared memory, the same behaviour.

mod command;
mod latched;
mod status;

pub(crate) use command::{Client, Exchange, Served, Server};
pub(crate) use latched::{Memory, TopicReader, TopicSample, TopicWriter};
pub(crate) use status::{StatusSource, StatusTarget};

use crate::bell::{Bell, BellName, Ring, Rings};
use crate::error::DomainError;
use crate::names::{Daemon, Topic};
use crate::signal::Signal;
use std::collections::BTreeMap;
use std::os::fd::BorrowedFd;
use std::sync::atomic::{AtomicU8, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

/// What the participants of a double share.
pub(crate) struct Hub {
    memory_bytes_max: u64,
    memory_bytes: AtomicU64,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    generation: u64,
    kept: bool,
    topics: BTreeMap<Topic, latched::Slot>,
    status_readers: Vec<Weak<status::Queue>>,
    servers: BTreeMap<Daemon, Weak<command::Queue>>,
    listeners: Vec<(BellName, Weak<LocalBell>)>,
    members: Vec<Weak<Membership>>,
}

impl Hub {
    pub(crate) fn new(memory_bytes_max: u64) -> Arc<Self> {
        Arc::new(Self { memory_bytes_max, memory_bytes: AtomicU64::new(0), state: Mutex::default() })
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn name(&self) -> String {
        "in process".to_owned()
    }

    fn free_bytes(&self) -> u64 {
        self.memory_bytes_max.saturating_sub(self.memory_bytes.load(Ordering::Acquire))
    }

    fn ring(&self, name: BellName, ring: Ring) {
        let mut state = self.state();
        state.listeners.retain(|(_, bell)| bell.strong_count() > 0);
        let bells: Vec<_> =
            state.listeners.iter().filter(|(n, _)| *n == name).filter_map(|(_, bell)| bell.upgrade()).collect();
        drop(state);
        for bell in bells {
            bell.rings.fetch_or(1 << ring as u8, Ordering::AcqRel);
            bell.signal.raise();
        }
    }
}

/// The keeper of a double.
pub(crate) struct Services {
    hub: Arc<Hub>,
    generation: u64,
}

impl Services {
    pub(crate) fn create(hub: &Arc<Hub>) -> Result<Self, DomainError> {
        let mut state = hub.state();
        if state.kept {
            return Err(DomainError::KeeperRuns { root: hub.name() });
        }
        state.kept = true;
        state.generation += 1;
        let generation = state.generation;
        drop(state);
        Ok(Self { hub: Arc::clone(hub), generation })
    }

    pub(crate) fn generation(&self) -> u64 {
        self.generation
    }
}

impl Drop for Services {
    fn drop(&mut self) {
        let mut state = self.hub.state();
        state.kept = false;
        let members: Vec<_> = std::mem::take(&mut state.members).iter().filter_map(Weak::upgrade).collect();
        drop(state);
        for member in members {
            member.changes.raise();
        }
    }
}

/// A participant.
pub(crate) struct Membership {
    hub: Arc<Hub>,
    generation: u64,
    bells: Mutex<BTreeMap<BellName, Arc<LocalBell>>>,
    more_bells: Signal,
    changes: Signal,
    superseded: std::sync::atomic::AtomicBool,
}

impl Membership {
    pub(crate) fn join(hub: &Arc<Hub>) -> Result<Arc<Self>, DomainError> {
        let signal = || Signal::new().map_err(|source| DomainError::File { path: "eventfd".into(), source });
        let (changes, more_bells) = (signal()?, signal()?);
        let mut state = hub.state();
        if !state.kept {
            return Err(DomainError::NoKeeper { root: hub.name() });
        }
        let membership = Arc::new(Self {
            hub: Arc::clone(hub),
            generation: state.generation,
            bells: Mutex::default(),
            more_bells,
            changes,
            superseded: false.into(),
        });
        state.members.push(Arc::downgrade(&membership));
        Ok(membership)
    }

    pub(crate) fn generation(&self) -> u64 {
        self.generation
    }

    pub(crate) fn is_superseded(&self) -> bool {
        self.superseded.load(Ordering::Relaxed)
    }

    pub(crate) fn more_bells(&self) -> &Signal {
        &self.more_bells
    }

    pub(crate) fn changes(&self) -> BorrowedFd<'_> {
        self.changes.descriptor()
    }

    pub(crate) fn look_at_changes(&self) -> bool {
        self.changes.clear();
        let state = self.hub.state();
        let gone = !state.kept || state.generation != self.generation;
        gone && !self.superseded.swap(true, Ordering::Relaxed)
    }

    /// The bell of a daemon, opened once.
    pub(crate) fn bell(&self, name: BellName) -> std::io::Result<Arc<LocalBell>> {
        let mut bells = self.bells.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(bell) = bells.get(&name) {
            return Ok(Arc::clone(bell));
        }
        let bell =
            Arc::new(LocalBell { hub: Arc::clone(&self.hub), name, rings: AtomicU8::new(0), signal: Signal::new()? });
        self.hub.state().listeners.push((name, Arc::downgrade(&bell)));
        bells.insert(name, Arc::clone(&bell));
        self.more_bells.raise();
        Ok(bell)
    }

    /// All bells that are open.
    pub(crate) fn bells(&self) -> Vec<(BellName, Arc<dyn Bell>)> {
        let bells = self.bells.lock().unwrap_or_else(PoisonError::into_inner);
        bells.iter().map(|(name, bell)| (*name, Arc::clone(bell) as Arc<dyn Bell>)).collect()
    }
}

/// A bell in the heap.
pub(crate) struct LocalBell {
    hub: Arc<Hub>,
    name: BellName,
    rings: AtomicU8,
    signal: Signal,
}

impl Bell for LocalBell {
    fn descriptor(&self) -> BorrowedFd<'_> {
        self.signal.descriptor()
    }

    fn look(&self) -> Rings {
        // In this order a ring in between is seen at the next look.
        self.signal.clear();
        Rings(self.rings.swap(0, Ordering::AcqRel))
    }

    fn ring(&self, ring: Ring) {
        self.hub.ring(self.name, ring);
    }
}
