//! A notifier and a listener of an event service.

use super::services;
use crate::error::PortError;
use crate::wakeup::{EventService, Wakeup, Wakeups};
use iceoryx2::node::Node;
use iceoryx2::port::event_id::EventId;
use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::prelude::FileDescriptorBased;
use iceoryx2::service::ipc_threadsafe::Service;
use std::os::fd::BorrowedFd;

/// Notifier and listener of one event service.
pub(crate) struct EventPort {
    listener: Listener<Service>,
    notifier: Notifier<Service>,
}

impl EventPort {
    pub(super) fn open(node: &Node<Service>, name: EventService) -> Result<Self, PortError> {
        let what = || format!("event/{}", name.text());
        let failed = |reason: String| PortError::Refused { what: what(), reason };
        let service = services::event(node, name.text()).open().map_err(|e| failed(format!("{e:?}")))?;
        let listener = service.listener_builder().create().map_err(|e| failed(format!("{e:?}")))?;
        let notifier = service.notifier_builder().create().map_err(|e| failed(format!("{e:?}")))?;
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
