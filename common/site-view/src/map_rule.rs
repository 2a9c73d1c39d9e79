//! The rule by which maps may be used: heartbeats, schedule states, indices and times go in, a verdict comes out.
//! No bus and no clock inside, times are arguments.

use crate::limits::{FOLLOWER, FRESH_TOLERANCE, GRIDS_LATE, SILENT_AFTER, WATCHED};
use crate::map_verdict::{MapVerdict, NoMapReason};
use crate::plan_clock::{ClockTime, NextState};
use bus::{Daemon, HEARTBEAT_PERIOD, Stamp};
use messages::{ContentHash, GridsHead, ScheduleStateHead};

/// What was heard of the daemons, and whether the maps that they drew may be used; nothing was heard by default.
#[derive(Debug, Default)]
pub struct MapRule {
    /// When each of [`WATCHED`] was heard; `None` before a bus is followed.
    heard: Option<[Stamp; WATCHED.len()]>,
    /// True if what follows a server was heard: it publishes the maps.
    is_following: bool,
    state: Option<StateKey>,
    /// The newest schedule state that differs from the one before, also across generations of the bus, and when it came.
    newer: Option<(ContentHash, Stamp)>,
    index: Option<IndexKey>,
    /// The last schedule state whose grids were there, also in an earlier generation of the bus.
    drawn: Option<ContentHash>,
    /// Since when the grids of the newest schedule state are not there, without a break.
    unmatched_since: Option<Stamp>,
    next_state: NextState,
}

/// What is asked of the newest schedule state.
#[derive(Debug, Clone, Copy)]
struct StateKey {
    hash: ContentHash,
    site: ContentHash,
    valid_until_s: i64,
}

/// What is asked of the newest index.
#[derive(Debug, Clone, Copy)]
struct IndexKey {
    state: ContentHash,
    site: ContentHash,
    /// True if the grids that it names are there.
    has_grids: bool,
}

impl MapRule {
    /// A generation of the bus was joined: samples come again, heartbeats count from `now`.
    pub fn joined(&mut self, now: Stamp) {
        self.heard = Some([now; WATCHED.len()]);
        (self.state, self.index) = (None, None);
        self.match_newest(now);
    }

    /// A daemon was heard at this time. What follows a server publishes the maps in the place of all watched ones; others than these
    /// count for nothing.
    pub fn insert_heartbeat(&mut self, at: Stamp, daemon: Daemon) {
        self.is_following |= daemon == FOLLOWER;
        for (heard, watched) in self.heard.iter_mut().flatten().zip(WATCHED) {
            if watched == daemon || daemon == FOLLOWER {
                *heard = at.max(*heard);
            }
        }
    }

    /// A schedule state has come; `hash` is its content hash. One that says the same as the last one is not newer.
    pub fn insert_schedule_state(&mut self, now: Stamp, hash: ContentHash, head: &ScheduleStateHead) {
        self.state = Some(StateKey { hash, site: head.site_hash, valid_until_s: head.valid_until_s });
        if self.newer.is_none_or(|(newer, _)| newer != hash) {
            self.newer = Some((hash, now));
        }
        self.match_newest(now);
    }

    /// An index of grids has come; `has_grids` is true if the grids that it names are there, as they are for who does not
    /// hold them: an index is published after its grids.
    pub fn insert_index(&mut self, now: Stamp, head: &GridsHead, has_grids: bool) {
        self.index = Some(IndexKey { state: head.schedule_state_hash, site: head.site_hash, has_grids });
        self.match_newest(now);
    }

    /// The grids that the newest index names are there, or one of them is not.
    pub fn set_grids(&mut self, now: Stamp, has_grids: bool) {
        if let Some(index) = &mut self.index {
            index.has_grids = has_grids;
        }
        self.match_newest(now);
    }

    /// When the next schedule state is due; it counts until the next call.
    pub fn set_next_state(&mut self, next: NextState) {
        self.next_state = next;
    }

    /// True if the newest index is of the newest schedule state, and its grids are there.
    pub fn is_matched(&self) -> bool {
        let (Some(state), Some(index)) = (self.state, self.index) else { return false };
        (index.state, index.site) == (state.hash, state.site) && index.has_grids
    }

    /// What a consumer may do that uses the newest maps that were drawn.
    pub fn verdict(&self, now: Stamp, clock: ClockTime) -> MapVerdict {
        if let Some(reason) = self.silence(now).or_else(|| self.expiry(clock)) {
            return MapVerdict::NoMap(reason);
        }
        if self.state.is_none() || self.drawn.is_none() {
            return MapVerdict::NoMap(NoMapReason::Incomplete);
        }
        match self.late_at() {
            None => MapVerdict::Current,
            Some(late) if now < late => MapVerdict::Overtaken,
            Some(_) => MapVerdict::Hold,
        }
    }

    /// When to ask for the verdict again if nothing comes before, and the clock does not pass an end of validity.
    pub fn next_change(&self, now: Stamp) -> Stamp {
        let silent = self.heard.iter().flatten().map(|heard| *heard + SILENT_AFTER);
        silent.chain(self.late_at()).filter(|at| *at > now).min().unwrap_or(now + HEARTBEAT_PERIOD)
    }

    fn match_newest(&mut self, now: Stamp) {
        if self.is_matched() {
            self.drawn = self.state.map(|state| state.hash);
            self.unmatched_since = None;
        } else {
            self.unmatched_since.get_or_insert(now);
        }
    }

    /// When the grids of the newest schedule state are late; `None` if they are there.
    ///
    /// What a newer state blocks is open on the maps, therefore they are late soon after it came. Newer ones that follow each
    /// other faster, and a state that was drawn before and comes again in a bus that was created anew, have the longer time.
    fn late_at(&self) -> Option<Stamp> {
        let since = self.unmatched_since?;
        let newer = self.newer.filter(|(hash, _)| self.state.is_some() && self.drawn != Some(*hash));
        let late = newer.map(|(_, came)| came + GRIDS_LATE);
        Some(late.into_iter().fold(since + FRESH_TOLERANCE, Stamp::min))
    }

    fn silence(&self, now: Stamp) -> Option<NoMapReason> {
        let mut watched = self.heard.iter().flatten().zip(WATCHED);
        let silent = watched.find(|(heard, _)| now.since(**heard) >= SILENT_AFTER);
        silent.map(|(_, daemon)| NoMapReason::Silent { daemon: if self.is_following { FOLLOWER } else { daemon } })
    }

    fn expiry(&self, clock: ClockTime) -> Option<NoMapReason> {
        match (&self.next_state, clock) {
            (NextState::Unknown { why }, _) => Some(NoMapReason::ClockDistrust { why: why.clone() }),
            (NextState::Due { utc_ms: due_ms }, ClockTime::Machine(utc_ms)) => {
                let is_overdue = utc_ms.saturating_sub(*due_ms) >= FRESH_TOLERANCE.as_millis() as i64;
                is_overdue.then_some(NoMapReason::Overdue { due_ms: *due_ms })
            }
            (_, ClockTime::Plan(plan_time_s)) => {
                let until_s = self.state?.valid_until_s;
                let is_past = until_s != ScheduleStateHead::NO_TIME && plan_time_s > until_s;
                is_past.then_some(NoMapReason::Expired)
            }
            (NextState::None, ClockTime::Machine(_)) | (_, ClockTime::Unknown) => None,
        }
    }
}
