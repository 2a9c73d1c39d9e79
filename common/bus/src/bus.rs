//! A participant: opens the ends of topics, of the status stream and of commands.

use crate::bell::{Bell, BellName};
use crate::command::{ClientPort, CommandClient, CommandServer, ServerPort};
use crate::domain::{Backend, Domain};
use crate::error::{DomainError, PortError};
use crate::latched::{Publisher, ReaderPort, Subscriber, WriterPort};
use crate::names::{Daemon, Topic};
use crate::signal::Signal;
use crate::status::{StatusReader, StatusSource, StatusTarget, StatusWriter};
use crate::waiter::Waiter;
use crate::{ipc, local};
use std::os::fd::BorrowedFd;
use std::sync::Arc;

/// A participant of a bus. Clones are the same participant; ends that it opened live on without it.
#[derive(Clone)]
pub struct Bus {
    daemon: Daemon,
    member: Member,
}

#[derive(Clone)]
pub(crate) enum Member {
    Ipc(Arc<ipc::Membership>),
    Local(Arc<local::Membership>),
}

impl Bus {
    /// Joins the current generation of a bus. One thread of the process waits on the [`Waiter`].
    ///
    /// # Errors
    /// No keeper, another version, no room in shared memory.
    pub fn join(domain: &Domain, daemon: Daemon) -> Result<(Self, Waiter), DomainError> {
        let member = match &domain.backend {
            Backend::Shared(place) => Member::Ipc(ipc::Membership::join(place, daemon)?),
            Backend::InProcess(hub) => Member::Local(local::Membership::join(hub)?),
        };
        let waiter = Waiter::new(daemon, member.clone())
            .map_err(|source| DomainError::File { path: "eventfd".into(), source })?;
        Ok((Self { daemon, member }, waiter))
    }

    /// Who this is.
    pub fn daemon(&self) -> Daemon {
        self.daemon
    }

    /// The generation that it joined.
    pub fn generation(&self) -> u64 {
        match &self.member {
            Member::Ipc(member) => member.generation(),
            Member::Local(member) => member.generation(),
        }
    }

    /// The publishing end of a topic, with room for samples of `length` bytes; larger ones are possible.
    ///
    /// # Errors
    /// The topic is another daemon's, or its publisher lives already.
    pub fn publisher(&self, topic: Topic, length: usize) -> Result<Publisher, PortError> {
        if topic.producer() != self.daemon {
            return Err(PortError::NotTheProducer { daemon: self.daemon, topic });
        }
        let port = match &self.member {
            Member::Ipc(member) => WriterPort::Ipc(ipc::TopicWriter::open(member, topic, length)?),
            Member::Local(member) => WriterPort::Local(local::TopicWriter::open(member, topic)?),
        };
        Ok(Publisher::new(topic, port))
    }

    /// The receiving end of a topic; its last sample is there as soon as the publisher's process looks up.
    ///
    /// # Errors
    /// Too many subscribers, no room in shared memory.
    pub fn subscriber(&self, topic: Topic) -> Result<Subscriber, PortError> {
        let port = match &self.member {
            Member::Ipc(member) => ReaderPort::Ipc(ipc::TopicReader::open(member, topic)?),
            Member::Local(member) => ReaderPort::Local(local::TopicReader::open(member, topic)?),
        };
        Ok(Subscriber::new(topic, port))
    }

    /// The sending end of the status stream.
    ///
    /// # Errors
    /// Too many participants, no room in shared memory.
    pub fn status_writer(&self) -> Result<StatusWriter, PortError> {
        let port = match &self.member {
            Member::Ipc(member) => StatusTarget::Ipc(ipc::StatusTarget::open(member)?),
            Member::Local(member) => StatusTarget::Local(local::StatusTarget::open(member)?),
        };
        Ok(StatusWriter::new(self.daemon, port))
    }

    /// The receiving end of the status stream.
    ///
    /// # Errors
    /// Too many participants, no room in shared memory.
    pub fn status_reader(&self) -> Result<StatusReader, PortError> {
        let port = match &self.member {
            Member::Ipc(member) => StatusSource::Ipc(ipc::StatusSource::open(member)?),
            Member::Local(member) => StatusSource::Local(local::StatusSource::open(member)?),
        };
        Ok(StatusReader::new(port))
    }

    /// The answering end of this daemon's commands.
    ///
    /// # Errors
    /// Another process answers them.
    pub fn command_server(&self) -> Result<CommandServer, PortError> {
        let port = match &self.member {
            Member::Ipc(member) => ServerPort::Ipc(ipc::Server::open(member, self.daemon)?),
            Member::Local(member) => ServerPort::Local(local::Server::open(member, self.daemon)?),
        };
        Ok(CommandServer::new(port))
    }

    /// The asking end of a daemon's commands.
    ///
    /// # Errors
    /// Too many clients, no room in shared memory.
    pub fn command_client(&self, daemon: Daemon) -> Result<CommandClient, PortError> {
        let port = match &self.member {
            Member::Ipc(member) => ClientPort::Ipc(ipc::Client::open(member, daemon)?),
            Member::Local(member) => ClientPort::Local(local::Client::open(member, daemon)?),
        };
        Ok(CommandClient::new(port))
    }
}

impl Member {
    pub(crate) fn bells(&self) -> Vec<(BellName, Arc<dyn Bell>)> {
        match self {
            Self::Ipc(member) => member.bells(),
            Self::Local(member) => member.bells(),
        }
    }

    pub(crate) fn serve_newcomers(&self) {
        // In the heap a newcomer takes the last sample itself.
        if let Self::Ipc(member) = self {
            member.serve_newcomers();
        }
    }

    /// Raised when a bell was opened.
    pub(crate) fn more_bells(&self) -> &Signal {
        match self {
            Self::Ipc(member) => member.more_bells(),
            Self::Local(member) => member.more_bells(),
        }
    }

    pub(crate) fn changes(&self) -> BorrowedFd<'_> {
        match self {
            Self::Ipc(member) => member.changes(),
            Self::Local(member) => member.changes(),
        }
    }

    pub(crate) fn look_at_changes(&self) -> bool {
        match self {
            Self::Ipc(member) => member.look_at_changes(),
            Self::Local(member) => member.look_at_changes(),
        }
    }

    pub(crate) fn is_superseded(&self) -> bool {
        match self {
            Self::Ipc(member) => member.is_superseded(),
            Self::Local(member) => member.is_superseded(),
        }
    }
}
