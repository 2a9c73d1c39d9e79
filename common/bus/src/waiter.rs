//! Waiting for events: samples, commands, replies, heartbeats, stop, new generation, deadline.

use crate::error::WaitError;
use crate::ipc;
use crate::names::Daemon;
use crate::signal::Signal;
use crate::wakeup::{EventService, Wakeup};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;
use std::io;
use std::os::fd::{AsFd, OwnedFd};
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
    /// The bus has another generation, or went down. Stays true, wakes once: drop everything that was opened, join again
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

/// The only place where a participant blocks. It also delivers last samples to late joiners: they get none while the
/// process does not call this.
pub struct Waiter {
    daemon: Daemon,
    member: Arc<ipc::Membership>,
    wake_up: Arc<Signal>,
    stop: Arc<Signal>,
    stop_on: Vec<OwnedFd>,
}

impl Waiter {
    pub(crate) fn new(daemon: Daemon, member: Arc<ipc::Membership>) -> io::Result<Self> {
        let (wake_up, stop) = (Arc::new(Signal::new()?), Arc::new(Signal::new()?));
        Ok(Self { daemon, member, wake_up, stop, stop_on: Vec::new() })
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
            let mut wake = self.poll_once(deadline.saturating_duration_since(Instant::now()))?;
            wake.superseded |= self.member.look_at_times();
            // Events that do not concern this participant are skipped.
            if !wake.timed_out() || Instant::now() >= deadline {
                return Ok(Wake { superseded: self.member.is_superseded(), ..wake });
            }
        }
    }

    /// Polls once and classifies the events.
    fn poll_once(&self, timeout: Duration) -> Result<Wake, WaitError> {
        // In this order an event port that another thread opens now ends the wait.
        self.member.event_ports_added().clear();
        let event_ports = self.member.event_ports();
        let event_ports_added = self.member.event_ports_added().descriptor();
        let fixed = [event_ports_added, self.stop.descriptor(), self.wake_up.descriptor(), self.member.changes()];
        let stops = self.stop_on.iter().map(AsFd::as_fd);
        let descriptors =
            fixed.into_iter().chain(stops).chain(event_ports.iter().map(|(_, event_port)| event_port.descriptor()));
        let mut polled: Vec<_> = descriptors.map(|d| PollFd::from_borrowed_fd(d, PollFlags::IN)).collect();
        let timeout = Timespec {
            tv_sec: i64::try_from(timeout.as_secs()).unwrap_or(i64::MAX),
            tv_nsec: i64::from(timeout.subsec_nanos()),
        };
        match poll(&mut polled, Some(&timeout)) {
            Ok(_) => {}
            Err(Errno::INTR) => return Ok(Wake::default()),
            Err(errno) => return Err(WaitError { source: errno.into() }),
        }
        let ready: Vec<bool> = polled.iter().map(|p| !p.revents().is_empty()).collect();
        let (fixed, rest) = ready.split_at(fixed.len());
        let (stops, notified) = rest.split_at(self.stop_on.len());
        let mut wake = Wake { stopped: fixed[1] || stops.contains(&true), woken: fixed[2], ..Wake::default() };
        if wake.woken {
            self.wake_up.clear();
        }
        wake.superseded = fixed[3] && self.member.read_changes();
        let mut late_joiners = false;
        for ((name, event_port), _) in event_ports.iter().zip(notified).filter(|(_, notified)| **notified) {
            let wakeups = event_port.take();
            let own = *name == EventService::Of(self.daemon);
            // A daemon receives its own events too.
            late_joiners |= own && wakeups.any(&[Wakeup::LateJoiner]);
            wake.commands |= own && wakeups.any(&[Wakeup::Command]);
            wake.data |= !own && wakeups.any(&[Wakeup::Data, Wakeup::Reply, Wakeup::Dead]);
        }
        if late_joiners {
            self.member.serve_late_joiners();
        }
        Ok(wake)
    }
}
