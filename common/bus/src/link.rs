//! The three ways to a bus: as a participant in its shared memory, as a client of its relay, or inside one process. Each port
//! has one of them.

use crate::error::{CommandError, PortError, PublishError, ReceiveError};
use crate::in_process::{self, InProcessBus};
use crate::ipc;
use crate::names::{Daemon, TopicName};
use crate::relay_link::{CommandLink, CopiedSample, RelayLink, RelayedCommand, StatusSubscription, TopicSubscription};
use crate::reply_kind::ReplyKind;
use crate::robot_name::{OfRobot, RobotName};
use crate::waiter::Source;
use messages::{SampleHeader, StatusRecord};
use std::sync::Arc;

/// The way of a participant.
#[derive(Clone)]
pub(crate) enum Link {
    Member(Arc<ipc::Membership>),
    Relay(Arc<RelayLink>),
    InProcess(InProcessBus),
}

impl From<Source> for Link {
    fn from(source: Source) -> Self {
        match source {
            Source::Member(member) => Self::Member(member),
            Source::Relay(relay) => Self::Relay(relay),
        }
    }
}

impl Link {
    pub(crate) fn generation(&self) -> u64 {
        match self {
            Self::Member(member) => member.generation(),
            Self::Relay(relay) => relay.generation(),
            Self::InProcess(bus) => bus.generation(),
        }
    }

    pub(crate) fn topic_target(&self, topic: OfRobot<TopicName>, length: usize) -> Result<TopicTarget, PortError> {
        Ok(match self {
            Self::Member(member) => TopicTarget::Memory(ipc::TopicWriter::open(member, topic, length)?),
            Self::Relay(relay) => return Err(relay.owner_only(topic.to_string())),
            Self::InProcess(bus) => TopicTarget::InProcess(bus.topic_writer(topic)?),
        })
    }

    pub(crate) fn topic_source(&self, topic: OfRobot<TopicName>) -> Result<TopicSource, PortError> {
        Ok(match self {
            Self::Member(member) => TopicSource::Memory(ipc::TopicReader::open(member, topic)?),
            Self::Relay(relay) => TopicSource::Relay(relay.subscribe(topic.what)),
            Self::InProcess(bus) => TopicSource::InProcess(bus.topic_reader(topic)),
        })
    }

    /// The sending end of the status stream of the site, or of a robot.
    pub(crate) fn status_target(&self, robot: Option<RobotName>) -> Result<StatusTarget, PortError> {
        Ok(match self {
            Self::Member(member) => StatusTarget::Memory(ipc::StatusTarget::open(member, robot)?),
            Self::Relay(relay) => return Err(relay.owner_only("status")),
            Self::InProcess(bus) => StatusTarget::InProcess(bus.status_target(robot)),
        })
    }

    /// The receiving end of the status stream of the site, or of a robot; a relay has both in one.
    pub(crate) fn status_source(&self, robot: Option<RobotName>) -> Result<StatusSource, PortError> {
        Ok(match self {
            Self::Member(member) => StatusSource::Memory(ipc::StatusSource::open(member, robot)?),
            Self::Relay(relay) => StatusSource::Relay(relay.subscribe_status()),
            Self::InProcess(bus) => StatusSource::InProcess(bus.status_source(robot)),
        })
    }

    pub(crate) fn command_server(&self, daemon: OfRobot<Daemon>) -> Result<ipc::Server, PortError> {
        match self {
            Self::Member(member) => ipc::Server::open(member, daemon),
            Self::Relay(relay) => Err(relay.owner_only(daemon.command())),
            Self::InProcess(_) => Err(InProcessBus::no_commands(daemon)),
        }
    }

    pub(crate) fn command_target(&self, daemon: OfRobot<Daemon>) -> Result<CommandTarget, PortError> {
        Ok(match self {
            Self::Member(member) => CommandTarget::Memory(ipc::Client::open(member, daemon)?),
            Self::Relay(relay) => CommandTarget::Relay(relay.commands(daemon.what)?),
            Self::InProcess(_) => return Err(InProcessBus::no_commands(daemon)),
        })
    }
}

