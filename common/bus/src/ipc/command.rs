//! Commands and streamed replies in shared memory.

use super::event_port::EventPort;
use super::membership::Membership;
use super::node::check_memory;
use super::wire::WireCommand;
use super::{memory, services};
use crate::error::{CommandError, PortError};
use crate::limits::{MAX_CLIENTS, MAX_NODES};
use crate::names::Daemon;
use crate::reply_kind::ReplyKind;
use crate::robot_name::OfRobot;
use crate::wakeup::{EventService, Wakeup};
use iceoryx2::active_request::ActiveRequest;
use iceoryx2::pending_response::PendingResponse;
use iceoryx2::port::LoanError;
use iceoryx2::port::client::{Client as ClientPort, RequestSendError};
use iceoryx2::port::server::Server as ServerPort;
use iceoryx2::prelude::{AllocationStrategy, BackpressureStrategy, PortFactory};
use iceoryx2::service::builder::request_response::RequestResponseOpenError;
use iceoryx2::service::ipc_threadsafe::Service;
use iceoryx2::service::port_factory::client::ClientCreateError;
use iceoryx2::service::port_factory::server::ServerCreateError;
use std::fmt::Debug;
use std::mem::MaybeUninit;
use std::sync::Arc;

/// Bytes of the first segment of a client or server; larger ones are made when they are needed.
const INITIAL_BYTES: usize = 4096;

fn open(membership: &Membership, daemon: OfRobot<Daemon>) -> Result<services::CommandService, PortError> {
    check_memory()?;
    services::command(&membership.node, daemon).open().map_err(|e| match e {
        RequestResponseOpenError::DoesNotExist => PortError::Missing { what: daemon.command() },
        RequestResponseOpenError::ExceedsMaxNumberOfNodes => full(daemon, MAX_NODES),
        e => refused_port(daemon, e),
    })
}

fn full(daemon: OfRobot<Daemon>, max: usize) -> PortError {
    PortError::Full { what: daemon.command(), max }
}

fn refused_port(daemon: OfRobot<Daemon>, reason: impl Debug) -> PortError {
    PortError::Refused { what: daemon.command(), reason: format!("{reason:?}") }
}

fn refused(daemon: Daemon, reason: impl Debug) -> CommandError {
    CommandError::Refused { daemon, reason: format!("{reason:?}") }
}

fn require_room(length: usize) -> Result<(), CommandError> {
    let free_bytes = memory::free_bytes();
    if free_bytes < memory::RESERVE_BYTES / 2 { Err(CommandError::NoMemory { length, free_bytes }) } else { Ok(()) }
}

/// Makes the pages of a loan; its content is written afterwards.
fn populate(memory: &mut [MaybeUninit<u8>]) -> Result<(), CommandError> {
    let length = memory.len();
    memory::populate(memory).map_err(|_| CommandError::NoMemory { length, free_bytes: memory::free_bytes() })
}

/// The bytes as a slice that is never empty, which the library does not promise to carry.
fn not_empty(bytes: &[u8]) -> &[u8] {
    if bytes.is_empty() { &[0] } else { bytes }
}

fn used(payload: &[u8], length: u64) -> &[u8] {
    payload.get(..length as usize).unwrap_or(payload)
}

/// The answering end of a daemon's commands.
pub(crate) struct Server {
    port: ServerPort<Service, [u8], WireCommand, [u8], WireCommand>,
    event_port: Arc<EventPort>,
    daemon: Daemon,
    membership: Arc<Membership>,
}

impl Server {
    pub(crate) fn open(membership: &Arc<Membership>, daemon: OfRobot<Daemon>) -> Result<Self, PortError> {
        let event_port = membership.event_port(EventService::Of(daemon))?;
        let port = open(membership, daemon)?
            .server_builder()
            .initial_max_slice_len(INITIAL_BYTES)
            .allocation_strategy(AllocationStrategy::PowerOfTwo)
            .backpressure_strategy(BackpressureStrategy::DiscardData)
            .create()
            .map_err(|e| match e {
                ServerCreateError::ExceedsMaxSupportedServers => PortError::Taken { what: daemon.command() },
                e => refused_port(daemon, e),
            })?;
        Ok(Self { port, event_port, daemon: daemon.what, membership: Arc::clone(membership) })
    }

    pub(crate) fn receive(&self) -> Result<Option<Served>, CommandError> {
        let request = self.port.receive().map_err(|e| refused(self.daemon, e))?;
        Ok(request.map(|request| Served {
            request,
            event_port: NotifyAtEnd(Arc::clone(&self.event_port)),
            daemon: self.daemon,
            _membership: Arc::clone(&self.membership),
        }))
    }
}

/// A command that is being carried out.
pub(crate) struct Served {
    request: ActiveRequest<Service, [u8], WireCommand, [u8], WireCommand>,
    /// Behind the request: the client is woken when it is closed.
    event_port: NotifyAtEnd,
    daemon: Daemon,
    _membership: Arc<Membership>,
}

