//! The relay: a participant of the bus that lets other users look at it, and send commands, over two Unix sockets.
//!
//! The bus itself stays its user's alone. Who may open which socket is decided by the group of each, and who sends a
//! command by the system, not by the client. A client that is slow misses samples between the newest ones, and holds up
//! nobody; one that sends anything else than the protocol is cut off.
//!
//! What a client costs is bounded: no more of it is read than is handled, one sample of each topic is on its way, and users
//! have so many places, and so much memory of samples that they do not take ([`crate::limits`]). One thing has no bound:
//! how long a client keeps a sample open that it says it has taken. The system counts it as memory of the relay until then.

mod admission;
mod connection;
mod event;
mod feeds;
mod report;
mod session;
mod sockets;
#[cfg(test)]
mod tests;

use crate::chain::chain;
use crate::domain::Domain;
use crate::error::DomainError;
use crate::relay_protocol::{FromRelay, Refusal};
use crate::report_kind::ReportKind;
use admission::{refusal, users_above_limit};
use connection::Connection;
pub use event::RelayEvent;
use report::Reports;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;
use session::Session;
use sockets::{Accepted, Sockets};
use std::io;
use std::mem::discriminant;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::path::Path;
use std::time::{Duration, Instant};

/// Interval at which a missing bus is tried.
const RETRY: Duration = Duration::from_millis(200);

/// Without a descriptor for one more client, the sockets are left alone for this long.
const ACCEPT_PAUSE: Duration = Duration::from_millis(500);

/// How a relay serves.
pub struct RelayOptions {
    /// Group, by name or number, whose members may look; `None` for nobody but the bus's user and root.
    pub view_group: Option<String>,
    /// Group whose members may also send commands.
    pub control_group: Option<String>,
    /// Makes the reports of the site that clients may ask for.
    pub report: Box<dyn Fn(ReportKind) -> Vec<u8> + Send>,
}

/// A relay that listens. It serves while [`Relay::serve`] is called.
pub struct Relay {
    domain: Domain,
    sockets: Sockets,
    reports: Reports,
    stop_on: Vec<OwnedFd>,
    session: Option<Session>,
    /// Why there is no session, if there is a bus.
    trouble: Option<DomainError>,
    connections: Vec<Connection>,
    /// No client is accepted before.
    accept_from: Option<Instant>,
}

impl Relay {
    /// Opens the sockets of a domain's relay; the texts are what an operator should know, such as a group that is missing.
    ///
    /// # Errors
    /// A bus of another user, another relay, a folder that cannot be used.
    pub fn open(domain: &Domain, options: RelayOptions) -> Result<(Self, Vec<String>), DomainError> {
        domain.require_own()?;
        let groups = [options.view_group.as_deref(), options.control_group.as_deref()];
        let (sockets, notes) = Sockets::open(domain.relay_folder(), groups)?;
        let relay = Self {
            domain: domain.clone(),
            sockets,
            reports: Reports::new(options.report),
            stop_on: Vec::new(),
            session: None,
            trouble: None,
            connections: Vec::new(),
            accept_from: None,
        };
        Ok((relay, notes))
    }

    /// The folder with its sockets.
    pub fn folder(&self) -> &Path {
        self.domain.relay_folder()
    }

    /// Stops when this descriptor is readable or closed at its other end.
    pub fn stop_on(&mut self, descriptor: OwnedFd) {
        self.stop_on.push(descriptor);
    }

