//! Bells in shared memory.

use super::services;
use crate::bell::{BellName, Ring, Rings};
use crate::error::PortError;
use iceoryx2::node::Node;
use iceoryx2::port::event_id::EventId;
use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::prelude::FileDescriptorBased;
use iceoryx2::service::ipc_threadsafe::Service;
use std::os::fd::BorrowedFd;

/// A bell in shared memory.
pub(crate) struct Bell {
    listener: Listener<Service>,
    notifier: Notifier<Service>,
}

impl Bell {
    pub(super) fn open(node: &Node<Service>, name: BellName) -> Result<Self, PortError> {
        let what = || format!("bell/{}", name.text());
        let failed = |reason: String| PortError::Refused { what: what(), reason };
        let service = services::bell(node, name.text()).open().map_err(|e| failed(format!("{e:?}")))?;
        let listener = service.listener_builder().create().map_err(|e| failed(format!("{e:?}")))?;
        let notifier = service.notifier_builder().create().map_err(|e| failed(format!("{e:?}")))?;
        Ok(Self { listener, notifier })
    }

    /// Readable while there are rings that nobody has looked at.
    pub(crate) fn descriptor(&self) -> BorrowedFd<'_> {
        // SAFETY: the descriptor belongs to the listener, which is borrowed as long as the result and closes it only
        // when it is dropped.
        unsafe { BorrowedFd::borrow_raw(self.listener.file_descriptor().native_handle()) }
    }

    /// The rings since the last call.
    pub(crate) fn look(&self) -> Rings {
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

    /// Wakes everybody who listens. A bell that cannot be rung is no error: what it announces is in place.
    pub(crate) fn ring(&self, ring: Ring) {
        let _ = self.notifier.notify_with_custom_event_id(EventId::new(ring as usize));
    }
}
