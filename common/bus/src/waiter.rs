//! Waiting for events: samples, commands, replies, heartbeats, stop, new generation, deadline.

use crate::error::WaitError;
use crate::ipc::Membership;
use crate::names::Daemon;
use crate::relay_link::RelayLink;
use crate::robot_name::OfRobot;
use crate::signal::Signal;
use crate::wakeup::{EventService, Wakeup};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;
use std::io;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Why a participant woke. Several may be true; all are false after a timeout.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Wake {
    /// Shut down. Stays true.
    pub stopped: bool,
    /// Samples of other daemons, replies or heartbeats may be available: take until there are no more.
    pub data: bool,
    /// Commands may be available.
    pub commands: bool,
    /// A [`Waker`] woke it.
    pub woken: bool,
    /// The bus has another generation, or went down, or its relay did. Stays true, wakes once: drop everything that was opened, join again
    /// and publish the last samples again.
    pub superseded: bool,
}

impl Wake {
    /// True after a timeout.
    pub fn timed_out(self) -> bool {
        self == Self::default()
    }
}

/// Wakes a waiter from any thread.
#[derive(Clone)]
pub struct Waker(Arc<Signal>);

impl Waker {
    /// Wakes it, or makes its next wait return at once.
    pub fn wake_up(&self) {
        self.0.raise();
    }
}

/// Stops a waiter from any thread.
#[derive(Clone)]
pub struct Stopper(Arc<Signal>);

impl Stopper {
    /// Makes this and all later waits return at once.
    pub fn stop(&self) {
        self.0.raise();
    }
}

/// What a waiter waits on: the shared memory of a member, or a relay.
#[derive(Clone)]
pub(crate) enum Source {
    Member(Arc<Membership>),
    Relay(Arc<RelayLink>),
}

/// The only place where a participant blocks. It also delivers last samples to late joiners: they get none while the
/// process does not call this.
pub struct Waiter {
    own: EventService,
    source: Source,
    wake_up: Arc<Signal>,
    stop: Arc<Signal>,
    stop_on: Vec<OwnedFd>,
}

impl Waiter {
    pub(crate) fn new(daemon: OfRobot<Daemon>, source: Source) -> io::Result<Self> {
        let (wake_up, stop) = (Arc::new(Signal::new()?), Arc::new(Signal::new()?));
        Ok(Self { own: EventService::Of(daemon), source, wake_up, stop, stop_on: Vec::new() })
    }

    /// Wakes this waiter, for instance when a worker is done.
    pub fn waker(&self) -> Waker {
        Waker(Arc::clone(&self.wake_up))
    }

    /// Stops this waiter.
    pub fn stopper(&self) -> Stopper {
        Stopper(Arc::clone(&self.stop))
    }

    /// Stops when this descriptor is readable or closed at its other end, as that of a signal handler's pipe.
    pub fn stop_on(&mut self, descriptor: OwnedFd) {
        self.stop_on.push(descriptor);
    }

    /// Waits for an event, at most for `timeout`.
    ///
    /// Wakes for every topic, stream and command that the bus has opened, also in other threads.
    ///
    /// # Errors
    /// The system cannot poll.
    pub fn wait(&mut self, timeout: Duration) -> Result<Wake, WaitError> {
        let deadline = Instant::now() + timeout;
        loop {
            let wake = self.wait_with(&[], deadline.saturating_duration_since(Instant::now()))?;
            // Events that do not concern this participant are skipped.
            if !wake.timed_out() || Instant::now() >= deadline {
                return Ok(Wake { superseded: self.is_superseded(), ..wake });
            }
        }
    }

    fn is_superseded(&self) -> bool {
        match &self.source {
            Source::Member(member) => member.is_superseded(),
            Source::Relay(relay) => relay.is_closed(),
        }
    }

