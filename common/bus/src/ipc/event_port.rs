//! A notifier and a listener of an event service.

use super::services;
use crate::error::PortError;
use crate::limits::MAX_NODES;
use crate::wakeup::{EventService, Wakeup, Wakeups};
use iceoryx2::node::Node;
use iceoryx2::port::event_id::EventId;
use iceoryx2::port::listener::{Listener, ListenerCreateError};
use iceoryx2::port::notifier::{Notifier, NotifierCreateError};
use iceoryx2::prelude::{FileDescriptorBased, PortFactory};
use iceoryx2::service::builder::event::EventOpenError;
use iceoryx2::service::ipc_threadsafe::Service;
use std::fmt::Debug;
use std::os::fd::BorrowedFd;

/// Notifier and listener of one event service.
pub(crate) struct EventPort {
    listener: Listener<Service>,
    notifier: Notifier<Service>,
}

impl EventPort {
    /// A guest leaves places to others.
    pub(super) fn open(node: &Node<Service>, name: EventService, is_guest: bool) -> Result<Self, PortError> {
        let what = || name.text();
        let full = |max| PortError::Full { what: what(), max };
        let refused = |reason: &dyn Debug| PortError::Refused { what: what(), reason: format!("{reason:?}") };
        let service = services::event(node, name).open().map_err(|e| match e {
            EventOpenError::DoesNotExist => PortError::Missing { what: what() },
            EventOpenError::ExceedsMaxNumberOfNodes => full(MAX_NODES),
            e => refused(&e),
        })?;
        let listener = service.listener_builder().create().map_err(|e| match e {
            ListenerCreateError::ExceedsMaxSupportedListeners => full(MAX_NODES),
            e => refused(&e),
        })?;
        let notifier = service.notifier_builder().create().map_err(|e| match e {
            NotifierCreateError::ExceedsMaxSupportedNotifiers => full(MAX_NODES),
            e => refused(&e),
        })?;
        services::leave_places(is_guest, service.dynamic_config().number_of_listeners(), MAX_NODES, what)?;
        Ok(Self { listener, notifier })
    }

    /// Readable while there are events that were not taken.
    pub(crate) fn descriptor(&self) -> BorrowedFd<'_> {
        // SAFETY: the descriptor belongs to the listener, which is borrowed as long as the result and closes it only
        // when it is dropped.
        unsafe { BorrowedFd::borrow_raw(self.listener.file_descriptor().native_handle()) }
    }

    /// The rings since the last call.
    pub(crate) fn take(&self) -> Wakeups {
        let mut wakeups = Wakeups::default();
        // A wake-up that cannot be read is no loss: the caller reads its topics anyway.
        let _ = self.listener.try_wait(|event| {
            for number in [Wakeup::Data, Wakeup::LateJoiner, Wakeup::Dead, Wakeup::Command, Wakeup::Reply] {
                if event.id == EventId::new(number as usize) {
                    wakeups.add(number as usize);
                }
            }
        });
        wakeups
    }

    /// Wakes all listeners. A failure is no error: the data that the event announces is in place.
    pub(crate) fn notify(&self, notify: Wakeup) {
        let _ = self.notifier.notify_with_custom_event_id(EventId::new(notify as usize));
    }
}
