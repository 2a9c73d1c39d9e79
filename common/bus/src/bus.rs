//! A participant of the bus: opens publishers, subscribers, the status stream and command ports.

use crate::accounts::user_text;
use crate::command::{CommandClient, CommandServer};
use crate::domain::{Domain, Robots};
use crate::error::{DomainError, PortError};
use crate::in_process::InProcessBus;
use crate::ipc;
use crate::latched::{Publisher, RawSubscriber, Subscriber};
use crate::link::Link;
use crate::names::{Daemon, TopicName};
use crate::relay_link::RelayLink;
use crate::report_kind::ReportKind;
use crate::robot_name::{OfRobot, RobotName, names_of_robots};
use crate::status::{StatusReader, StatusWriter};
use crate::topics::Topic;
use crate::waiter::{Source, Waiter};
use std::sync::Arc;

/// A participant of a bus. Clones are the same participant; ports that it opened outlive it.
#[derive(Clone)]
pub struct Bus {
    daemon: Daemon,
    robots: Robots,
    link: Link,
}

impl Bus {
    /// Joins the current generation of a bus. One thread of the process waits on the [`Waiter`].
    ///
    /// The bus is for the user alone who owns its folder. A client or robot of any other user, root included, goes through
    /// the relay: it reads copies of samples, sends commands if it is in the group for that, and publishes nothing.
    ///
    /// Of a domain with named robots, a participant has what is the site's and what is of the robot that the domain means.
    ///
    /// # Errors
    /// No keeper, another version, no room in shared memory; a user whom the relay does not serve, a daemon of another
    /// user than the bus's; a daemon of a robot where the domain means none of several.
    pub fn join(domain: &Domain, daemon: Daemon) -> Result<(Self, Waiter), DomainError> {
        let robots = domain.scope();
        if daemon.is_of_robot() && robots.own().is_none() && !robots.all().is_empty() {
            return Err(DomainError::NoRobotNamed { daemon, robots: names_of_robots(robots.all()) });
        }
        match domain.foreign_owner()? {
            Some(owner) if daemon.is_of_site() => Err(DomainError::Foreign { owner: user_text(owner) }),
            Some(owner) => Self::join_by_relay(domain, daemon, owner),
            None => Self::join_as_owner(domain, daemon),
        }
    }

    /// Goes through the relay of the user who owns the bus.
    pub(crate) fn join_by_relay(domain: &Domain, daemon: Daemon, owner: u32) -> Result<(Self, Waiter), DomainError> {
        let relay = RelayLink::connect(domain, owner)?;
        Self::with(Source::Relay(relay), daemon, domain.scope())
    }

    /// Joins in shared memory.
    pub(crate) fn join_as_owner(domain: &Domain, daemon: Daemon) -> Result<(Self, Waiter), DomainError> {
        domain.require_own()?;
        let robots = domain.scope();
        let member = ipc::Membership::join(&domain.place, OfRobot::new(robots.own(), daemon))?;
        Self::with(Source::Member(member), daemon, robots)
    }

    fn with(source: Source, daemon: Daemon, robots: Robots) -> Result<(Self, Waiter), DomainError> {
        let waiter = Waiter::new(OfRobot::new(robots.own(), daemon), source.clone())
            .map_err(|source| DomainError::File { path: "eventfd".into(), source })?;
        Ok((Self { daemon, robots, link: source.into() }, waiter))
    }

    /// Joins a bus inside this process. Nothing wakes the participant: it asks its ports.
    pub fn in_process(bus: &InProcessBus, daemon: Daemon) -> Self {
        Self { daemon, robots: Robots::default(), link: Link::InProcess(bus.clone()) }
    }

    /// As [`Bus::in_process`], of a robot with a name.
    pub fn in_process_of_robot(bus: &InProcessBus, daemon: Daemon, robot: RobotName) -> Self {
        Self { robots: Robots::one(robot), ..Self::in_process(bus, daemon) }
    }

    /// The same participant with what is of another robot of the site, or of none.
    ///
    /// # Errors
    /// A robot that the site does not have.
    pub fn meaning(&self, robot: Option<RobotName>) -> Result<Self, DomainError> {
        Ok(Self { robots: self.robots.meaning(robot)?, ..self.clone() })
    }

    /// Who this is.
    pub fn daemon(&self) -> Daemon {
        self.daemon
    }

    /// The generation that it joined.
    pub fn generation(&self) -> u64 {
        self.link.generation()
    }

