//! The client's end of a relay: subscriptions, heartbeats and commands of a user who is not the bus's own.

use crate::accounts::user_text;
use crate::error::{CommandError, DomainError, PortError, ReceiveError};
use crate::limits::{REPLY_BUFFER, STATUS_BUFFER};
use crate::names::{Daemon, TopicName};
use crate::relay_access::connect;
use crate::relay_protocol::{FrameReader, FrameWriter, FromRelay, Refusal, ToRelay, max_body_from_relay, read_sealed};
use crate::reply_kind::ReplyKind;
use crate::report_kind::ReportKind;
use crate::signal::Signal;
use messages::{ArchiveBuffer, SampleHeader, StatusRecord};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::net::SendFlags;
use std::collections::{BTreeMap, VecDeque};
use std::io;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError, Weak};
use std::time::{Duration, Instant};

/// A relay that takes no bytes for this long has hung.
const SEND_TIMEOUT: Duration = Duration::from_secs(10);

/// Timeout of the first answer.
const WELCOME_TIMEOUT: Duration = Duration::from_secs(10);

/// A conversation with a relay. It ends with the generation of the bus.
pub(crate) struct RelayLink {
    socket: UnixStream,
    generation: u64,
    may_command: bool,
    control_group: String,
    owner: u32,
    writer: Mutex<FrameWriter>,
    inbox: Mutex<Inbox>,
    /// Raised when something was put into the inbox by another than the waiter.
    arrived: Signal,
    is_closed: AtomicBool,
    next_command: AtomicU64,
}

/// What came and was not taken yet.
#[derive(Default)]
struct Inbox {
    reader: FrameReader,
    topics: BTreeMap<TopicName, Topic>,
    status: Vec<Weak<Mutex<VecDeque<StatusRecord>>>>,
    commands: BTreeMap<u64, VecDeque<CommandNews>>,
    report: Option<Vec<u8>>,
}

/// A reply to a command, or its end.
type CommandNews = Result<(ReplyKind, Vec<u8>), CommandError>;

/// A topic that is followed.
#[derive(Default)]
struct Topic {
    subscriptions: Vec<Weak<Slot>>,
    last: Option<Arc<RelayedSample>>,
    refused: Option<String>,
}

/// The newest sample that one subscription did not take.
type Slot = Mutex<Option<Arc<RelayedSample>>>;

/// A sample that was announced; its bytes are still in the relay's memory.
struct RelayedSample {
    header: SampleHeader,
    memory: Arc<OwnedFd>,
}

impl RelayLink {
    /// Connects to the relay of a bus that belongs to another user.
    pub(crate) fn connect(root: &Path, folder: &Path, owner: u32) -> Result<Arc<Self>, DomainError> {
        let socket = connect(folder, owner)?;
        let failed = |reason: io::Error| DomainError::NoRelay {
            owner: user_text(owner),
            folder: folder.to_owned(),
            reason: reason.to_string(),
        };
        socket.set_write_timeout(Some(SEND_TIMEOUT)).map_err(failed)?;
        let mut writer = FrameWriter::default();
        writer.begin(ToRelay::hello().frame());
        // One that is refused at once may find its socket closed; the reason is there nevertheless.
        let _ = writer.flush(&socket, SendFlags::empty());
        let mut inbox = Inbox::default();
        let first = first_frame(&socket, &mut inbox.reader).map_err(failed)?;
        let FromRelay::Welcome { generation, may_command, control_group } = first else {
            return Err(match first {
                FromRelay::Refused(Refusal::NoBus) => DomainError::NoKeeper { root: root.display().to_string() },
                FromRelay::Refused(Refusal::Version(found)) => DomainError::Version { found },
                FromRelay::Refused(Refusal::Full(reason)) => failed(io::Error::other(reason)),
                FromRelay::Refused(Refusal::CannotJoin(reason)) => {
                    failed(io::Error::other(format!("it cannot join the bus: {reason}")))
                }
                _ => failed(io::Error::other("it does not begin with a welcome")),
            });
        };
        Ok(Arc::new(Self {
            socket,
            generation,
            may_command,
            control_group,
            owner,
            writer: Mutex::new(writer),
            inbox: Mutex::new(inbox),
            arrived: Signal::new().map_err(failed)?,
            is_closed: AtomicBool::new(false),
            next_command: AtomicU64::new(1),
        }))
    }

