//! Frames: a header of 16 bytes with kind, length and number, then a body. All numbers are those of the machine: both ends
//! run on it.

use super::command_error::{command_error_body, parse_command_error};
use super::text::{MAX_TEXT_BYTES, text_bytes};
use crate::error::CommandError;
use crate::limits::MAX_COMMAND_BYTES;
use crate::names::{Daemon, TopicName};
use crate::reply_kind::ReplyKind;
use crate::report_kind::ReportKind;
use bytemuck::{Pod, Zeroable};
use messages::{LAYOUT_VERSION, SampleHeader, StatusRecord};
use std::os::fd::OwnedFd;
use std::sync::Arc;

/// First bytes of a conversation.
const MAGIC: u32 = u32::from_le_bytes(*b"GPRL");

/// Header of a frame.
#[derive(Debug, Clone, Copy, Zeroable, Pod)]
#[repr(C)]
pub(crate) struct FrameHeader {
    pub(super) kind: u32,
    /// Bytes of the body.
    pub(super) length: u32,
    /// What the frame is about: a topic, a command.
    pub(super) id: u64,
}

/// A frame on its way out.
#[derive(Debug)]
pub(crate) struct Frame {
    pub(super) header: FrameHeader,
    pub(super) body: Vec<u8>,
    /// Travels beside the bytes.
    pub(super) descriptor: Option<Arc<OwnedFd>>,
}

impl Frame {
    fn new(kind: u32, id: u64, body: Vec<u8>) -> Self {
        let length = u32::try_from(body.len()).expect("bodies are far shorter than 4 GiB");
        Self { header: FrameHeader { kind, length, id }, body, descriptor: None }
    }

    fn with(mut self, descriptor: Arc<OwnedFd>) -> Self {
        self.descriptor = Some(descriptor);
        self
    }
}

/// Bytes that are no frame of this protocol: the other end is cut off.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub(crate) enum ProtocolError {
    /// A kind that there is not, or a longer body than it may have.
    #[error("a frame of kind {kind} with {length} bytes")]
    Frame {
        /// As sent.
        kind: u32,
        /// As sent.
        length: u32,
    },
    /// A body that is not that of its kind.
    #[error("a frame of kind {kind} with a damaged body")]
    Body {
        /// As sent.
        kind: u32,
    },
}

/// What a client says.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum ToRelay {
    /// The first frame.
    Hello { layout_version: u32 },
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

const HELLO: u32 = 1;
const SUBSCRIBE: u32 = 2;
const UNSUBSCRIBE: u32 = 3;
const TAKEN: u32 = 4;
const SUBSCRIBE_STATUS: u32 = 5;
const COMMAND: u32 = 6;
const CANCEL: u32 = 7;
const ASK_REPORT: u32 = 8;

const WELCOME: u32 = 101;
const REFUSED: u32 = 102;
/// With a descriptor.
pub(super) const SAMPLE: u32 = 103;
const NO_TOPIC: u32 = 104;
const STATUS: u32 = 105;
const REPLY: u32 = 106;
const COMMAND_FAILED: u32 = 107;
const REPORT: u32 = 108;

