//! A participant of the bus: opens publishers, subscribers, the status stream and command ports.

use crate::accounts::user_text;
use crate::command::{CommandClient, CommandServer};
use crate::domain::Domain;
use crate::error::{DomainError, PortError};
use crate::in_process::InProcessBus;
use crate::ipc;
use crate::latched::{Publisher, RawSubscriber, Subscriber};
use crate::link::Link;
use crate::names::{Daemon, TopicName};
use crate::relay_link::RelayLink;
use crate::report_kind::ReportKind;
use crate::status::{StatusReader, StatusWriter};
use crate::topics::Topic;
use crate::waiter::{Source, Waiter};
use std::sync::Arc;

/// A participant of a bus. Clones are the same participant; ports that it opened outlive it.
#[derive(Clone)]
pub struct Bus {
    daemon: Daemon,
    link: Link,
}

impl Bus {
    /// Joins the current generation of a bus. One thread of the process waits on the [`Waiter`].
    ///
    /// The bus is for the user alone who owns its folder. A client or robot of any other user, root included, goes through
    /// the relay: it reads copies of samples, sends commands if it is in the group for that, and publishes nothing.
    ///
    /// # Errors
    /// No keeper, another version, no room in shared memory; a user whom the relay does not serve, a daemon of another
    /// user than the bus's.
    pub fn join(domain: &Domain, daemon: Daemon) -> Result<(Self, Waiter), DomainError> {
        match domain.foreign_owner()? {
            Some(owner) if daemon.is_of_site() => Err(DomainError::Foreign { owner: user_text(owner) }),
            Some(owner) => Self::join_by_relay(domain, daemon, owner),
            None => Self::join_as_owner(domain, daemon),
        }
    }

    /// Goes through the relay of the user who owns the bus.
    pub(crate) fn join_by_relay(domain: &Domain, daemon: Daemon, owner: u32) -> Result<(Self, Waiter), DomainError> {
        let relay = RelayLink::connect(domain.place.root(), domain.relay_folder(), owner)?;
        Self::with(Source::Relay(relay), daemon)
    }

    /// Joins in shared memory.
    pub(crate) fn join_as_owner(domain: &Domain, daemon: Daemon) -> Result<(Self, Waiter), DomainError> {
        domain.require_own()?;
        Self::with(Source::Member(ipc::Membership::join(&domain.place, daemon)?), daemon)
    }

    fn with(source: Source, daemon: Daemon) -> Result<(Self, Waiter), DomainError> {
        let waiter = Waiter::new(daemon, source.clone())
            .map_err(|source| DomainError::File { path: "eventfd".into(), source })?;
        Ok((Self { daemon, link: source.into() }, waiter))
    }

    /// Joins a bus inside this process. Nothing wakes the participant: it asks its ports.
    pub fn in_process(bus: &InProcessBus, daemon: Daemon) -> Self {
        Self { daemon, link: Link::InProcess(bus.clone()) }
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
        if name.producer() != self.daemon {
            return Err(PortError::NotTheProducer { daemon: self.daemon, topic: name });
        }
        Ok(Publisher::new(topic, self.link.topic_target(name, length)?))
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
        Ok(RawSubscriber::new(topic, self.link.topic_source(topic)?))
    }

    /// The sending end of the status stream.
    ///
    /// # Errors
    /// Too many participants, no room in shared memory; the bus is another user's.
    pub fn status_writer(&self) -> Result<StatusWriter, PortError> {
        Ok(StatusWriter::new(self.daemon, self.link.status_target()?))
    }

    /// The receiving end of the status stream.
    ///
    /// # Errors
    /// Too many participants, no room in shared memory.
    pub fn status_reader(&self) -> Result<StatusReader, PortError> {
        Ok(StatusReader::new(self.link.status_source()?))
    }

    /// The answering end of this daemon's commands.
    ///
    /// # Errors
    /// Another process answers them; the bus is another user's, or inside one process.
    pub fn command_server(&self) -> Result<CommandServer, PortError> {
        Ok(CommandServer::new(self.link.command_server(self.daemon)?))
    }

    /// The asking end of a daemon's commands.
    ///
    /// # Errors
    /// Too many clients, no room in shared memory; a user who may look only; a bus inside one process.
    pub fn command_client(&self, daemon: Daemon) -> Result<CommandClient, PortError> {
        Ok(CommandClient::new(self.link.command_target(daemon)?))
    }
}

/// A report of a site whose bus belongs to another user, from its relay; `None` for the bus's own user, who makes it himself.
///
/// # Errors
/// No relay, or none that serves this user.
pub fn relayed_report(domain: &Domain, kind: ReportKind) -> Result<Option<Vec<u8>>, DomainError> {
    let Some(owner) = domain.foreign_owner()? else { return Ok(None) };
    let relay: Arc<RelayLink> = RelayLink::connect(domain.place.root(), domain.relay_folder(), owner)?;
    let report = relay.report(kind).map_err(|error| DomainError::NoRelay {
        owner: user_text(owner),
        folder: domain.relay_folder().to_owned(),
        reason: error.to_string(),
    })?;
    Ok(Some(report))
}
