//! Commands and streamed replies in the heap.

use super::{LocalBell, Membership};
use crate::bell::{Bell, BellName, Ring};
use crate::command::{MAX_OPEN, ReplyKind};
use crate::error::{CommandError, PortError};
use crate::ipc::REPLY_BUFFER;
use crate::names::Daemon;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError, Weak};

/// Commands that the server has not taken.
pub(super) type Queue = Mutex<VecDeque<Served>>;

type Replies = Mutex<VecDeque<(ReplyKind, Vec<u8>)>>;

fn bell(membership: &Membership, daemon: Daemon) -> Result<Arc<LocalBell>, PortError> {
    let failed = |e: std::io::Error| PortError::Refused { what: format!("command/{daemon}"), reason: e.to_string() };
    membership.bell(BellName::Of(daemon)).map_err(failed)
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The answering end of a daemon's commands.
pub(crate) struct Server {
    queue: Arc<Queue>,
    _membership: Arc<Membership>,
}

impl Server {
    pub(crate) fn open(membership: &Arc<Membership>, daemon: Daemon) -> Result<Self, PortError> {
        bell(membership, daemon)?;
        let mut state = membership.hub.state();
        let server = state.servers.entry(daemon).or_default();
        if server.strong_count() > 0 {
            return Err(PortError::Taken { what: format!("command/{daemon}") });
        }
        let queue = Arc::default();
        *server = Arc::downgrade(&queue);
        drop(state);
        Ok(Self { queue, _membership: Arc::clone(membership) })
    }

    pub(crate) fn receive(&self) -> Option<Served> {
        lock(&self.queue).pop_front()
    }
}

/// A command that is being carried out. The client sees its end when this half of the replies goes away.
pub(crate) struct Served {
    bytes: Vec<u8>,
    replies: Weak<Replies>,
    /// Before the bell: the client is woken when it is closed.
    _open: Arc<()>,
    bell: RingAtEnd,
}

struct RingAtEnd(Arc<LocalBell>);

impl Drop for RingAtEnd {
    fn drop(&mut self) {
        self.0.ring(Ring::Reply);
    }
}

impl Served {
    pub(crate) fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    pub(crate) fn is_cancelled(&self) -> bool {
        self.replies.strong_count() == 0
    }

    pub(crate) fn reply(&self, kind: ReplyKind, bytes: &[u8]) {
        let Some(replies) = self.replies.upgrade() else { return };
        let mut replies = lock(&replies);
        if replies.len() == REPLY_BUFFER {
            replies.pop_front();
        }
        replies.push_back((kind, bytes.to_vec()));
        drop(replies);
        self.bell.0.ring(Ring::Reply);
    }
}

/// The asking end of a daemon's commands.
pub(crate) struct Client {
    bell: Arc<LocalBell>,
    daemon: Daemon,
    open: Arc<()>,
    membership: Arc<Membership>,
}

impl Client {
    pub(crate) fn open(membership: &Arc<Membership>, daemon: Daemon) -> Result<Self, PortError> {
        Ok(Self { bell: bell(membership, daemon)?, daemon, open: Arc::default(), membership: Arc::clone(membership) })
    }

    pub(crate) fn send(&self, bytes: &[u8]) -> Result<Exchange, CommandError> {
        if Arc::strong_count(&self.open) > MAX_OPEN {
            return Err(CommandError::TooMany { daemon: self.daemon });
        }
        let queue = self.membership.hub.state().servers.get(&self.daemon).and_then(Weak::upgrade);
        let queue = queue.ok_or(CommandError::NotServed { daemon: self.daemon })?;
        let replies: Arc<Replies> = Arc::default();
        let served = Arc::new(());
        lock(&queue).push_back(Served {
            bytes: bytes.to_vec(),
            replies: Arc::downgrade(&replies),
            _open: Arc::clone(&served),
            bell: RingAtEnd(Arc::clone(&self.bell)),
        });
        self.bell.ring(Ring::Command);
        Ok(Exchange { replies, served: Arc::downgrade(&served), daemon: self.daemon, _open: Arc::clone(&self.open) })
    }
}

/// A command that waits for its replies.
pub(crate) struct Exchange {
    replies: Arc<Replies>,
    served: Weak<()>,
    daemon: Daemon,
    _open: Arc<()>,
}

impl Exchange {
    pub(crate) fn receive(&self) -> Result<Option<(ReplyKind, Vec<u8>)>, CommandError> {
        // Asked first: a server that answers and goes away between the two looks has answered.
        let served = self.served.strong_count() > 0;
        match lock(&self.replies).pop_front() {
            None if !served => Err(CommandError::Lost { daemon: self.daemon }),
            reply => Ok(reply),
        }
    }
}
