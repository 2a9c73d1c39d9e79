//! The two ways to a bus: as a participant in its shared memory, or as a client of its relay. Each port has one of them.

use crate::error::{CommandError, PortError, ReceiveError};
use crate::ipc;
use crate::names::{Daemon, TopicName};
use crate::relay_link::{CommandLink, CopiedSample, RelayLink, RelayedCommand, StatusSubscription, TopicSubscription};
use crate::reply_kind::ReplyKind;
use messages::{SampleHeader, StatusRecord};
use std::sync::Arc;

/// The way of a participant.
#[derive(Clone)]
pub(crate) enum Link {
    Member(Arc<ipc::Membership>),
    Relay(Arc<RelayLink>),
}

impl Link {
    pub(crate) fn generation(&self) -> u64 {
        match self {
            Self::Member(member) => member.generation(),
            Self::Relay(relay) => relay.generation(),
        }
    }

    /// The membership that an end needs which only the bus's user has.
    pub(crate) fn member(&self, what: impl Into<String>) -> Result<&Arc<ipc::Membership>, PortError> {
        match self {
            Self::Member(member) => Ok(member),
            Self::Relay(relay) => Err(relay.owner_only(what)),
        }
    }

    pub(crate) fn topic_source(&self, topic: TopicName) -> Result<TopicSource, PortError> {
        Ok(match self {
            Self::Member(member) => TopicSource::Memory(ipc::TopicReader::open(member, topic)?),
            Self::Relay(relay) => TopicSource::Relay(relay.subscribe(topic)),
        })
    }

    pub(crate) fn status_source(&self) -> Result<StatusSource, PortError> {
        Ok(match self {
            Self::Member(member) => StatusSource::Memory(ipc::StatusSource::open(member)?),
            Self::Relay(relay) => StatusSource::Relay(relay.subscribe_status()),
        })
    }

    pub(crate) fn command_target(&self, daemon: Daemon) -> Result<CommandTarget, PortError> {
        Ok(match self {
            Self::Member(member) => CommandTarget::Memory(ipc::Client::open(member, daemon)?),
            Self::Relay(relay) => CommandTarget::Relay(relay.commands(daemon)?),
        })
    }
}

/// The receiving end of a topic.
pub(crate) enum TopicSource {
    Memory(ipc::TopicReader),
    Relay(TopicSubscription),
}

impl TopicSource {
    pub(crate) fn receive(&self) -> Result<Option<SampleMemory>, ReceiveError> {
        Ok(match self {
            Self::Memory(port) => port.receive()?.map(SampleMemory::Shared),
            Self::Relay(port) => port.receive()?.map(|sample| SampleMemory::Copied(Box::new(sample))),
        })
    }
}

/// A sample where it is read: in the memory of its publisher, or in a copy.
pub(crate) enum SampleMemory {
    Shared(ipc::TopicSample),
    Copied(Box<CopiedSample>),
}

impl SampleMemory {
    pub(crate) fn header(&self) -> &SampleHeader {
        match self {
            Self::Shared(sample) => sample.header(),
            Self::Copied(sample) => sample.header(),
        }
    }

    pub(crate) fn bytes(&self) -> &[u8] {
        match self {
            Self::Shared(sample) => sample.bytes(),
            Self::Copied(sample) => sample.bytes(),
        }
    }
}

/// The receiving end of heartbeats.
pub(crate) enum StatusSource {
    Memory(ipc::StatusSource),
    Relay(StatusSubscription),
}

impl StatusSource {
    pub(crate) fn receive(&self) -> Result<Option<StatusRecord>, ReceiveError> {
        match self {
            Self::Memory(port) => port.receive(),
            Self::Relay(port) => Ok(port.receive()),
        }
    }
}

/// The asking end of a daemon's commands.
pub(crate) enum CommandTarget {
    Memory(ipc::Client),
    Relay(CommandLink),
}

impl CommandTarget {
    /// Sends a command; `uid` is the user in whose name a member sends it. The relay knows that of its clients.
    pub(crate) fn send(&self, bytes: &[u8], uid: u32) -> Result<Exchange, CommandError> {
        Ok(match self {
            Self::Memory(port) => Exchange::Memory(port.send(bytes, uid)?),
            Self::Relay(port) => Exchange::Relay(port.send(bytes)?),
        })
    }
}

/// A command that waits for its replies.
pub(crate) enum Exchange {
    Memory(ipc::Exchange),
    Relay(RelayedCommand),
}

impl Exchange {
    pub(crate) fn receive(&self) -> Result<Option<(ReplyKind, Vec<u8>)>, CommandError> {
        match self {
            Self::Memory(exchange) => exchange.receive(),
            Self::Relay(exchange) => exchange.receive(),
        }
    }
}
