//! The bus in shared memory: the only module with unsafe code.
#![expect(unsafe_code, reason = "shared memory; every block says why it is sound")]

mod command;
mod latched;
mod memory;
mod services;
mod status;
mod wire;

pub(crate) use command::{Client, Exchange, Served, Server};
pub(crate) use latched::{Memory, TopicReader, TopicSample, TopicWriter};
pub(crate) use services::{REPLY_BUFFER, STATUS_BUFFER};
pub(crate) use status::{StatusSource, StatusTarget};

use crate::bell::{Bell, BellName, Ring, Rings};
use crate::error::{DomainError, PortError};
use crate::generation::{CURRENT, Lock, Place};
use crate::names::{Daemon, Topic};
use crate::signal::Signal;
use iceoryx2::config::Config;
use iceoryx2::node::node_name::NodeName;
use iceoryx2::node::{Node, NodeBuilder};
use iceoryx2::port::event_id::EventId;
use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::prelude::{FileDescriptorBased, FileName, LogLevel, Path, SemanticString, set_log_level};
use iceoryx2::service::ipc_threadsafe::Service;
use iceoryx2::signal_handling_mode::SignalHandlingMode;
use rustix::fs::inotify;
use std::collections::BTreeMap;
use std::fmt::Debug;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError, Weak};

/// How often a participant starts again because the generation changed while it joined.
const MAX_JOIN_ATTEMPTS: usize = 8;

/// A participant in a generation of a domain.
pub(crate) struct Membership {
    node: Node<Service>,
    place: Place,
    generation: u64,
    bells: Mutex<BTreeMap<BellName, Arc<IpcBell>>>,
    writers: Mutex<Vec<Weak<TopicWriter>>>,
    more_bells: Signal,
    changes: OwnedFd,
    superseded: AtomicBool,
    /// Last, so that it outlives all of the above: a generation is removed when nobody holds this.
    _life: Lock,
}

/// Checks that the small segments of a start can be made.
fn require_memory() -> Result<(), DomainError> {
    let free_bytes = memory::free_bytes();
    if free_bytes < memory::RESERVE_BYTES {
        return Err(DomainError::SharedMemoryFull { free_bytes, needed_bytes: memory::RESERVE_BYTES });
    }
    Ok(())
}

fn refused(what: impl Into<String>, reason: impl Debug) -> DomainError {
    DomainError::Refused { what: what.into(), reason: format!("{reason:?}") }
}

/// Configuration of a generation; never the library's own search, which depends on the working directory.
fn config(place: &Place, generation: u64) -> Result<Config, DomainError> {
    // The library's words about a failure come back in its errors; alone they would appear without a context.
    set_log_level(LogLevel::Fatal);
    let mut config = Config::default();
    let folder = place.folder_of(generation);
    let folder = folder.to_str().unwrap_or_default();
    config.global.prefix = FileName::new(place.prefix_of(generation).as_bytes()).map_err(|e| refused("prefix", e))?;
    config.global.set_root_path(&Path::new(folder.as_bytes()).map_err(|e| refused("folder", e))?);
    Ok(config)
}

fn node(place: &Place, generation: u64, name: &str) -> Result<Node<Service>, DomainError> {
    let name = format!("{name}-{}", std::process::id());
    let node = NodeBuilder::new()
        .name(&NodeName::new(&name).map_err(|e| refused("node name", e))?)
        .config(&config(place, generation)?)
        .signal_handling_mode(SignalHandlingMode::Disabled)
        .create::<Service>()
        .map_err(|e| refused("node", e))?;
    // Ports of a daemon that died would keep its successor out.
    node.try_cleanup_dead_nodes();
    Ok(node)
}

/// All services of a generation, held by the keeper.
pub(crate) struct Services {
    _topics: Vec<services::TopicService>,
    _status: services::StatusService,
    _commands: Vec<services::CommandService>,
    _bells: Vec<services::BellService>,
    node: Node<Service>,
    _life: Lock,
}

