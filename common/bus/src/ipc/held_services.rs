//! The services of a generation, held by the keeper.

use super::node::{node, refused, require_memory};
use super::services;
use crate::error::DomainError;
use crate::file_lock::Lock;
use crate::generation::Place;
use crate::names::{Daemon, TopicName};
use crate::wakeup::EventService;
use iceoryx2::node::Node;
use iceoryx2::service::ipc_threadsafe::Service;

/// All services of a generation, held by the keeper.
pub(crate) struct Services {
    _topics: Vec<services::TopicService>,
    _status: services::StatusService,
    _commands: Vec<services::CommandService>,
    _event_services: Vec<services::EventServiceFactory>,
    node: Node<Service>,
    member_lock: Lock,
}

impl Services {
    /// Creates the services of a generation, or opens those that participants still hold.
    pub(crate) fn create(place: &Place, generation: u64) -> Result<Self, DomainError> {
        require_memory()?;
        let member_lock = place.join_members(generation)?;
        let node = node(place, generation, "keeper")?;
        let topics = TopicName::all()
            .map(|t| services::topic(&node, t).open_or_create().map_err(|e| refused(format!("topic `{t}`"), e)));
        let topics = topics.collect::<Result<_, _>>()?;
        let status = services::status(&node).open_or_create().map_err(|e| refused("status stream", e))?;
        let commands = Daemon::ALL
            .map(|d| services::command(&node, d).open_or_create().map_err(|e| refused(format!("command/{d}"), e)));
        let commands = commands.into_iter().collect::<Result<_, _>>()?;
        let names = Daemon::ALL.map(EventService::Of).into_iter().chain([EventService::Status]);
        let event_ports = names
            .map(|n| services::event(&node, n.text()).open_or_create().map_err(|e| refused(format!("event/{n:?}"), e)));
        let event_ports = event_ports.collect::<Result<_, _>>()?;
        Ok(Self {
            _topics: topics,
            _status: status,
            _commands: commands,
            _event_services: event_ports,
            node,
            member_lock,
        })
    }

    /// True if no participant is left; the generation's lock is then exclusive, so that nobody joins it.
    ///
    /// To be asked before these services are dropped, and not before: the place among the members may be lost by it.
    pub(crate) fn outlive_all_members(&self) -> bool {
        self.member_lock.make_exclusive()
    }

    /// Returns what dead participants left; the number of them.
    pub(crate) fn remove_dead(&self) -> u64 {
        self.node.try_cleanup_dead_nodes().cleanups
    }
}