    /// Waits once, also for other descriptors, and classifies the events of the bus.
    pub(crate) fn wait_with(
        &mut self,
        others: &[(BorrowedFd<'_>, PollFlags)],
        timeout: Duration,
    ) -> Result<Wake, WaitError> {
        match &self.source {
            Source::Member(member) => self.wait_for_member(member, others, timeout),
            Source::Relay(relay) => self.wait_for_relay(relay, others, timeout),
        }
    }

    fn wait_for_member(
        &self,
        member: &Membership,
        others: &[(BorrowedFd<'_>, PollFlags)],
        timeout: Duration,
    ) -> Result<Wake, WaitError> {
        // In this order an event port that another thread opens now ends the wait.
        member.event_ports_added().clear();
        let event_ports = member.event_ports();
        let changes = [member.event_ports_added().descriptor(), member.changes()];
        let of_ports = event_ports.iter().map(|(_, event_port)| event_port.descriptor());
        let of_bus: Vec<_> = changes.into_iter().chain(of_ports).map(|fd| (fd, PollFlags::IN)).collect();
        let (mut wake, ready) = self.poll(&of_bus, others, timeout)?;
        wake.superseded = ready[1] && member.read_changes();
        wake.superseded |= member.look_at_times();
        let mut late_joiners = Vec::new();
        for ((name, event_port), _) in event_ports.iter().zip(&ready[2..]).filter(|(_, notified)| **notified) {
            let wakeups = event_port.take();
            let own = *name == self.own;
            // Who publishes a topic is told by the service of its producer, which may be another daemon.
            if wakeups.any(&[Wakeup::LateJoiner]) {
                late_joiners.push(Arc::clone(event_port));
            }
            // A daemon receives its own events too.
            wake.commands |= own && wakeups.any(&[Wakeup::Command]);
            wake.data |= !own && wakeups.any(&[Wakeup::Data, Wakeup::Reply, Wakeup::Dead]);
        }
        if !late_joiners.is_empty() {
            member.serve_late_joiners(&late_joiners);
        }
        Ok(wake)
    }

    fn wait_for_relay(
        &self,
        relay: &RelayLink,
        others: &[(BorrowedFd<'_>, PollFlags)],
        timeout: Duration,
    ) -> Result<Wake, WaitError> {
        let was_closed = relay.is_closed();
        // A socket whose other end is gone is readable for ever.
        let of_bus = [relay.arrived().descriptor(), relay.socket()].map(|fd| (fd, PollFlags::IN));
        let (mut wake, ready) = self.poll(&of_bus[..if was_closed { 1 } else { 2 }], others, timeout)?;
        // In this order what comes now is not missed.
        relay.arrived().clear();
        wake.data = relay.receive() || ready[0];
        wake.superseded = !was_closed && relay.is_closed();
        Ok(wake)
    }

    /// Polls descriptors of the bus, the waiter's own and others; which of the bus's are ready.
    fn poll(
        &self,
        of_bus: &[(BorrowedFd<'_>, PollFlags)],
        others: &[(BorrowedFd<'_>, PollFlags)],
        timeout: Duration,
    ) -> Result<(Wake, Vec<bool>), WaitError> {
        let own = [self.stop.descriptor(), self.wake_up.descriptor()];
        let stops = self.stop_on.iter().map(AsFd::as_fd);
        let own = own.into_iter().chain(stops).map(|fd| (fd, PollFlags::IN));
        let all = own.chain(of_bus.iter().copied()).chain(others.iter().copied());
        let mut polled: Vec<_> = all.map(|(fd, flags)| PollFd::from_borrowed_fd(fd, flags)).collect();
        let timeout = Timespec {
            tv_sec: i64::try_from(timeout.as_secs()).unwrap_or(i64::MAX),
            tv_nsec: i64::from(timeout.subsec_nanos()),
        };
        match poll(&mut polled, Some(&timeout)) {
            Ok(_) => {}
            Err(Errno::INTR) => return Ok((Wake::default(), vec![false; of_bus.len()])),
            Err(errno) => return Err(WaitError { source: errno.into() }),
        }
        let ready: Vec<bool> = polled.iter().map(|p| !p.revents().is_empty()).collect();
        let (own, rest) = ready.split_at(2 + self.stop_on.len());
        let wake = Wake { stopped: own[0] || own[2..].contains(&true), woken: own[1], ..Wake::default() };
        if wake.woken {
            self.wake_up.clear();
        }
        Ok((wake, rest[..of_bus.len()].to_vec()))
    }
}
