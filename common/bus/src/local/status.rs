//! The status stream in the heap.

use super::{LocalBell, Membership};
use crate::bell::{Bell, BellName, Ring};
use crate::error::PortError;
use crate::ipc::STATUS_BUFFER;
use messages::StatusRecord;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError, Weak};

/// Heartbeats that a reader has not taken.
pub(super) type Queue = Mutex<VecDeque<StatusRecord>>;

fn bell(membership: &Membership) -> Result<Arc<LocalBell>, PortError> {
    let failed = |e: std::io::Error| PortError::Refused { what: "status".to_owned(), reason: e.to_string() };
    membership.bell(BellName::Status).map_err(failed)
}

/// The sending end.
pub(crate) struct StatusTarget {
    bell: Arc<LocalBell>,
    membership: Arc<Membership>,
}

impl StatusTarget {
    pub(crate) fn open(membership: &Arc<Membership>) -> Result<Self, PortError> {
        Ok(Self { bell: bell(membership)?, membership: Arc::clone(membership) })
    }

    pub(crate) fn send(&self, record: StatusRecord) {
        let mut state = self.membership.hub.state();
        state.status_readers.retain(|q| q.strong_count() > 0);
        for queue in state.status_readers.iter().filter_map(Weak::upgrade) {
            let mut queue = queue.lock().unwrap_or_else(PoisonError::into_inner);
            if queue.len() == STATUS_BUFFER {
                queue.pop_front();
            }
            queue.push_back(record);
        }
        drop(state);
        self.bell.ring(Ring::Data);
    }
}

/// The receiving end.
pub(crate) struct StatusSource {
    queue: Arc<Queue>,
    _bell: Arc<LocalBell>,
}

impl StatusSource {
    pub(crate) fn open(membership: &Arc<Membership>) -> Result<Self, PortError> {
        let bell = bell(membership)?;
        let queue = Arc::default();
        membership.hub.state().status_readers.push(Arc::downgrade(&queue));
        Ok(Self { queue, _bell: bell })
    }

    pub(crate) fn receive(&self) -> Option<StatusRecord> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner).pop_front()
    }
}
