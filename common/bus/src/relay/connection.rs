//! A client of the relay: what it follows, what it asked, what it is still to be told. Everything that waits is bounded.

use super::event::RelayEvent;
use super::feeds::Feeds;
use super::report::Reports;
use crate::bus::Bus;
use crate::command::{CommandClient, OpenCommand, Reply};
use crate::error::{CommandError, DomainError};
use crate::limits::{STATUS_BUFFER, TAKE_TIMEOUT};
use crate::names::{Daemon, TopicName};
use crate::relay_protocol::{FrameReader, FrameWriter, FromRelay, ProtocolError, Refusal, ToRelay, max_body_to_relay};
use crate::reply_kind::ReplyKind;
use crate::robot_name::{OfRobot, RobotName};
use messages::{LAYOUT_VERSION, StatusRecord};
use rustix::event::PollFlags;
use rustix::net::SendFlags;
use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, VecDeque};
use std::io;
use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::net::UnixStream;
use std::time::{Duration, Instant};

/// Answers that a client has not read; it is not listened to until it does.
const MAX_ANSWERS: usize = 64;

/// Frames of one client that are handled before it is the turn of the others.
const MAX_FRAMES_AT_ONCE: usize = 64;

/// A client says in this time which version it is.
const HELLO_TIMEOUT: Duration = Duration::from_secs(5);

/// A client of the relay.
pub(super) struct Connection {
    socket: UnixStream,
    uid: u32,
    may_command: bool,
    since: Instant,
    state: State,
    /// The robot whose topics and daemons it means.
    robot: Option<RobotName>,
    reader: FrameReader,
    writer: FrameWriter,
    answers: VecDeque<FromRelay>,
    /// Topics that it follows, with the number of the last news of each.
    subscriptions: BTreeMap<TopicName, u64>,
    /// Samples that it has not taken, one of a topic, also of topics that it does not follow any more.
    on_their_way: BTreeMap<TopicName, OnItsWay>,
    /// Heartbeats that it has not read, if it wants any.
    status: Option<VecDeque<StatusRecord>>,
    clients: BTreeMap<Daemon, CommandClient>,
    commands: BTreeMap<u64, (Daemon, OpenCommand)>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum State {
    /// It has not said which version it is.
    New,
    Served,
    /// It is told why it is not served.
    Refused,
}

/// A sample that it was sent and has not taken.
struct OnItsWay {
    number: u64,
    n_bytes: u64,
    since: Instant,
}

/// A copy of a sample, by topic and number, and its bytes.
pub(super) type Lent = ((TopicName, u64), u64);

impl Connection {
    pub(super) fn new(socket: UnixStream, uid: u32, may_command: bool) -> Self {
        Self {
            socket,
            uid,
            may_command,
            since: Instant::now(),
            state: State::New,
            robot: None,
            reader: FrameReader::default(),
            writer: FrameWriter::default(),
            answers: VecDeque::new(),
            subscriptions: BTreeMap::new(),
            on_their_way: BTreeMap::new(),
            status: None,
            clients: BTreeMap::new(),
            commands: BTreeMap::new(),
        }
    }

    pub(super) fn uid(&self) -> u32 {
        self.uid
    }

    pub(super) fn may_command(&self) -> bool {
        self.may_command
    }

    pub(super) fn socket(&self) -> BorrowedFd<'_> {
        self.socket.as_fd()
    }

    /// What to wait for.
    pub(super) fn interest(&self) -> PollFlags {
        let reads = if self.reads() { PollFlags::IN } else { PollFlags::empty() };
        let writes = if self.writer.is_idle() { PollFlags::empty() } else { PollFlags::OUT };
        reads | writes
    }

    fn is_listened_to(&self) -> bool {
        self.answers.len() < MAX_ANSWERS && self.state != State::Refused
    }

    /// What has come is handled before more of it is read: it cannot pile up here.
    fn reads(&self) -> bool {
        self.is_listened_to() && !self.reader.has_frame()
    }

    /// True if it has said something that can be handled at once.
    pub(super) fn has_request(&self) -> bool {
        self.is_listened_to() && self.reader.has_frame()
    }

    #[cfg(test)]
    pub(super) fn n_unhandled_bytes(&self) -> usize {
        self.reader.n_bytes()
    }

    pub(super) fn follows(&self, topic: OfRobot<TopicName>) -> bool {
        self.subscriptions.contains_key(&topic.what) && self.meant(topic.what) == topic
    }

    /// The topic that it means by a name.
    fn meant(&self, topic: TopicName) -> OfRobot<TopicName> {
        OfRobot::new(self.robot, topic)
    }

