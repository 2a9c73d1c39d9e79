//! Ends of a link to a relay: a followed topic, heartbeats, commands and their replies.

use super::RelayLink;
use super::inbox::Slot;
use crate::error::{CommandError, ReceiveError};
use crate::names::{Daemon, TopicName};
use crate::relay_protocol::{ToRelay, read_sealed};
use crate::reply_kind::ReplyKind;
use messages::{ArchiveBuffer, SampleHeader, StatusRecord};
use std::collections::VecDeque;
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex, PoisonError};

/// A subscription to a topic.
pub(crate) struct TopicSubscription {
    pub(super) link: Arc<RelayLink>,
    pub(super) topic: TopicName,
    pub(super) slot: Arc<Slot>,
}

impl TopicSubscription {
    /// The newest sample that was not taken.
    pub(crate) fn receive(&self) -> Result<Option<CopiedSample>, ReceiveError> {
        self.link.receive_for_port();
        let refused = |reason: String| ReceiveError::Refused { what: self.topic.to_string(), reason };
        let sample = self.slot.lock().unwrap_or_else(PoisonError::into_inner).take();
        let Some(sample) = sample else {
            let mut inbox = self.link.lock();
            let reason = inbox.topics.get_mut(&self.topic).and_then(|topic| topic.refused.take());
            return reason.map_or(Ok(None), |reason| Err(refused(reason)));
        };
        let bytes = read_sealed(&*sample.memory, sample.header.payload_length);
        let bytes = bytes.map_err(|reason| refused(reason.to_string()))?;
        Ok(Some(CopiedSample { header: sample.header, bytes }))
    }
}

impl Drop for TopicSubscription {
    fn drop(&mut self) {
        let mut inbox = self.link.lock();
        let Some(followed) = inbox.topics.get_mut(&self.topic) else { return };
        let own = Arc::as_ptr(&self.slot);
        followed.subscriptions.retain(|slot| slot.strong_count() > 0 && slot.as_ptr() != own);
        if followed.subscriptions.is_empty() {
            inbox.topics.remove(&self.topic);
            // Before the inbox is given back, as in `subscribe`. A relay that is gone needs no word.
            let _ = self.link.send(&ToRelay::Unsubscribe(self.topic));
        }
    }
}

/// A sample that was copied out of the relay's memory.
pub(crate) struct CopiedSample {
    header: SampleHeader,
    bytes: ArchiveBuffer,
}

impl CopiedSample {
    pub(crate) fn header(&self) -> &SampleHeader {
        &self.header
    }

    pub(crate) fn bytes(&self) -> &[u8] {
        self.bytes.bytes()
    }
}

/// A subscription to heartbeats.
pub(crate) struct StatusSubscription {
    pub(super) link: Arc<RelayLink>,
    pub(super) records: Arc<Mutex<VecDeque<StatusRecord>>>,
}

impl StatusSubscription {
    pub(crate) fn receive(&self) -> Option<StatusRecord> {
        self.link.receive_for_port();
        self.records.lock().unwrap_or_else(PoisonError::into_inner).pop_front()
    }
}

/// Commands to a daemon.
pub(crate) struct CommandLink {
    pub(super) link: Arc<RelayLink>,
    pub(super) daemon: Daemon,
}

impl CommandLink {
    pub(crate) fn send(&self, bytes: &[u8]) -> Result<RelayedCommand, CommandError> {
        let (link, daemon) = (&self.link, self.daemon);
        let id = link.next_command.fetch_add(1, Ordering::Relaxed);
        link.lock().commands.insert(id, VecDeque::new());
        let command = RelayedCommand { link: Arc::clone(link), daemon, id };
        let sent = link.send(&ToRelay::Command { id, daemon, bytes: bytes.to_vec() });
        sent.map_err(|reason| CommandError::Refused { daemon, reason: format!("the relay of the bus: {reason}") })?;
        Ok(command)
    }
}

/// A command that waits for its replies; dropped, it is given up.
pub(crate) struct RelayedCommand {
    pub(super) link: Arc<RelayLink>,
    pub(super) daemon: Daemon,
    pub(super) id: u64,
}

impl RelayedCommand {
    pub(crate) fn receive(&self) -> Result<Option<(ReplyKind, Vec<u8>)>, CommandError> {
        self.link.receive_for_port();
        // Asked first: a relay that answers and goes away between the two looks has answered.
        let is_closed = self.link.is_closed();
        let reply = self.link.lock().commands.get_mut(&self.id).and_then(VecDeque::pop_front);
        match reply {
            Some(reply) => reply.map(Some),
            None if is_closed => Err(CommandError::Lost { daemon: self.daemon }),
            None => Ok(None),
        }
    }
}

impl Drop for RelayedCommand {
    fn drop(&mut self) {
        self.link.lock().commands.remove(&self.id);
        // A relay that is gone, or has answered, needs no word.
        let _ = self.link.send(&ToRelay::Cancel { id: self.id });
    }
}
