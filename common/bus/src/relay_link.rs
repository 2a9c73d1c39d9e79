//! The client's end of a relay: subscriptions, heartbeats and commands of a user who is not the bus's own.

mod ends;
mod inbox;

use crate::accounts::user_text;
use crate::domain::Domain;
use crate::error::{DomainError, PortError};
use crate::names::{Daemon, TopicName};
use crate::relay_access::connect;
use crate::relay_protocol::{FrameReader, FrameWriter, FromRelay, Refusal, ToRelay, max_body_from_relay};
use crate::report_kind::ReportKind;
use crate::signal::Signal;
pub(crate) use ends::{CommandLink, CopiedSample, RelayedCommand, StatusSubscription, TopicSubscription};
use inbox::{Inbox, Slot};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::net::SendFlags;
use std::io;
use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::net::UnixStream;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
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

impl RelayLink {
    /// Connects to the relay of a bus that belongs to another user.
    pub(crate) fn connect(domain: &Domain, owner: u32) -> Result<Arc<Self>, DomainError> {
        let folder = domain.relay_folder();
        let socket = connect(folder, owner)?;
        let failed = |reason: io::Error| DomainError::NoRelay {
            owner: user_text(owner),
            folder: folder.to_owned(),
            reason: reason.to_string(),
        };
        socket.set_write_timeout(Some(SEND_TIMEOUT)).map_err(failed)?;
        let mut writer = FrameWriter::default();
        writer.begin(ToRelay::hello(domain.robot()).frame());
        // One that is refused at once may find its socket closed; the reason is there nevertheless.
        let _ = writer.flush(&socket, SendFlags::empty());
        let mut inbox = Inbox::default();
        let first = first_frame(&socket, &mut inbox.reader).map_err(failed)?;
        let FromRelay::Welcome { generation, may_command, control_group } = first else {
            return Err(match first {
                FromRelay::Refused(Refusal::NoBus) => {
                    DomainError::NoKeeper { root: domain.place.root().display().to_string() }
                }
                FromRelay::Refused(Refusal::Version(found)) => DomainError::Version { found },
                FromRelay::Refused(Refusal::Full(reason) | Refusal::NoRobot(reason)) => {
                    failed(io::Error::other(reason))
                }
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
            let domain = Domain::shared("gplink_", "/dev/shm/gplink").unwrap().with_relay(folder.path()).unwrap();
            let link = RelayLink::connect(&domain, own).unwrap();
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
        assert_eq!(heard, [ToRelay::hello(None), ToRelay::Subscribe(TOPIC), ToRelay::Unsubscribe(TOPIC)]);
    }
}