/// Bytes that a frame to the relay may have; `None` for a kind that there is not. Only those who `may_command` send long
/// ones.
pub(crate) fn max_body_to_relay(kind: u32, may_command: bool) -> Option<usize> {
    match kind {
        HELLO => Some(8),
        SUBSCRIBE | UNSUBSCRIBE | TAKEN | SUBSCRIBE_STATUS | CANCEL | ASK_REPORT => Some(0),
        COMMAND if may_command => Some(4 + MAX_COMMAND_BYTES),
        _ => None,
    }
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

impl ToRelay {
    /// The first frame of this program.
    pub(crate) fn hello() -> Self {
        Self::Hello { layout_version: LAYOUT_VERSION }
    }

    /// As a frame.
    pub(crate) fn frame(&self) -> Frame {
        match self {
            Self::Hello { layout_version } => Frame::new(HELLO, 0, numbered(MAGIC, &layout_version.to_ne_bytes())),
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
                let (layout_version, _) = number_and_rest(rest).ok_or(damaged)?;
                if magic != MAGIC {
                    return Err(damaged);
                }
                Self::Hello { layout_version }
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
                    Refusal::Full(text) | Refusal::CannotJoin(text) => (0, text.as_str()),
                };
                let id = match refusal {
                    Refusal::Version(_) => 1,
                    Refusal::NoBus => 2,
                    Refusal::Full(_) => 3,
                    Refusal::CannotJoin(_) => 4,
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

fn number_of(topic: TopicName) -> u64 {
    TopicName::all().position(|other| other == topic).expect("all topics are listed") as u64
}

fn topic_of(number: u64) -> Option<TopicName> {
    TopicName::all().nth(usize::try_from(number).ok()?)
}

/// A body that begins with a number.
fn numbered(number: u32, rest: &[u8]) -> Vec<u8> {
    [&number.to_ne_bytes(), rest].concat()
}

fn number_and_rest(body: &[u8]) -> Option<(u32, &[u8])> {
    let (number, rest) = body.split_first_chunk()?;
    Some((u32::from_ne_bytes(*number), rest))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::relay_protocol::{FrameReader, FrameWriter, read_sealed, seal};
    use rustix::net::SendFlags;
    use std::os::unix::net::UnixStream;

    fn through_a_socket(frame: Frame) -> (u32, u64, Vec<u8>, Option<OwnedFd>) {
        let (near, far) = UnixStream::pair().unwrap();
        let (mut writer, mut reader) = (FrameWriter::default(), FrameReader::default());
        writer.begin(frame);
        loop {
            writer.flush(&near, SendFlags::DONTWAIT).unwrap();
            assert!(reader.fill_with_descriptors(&far).unwrap().is_some());
            if let Some(received) = reader.next(|_| Some(usize::MAX)).unwrap() {
                assert!(writer.is_idle() && reader.is_empty());
                return (received.kind, received.id, received.body, received.descriptor);
            }
        }
    }

    #[test]
    fn what_a_client_says_is_what_the_relay_reads() {
        let long: Vec<u8> = (0..300_000u32).map(|k| k as u8).collect();
        for said in [
            ToRelay::hello(),
            ToRelay::Subscribe(TopicName::Site),
            ToRelay::Unsubscribe(TopicName::all().last().unwrap()),
            ToRelay::Taken(TopicName::Grids),
            ToRelay::SubscribeStatus,
            ToRelay::Command { id: u64::MAX, daemon: Daemon::SlamAlign, bytes: long },
            ToRelay::Cancel { id: 7 },
            ToRelay::Report(ReportKind::History),
        ] {
            let (kind, id, body, _) = through_a_socket(said.frame());
            assert!(max_body_to_relay(kind, true).is_some_and(|max| body.len() <= max));
            assert_eq!(ToRelay::parse(kind, id, &body), Ok(said));
        }
    }

    #[test]
    fn what_the_relay_says_is_what_a_client_reads() {
        let header = SampleHeader { epoch: 5, payload_length: 3, ..SampleHeader::of(TopicName::Grids.kind()) };
        let memory = Arc::new(seal("test", b"abc").unwrap());
        let daemon = Daemon::Rasterize;
        for said in [
            FromRelay::Welcome { generation: 9, may_command: true, control_group: "crew".to_owned() },
            FromRelay::Refused(Refusal::Version(6)),
            FromRelay::Refused(Refusal::NoBus),
            FromRelay::Refused(Refusal::Full("too many".to_owned())),
            FromRelay::Refused(Refusal::CannotJoin("another version".to_owned())),
            FromRelay::Sample { topic: TopicName::Grids, header: Box::new(header), memory },
            FromRelay::NoTopic { topic: TopicName::Site, reason: "full".to_owned() },
            FromRelay::Status(Box::new(StatusRecord { process_id: 5, ..Zeroable::zeroed() })),
            FromRelay::Reply { id: 3, kind: ReplyKind::Done, bytes: vec![1, 2, 3] },
            FromRelay::CommandFailed { id: 1, error: CommandError::NotServed { daemon } },
            FromRelay::CommandFailed { id: 1, error: CommandError::Lost { daemon } },
            FromRelay::CommandFailed { id: 1, error: CommandError::TooLarge { length: 8, max: 7 } },
            FromRelay::CommandFailed { id: 1, error: CommandError::TooMany { daemon } },
            FromRelay::CommandFailed { id: 1, error: CommandError::NoMemory { length: 8, free_bytes: 7 } },
            FromRelay::CommandFailed { id: 1, error: CommandError::Refused { daemon, reason: "no".to_owned() } },
            FromRelay::Report(b"{}".as_slice().into()),
        ] {
            let (kind, id, body, descriptor) = through_a_socket(said.frame());
            assert!(max_body_from_relay(kind).is_some_and(|max| body.len() <= max));
            assert_eq!(descriptor.is_some(), kind == SAMPLE);
            let heard = FromRelay::parse(kind, id, &body, descriptor).unwrap();
            if let FromRelay::Sample { memory, .. } = &heard {
                assert_eq!(read_sealed(memory, 3).unwrap().bytes(), b"abc");
            } else {
                assert_eq!(format!("{heard:?}"), format!("{said:?}"));
            }
        }
    }

    #[test]
    fn hostile_bytes_are_errors_and_never_more() {
        let mut state = 1u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            state >> 33
        };
        let (mut refused, mut read) = (0, 0);
        for _ in 0..20_000 {
            let kind = if random() % 2 == 0 { random() % 10 } else { 100 + random() % 10 } as u32;
            let body: Vec<u8> = (0..random() % 300).map(|_| random() as u8).collect();
            let outcomes = [
                ToRelay::parse(kind, random() % 80, &body).is_ok(),
                FromRelay::parse(kind, random() % 80, &body, None).is_ok(),
            ];
            for outcome in outcomes {
                *(if outcome { &mut read } else { &mut refused }) += 1;
            }
        }
        assert!(refused > 1000 && read > 1000, "{refused} refused, {read} read");
    }

    #[test]
    fn a_length_beyond_its_bound_is_refused_before_its_bytes_come() {
        let (near, far) = UnixStream::pair().unwrap();
        let header = FrameHeader { kind: COMMAND, length: u32::MAX, id: 0 };
        rustix::io::write(&near, bytemuck::bytes_of(&header)).unwrap();
        let mut reader = FrameReader::default();
        assert_eq!(reader.fill(&far).unwrap(), Some(size_of::<FrameHeader>()));
        let refused = reader.next(|kind| max_body_to_relay(kind, true)).map(drop);
        assert_eq!(refused, Err(ProtocolError::Frame { kind: COMMAND, length: u32::MAX }));
        assert_eq!(max_body_to_relay(COMMAND, false), None, "who may look only sends no commands");
    }
}
