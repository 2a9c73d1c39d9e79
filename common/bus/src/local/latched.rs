//! Latched topics in the heap.

use super::{Hub, LocalBell, Membership};
use crate::bell::{Bell, BellName, Ring};
use crate::error::{PortError, PublishError};
use crate::names::Topic;
use messages::{ArchiveBuffer, SampleHeader};
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex, PoisonError, Weak};

/// What a loan is filled with: nobody may count on zeros, shared memory has none.
const STALE: u8 = 0xa5;

/// A topic: its publisher, its last sample, its subscribers.
#[derive(Default)]
pub(super) struct Slot {
    publisher: Weak<TopicWriter>,
    last: Option<Arc<Stored>>,
    mailboxes: Vec<Weak<Mailbox>>,
}

type Mailbox = Mutex<Option<Arc<Stored>>>;

struct Stored {
    header: SampleHeader,
    memory: Memory,
}

/// The publishing end of a topic.
pub(crate) struct TopicWriter {
    topic: Topic,
    membership: Arc<Membership>,
    bell: Arc<LocalBell>,
    loaned: Arc<Mutex<bool>>,
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

fn refused(topic: Topic, reason: &std::io::Error) -> PortError {
    PortError::Refused { what: topic.to_string(), reason: reason.to_string() }
}

impl TopicWriter {
    pub(crate) fn open(membership: &Arc<Membership>, topic: Topic) -> Result<Arc<Self>, PortError> {
        let bell = membership.bell(BellName::Of(topic.producer())).map_err(|e| refused(topic, &e))?;
        let mut state = membership.hub.state();
        let slot = state.topics.entry(topic).or_default();
        if slot.publisher.strong_count() > 0 {
            return Err(PortError::Taken { what: topic.to_string() });
        }
        let writer = Arc::new(Self { topic, membership: Arc::clone(membership), bell, loaned: Arc::default() });
        slot.publisher = Arc::downgrade(&writer);
        Ok(writer)
    }

    pub(crate) fn loan(&self, length: usize) -> Result<Memory, PublishError> {
        let hub = &self.membership.hub;
        let bytes = length.next_multiple_of(64).max(64);
        let mut loaned = lock(&self.loaned);
        if *loaned {
            return Err(PublishError::LoanedOut { topic: self.topic });
        }
        let taken = hub.memory_bytes.fetch_update(Ordering::AcqRel, Ordering::Acquire, |used| {
            used.checked_add(bytes as u64).filter(|&u| u <= hub.memory_bytes_max)
        });
        if taken.is_err() {
            return Err(PublishError::NoMemory { length, free_bytes: hub.free_bytes() });
        }
        *loaned = true;
        let mut memory = Memory {
            buffer: ArchiveBuffer::zeroed(bytes),
            hub: Arc::clone(hub),
            loaned: Some(Arc::clone(&self.loaned)),
        };
        memory.bytes_mut()[..length].fill(STALE);
        Ok(memory)
    }

    pub(crate) fn send(&self, mut memory: Memory, header: SampleHeader) -> usize {
        memory.end_of_loan();
        let stored = Arc::new(Stored { header, memory });
        let mut state = self.membership.hub.state();
        let slot = state.topics.entry(self.topic).or_default();
        slot.mailboxes.retain(|m| m.strong_count() > 0);
        let mailboxes: Vec<_> = slot.mailboxes.iter().filter_map(Weak::upgrade).collect();
        for mailbox in &mailboxes {
            *lock(mailbox) = Some(Arc::clone(&stored));
        }
        slot.last = Some(stored);
        drop(state);
        self.bell.ring(Ring::Data);
        mailboxes.len()
    }
}

impl Drop for TopicWriter {
    fn drop(&mut self) {
        // The last sample goes with its publisher, as it does in shared memory.
        if let Some(slot) = self.membership.hub.state().topics.get_mut(&self.topic) {
            slot.last = None;
        }
    }
}

/// Memory of a sample.
pub(crate) struct Memory {
    buffer: ArchiveBuffer,
    hub: Arc<Hub>,
    loaned: Option<Arc<Mutex<bool>>>,
}

impl Memory {
    pub(crate) fn bytes(&self) -> &[u8] {
        self.buffer.bytes()
    }

    pub(crate) fn bytes_mut(&mut self) -> &mut [u8] {
        self.buffer.bytes_mut()
    }

    fn end_of_loan(&mut self) {
        if let Some(loaned) = self.loaned.take() {
            *lock(&loaned) = false;
        }
    }
}

impl Drop for Memory {
    fn drop(&mut self) {
        self.end_of_loan();
        self.hub.memory_bytes.fetch_sub(self.buffer.bytes().len() as u64, Ordering::AcqRel);
    }
}

/// The receiving end of a topic.
pub(crate) struct TopicReader {
    mailbox: Arc<Mailbox>,
    _membership: Arc<Membership>,
}

impl TopicReader {
    pub(crate) fn open(membership: &Arc<Membership>, topic: Topic) -> Result<Self, PortError> {
        let bell = membership.bell(BellName::Of(topic.producer())).map_err(|e| refused(topic, &e))?;
        let mut state = membership.hub.state();
        let slot = state.topics.entry(topic).or_default();
        let mailbox = Arc::new(Mutex::new(slot.last.clone()));
        slot.mailboxes.push(Arc::downgrade(&mailbox));
        drop(state);
        bell.ring(Ring::Data);
        Ok(Self { mailbox, _membership: Arc::clone(membership) })
    }

    pub(crate) fn receive(&self) -> Option<TopicSample> {
        lock(&self.mailbox).take().map(TopicSample)
    }
}

/// A sample that is read in place.
pub(crate) struct TopicSample(Arc<Stored>);

impl TopicSample {
    pub(crate) fn header(&self) -> &SampleHeader {
        &self.0.header
    }

    pub(crate) fn bytes(&self) -> &[u8] {
        self.0.memory.bytes()
    }
}