/// The publishing end of a topic.
pub(crate) enum TopicTarget {
    Memory(Arc<ipc::TopicWriter>),
    InProcess(in_process::TopicWriter),
}

impl TopicTarget {
    pub(crate) fn loan(&self, length: usize) -> Result<LoanMemory<'_>, PublishError> {
        Ok(match self {
            Self::Memory(port) => LoanMemory::Shared(port, port.loan(length)?),
            Self::InProcess(port) => LoanMemory::InProcess(port.loan(length)?),
        })
    }
}

/// Memory of a sample to be, with the port that sends it.
pub(crate) enum LoanMemory<'a> {
    Shared(&'a ipc::TopicWriter, ipc::Memory),
    InProcess(in_process::Loan<'a>),
}

impl LoanMemory<'_> {
    pub(crate) fn bytes(&self) -> &[u8] {
        match self {
            Self::Shared(_, memory) => memory.bytes(),
            Self::InProcess(loan) => loan.bytes(),
        }
    }

    pub(crate) fn bytes_mut(&mut self) -> &mut [u8] {
        match self {
            Self::Shared(_, memory) => memory.bytes_mut(),
            Self::InProcess(loan) => loan.bytes_mut(),
        }
    }

    /// Sends the sample; the number of subscribers that it went to.
    pub(crate) fn send(self, header: SampleHeader) -> Result<usize, PublishError> {
        match self {
            Self::Shared(port, memory) => port.send(memory, header),
            Self::InProcess(loan) => Ok(loan.send(header)),
        }
    }
}

/// The receiving end of a topic.
pub(crate) enum TopicSource {
    Memory(ipc::TopicReader),
    Relay(TopicSubscription),
    InProcess(in_process::TopicReader),
}

impl TopicSource {
    pub(crate) fn receive(&self) -> Result<Option<SampleMemory>, ReceiveError> {
        Ok(match self {
            Self::Memory(port) => port.receive()?.map(SampleMemory::Shared),
            Self::Relay(port) => port.receive()?.map(|sample| SampleMemory::Copied(Box::new(sample))),
            Self::InProcess(port) => port.receive().map(SampleMemory::InProcess),
        })
    }
}

/// A sample where it is read: in the memory of its publisher, or in a copy.
pub(crate) enum SampleMemory {
    Shared(ipc::TopicSample),
    Copied(Box<CopiedSample>),
    InProcess(Arc<in_process::TopicSample>),
}

impl SampleMemory {
    pub(crate) fn header(&self) -> &SampleHeader {
        match self {
            Self::Shared(sample) => sample.header(),
            Self::Copied(sample) => sample.header(),
            Self::InProcess(sample) => sample.header(),
        }
    }

    pub(crate) fn bytes(&self) -> &[u8] {
        match self {
            Self::Shared(sample) => sample.bytes(),
            Self::Copied(sample) => sample.bytes(),
            Self::InProcess(sample) => sample.bytes(),
        }
    }
}

/// The sending end of heartbeats.
pub(crate) enum StatusTarget {
    Memory(ipc::StatusTarget),
    InProcess(in_process::StatusTarget),
}

impl StatusTarget {
    /// False if it could not be sent.
    pub(crate) fn send(&self, record: StatusRecord) -> bool {
        match self {
            Self::Memory(port) => port.send(record),
            Self::InProcess(port) => port.send(record),
        }
    }
}

/// The receiving end of heartbeats.
pub(crate) enum StatusSource {
    Memory(ipc::StatusSource),
    Relay(StatusSubscription),
    InProcess(in_process::StatusSource),
}

impl StatusSource {
    pub(crate) fn receive(&self) -> Result<Option<StatusRecord>, ReceiveError> {
        match self {
            Self::Memory(port) => port.receive(),
            Self::Relay(port) => Ok(port.receive()),
            Self::InProcess(port) => Ok(port.receive()),
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