impl Services {
    /// Creates the services of a generation, or opens those that participants kept.
    pub(crate) fn create(place: &Place, generation: u64) -> Result<Self, DomainError> {
        require_memory()?;
        let life = place.live_in(generation)?;
        let node = node(place, generation, "keeper")?;
        let topics = Topic::all()
            .map(|t| services::topic(&node, t).open_or_create().map_err(|e| refused(format!("topic `{t}`"), e)));
        let topics = topics.collect::<Result<_, _>>()?;
        let status = services::status(&node).open_or_create().map_err(|e| refused("status stream", e))?;
        let commands = Daemon::ALL
            .map(|d| services::command(&node, d).open_or_create().map_err(|e| refused(format!("command/{d}"), e)));
        let commands = commands.into_iter().collect::<Result<_, _>>()?;
        let names = Daemon::ALL.map(BellName::Of).into_iter().chain([BellName::Status]);
        let bells = names
            .map(|n| services::bell(&node, n.text()).open_or_create().map_err(|e| refused(format!("bell/{n:?}"), e)));
        let bells = bells.collect::<Result<_, _>>()?;
        Ok(Self { _topics: topics, _status: status, _commands: commands, _bells: bells, node, _life: life })
    }

    /// Returns what dead participants left; the number of them.
    pub(crate) fn remove_dead(&self) -> u64 {
        self.node.try_cleanup_dead_nodes().cleanups
    }
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
    pub(crate) fn bell(&self, name: BellName) -> Result<Arc<IpcBell>, PortError> {
        let mut bells = self.bells.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(bell) = bells.get(&name) {
            return Ok(Arc::clone(bell));
        }
        check_memory()?;
        let bell = Arc::new(IpcBell::open(&self.node, name)?);
        bells.insert(name, Arc::clone(&bell));
        self.more_bells.raise();
        Ok(bell)
    }

    /// All bells that are open.
    pub(crate) fn bells(&self) -> Vec<(BellName, Arc<dyn Bell>)> {
        let bells = self.bells.lock().unwrap_or_else(PoisonError::into_inner);
        bells.iter().map(|(name, bell)| (*name, Arc::clone(bell) as Arc<dyn Bell>)).collect()
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

/// Opening a port makes small segments, which must find room.
fn check_memory() -> Result<(), PortError> {
    let free_bytes = memory::free_bytes();
    if free_bytes < memory::RESERVE_BYTES / 2 { Err(PortError::SharedMemoryFull { free_bytes }) } else { Ok(()) }
}

fn watch(place: &Place) -> Result<OwnedFd, DomainError> {
    let failed = |e: rustix::io::Errno| DomainError::File { path: place.root().join(CURRENT), source: e.into() };
    let changes = inotify::init(inotify::CreateFlags::CLOEXEC | inotify::CreateFlags::NONBLOCK).map_err(failed)?;
    let what = inotify::WatchFlags::MOVED_TO | inotify::WatchFlags::DELETE;
    inotify::add_watch(&changes, place.root(), what).map_err(failed)?;
    Ok(changes)
}

/// A bell in shared memory.
pub(crate) struct IpcBell {
    listener: Listener<Service>,
    notifier: Notifier<Service>,
}

impl IpcBell {
    fn open(node: &Node<Service>, name: BellName) -> Result<Self, PortError> {
        let what = || format!("bell/{}", name.text());
        let failed = |reason: String| PortError::Refused { what: what(), reason };
        let service = services::bell(node, name.text()).open().map_err(|e| failed(format!("{e:?}")))?;
        let listener = service.listener_builder().create().map_err(|e| failed(format!("{e:?}")))?;
        let notifier = service.notifier_builder().create().map_err(|e| failed(format!("{e:?}")))?;
        Ok(Self { listener, notifier })
    }
}

impl Bell for IpcBell {
    fn descriptor(&self) -> BorrowedFd<'_> {
        // SAFETY: the descriptor belongs to the listener, which is borrowed as long as the result and closes it only
        // when it is dropped.
        unsafe { BorrowedFd::borrow_raw(self.listener.file_descriptor().native_handle()) }
    }

    fn look(&self) -> Rings {
        let mut rings = Rings::default();
        // An error says that a wake-up cannot be read; whoever waits looks at its topics anyway.
        let _ = self.listener.try_wait(|event| {
            for number in [Ring::Data, Ring::Newcomer, Ring::Dead, Ring::Command, Ring::Reply] {
                if event.id == EventId::new(number as usize) {
                    rings.add(number as usize);
                }
            }
        });
        rings
    }

    fn ring(&self, ring: Ring) {
        let _ = self.notifier.notify_with_custom_event_id(EventId::new(ring as usize));
    }
}