    /// Outdated samples that it has not taken for a while. Their memory is there for it alone.
    pub(super) fn outdated(&self, feeds: &Feeds, now: Instant) -> impl Iterator<Item = Lent> {
        let slow = move |sample: &OnItsWay| now.saturating_duration_since(sample.since) > TAKE_TIMEOUT;
        let samples = self.on_their_way.iter().filter(move |(_, sample)| slow(sample));
        let outdated = samples.filter(|(topic, sample)| !feeds.is_newest(self.meant(**topic), sample.number));
        outdated.map(|(topic, sample)| ((*topic, sample.number), sample.n_bytes))
    }

    /// True if it is to be told why it is not served.
    pub(super) fn is_refused(&self) -> bool {
        self.state == State::Refused
    }

    /// Does not serve it, and says why.
    pub(super) fn refuse(&mut self, refusal: Refusal) {
        if self.state != State::Refused {
            self.state = State::Refused;
            self.answers.push_back(FromRelay::Refused(refusal));
        }
    }

    /// True if it is refused and knows it, or says nothing.
    pub(super) fn is_done(&self) -> bool {
        match self.state {
            State::Refused => {
                let is_told = self.answers.is_empty() && self.writer.is_idle();
                is_told || self.since.elapsed() > HELLO_TIMEOUT
            }
            State::New => self.since.elapsed() > HELLO_TIMEOUT,
            State::Served => false,
        }
    }

    /// A heartbeat of the site, or of a robot; who falls behind loses the oldest.
    pub(super) fn put_status(&mut self, robot: Option<RobotName>, record: StatusRecord) {
        if let Some(status) = self.status.as_mut().filter(|_| robot.is_none() || robot == self.robot) {
            if status.len() >= STATUS_BUFFER {
                status.pop_front();
            }
            status.push_back(record);
        }
    }

    /// Reads what has come.
    ///
    /// # Errors
    /// It is gone.
    pub(super) fn receive(&mut self) -> io::Result<()> {
        if !self.reads() || self.reader.fill(&self.socket)?.is_some() {
            return Ok(());
        }
        Err(io::ErrorKind::ConnectionReset.into())
    }

