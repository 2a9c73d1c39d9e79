//! iceoryx2 services of a domain: names and quality of service, shared by creator and openers.

use super::wire::{WireBlock, WireCommand, WireHeader, WireStatus};
use crate::error::PortError;
use crate::limits::{
    KEPT_PLACES, MAX_BORROWED, MAX_CLIENTS, MAX_NODES, MAX_OPEN, MAX_SUBSCRIBERS, REPLY_BUFFER, STATUS_BUFFER,
};
use crate::names::{Daemon, TopicName};
use crate::robot_name::{OfRobot, RobotName, below_robot};
use crate::wakeup::EventService;
use iceoryx2::node::Node;
use iceoryx2::port::event_id::EventId;
use iceoryx2::service::builder::{event, publish_subscribe, request_response};
use iceoryx2::service::ipc_threadsafe::Service;
use iceoryx2::service::port_factory;
use iceoryx2::service::service_name::ServiceName;

/// Largest number of an event.
const MAX_EVENT: usize = 7;

pub(crate) type TopicBuilder = publish_subscribe::Builder<[WireBlock], WireHeader, Service>;
pub(crate) type TopicService = port_factory::publish_subscribe::PortFactory<Service, [WireBlock], WireHeader>;
pub(crate) type StatusBuilder = publish_subscribe::Builder<WireStatus, (), Service>;
pub(crate) type StatusService = port_factory::publish_subscribe::PortFactory<Service, WireStatus, ()>;
pub(crate) type CommandBuilder = request_response::Builder<[u8], WireCommand, [u8], WireCommand, Service>;
pub(crate) type CommandService =
    port_factory::request_response::PortFactory<Service, [u8], WireCommand, [u8], WireCommand>;
pub(crate) type EventServiceFactory = port_factory::event::PortFactory<Service>;

fn name_of(text: &str) -> ServiceName {
    ServiceName::new(text).expect("names of services are short and not empty")
}

/// A latched topic.
pub(crate) fn topic(node: &Node<Service>, topic: OfRobot<TopicName>) -> TopicBuilder {
    node.service_builder(&name_of(&topic.to_string()))
        .publish_subscribe::<[WireBlock]>()
        .user_header::<WireHeader>()
        .history_size(1)
        .subscriber_max_buffer_size(1)
        .subscriber_max_borrowed_samples(MAX_BORROWED)
        .max_publishers(1)
        .max_subscribers(MAX_SUBSCRIBERS)
        .max_nodes(MAX_NODES)
        .enable_safe_overflow(true)
}

/// The name of the status stream of the site, or of a robot.
pub(crate) fn status_name(robot: Option<RobotName>) -> String {
    below_robot(robot, "status")
}

/// The status stream of the site, or of a robot.
pub(crate) fn status(node: &Node<Service>, robot: Option<RobotName>) -> StatusBuilder {
    node.service_builder(&name_of(&status_name(robot)))
        .publish_subscribe::<WireStatus>()
        .history_size(0)
        .subscriber_max_buffer_size(STATUS_BUFFER)
        .subscriber_max_borrowed_samples(2)
        .max_publishers(MAX_NODES)
        .max_subscribers(MAX_SUBSCRIBERS)
        .max_nodes(MAX_NODES)
        .enable_safe_overflow(true)
}

/// Commands to a daemon.
pub(crate) fn command(node: &Node<Service>, daemon: OfRobot<Daemon>) -> CommandBuilder {
    node.service_builder(&name_of(&daemon.command()))
        .request_response::<[u8], [u8]>()
        .request_user_header::<WireCommand>()
        .response_user_header::<WireCommand>()
        .max_servers(1)
        .max_clients(MAX_CLIENTS)
        .max_nodes(MAX_NODES)
        .max_active_requests_per_client(MAX_OPEN)
        .max_response_buffer_size(REPLY_BUFFER)
        .enable_safe_overflow_for_requests(false)
        .enable_safe_overflow_for_responses(true)
        .enable_fire_and_forget_requests(false)
}

/// Events around a daemon, or around the status stream.
pub(crate) fn event(node: &Node<Service>, name: EventService) -> event::Builder<Service> {
    node.service_builder(&name_of(&name.text()))
        .event()
        .event_id_max_value(MAX_EVENT)
        .max_listeners(MAX_NODES)
        .max_notifiers(MAX_NODES)
        .max_nodes(MAX_NODES)
        .notifier_dead_event(EventId::new(crate::wakeup::Wakeup::Dead as usize))
}

/// Refuses a guest that has taken one of the last [`KEPT_PLACES`] of `max` places, of which `n` are taken now. Asked after the place is
/// taken: of two guests that come at once none gets one too many.
///
/// # Errors
/// Too few places are left.
pub(super) fn leave_places(is_guest: bool, n: usize, max: usize, what: impl Fn() -> String) -> Result<(), PortError> {
    let most = max - KEPT_PLACES;
    if is_guest && n > most { Err(PortError::Full { what: what(), max: most }) } else { Ok(()) }
}
