//! Messages of a relay to a client, as frames and back.

use super::{Frame, ProtocolError, number_and_rest, number_of, numbered, topic_of};
use crate::error::CommandError;
use crate::limits::MAX_COMMAND_BYTES;
use crate::names::TopicName;
use crate::relay_protocol::command_error::{command_error_body, parse_command_error};
use crate::relay_protocol::text::{MAX_TEXT_BYTES, text_bytes};
use crate::reply_kind::ReplyKind;
use messages::{SampleHeader, StatusRecord};
use std::os::fd::OwnedFd;
use std::sync::Arc;

const WELCOME: u32 = 101;
const REFUSED: u32 = 102;
/// With a descriptor.
pub(in crate::relay_protocol) const SAMPLE: u32 = 103;
const NO_TOPIC: u32 = 104;
const STATUS: u32 = 105;
const REPLY: u32 = 106;
const COMMAND_FAILED: u32 = 107;
const REPORT: u32 = 108;

/// Why a relay does not serve a client.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Refusal {
    /// The relay is of another layout version.
    Version(u32),
    /// There is no bus at the moment.
    NoBus,
    /// There is a bus, which the relay cannot join.
    CannotJoin(String),
    /// Too many clients.
    Full(String),
    /// A robot that the site does not have.
    NoRobot(String),
}

/// What a relay says.
#[derive(Debug)]
pub(crate) enum FromRelay {
    /// The client is served; `control_group` names the group that may send commands, and is empty if there is none.
    Welcome { generation: u64, may_command: bool, control_group: String },
    /// The client is not served.
    Refused(Refusal),
    /// A sample, with its bytes in a sealed memory file.
    Sample { topic: TopicName, header: Box<SampleHeader>, memory: Arc<OwnedFd> },
    /// A topic cannot be followed.
    NoTopic { topic: TopicName, reason: String },
    /// A heartbeat.
    Status(Box<StatusRecord>),
    /// A reply to a command.
    Reply { id: u64, kind: ReplyKind, bytes: Vec<u8> },
    /// A command fails.
    CommandFailed { id: u64, error: CommandError },
    /// The report of the site.
    Report(Arc<[u8]>),
}

/// Bytes that a frame of the relay may have; `None` for a kind that there is not.
pub(crate) fn max_body_from_relay(kind: u32) -> Option<usize> {
    match kind {
        WELCOME | REFUSED | NO_TOPIC => Some(4 + MAX_TEXT_BYTES),
        SAMPLE => Some(size_of::<SampleHeader>()),
        STATUS => Some(size_of::<StatusRecord>()),
        REPLY => Some(4 + MAX_COMMAND_BYTES),
        COMMAND_FAILED => Some(24 + MAX_TEXT_BYTES),
        REPORT => Some(MAX_COMMAND_BYTES),
        _ => None,
    }
}

impl FromRelay {
    /// As a frame.
    pub(crate) fn frame(&self) -> Frame {
        match self {
            Self::Welcome { generation, may_command, control_group } => {
                Frame::new(WELCOME, *generation, numbered(u32::from(*may_command), text_bytes(control_group)))
            }
            Self::Refused(refusal) => {
                let (code, text) = match refusal {
                    Refusal::Version(found) => (*found, ""),
                    Refusal::NoBus => (0, ""),
                    Refusal::Full(text) | Refusal::CannotJoin(text) | Refusal::NoRobot(text) => (0, text.as_str()),
                };
                let id = match refusal {
                    Refusal::Version(_) => 1,
                    Refusal::NoBus => 2,
                    Refusal::Full(_) => 3,
                    Refusal::CannotJoin(_) => 4,
                    Refusal::NoRobot(_) => 5,
                };
                Frame::new(REFUSED, id, numbered(code, text_bytes(text)))
            }
            Self::Sample { topic, header, memory } => {
                let body = bytemuck::bytes_of(&**header).to_vec();
                Frame::new(SAMPLE, number_of(*topic), body).with(Arc::clone(memory))
            }
            Self::NoTopic { topic, reason } => Frame::new(NO_TOPIC, number_of(*topic), numbered(0, text_bytes(reason))),
            Self::Status(record) => Frame::new(STATUS, 0, bytemuck::bytes_of(&**record).to_vec()),
            Self::Reply { id, kind, bytes } => Frame::new(REPLY, *id, numbered(*kind as u32, bytes)),
            Self::CommandFailed { id, error } => Frame::new(COMMAND_FAILED, *id, command_error_body(error)),
            Self::Report(bytes) => Frame::new(REPORT, 0, bytes[..bytes.len().min(MAX_COMMAND_BYTES)].to_vec()),
        }
    }

    /// Reads what came; `descriptor` came with it.
    pub(crate) fn parse(kind: u32, id: u64, body: &[u8], descriptor: Option<OwnedFd>) -> Result<Self, ProtocolError> {
        let damaged = ProtocolError::Body { kind };
        let topic = || topic_of(id).ok_or(damaged);
        let numbered = || number_and_rest(body).ok_or(damaged);
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        Ok(match kind {
            WELCOME => {
                let (may_command, group) = numbered()?;
                Self::Welcome { generation: id, may_command: may_command != 0, control_group: text(group) }
            }
            REFUSED => {
                let (number, reason) = numbered()?;
                Self::Refused(match id {
                    1 => Refusal::Version(number),
                    2 => Refusal::NoBus,
                    4 => Refusal::CannotJoin(text(reason)),
                    5 => Refusal::NoRobot(text(reason)),
                    _ => Refusal::Full(text(reason)),
                })
            }
            SAMPLE => {
                let header: SampleHeader = bytemuck::try_pod_read_unaligned(body).map_err(|_| damaged)?;
                let memory = Arc::new(descriptor.ok_or(damaged)?);
                Self::Sample { topic: topic()?, header: Box::new(header), memory }
            }
            NO_TOPIC => Self::NoTopic { topic: topic()?, reason: text(numbered()?.1) },
            STATUS => Self::Status(Box::new(bytemuck::try_pod_read_unaligned(body).map_err(|_| damaged)?)),
            REPLY => {
                let (reply, bytes) = numbered()?;
                let kind = ReplyKind::from_id(reply).ok_or(damaged)?;
                Self::Reply { id, kind, bytes: bytes.to_vec() }
            }
            COMMAND_FAILED => Self::CommandFailed { id, error: parse_command_error(body).ok_or(damaged)? },
            REPORT => Self::Report(body.into()),
            kind => return Err(ProtocolError::Frame { kind, length: body.len() as u32 }),
        })
    }
}
