//! The inbox of a relay's client: samples, replies and reports that were not taken yet.

use crate::bounded_queue::push_bounded;
use crate::error::CommandError;
use crate::limits::{REPLY_BUFFER, STATUS_BUFFER};
use crate::names::TopicName;
use crate::relay_protocol::{FrameReader, FromRelay};
use crate::reply_kind::ReplyKind;
use messages::{SampleHeader, StatusRecord};
use std::collections::{BTreeMap, VecDeque};
use std::os::fd::OwnedFd;
use std::sync::{Arc, Mutex, PoisonError, Weak};

/// What came and was not taken yet.
#[derive(Default)]
pub(super) struct Inbox {
    pub(super) reader: FrameReader,
    pub(super) topics: BTreeMap<TopicName, Topic>,
    pub(super) status: Vec<Weak<Mutex<VecDeque<StatusRecord>>>>,
    pub(super) commands: BTreeMap<u64, VecDeque<CommandNews>>,
    pub(super) report: Option<Vec<u8>>,
}

/// A reply to a command, or its end.
pub(super) type CommandNews = Result<(ReplyKind, Vec<u8>), CommandError>;

/// A topic that is followed.
#[derive(Default)]
pub(super) struct Topic {
    pub(super) subscriptions: Vec<Weak<Slot>>,
    pub(super) last: Option<Arc<RelayedSample>>,
    pub(super) refused: Option<String>,
}

/// The newest sample that one subscription did not take.
pub(super) type Slot = Mutex<Option<Arc<RelayedSample>>>;

/// A sample that was announced; its bytes are still in the relay's memory.
pub(super) struct RelayedSample {
    pub(super) header: SampleHeader,
    pub(super) memory: Arc<OwnedFd>,
}

impl Inbox {
    /// Puts a frame where it belongs; the topic of a sample that the relay is told of.
    pub(super) fn put(&mut self, frame: FromRelay) -> Option<TopicName> {
        match frame {
            FromRelay::Sample { topic, header, memory } => {
                let sample = Arc::new(RelayedSample { header: *header, memory });
                if let Some(followed) = self.topics.get_mut(&topic) {
                    for slot in followed.subscriptions.iter().filter_map(Weak::upgrade) {
                        *slot.lock().unwrap_or_else(PoisonError::into_inner) = Some(Arc::clone(&sample));
                    }
                    (followed.last, followed.refused) = (Some(sample), None);
                }
                // Also if it is not followed any more: the relay sends no other one before.
                return Some(topic);
            }
            FromRelay::NoTopic { topic, reason } => {
                if let Some(followed) = self.topics.get_mut(&topic) {
                    followed.refused = Some(reason);
                }
            }
            FromRelay::Status(record) => {
                self.status.retain(|records| records.strong_count() > 0);
                for records in self.status.iter().filter_map(Weak::upgrade) {
                    push_bounded(&mut records.lock().unwrap_or_else(PoisonError::into_inner), *record, STATUS_BUFFER);
                }
            }
            // A command that was given up has no place any more.
            FromRelay::Reply { id, kind, bytes } => {
                if let Some(replies) = self.commands.get_mut(&id) {
                    push_bounded(replies, Ok((kind, bytes)), REPLY_BUFFER);
                }
            }
            FromRelay::CommandFailed { id, error } => {
                if let Some(replies) = self.commands.get_mut(&id) {
                    push_bounded(replies, Err(error), REPLY_BUFFER);
                }
            }
            FromRelay::Report(bytes) => self.report = Some(bytes.to_vec()),
            // They come once, and first.
            FromRelay::Welcome { .. } | FromRelay::Refused(_) => {}
        }
        None
    }
}