    pub(crate) fn generation(&self) -> u64 {
        self.generation
    }

    /// True from the moment that the relay is gone, or the generation of the bus is over.
    pub(crate) fn is_closed(&self) -> bool {
        self.is_closed.load(Ordering::Relaxed)
    }

    /// Readable when the relay sent something.
    pub(crate) fn socket(&self) -> BorrowedFd<'_> {
        self.socket.as_fd()
    }

    /// Raised when something came that the waiter has not seen.
    pub(crate) fn arrived(&self) -> &Signal {
        &self.arrived
    }

    /// Why this user cannot have an end that only the bus's user has.
    pub(crate) fn owner_only(&self, what: impl Into<String>) -> PortError {
        PortError::OwnerOnly { what: what.into(), owner: user_text(self.owner) }
    }

    /// Follows a topic. When the relay is gone nothing comes, and the waiter says so.
    pub(crate) fn subscribe(self: &Arc<Self>, topic: TopicName) -> TopicSubscription {
        let slot = Arc::new(Slot::default());
        let mut inbox = self.lock();
        let followed = inbox.topics.entry(topic).or_default();
        followed.subscriptions.retain(|slot| slot.strong_count() > 0);
        let is_first = followed.subscriptions.is_empty();
        followed.subscriptions.push(Arc::downgrade(&slot));
        // Who comes second gets what the first one got last.
        *slot.lock().unwrap_or_else(PoisonError::into_inner) = followed.last.clone();
        if is_first {
            // Before the inbox is given back: the relay hears of the subscriptions of all threads in their order.
            let _ = self.send(&ToRelay::Subscribe(topic));
        } else {
            self.arrived.raise();
        }
        drop(inbox);
        TopicSubscription { link: Arc::clone(self), topic, slot }
    }

    /// Follows heartbeats, as [`RelayLink::subscribe`].
    pub(crate) fn subscribe_status(self: &Arc<Self>) -> StatusSubscription {
        let records = Arc::default();
        self.lock().status.push(Arc::downgrade(&records));
        let _ = self.send(&ToRelay::SubscribeStatus);
        StatusSubscription { link: Arc::clone(self), records }
    }

    /// Commands to a daemon, if this user may send them.
    pub(crate) fn commands(self: &Arc<Self>, daemon: Daemon) -> Result<CommandLink, PortError> {
        if self.may_command {
            return Ok(CommandLink { link: Arc::clone(self), daemon });
        }
        Err(PortError::ViewOnly { owner: user_text(self.owner), group: self.control_group.clone() })
    }

    /// A report of the site.
    pub(crate) fn report(&self, kind: ReportKind) -> io::Result<Vec<u8>> {
        self.send(&ToRelay::Report(kind))?;
        let deadline = Instant::now() + WELCOME_TIMEOUT;
        loop {
            if let Some(report) = self.lock().report.take() {
                return Ok(report);
            }
            if self.is_closed() {
                return Err(io::ErrorKind::ConnectionReset.into());
            }
            wait_until_readable(&self.socket, deadline)?;
            self.receive();
        }
    }

    /// Takes what has come into the inbox; true if anything has.
    pub(crate) fn receive(&self) -> bool {
        if self.is_closed() {
            return false;
        }
        let mut inbox = self.lock();
        let mut has_come = false;
        loop {
            let n_bytes = inbox.reader.fill_with_descriptors(&self.socket).unwrap_or_default();
            let is_whole = loop {
                match next_frame(&mut inbox.reader) {
                    Ok(Some(frame)) => {
                        has_come = true;
                        if let Some(topic) = inbox.put(frame) {
                            // What cannot be sent shows at the next look.
                            let _ = self.send(&ToRelay::Taken(topic));
                        }
                    }
                    Ok(None) => break true,
                    Err(_) => break false,
                }
            };
            match n_bytes {
                Some(0) if is_whole => return has_come,
                Some(_) if is_whole => {}
                _ => {
                    self.is_closed.store(true, Ordering::Relaxed);
                    return true;
                }
            }
        }
    }

    /// Takes what has come on behalf of one of several ports: the waiter wakes for the others.
    fn receive_for_port(&self) {
        if self.receive() {
            self.arrived.raise();
        }
    }

    fn send(&self, frame: &ToRelay) -> io::Result<()> {
        let mut writer = self.writer.lock().unwrap_or_else(PoisonError::into_inner);
        if !writer.is_idle() || self.is_closed() {
            return Err(io::ErrorKind::BrokenPipe.into());
        }
        writer.begin(frame.frame());
        let sent = writer.flush(&self.socket, SendFlags::empty());
        if sent.is_err() || !writer.is_idle() {
            // Half a frame is out: there is no way back.
            self.is_closed.store(true, Ordering::Relaxed);
            return sent.and(Err(io::ErrorKind::TimedOut.into()));
        }
        Ok(())
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Inbox> {
        self.inbox.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Inbox {
    /// Puts a frame where it belongs; the topic of a sample that the relay is told of.
    fn put(&mut self, frame: FromRelay) -> Option<TopicName> {
        match frame {
            FromRelay::Sample { topic, header, memory } => {
                let sample = Arc::new(RelayedSample { header: *header, memory });
                if let Some(followed) = self.topics.get_mut(&topic) {
                    for slot in followed.subscriptions.iter().filter_map(Weak::upgrade) {
                        *slot.lock().unwrap_or_else(PoisonError::into_inner) = Some(Arc::clone(&sample));
                    }
                    (followed.last, followed.refused) = (Some(sample), None);
                }
                // Also if it is not followed any more: the relay sends no other one before.
                return Some(topic);
            }
            FromRelay::NoTopic { topic, reason } => {
                if let Some(followed) = self.topics.get_mut(&topic) {
                    followed.refused = Some(reason);
                }
            }
            FromRelay::Status(record) => {
                self.status.retain(|records| records.strong_count() > 0);
                for records in self.status.iter().filter_map(Weak::upgrade) {
                    push_bounded(&mut records.lock().unwrap_or_else(PoisonError::into_inner), *record, STATUS_BUFFER);
                }
            }
            // A command that was given up has no place any more.
            FromRelay::Reply { id, kind, bytes } => {
                if let Some(replies) = self.commands.get_mut(&id) {
                    push_bounded(replies, Ok((kind, bytes)), REPLY_BUFFER);
                }
            }
            FromRelay::CommandFailed { id, error } => {
                if let Some(replies) = self.commands.get_mut(&id) {
                    push_bounded(replies, Err(error), REPLY_BUFFER);
                }
            }
            FromRelay::Report(bytes) => self.report = Some(bytes.to_vec()),
            // They come once, and first.
            FromRelay::Welcome { .. } | FromRelay::Refused(_) => {}
        }
        None
    }
}

/// The oldest gives way.
fn push_bounded<T>(queue: &mut VecDeque<T>, item: T, max: usize) {
    if queue.len() >= max {
        queue.pop_front();
    }
    queue.push_back(item);
}

/// The next whole frame.
fn next_frame(reader: &mut FrameReader) -> io::Result<Option<FromRelay>> {
    let received = reader.next(max_body_from_relay).map_err(io::Error::other)?;
    let Some(received) = received else { return Ok(None) };
    let frame = FromRelay::parse(received.kind, received.id, &received.body, received.descriptor);
    Ok(Some(frame.map_err(io::Error::other)?))
}

fn first_frame(socket: &UnixStream, reader: &mut FrameReader) -> io::Result<FromRelay> {
    let deadline = Instant::now() + WELCOME_TIMEOUT;
    loop {
        if let Some(frame) = next_frame(reader)? {
            return Ok(frame);
        }
        wait_until_readable(socket, deadline)?;
        if reader.fill_with_descriptors(socket)?.is_none() && reader.is_empty() {
            return Err(io::Error::other("it hung up"));
        }
    }
}

fn wait_until_readable(socket: impl AsFd, deadline: Instant) -> io::Result<()> {
    let left = deadline.saturating_duration_since(Instant::now());
    let timeout = Timespec { tv_sec: left.as_secs().cast_signed(), tv_nsec: i64::from(left.subsec_nanos()) };
    let mut polled = [PollFd::new(&socket, PollFlags::IN)];
    match poll(&mut polled, Some(&timeout)) {
        Ok(0) => Err(io::Error::new(io::ErrorKind::TimedOut, "it does not answer")),
        Ok(_) | Err(rustix::io::Errno::INTR) => Ok(()),
        Err(errno) => Err(errno.into()),
    }
}

/// A subscription to a topic.
pub(crate) struct TopicSubscription {
    link: Arc<RelayLink>,
    topic: TopicName,
    slot: Arc<Slot>,
}

impl TopicSubscription {
    /// The newest sample that was not taken.
    pub(crate) fn receive(&self) -> Result<Option<CopiedSample>, ReceiveError> {
        self.link.receive_for_port();
        let refused = |reason: String| ReceiveError::Refused { what: self.topic.to_string(), reason };
        let sample = self.slot.lock().unwrap_or_else(PoisonError::into_inner).take();
        let Some(sample) = sample else {
            let mut inbox = self.link.lock();
            let reason = inbox.topics.get_mut(&self.topic).and_then(|topic| topic.refused.take());
            return reason.map_or(Ok(None), |reason| Err(refused(reason)));
        };
        let bytes = read_sealed(&*sample.memory, sample.header.payload_length);
        let bytes = bytes.map_err(|reason| refused(reason.to_string()))?;
        Ok(Some(CopiedSample { header: sample.header, bytes }))
    }
}

impl Drop for TopicSubscription {
    fn drop(&mut self) {
        let mut inbox = self.link.lock();
        let Some(followed) = inbox.topics.get_mut(&self.topic) else { return };
        let own = Arc::as_ptr(&self.slot);
        followed.subscriptions.retain(|slot| slot.strong_count() > 0 && slot.as_ptr() != own);
        if followed.subscriptions.is_empty() {
            inbox.topics.remove(&self.topic);
            // Before the inbox is given back, as in `subscribe`. A relay that is gone needs no word.
            let _ = self.link.send(&ToRelay::Unsubscribe(self.topic));
        }
    }
}

/// A sample that was copied out of the relay's memory.
pub(crate) struct CopiedSample {
    header: SampleHeader,
    bytes: ArchiveBuffer,
}

impl CopiedSample {
    pub(crate) fn header(&self) -> &SampleHeader {
        &self.header
    }

    pub(crate) fn bytes(&self) -> &[u8] {
        self.bytes.bytes()
    }
}

/// A subscription to heartbeats.
pub(crate) struct StatusSubscription {
    link: Arc<RelayLink>,
    records: Arc<Mutex<VecDeque<StatusRecord>>>,
}

impl StatusSubscription {
    pub(crate) fn receive(&self) -> Option<StatusRecord> {
        self.link.receive_for_port();
        self.records.lock().unwrap_or_else(PoisonError::into_inner).pop_front()
    }
}

/// Commands to a daemon.
pub(crate) struct CommandLink {
    link: Arc<RelayLink>,
    daemon: Daemon,
}

impl CommandLink {
    pub(crate) fn send(&self, bytes: &[u8]) -> Result<RelayedCommand, CommandError> {
        let (link, daemon) = (&self.link, self.daemon);
        let id = link.next_command.fetch_add(1, Ordering::Relaxed);
        link.lock().commands.insert(id, VecDeque::new());
        let command = RelayedCommand { link: Arc::clone(link), daemon, id };
        let sent = link.send(&ToRelay::Command { id, daemon, bytes: bytes.to_vec() });
        sent.map_err(|reason| CommandError::Refused { daemon, reason: format!("the relay of the bus: {reason}") })?;
        Ok(command)
    }
}

/// A command that waits for its replies; dropped, it is given up.
pub(crate) struct RelayedCommand {
    link: Arc<RelayLink>,
    daemon: Daemon,
    id: u64,
}

impl RelayedCommand {
    pub(crate) fn receive(&self) -> Result<Option<(ReplyKind, Vec<u8>)>, CommandError> {
        self.link.receive_for_port();
        // Asked first: a relay that answers and goes away between the two looks has answered.
        let is_closed = self.link.is_closed();
        let reply = self.link.lock().commands.get_mut(&self.id).and_then(VecDeque::pop_front);
        match reply {
            Some(reply) => reply.map(Some),
            None if is_closed => Err(CommandError::Lost { daemon: self.daemon }),
            None => Ok(None),
        }
    }
}

impl Drop for RelayedCommand {
    fn drop(&mut self) {
        self.link.lock().commands.remove(&self.id);
        // A relay that is gone, or has answered, needs no word.
        let _ = self.link.send(&ToRelay::Cancel { id: self.id });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::relay_protocol::{CONTROL_SOCKET, max_body_to_relay};
    use std::os::unix::net::UnixListener;

    /// What a client says until it hangs up; it is welcomed.
    fn listen(listener: &UnixListener) -> Vec<ToRelay> {
        let (socket, _) = listener.accept().unwrap();
        let mut writer = FrameWriter::default();
        let welcome = FromRelay::Welcome { generation: 1, may_command: true, control_group: String::new() };
        writer.begin(welcome.frame());
        writer.flush(&socket, SendFlags::empty()).unwrap();
        let (mut reader, mut heard) = (FrameReader::default(), Vec::new());
        loop {
            wait_until_readable(&socket, Instant::now() + WELCOME_TIMEOUT).unwrap();
            let n_bytes = reader.fill(&socket).unwrap();
            while let Some(frame) = reader.next(|kind| max_body_to_relay(kind, true)).unwrap() {
                heard.push(ToRelay::parse(frame.kind, frame.id, &frame.body).unwrap());
            }
            if n_bytes.is_none() {
                return heard;
            }
        }
    }

    /// Waits until another thread has had the inbox for a while, in vain if it gives it back with the topics changed.
    fn wait_until_the_inbox_is_kept(link: &RelayLink, is_changed: impl Fn(&Inbox) -> bool) {
        let begun = Instant::now();
        let mut n_kept = 0;
        while n_kept < 20 {
            match link.inbox.try_lock() {
                Ok(inbox) => {
                    assert!(!is_changed(&inbox), "another thread could change it back now, and be heard first");
                    n_kept = 0;
                }
                Err(_) => n_kept += 1,
            }
            assert!(begun.elapsed() < Duration::from_secs(60), "nobody takes the inbox");
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    #[test]
    fn the_relay_hears_of_subscriptions_of_all_threads_in_their_order() {
        const TOPIC: TopicName = TopicName::Site;
        let folder = tempfile::tempdir().unwrap();
        let listener = UnixListener::bind(folder.path().join(CONTROL_SOCKET)).unwrap();
        let heard = std::thread::scope(|scope| {
            let relay = scope.spawn(|| listen(&listener));
            let own = rustix::process::geteuid().as_raw();
            let link = RelayLink::connect(folder.path(), folder.path(), own).unwrap();
            // What holds up the words to the relay holds up who else would subscribe.
            let held_up = link.writer.lock().unwrap();
            let linked = Arc::clone(&link);
            let subscribing = scope.spawn(move || linked.subscribe(TOPIC));
            wait_until_the_inbox_is_kept(&link, |inbox| inbox.topics.contains_key(&TOPIC));
            drop(held_up);
            let subscription = subscribing.join().unwrap();
            let held_up = link.writer.lock().unwrap();
            let leaving = scope.spawn(|| drop(subscription));
            wait_until_the_inbox_is_kept(&link, |inbox| !inbox.topics.contains_key(&TOPIC));
            drop(held_up);
            leaving.join().unwrap();
            drop(link);
            relay.join().unwrap()
        });
        assert_eq!(heard, [ToRelay::hello(), ToRelay::Subscribe(TOPIC), ToRelay::Unsubscribe(TOPIC)]);
    }
}
