//! Status streams in shared memory.

use super::event_port::EventPort;
use super::membership::Membership;
use super::node::check_memory;
use super::wire::WireStatus;
use super::{memory, services};
use crate::error::{PortError, ReceiveError};
use crate::limits::{MAX_NODES, MAX_SUBSCRIBERS};
use crate::robot_name::RobotName;
use crate::wakeup::{EventService, Wakeup};
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::{Subscriber, SubscriberCreateError};
use iceoryx2::prelude::BackpressureStrategy;
use iceoryx2::service::builder::publish_subscribe::PublishSubscribeOpenError;
use iceoryx2::service::ipc_threadsafe::Service;
use messages::StatusRecord;
use std::fmt::Debug;
use std::sync::Arc;

fn refused(robot: Option<RobotName>, reason: impl Debug) -> PortError {
    PortError::Refused { what: services::status_name(robot), reason: format!("{reason:?}") }
}

fn open(membership: &Membership, robot: Option<RobotName>) -> Result<services::StatusService, PortError> {
    check_memory()?;
    let what = || services::status_name(robot);
    services::status(&membership.node, robot).open().map_err(|e| match e {
        PublishSubscribeOpenError::DoesNotExist => PortError::Missing { what: what() },
        PublishSubscribeOpenError::ExceedsMaxNumberOfNodes => PortError::Full { what: what(), max: MAX_NODES },
        e => refused(robot, e),
    })
}

/// The sending end.
pub(crate) struct StatusTarget {
    port: Publisher<Service, WireStatus, ()>,
    event_port: Arc<EventPort>,
    _membership: Arc<Membership>,
}

impl StatusTarget {
    pub(crate) fn open(membership: &Arc<Membership>, robot: Option<RobotName>) -> Result<Self, PortError> {
        let event_port = membership.event_port(EventService::Status(robot))?;
        let port = open(membership, robot)?
            .publisher_builder()
            .max_loaned_samples(1)
            .backpressure_strategy(BackpressureStrategy::DiscardData)
            .create()
            .map_err(|e| refused(robot, e))?;
        Ok(Self { port, event_port, _membership: Arc::clone(membership) })
    }

    /// False if it could not be sent.
    pub(crate) fn send(&self, record: StatusRecord) -> bool {
        // Its segment is small, but its pages are made on first use.
        if memory::free_bytes() < memory::RESERVE_BYTES / 4 {
            return false;
        }
        let sent = self.port.send_copy(WireStatus(record)).is_ok();
        self.event_port.notify(Wakeup::Data);
        sent
    }
}

/// The receiving end.
pub(crate) struct StatusSource {
    port: Subscriber<Service, WireStatus, ()>,
    _event_port: Arc<EventPort>,
    _membership: Arc<Membership>,
}

impl StatusSource {
    pub(crate) fn open(membership: &Arc<Membership>, robot: Option<RobotName>) -> Result<Self, PortError> {
        let event_port = membership.event_port(EventService::Status(robot))?;
        let port = open(membership, robot)?.subscriber_builder().create().map_err(|e| match e {
            SubscriberCreateError::ExceedsMaxSupportedSubscribers => {
                PortError::Full { what: services::status_name(robot), max: MAX_SUBSCRIBERS }
            }
            e => refused(robot, e),
        })?;
        Ok(Self { port, _event_port: event_port, _membership: Arc::clone(membership) })
    }

    pub(crate) fn receive(&self) -> Result<Option<StatusRecord>, ReceiveError> {
        let failed = |e| ReceiveError::Refused { what: "status".to_owned(), reason: format!("{e:?}") };
        Ok(self.port.receive().map_err(failed)?.map(|s| s.payload().0))
    }
}
