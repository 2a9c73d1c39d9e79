//! The services of a generation, held by the keeper.

use super::node::{node, refused, require_memory};
use super::services;
use crate::error::DomainError;
use crate::file_lock::Lock;
use crate::generation::Place;
use crate::names::{Daemon, TopicName};
use crate::robot_name::{OfRobot, RobotName};
use crate::wakeup::EventService;
use iceoryx2::node::Node;
use iceoryx2::service::ipc_threadsafe::Service;

/// All services of a generation, held by the keeper.
pub(crate) struct Services {
    _topics: Vec<services::TopicService>,
    _status: Vec<services::StatusService>,
    _commands: Vec<services::CommandService>,
    _event_services: Vec<services::EventServiceFactory>,
    node: Node<Service>,
    member_lock: Lock,
}

impl Services {
    /// Creates the services of a generation, or opens those that participants still hold. With `robots` each of them has its own
    /// of what is a robot's; without, there is one robot, which has no name.
    pub(crate) fn create(place: &Place, generation: u64, robots: &[RobotName]) -> Result<Self, DomainError> {
        require_memory()?;
        let member_lock = place.join_members(generation)?;
        let node = node(place, generation, "keeper")?;
        let unnamed = robots.is_empty().then_some(None);
        let of_robots: Vec<Option<RobotName>> = unnamed.into_iter().chain(robots.iter().copied().map(Some)).collect();
        let topics = all(TopicName::all(), TopicName::is_of_robot, &of_robots)
            .map(|t| services::topic(&node, t).open_or_create().map_err(|e| refused(format!("topic `{t}`"), e)));
        let topics = topics.collect::<Result<_, _>>()?;
        let streams = std::iter::once(None).chain(robots.iter().copied().map(Some));
        let status = streams.clone().map(|robot| {
            let stream = services::status(&node, robot).open_or_create();
            stream.map_err(|e| refused(services::status_name(robot), e))
        });
        let status = status.collect::<Result<_, _>>()?;
        let daemons = || all(Daemon::ALL.into_iter(), Daemon::is_of_robot, &of_robots);
        let commands =
            daemons().map(|d| services::command(&node, d).open_or_create().map_err(|e| refused(d.command(), e)));
        let commands = commands.collect::<Result<_, _>>()?;
        let names = daemons().map(EventService::Of).chain(streams.map(EventService::Status));
        let event_ports = names.map(|n| services::event(&node, n).open_or_create().map_err(|e| refused(n.text(), e)));
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

/// What is the site's once, and what is a robot's for each of them.
fn all<T: Copy>(
    all: impl Iterator<Item = T>,
    is_of_robot: fn(T) -> bool,
    robots: &[Option<RobotName>],
) -> impl Iterator<Item = OfRobot<T>> {
    all.flat_map(move |what| {
        let owners = if is_of_robot(what) { robots } else { &[None] };
        owners.iter().map(move |&robot| OfRobot { robot, what })
    })
}
