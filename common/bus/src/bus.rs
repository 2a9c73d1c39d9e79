//! A participant of the bus: opens publishers, subscribers, the status stream and command ports.

use crate::command::{CommandClient, CommandServer};
use crate::domain::Domain;
use crate::error::{DomainError, PortError};
use crate::ipc;
use crate::latched::{Publisher, RawSubscriber, Subscriber};
use crate::names::{Daemon, TopicName};
use crate::status::{StatusReader, StatusWriter};
use crate::topics::Topic;
use crate::waiter::Waiter;
use std::sync::Arc;

/// A participant of a bus. Clones are the same participant; ports that it opened outlive it.
#[derive(Clone)]
pub struct Bus {
    daemon: Daemon,
    member: Arc<ipc::Membership>,
}

impl Bus {
    /// Joins the current generation of a bus. One thread of the process waits on the [`Waiter`].
    ///
    /// # Errors
    /// No keeper, another version, no room in shared memory.
    pub fn join(domain: &Domain, daemon: Daemon) -> Result<(Self, Waiter), DomainError> {
        let member = ipc::Membership::join(&domain.place, daemon)?;
        let waiter = Waiter::new(daemon, Arc::clone(&member))
            .map_err(|source| DomainError::File { path: "eventfd".into(), source })?;
        Ok((Self { daemon, member }, waiter))
    }

    /// Who this is.
    pub fn daemon(&self) -> Daemon {
        self.daemon
    }

    /// The generation that it joined.
    pub fn generation(&self) -> u64 {
        self.member.generation()
    }

    /// The publishing end of a topic, with room for samples of `length` bytes; larger ones are possible.
    ///
    /// # Errors
    /// The topic is another daemon's, or its publisher lives already.
    pub fn publisher<T: Topic>(&self, topic: T, length: usize) -> Result<Publisher<T>, PortError> {
        let name = topic.name();
        if name.producer() != self.daemon {
            return Err(PortError::NotTheProducer { daemon: self.daemon, topic: name });
        }
        let port = ipc::TopicWriter::open(&self.member, name, length)?;
        Ok(Publisher::new(topic, port))
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
        Ok(RawSubscriber::new(topic, ipc::TopicReader::open(&self.member, topic)?))
    }

    /// The sending end of the status stream.
    ///
    /// # Errors
    /// Too many participants, no room in shared memory.
    pub fn status_writer(&self) -> Result<StatusWriter, PortError> {
        let port = ipc::StatusTarget::open(&self.member)?;
        Ok(StatusWriter::new(self.daemon, port))
    }

    /// The receiving end of the status stream.
    ///
    /// # Errors
    /// Too many participants, no room in shared memory.
    pub fn status_reader(&self) -> Result<StatusReader, PortError> {
        let port = ipc::StatusSource::open(&self.member)?;
        Ok(StatusReader::new(port))
    }

    /// The answering end of this daemon's commands.
    ///
    /// # Errors
    /// Another process answers them.
    pub fn command_server(&self) -> Result<CommandServer, PortError> {
        let port = ipc::Server::open(&self.member, self.daemon)?;
        Ok(CommandServer::new(port))
    }

    /// The asking end of a daemon's commands.
    ///
    /// # Errors
    /// Too many clients, no room in shared memory.
    pub fn command_client(&self, daemon: Daemon) -> Result<CommandClient, PortError> {
        let port = ipc::Client::open(&self.member, daemon)?;
        Ok(CommandClient::new(port))
    }
}