    /// The publishing end of a topic, with room for samples of `length` bytes; larger ones are possible.
    ///
    /// # Errors
    /// The topic is another daemon's, or its publisher lives already; the bus is another user's.
    pub fn publisher<T: Topic>(&self, topic: T, length: usize) -> Result<Publisher<T>, PortError> {
        let name = topic.name();
        if !name.is_published_by(self.daemon) {
            return Err(PortError::NotTheProducer { daemon: self.daemon, topic: name });
        }
        Ok(Publisher::new(topic, self.link.topic_target(self.robots.find(name, || name.to_string())?, length)?))
    }

    /// The receiving end of a topic; its last sample is there as soon as the publisher's process looks up.
    ///
    /// # Errors
    /// Too many subscribers, no room in shared memory.
    pub fn subscriber<T: Topic>(&self, topic: T) -> Result<Subscriber<T>, PortError> {
        Ok(Subscriber::new(topic, self.raw_subscriber(topic.name())?))
    }

    /// The receiving end of a topic that is known by name only.
    ///
    /// # Errors
    /// As [`Bus::subscriber`].
    pub fn raw_subscriber(&self, topic: TopicName) -> Result<RawSubscriber, PortError> {
        let found = self.robots.find(topic, || topic.to_string())?;
        Ok(RawSubscriber::new(topic, self.link.topic_source(found)?))
    }

    /// The sending end of the status stream: that of its robot for a daemon of a robot, that of the site for others.
    ///
    /// # Errors
    /// Too many participants, no room in shared memory; the bus is another user's.
    pub fn status_writer(&self) -> Result<StatusWriter, PortError> {
        let stream = OfRobot::new(self.robots.own(), self.daemon).robot;
        Ok(StatusWriter::new(self.daemon, self.link.status_target(stream)?))
    }

    /// The receiving end of the status streams of the site and of its robot. What it gets is of one daemon of each kind.
    ///
    /// # Errors
    /// Too many participants, no room in shared memory.
    pub fn status_reader(&self) -> Result<StatusReader, PortError> {
        let robot = match &self.link {
            // The relay has both in one.
            Link::Relay(_) => None,
            Link::Member(_) | Link::InProcess(_) => self.robots.own(),
        };
        let streams = std::iter::once(None).chain(robot.map(Some));
        let ports = streams.map(|stream| self.link.status_source(stream)).collect::<Result<_, _>>()?;
        Ok(StatusReader::new(ports))
    }

    /// The receiving ends of the status streams of the site and of each of its named robots.
    pub(crate) fn status_streams(&self) -> Result<Vec<(Option<RobotName>, StatusReader)>, PortError> {
        let streams = std::iter::once(None).chain(self.robots.all().iter().copied().map(Some));
        streams.map(|robot| Ok((robot, StatusReader::new(vec![self.link.status_source(robot)?])))).collect()
    }

    /// The answering end of this daemon's commands.
    ///
    /// # Errors
    /// Another process answers them; the bus is another user's, or inside one process.
    pub fn command_server(&self) -> Result<CommandServer, PortError> {
        Ok(CommandServer::new(self.link.command_server(self.found(self.daemon)?)?))
    }

    /// The asking end of a daemon's commands.
    ///
    /// # Errors
    /// Too many clients, no room in shared memory; a user who may look only; a bus inside one process.
    pub fn command_client(&self, daemon: Daemon) -> Result<CommandClient, PortError> {
        Ok(CommandClient::new(self.link.command_target(self.found(daemon)?)?))
    }

    fn found(&self, daemon: Daemon) -> Result<OfRobot<Daemon>, PortError> {
        self.robots.find(daemon, || format!("command/{daemon}"))
    }
}

/// A report of a site whose bus belongs to another user, from its relay; `None` for the bus's own user, who makes it himself.
///
/// # Errors
/// No relay, or none that serves this user.
pub fn relayed_report(domain: &Domain, kind: ReportKind) -> Result<Option<Vec<u8>>, DomainError> {
    let Some(owner) = domain.foreign_owner()? else { return Ok(None) };
    let relay: Arc<RelayLink> = RelayLink::connect(domain, owner)?;
    let report = relay.report(kind).map_err(|error| DomainError::NoRelay {
        owner: user_text(owner),
        folder: domain.relay_folder().to_owned(),
        reason: error.to_string(),
    })?;
    Ok(Some(report))
}
