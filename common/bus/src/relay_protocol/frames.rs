//! Frames: a header of 16 bytes with kind, length and number, then a body. All numbers are those of the machine: both ends
//! run on it.

mod from_relay;
mod to_relay;

use crate::names::TopicName;
use bytemuck::{Pod, Zeroable};
pub(super) use from_relay::SAMPLE;
pub(crate) use from_relay::{FromRelay, Refusal, max_body_from_relay};
use std::os::fd::OwnedFd;
use std::sync::Arc;
pub(crate) use to_relay::{ToRelay, max_body_to_relay};

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
    use super::to_relay::COMMAND;
    use super::*;
    use crate::error::CommandError;
    use crate::names::Daemon;
    use crate::relay_protocol::{FrameReader, FrameWriter, read_sealed, seal};
    use crate::reply_kind::ReplyKind;
    use crate::report_kind::ReportKind;
    use messages::{SampleHeader, StatusRecord};
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
            ToRelay::hello(None),
            ToRelay::hello(Some("lift-2".parse().unwrap())),
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
            FromRelay::Refused(Refusal::NoRobot("there is none".to_owned())),
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
    fn a_client_without_a_named_robot_begins_as_before_robots_had_names() {
        let frame = ToRelay::hello(None).frame();
        assert_eq!(frame.body, [b"GPRL".as_slice(), &messages::LAYOUT_VERSION.to_ne_bytes()].concat());
        let no_name = [frame.body.as_slice(), b"Lift"].concat();
        assert!(ToRelay::parse(frame.header.kind, 0, &no_name).is_err());
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