    /// Serves for a time; true if the relay is to stop.
    ///
    /// # Errors
    /// The system cannot poll, or the sockets were deleted and cannot be made again.
    pub fn serve(&mut self, time: Duration, on_event: &mut dyn FnMut(RelayEvent<'_>)) -> Result<bool, DomainError> {
        let deadline = Instant::now() + time;
        self.sockets.keep()?;
        self.cut_off_slow_clients(on_event);
        loop {
            self.join(on_event);
            let left = deadline.saturating_duration_since(Instant::now());
            let is_over = self.wait(left)?;
            if is_over {
                // Its clients join the next generation.
                (self.session, self.connections) = (None, Vec::new());
            }
            if self.is_stopped() {
                return Ok(true);
            }
            self.accept(on_event);
            self.converse(on_event);
            if Instant::now() >= deadline {
                return Ok(false);
            }
        }
    }

    /// Why the bus that is there cannot be joined.
    pub fn trouble(&self) -> Option<String> {
        self.trouble.as_ref().map(|error| chain(error))
    }

    /// Joins the bus, if it is there and not joined.
    fn join(&mut self, on_event: &mut dyn FnMut(RelayEvent<'_>)) {
        if self.session.is_some() {
            return;
        }
        let trouble = match Session::join(&self.domain) {
            Ok(session) => {
                self.session = Some(session);
                None
            }
            // There is no bus at the moment, which is no trouble.
            Err(DomainError::NoKeeper { .. }) => None,
            Err(error) => Some(error),
        };
        // Words of the same kind may differ by a number, such as that of free bytes.
        if let Some(error) = &trouble
            && self.trouble.as_ref().map(discriminant) != Some(discriminant(error))
        {
            on_event(RelayEvent::CannotJoin { reason: chain(error) });
        }
        self.trouble = trouble;
    }

    /// Waits until something happens; true if the generation of the bus is over.
    fn wait(&mut self, timeout: Duration) -> Result<bool, DomainError> {
        let failed = |source| DomainError::File { path: self.domain.relay_folder().to_owned(), source };
        let stops = self.stop_on.iter().map(|stop| (stop.as_fd(), PollFlags::IN));
        let pause = self.accept_from.map(|from| from.saturating_duration_since(Instant::now()));
        let timeout = pause.map_or(timeout, |pause| timeout.min(pause));
        let listeners = self.sockets.listeners().filter(|_| pause.is_none()).map(|socket| (socket, PollFlags::IN));
        let clients = self.connections.iter().map(|client| (client.socket(), client.interest()));
        let polled: Vec<(BorrowedFd<'_>, PollFlags)> = stops.chain(listeners).chain(clients).collect();
        // What was read and not handled yet does not wait for another event.
        let has_request = self.connections.iter().any(Connection::has_request);
        let timeout = if has_request { Duration::ZERO } else { timeout };
        match &mut self.session {
            Some(session) => {
                let wake = session.waiter.wait_with(&polled, timeout).map_err(|e| failed(e.source))?;
                Ok(wake.superseded)
            }
            None => {
                let timeout = timeout.min(RETRY);
                let timeout =
                    Timespec { tv_sec: timeout.as_secs().cast_signed(), tv_nsec: i64::from(timeout.subsec_nanos()) };
                let mut polled: Vec<_> =
                    polled.into_iter().map(|(fd, flags)| PollFd::from_borrowed_fd(fd, flags)).collect();
                match poll(&mut polled, Some(&timeout)) {
                    Ok(_) | Err(Errno::INTR) => Ok(false),
                    Err(errno) => Err(failed(errno.into())),
                }
            }
        }
    }

    fn is_stopped(&self) -> bool {
        let mut polled: Vec<_> =
            self.stop_on.iter().map(|stop| PollFd::from_borrowed_fd(stop.as_fd(), PollFlags::IN)).collect();
        let at_once = Timespec { tv_sec: 0, tv_nsec: 0 };
        poll(&mut polled, Some(&at_once)).is_ok_and(|n| n > 0)
    }

    fn accept(&mut self, on_event: &mut dyn FnMut(RelayEvent<'_>)) {
        if self.accept_from.is_some_and(|from| Instant::now() < from) {
            return;
        }
        let (accepted, done) = self.sockets.accept();
        if let Err(error) = &done
            && self.accept_from.is_none()
        {
            on_event(RelayEvent::NotAccepting { reason: error.to_string() });
        }
        // A socket with clients that cannot be accepted stays readable.
        self.accept_from = done.err().map(|_| Instant::now() + ACCEPT_PAUSE);
        for Accepted { socket, uid, may_command } in accepted {
            let is_served = |client: &&Connection| !client.is_refused() && client.may_command() == may_command;
            let served: Vec<&Connection> = self.connections.iter().filter(is_served).collect();
            let n_own = served.iter().filter(|client| client.uid() == uid).count();
            let refusal = refusal(served.len(), n_own);
            let mut connection = Connection::new(socket, uid, may_command);
            if let Some(reason) = refusal {
                on_event(RelayEvent::TurnedAway { uid, reason: reason.clone() });
                connection.refuse(Refusal::Full(reason));
            }
            self.connections.push(connection);
        }
    }

    /// Ends conversations of users whose clients keep more memory of outdated samples than they may.
    fn cut_off_slow_clients(&mut self, on_event: &mut dyn FnMut(RelayEvent<'_>)) {
        let Some(session) = &self.session else { return };
        let now = Instant::now();
        let users = users_above_limit(&self.connections, &session.feeds, now);
        self.connections.retain(|client| {
            let is_slow = users.contains(&client.uid()) && client.outdated(&session.feeds, now).next().is_some();
            if is_slow {
                let reason = "it takes no samples, and this user's clients keep too much memory of old ones".to_owned();
                on_event(RelayEvent::CutOff { uid: client.uid(), reason });
            }
            !is_slow
        });
    }

    /// Reads what clients say, and tells them what is new.
    fn converse(&mut self, on_event: &mut dyn FnMut(RelayEvent<'_>)) {
        let Self { session, trouble, connections, sockets, reports, .. } = self;
        if let Some(session) = session {
            for (robot, status) in &session.status {
                while let Ok(Some(record)) = status.take() {
                    connections.iter_mut().for_each(|client| client.put_status(*robot, record));
                }
            }
        }
        connections.retain_mut(|client| {
            let mut went = client.receive();
            went = went.and_then(|()| match session {
                Some(session) => {
                    let welcome = FromRelay::Welcome {
                        generation: session.bus.generation(),
                        may_command: client.may_command(),
                        control_group: sockets.control_group().to_owned(),
                    };
                    client.handle(welcome, &session.bus, &mut session.feeds, reports, on_event)
                }
                None => {
                    let reason = trouble.as_ref().map(|error| chain(error));
                    client.refuse(reason.map_or(Refusal::NoBus, Refusal::CannotJoin));
                    Ok(())
                }
            });
            if let Err(reason) = &went
                && reason.kind() == io::ErrorKind::InvalidData
            {
                on_event(RelayEvent::CutOff { uid: client.uid(), reason: reason.to_string() });
            }
            went.is_ok()
        });
        if let Some(session) = session {
            let is_used = |topic| connections.iter().any(|client| client.follows(topic));
            session.feeds.take(is_used, Instant::now(), on_event);
        }
        let feeds = session.as_ref().map(|session| &session.feeds);
        connections.retain_mut(|client| client.send(feeds).is_ok() && !client.is_done());
    }
}