    /// Does what it asks for, a part of it at a time.
    ///
    /// # Errors
    /// It sent something that is not the protocol (`InvalidData`).
    pub(super) fn handle(
        &mut self,
        welcome: FromRelay,
        bus: &Bus,
        feeds: &mut Feeds,
        reports: &mut Reports,
        on_event: &mut dyn FnMut(RelayEvent<'_>),
    ) -> io::Result<()> {
        let mut welcome = Some(welcome);
        for _ in 0..MAX_FRAMES_AT_ONCE {
            if !self.is_listened_to() {
                break;
            }
            let Some(frame) = self.next_frame().map_err(invalid)? else { break };
            match (frame, self.state) {
                (ToRelay::Hello { layout_version, .. }, State::New) if layout_version != LAYOUT_VERSION => {
                    self.refuse(Refusal::Version(LAYOUT_VERSION));
                }
                (ToRelay::Hello { robot, .. }, State::New) => match bus.meaning(robot) {
                    Ok(_) => {
                        (self.state, self.robot) = (State::Served, robot);
                        self.answers.extend(welcome.take());
                    }
                    Err(error) => self.refuse(Refusal::NoRobot(error.to_string())),
                },
                (_, State::New) | (ToRelay::Hello { .. }, _) => return Err(invalid("a conversation without a begin")),
                (ToRelay::Subscribe(topic), _) => {
                    let followed = self.bus(bus).map_err(invalid)?;
                    match feeds.follow(&followed, self.meant(topic)) {
                        Ok(()) => drop(self.subscriptions.insert(topic, 0)),
                        Err(error) => {
                            self.answers.push_back(FromRelay::NoTopic { topic, reason: error.to_string() });
                        }
                    }
                }
                (ToRelay::Unsubscribe(topic), _) => drop(self.subscriptions.remove(&topic)),
                (ToRelay::Taken(topic), _) => drop(self.on_their_way.remove(&topic)),
                (ToRelay::SubscribeStatus, _) => drop(self.status.get_or_insert_default()),
                (ToRelay::Command { id, daemon, bytes }, _) => {
                    let robot = OfRobot::new(self.robot, daemon).robot;
                    on_event(RelayEvent::Command { uid: self.uid, daemon, robot, bytes: &bytes });
                    self.command(bus, id, daemon, &bytes);
                }
                (ToRelay::Cancel { id }, _) => self.end_command(id),
                (ToRelay::Report(kind), _) => self.answers.push_back(FromRelay::Report(reports.get(kind))),
            }
        }
        Ok(())
    }

    fn next_frame(&mut self) -> Result<Option<ToRelay>, ProtocolError> {
        let may_command = self.may_command;
        let received = self.reader.next(|kind| max_body_to_relay(kind, may_command))?;
        received.map(|received| ToRelay::parse(received.kind, received.id, &received.body)).transpose()
    }

    fn command(&mut self, bus: &Bus, id: u64, daemon: Daemon, bytes: &[u8]) {
        let refused = |reason: String| CommandError::Refused { daemon, reason };
        let sent = if self.commands.contains_key(&id) {
            Err(refused("another command has this number".to_owned()))
        } else {
            let uid = self.uid;
            self.client(bus, daemon).map_err(refused).and_then(|client| client.send_for(bytes, uid))
        };
        match sent {
            Ok(open) => drop(self.commands.insert(id, (daemon, open))),
            Err(error) => {
                self.answers.push_back(FromRelay::CommandFailed { id, error });
                self.leave_if_idle(daemon);
            }
        }
    }

    /// The bus, with what is of its robot.
    fn bus(&self, bus: &Bus) -> Result<Bus, DomainError> {
        bus.meaning(self.robot)
    }

    fn client(&mut self, bus: &Bus, daemon: Daemon) -> Result<&CommandClient, String> {
        let bus = self.bus(bus).map_err(|error| error.to_string())?;
        Ok(match self.clients.entry(daemon) {
            Entry::Occupied(client) => client.into_mut(),
            Entry::Vacant(place) => place.insert(bus.command_client(daemon).map_err(|error| error.to_string())?),
        })
    }

    /// Forgets a command.
    fn end_command(&mut self, id: u64) {
        if let Some((daemon, _)) = self.commands.remove(&id) {
            self.leave_if_idle(daemon);
        }
    }

    /// The bus has room for few clients of each daemon: one without commands leaves.
    fn leave_if_idle(&mut self, daemon: Daemon) {
        if !self.commands.values().any(|(other, _)| *other == daemon) {
            self.clients.remove(&daemon);
        }
    }

    /// Tells it what is new, as far as it reads.
    ///
    /// # Errors
    /// It is gone.
    pub(super) fn send(&mut self, feeds: Option<&Feeds>) -> io::Result<()> {
        loop {
            self.writer.flush(&self.socket, SendFlags::DONTWAIT)?;
            if !self.writer.is_idle() {
                return Ok(());
            }
            let Some(frame) = self.next_news(feeds) else { return Ok(()) };
            self.writer.begin(frame.frame());
        }
    }

    /// What it is told next: answers, then replies, heartbeats, samples.
    fn next_news(&mut self, feeds: Option<&Feeds>) -> Option<FromRelay> {
        let answer = self.answers.pop_front();
        answer.or_else(|| self.next_reply()).or_else(|| self.next_status()).or_else(|| self.next_sample(feeds?))
    }

    fn next_reply(&mut self) -> Option<FromRelay> {
        let (id, reply) = self.commands.iter().find_map(|(id, (_, open))| Some((*id, open.take().transpose()?)))?;
        if reply.as_ref().map_or(true, Reply::is_final) {
            self.end_command(id);
        }
        Some(match reply {
            Ok(Reply::Progress(bytes)) => FromRelay::Reply { id, kind: ReplyKind::Progress, bytes },
            Ok(Reply::Done(bytes)) => FromRelay::Reply { id, kind: ReplyKind::Done, bytes },
            Ok(Reply::Failed(bytes)) => FromRelay::Reply { id, kind: ReplyKind::Failed, bytes },
            Err(error) => FromRelay::CommandFailed { id, error },
        })
    }

    fn next_status(&mut self) -> Option<FromRelay> {
        Some(FromRelay::Status(Box::new(self.status.as_mut()?.pop_front()?)))
    }

    fn next_sample(&mut self, feeds: &Feeds) -> Option<FromRelay> {
        let Self { subscriptions, on_their_way, robot, .. } = self;
        let mut waiting = subscriptions.iter_mut().filter(|(topic, _)| !on_their_way.contains_key(topic));
        let (topic, last, (number, frame)) = waiting.find_map(|(topic, last)| {
            feeds.newer(OfRobot::new(*robot, *topic), *last).map(|newer| (*topic, last, newer))
        })?;
        *last = number;
        if let FromRelay::Sample { header, .. } = &frame {
            let sample = OnItsWay { number, n_bytes: header.payload_length, since: Instant::now() };
            on_their_way.insert(topic, sample);
        }
        Some(frame)
    }
}

fn invalid(reason: impl Into<Box<dyn std::error::Error + Send + Sync>>) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, reason)
}