/// Wakes clients when it goes away.
struct NotifyAtEnd(Arc<EventPort>);

impl Drop for NotifyAtEnd {
    fn drop(&mut self) {
        self.0.notify(Wakeup::Reply);
    }
}

impl Served {
    pub(crate) fn bytes(&self) -> &[u8] {
        used(self.request.payload(), self.request.user_header().length)
    }

    pub(crate) fn caller_uid(&self) -> u32 {
        self.request.user_header().uid
    }

    pub(crate) fn is_cancelled(&self) -> bool {
        !self.request.is_connected() || self.request.has_disconnect_hint()
    }

    pub(crate) fn reply(&self, kind: ReplyKind, bytes: &[u8]) -> Result<(), CommandError> {
        if !self.request.is_connected() {
            return Ok(());
        }
        require_room(bytes.len())?;
        let payload = not_empty(bytes);
        let mut reply = self.request.loan_slice_uninit(payload.len()).map_err(|e| refused(self.daemon, e))?;
        populate(reply.payload_mut())?;
        let mut reply = reply.write_from_slice(payload);
        *reply.user_header_mut() = WireCommand { length: bytes.len() as u64, kind: kind as u32, uid: 0 };
        reply.send().map_err(|e| refused(self.daemon, e))?;
        self.event_port.0.notify(Wakeup::Reply);
        Ok(())
    }
}

/// The asking end of a daemon's commands.
pub(crate) struct Client {
    port: ClientPort<Service, [u8], WireCommand, [u8], WireCommand>,
    service: services::CommandService,
    event_port: Arc<EventPort>,
    daemon: Daemon,
    membership: Arc<Membership>,
}

impl Client {
    pub(crate) fn open(membership: &Arc<Membership>, daemon: OfRobot<Daemon>) -> Result<Self, PortError> {
        let event_port = membership.event_port(EventService::Of(daemon))?;
        let service = open(membership, daemon)?;
        let port = service
            .client_builder()
            .initial_max_slice_len(INITIAL_BYTES)
            .allocation_strategy(AllocationStrategy::PowerOfTwo)
            .backpressure_strategy(BackpressureStrategy::DiscardData)
            .create()
            .map_err(|e| match e {
                ClientCreateError::ExceedsMaxSupportedClients => full(daemon, MAX_CLIENTS),
                e => refused_port(daemon, e),
            })?;
        Ok(Self { port, service, event_port, daemon: daemon.what, membership: Arc::clone(membership) })
    }

    /// Sends a command in the name of a user.
    pub(crate) fn send(&self, bytes: &[u8], uid: u32) -> Result<Exchange, CommandError> {
        require_room(bytes.len())?;
        let too_many = CommandError::TooMany { daemon: self.daemon };
        let payload = not_empty(bytes);
        let mut request = self.port.loan_slice_uninit(payload.len()).map_err(|e| match e {
            LoanError::ExceedsMaxLoans => CommandError::TooMany { daemon: self.daemon },
            e => refused(self.daemon, e),
        })?;
        populate(request.payload_mut())?;
        let mut request = request.write_from_slice(payload);
        *request.user_header_mut() = WireCommand { length: bytes.len() as u64, kind: 0, uid };
        let pending = request.send().map_err(|e| match e {
            RequestSendError::ExceedsMaxActiveRequests => too_many,
            e => refused(self.daemon, e),
        })?;
        if pending.number_of_server_connections() == 0 {
            // A server that has not yet thrown away commands which this client cancelled takes no more of them.
            let full = self.service.dynamic_config().number_of_servers() > 0;
            let daemon = self.daemon;
            return Err(if full { CommandError::TooMany { daemon } } else { CommandError::NotServed { daemon } });
        }
        self.event_port.notify(Wakeup::Command);
        Ok(Exchange { pending, daemon: self.daemon, _membership: Arc::clone(&self.membership) })
    }
}

/// A command that waits for its replies.
pub(crate) struct Exchange {
    pending: PendingResponse<Service, [u8], WireCommand, [u8], WireCommand>,
    daemon: Daemon,
    _membership: Arc<Membership>,
}

impl Exchange {
    pub(crate) fn receive(&self) -> Result<Option<(ReplyKind, Vec<u8>)>, CommandError> {
        // Asked first: a server that answers and goes away between the two looks has answered.
        let connected = self.pending.is_connected();
        let Some(reply) = self.pending.receive().map_err(|e| refused(self.daemon, e))? else {
            return if connected { Ok(None) } else { Err(CommandError::Lost { daemon: self.daemon }) };
        };
        let header = *reply.user_header();
        let kind = ReplyKind::from_id(header.kind).ok_or_else(|| refused(self.daemon, "a reply of no known kind"))?;
        Ok(Some((kind, used(reply.payload(), header.length).to_vec())))
    }
}
