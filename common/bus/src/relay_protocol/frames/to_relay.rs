//! Messages of a client to a relay, as frames and back.

use super::{Frame, ProtocolError, number_and_rest, number_of, numbered, topic_of};
use crate::limits::{MAX_COMMAND_BYTES, MAX_ROBOT_NAME_BYTES};
use crate::names::{Daemon, TopicName};
use crate::report_kind::ReportKind;
use crate::robot_name::RobotName;
use messages::LAYOUT_VERSION;

/// First bytes of a conversation.
const MAGIC: u32 = u32::from_le_bytes(*b"GPRL");

const HELLO: u32 = 1;
const SUBSCRIBE: u32 = 2;
const UNSUBSCRIBE: u32 = 3;
const TAKEN: u32 = 4;
const SUBSCRIBE_STATUS: u32 = 5;
pub(super) const COMMAND: u32 = 6;
const CANCEL: u32 = 7;
const ASK_REPORT: u32 = 8;

/// What a client says.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum ToRelay {
    /// The first frame; with a robot, what is a robot's means this one's. Without one the frame is as it was before robots had
    /// names.
    Hello { layout_version: u32, robot: Option<RobotName> },
    /// Samples of a topic, the last one at once.
    Subscribe(TopicName),
    /// No more of them.
    Unsubscribe(TopicName),
    /// A sample has come; the next one may be sent.
    Taken(TopicName),
    /// Heartbeats.
    SubscribeStatus,
    /// A command under a number of the client's choice.
    Command { id: u64, daemon: Daemon, bytes: Vec<u8> },
    /// The answer to a command is not wanted any more.
    Cancel { id: u64 },
    /// A report of the site.
    Report(ReportKind),
}

/// Bytes that a frame to the relay may have; `None` for a kind that there is not. Only those who `may_command` send long
/// ones.
pub(crate) fn max_body_to_relay(kind: u32, may_command: bool) -> Option<usize> {
    match kind {
        HELLO => Some(8 + MAX_ROBOT_NAME_BYTES),
        SUBSCRIBE | UNSUBSCRIBE | TAKEN | SUBSCRIBE_STATUS | CANCEL | ASK_REPORT => Some(0),
        COMMAND if may_command => Some(4 + MAX_COMMAND_BYTES),
        _ => None,
    }
}

impl ToRelay {
    /// The first frame of this program.
    pub(crate) fn hello(robot: Option<RobotName>) -> Self {
        Self::Hello { layout_version: LAYOUT_VERSION, robot }
    }

    /// As a frame.
    pub(crate) fn frame(&self) -> Frame {
        match self {
            Self::Hello { layout_version, robot } => {
                let name = robot.as_ref().map_or("", RobotName::as_str).as_bytes();
                Frame::new(HELLO, 0, numbered(MAGIC, &numbered(*layout_version, name)))
            }
            Self::Subscribe(topic) => Frame::new(SUBSCRIBE, number_of(*topic), Vec::new()),
            Self::Unsubscribe(topic) => Frame::new(UNSUBSCRIBE, number_of(*topic), Vec::new()),
            Self::Taken(topic) => Frame::new(TAKEN, number_of(*topic), Vec::new()),
            Self::SubscribeStatus => Frame::new(SUBSCRIBE_STATUS, 0, Vec::new()),
            Self::Command { id, daemon, bytes } => Frame::new(COMMAND, *id, numbered(*daemon as u32, bytes)),
            Self::Cancel { id } => Frame::new(CANCEL, *id, Vec::new()),
            Self::Report(kind) => Frame::new(ASK_REPORT, *kind as u64, Vec::new()),
        }
    }

    /// Reads what came.
    pub(crate) fn parse(kind: u32, id: u64, body: &[u8]) -> Result<Self, ProtocolError> {
        let damaged = ProtocolError::Body { kind };
        let topic = || topic_of(id).ok_or(damaged);
        Ok(match kind {
            HELLO => {
                let (magic, rest) = number_and_rest(body).ok_or(damaged)?;
                let (layout_version, name) = number_and_rest(rest).ok_or(damaged)?;
                if magic != MAGIC {
                    return Err(damaged);
                }
                let robot = match std::str::from_utf8(name).map_err(|_| damaged)? {
                    "" => None,
                    name => Some(name.parse().map_err(|_| damaged)?),
                };
                Self::Hello { layout_version, robot }
            }
            SUBSCRIBE => Self::Subscribe(topic()?),
            UNSUBSCRIBE => Self::Unsubscribe(topic()?),
            TAKEN => Self::Taken(topic()?),
            SUBSCRIBE_STATUS => Self::SubscribeStatus,
            COMMAND => {
                let (daemon, bytes) = number_and_rest(body).ok_or(damaged)?;
                let daemon = Daemon::from_id(daemon).ok_or(damaged)?;
                Self::Command { id, daemon, bytes: bytes.to_vec() }
            }
            CANCEL => Self::Cancel { id },
            ASK_REPORT => Self::Report(ReportKind::from_id(id).ok_or(damaged)?),
            kind => return Err(ProtocolError::Frame { kind, length: body.len() as u32 }),
        })
    }
}
