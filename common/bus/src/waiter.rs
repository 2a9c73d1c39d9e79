//! Waiting for events: samples, commands, replies, heartbeats, stop, new generation, deadline.

use crate::bell::{BellName, Ring};
use crate::error::WaitError;
use crate::ipc;
use crate::names::Daemon;
use crate::signal::Signal;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;
use std::io;
use std::os::fd::{AsFd, OwnedFd};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// What woke a participant. Several may be true; all are false when the time was up.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Wake {
    /// Shut down. Stays true.
    pub stopped: bool,
    /// Samples of other daemons, replies or heartbeats may be there: take until there are no more.
    pub news: bool,
    /// Commands may be there.
    pub commands: bool,
    /// A [`Nudger`] woke it.
    pub nudged: bool,
    /// The bus has another generation, or went down. Stays true, wakes once: drop everything that was opened, join again
    /// and publish the last samples again.
    pub superseded: bool,
}

impl Wake {
    /// True if the time was up.
    pub fn timed_out(self) -> bool {
        self == Self::default()
    }
}

/// Wakes a waiter from any thread.
#[derive(Clone)]
pub struct Nudger(Arc<Signal>);

impl Nudger {
    /// Wakes it, or makes its next wait return at once.
    pub fn nudge(&self) {
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

/// The one place where a participant sleeps. It also gives newcomers the last samples: a process that does not come back
/// here leaves late subscribers without.
pub struct Waiter {
    daemon: Daemon,
    member: Arc<ipc::Membership>,
    nudge: Arc<Signal>,
    stop: Arc<Signal>,
    stop_on: Vec<OwnedFd>,
}

impl Waiter {
    pub(crate) fn new(daemon: Daemon, member: Arc<ipc::Membership>) -> io::Result<Self> {
        let (nudge, stop) = (Arc::new(Signal::new()?), Arc::new(Signal::new()?));
        Ok(Self { daemon, member, nudge, stop, stop_on: Vec::new() })
    }

    /// Wakes this waiter, for instance when a worker is done.
    pub fn nudger(&self) -> Nudger {
        Nudger(Arc::clone(&self.nudge))
    }

    /// Stops this waiter.
    pub fn stopper(&self) -> Stopper {
        Stopper(Arc::clone(&self.stop))
    }

    /// Stops when this descriptor is readable or closed at its other end, as that of a signal handler's pipe.
    pub fn stop_on(&mut self, descriptor: OwnedFd) {
        self.stop_on.push(descriptor);
    }

    /// Sleeps until something happens, or for `timeout`.
    ///
    /// Wakes for every topic, stream and command that the bus has opened, also in other threads.
    ///
    /// # Errors
    /// The system cannot poll.
    pub fn wait(&mut self, timeout: Duration) -> Result<Wake, WaitError> {
        let deadline = Instant::now() + timeout;
        loop {
            let wake = self.look(deadline.saturating_duration_since(Instant::now()))?;
            // A wake-up that was meant for others is none.
            if !wake.timed_out() || Instant::now() >= deadline {
                return Ok(Wake { superseded: self.member.is_superseded(), ..wake });
            }
        }
    }

    /// Sleeps once and sorts what happened.
    fn look(&self, timeout: Duration) -> Result<Wake, WaitError> {
        // In this order a bell that another thread opens now ends the sleep.
        self.member.more_bells().clear();
        let bells = self.member.bells();
        let more_bells = self.member.more_bells().descriptor();
        let fixed = [more_bells, self.stop.descriptor(), self.nudge.descriptor(), self.member.changes()];
        let stops = self.stop_on.iter().map(AsFd::as_fd);
        let descriptors = fixed.into_iter().chain(stops).chain(bells.iter().map(|(_, bell)| bell.descriptor()));
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
        let (stops, rung) = rest.split_at(self.stop_on.len());
        let mut wake = Wake { stopped: fixed[1] || stops.contains(&true), nudged: fixed[2], ..Wake::default() };
        if wake.nudged {
            self.nudge.clear();
        }
        wake.superseded = fixed[3] && self.member.look_at_changes();
        let mut newcomers = false;
        for ((name, bell), _) in bells.iter().zip(rung).filter(|(_, rung)| **rung) {
            let rings = bell.look();
            let own = *name == BellName::Of(self.daemon);
            // A daemon hears its own bell too.
            newcomers |= own && rings.any(&[Ring::Newcomer]);
            wake.commands |= own && rings.any(&[Ring::Command]);
            wake.news |= !own && rings.any(&[Ring::Data, Ring::Reply, Ring::Dead]);
        }
        if newcomers {
            self.member.serve_newcomers();
        }
        Ok(wake)
    }
}
