//! Limits of the rule by which maps may be used.

use bus::{Daemon, HEARTBEAT_PERIOD, Stamp};
use std::time::Duration;

/// Daemons without which maps grow old unnoticed: they are watched by their heartbeats.
pub const WATCHED: [Daemon; 2] = [Daemon::ScheduleEval, Daemon::Rasterize];

/// Publishes the maps in the place of all [`WATCHED`] daemons where a robot follows a server: its heartbeats count for each of them.
pub const FOLLOWER: Daemon = Daemon::SiteFollow;

/// Daemons that report when the next schedule state is due. One of them runs: [`newest_schedule_report`] tells which.
pub const SCHEDULE_REPORTERS: [Daemon; 2] = [Daemon::ScheduleEval, FOLLOWER];

/// Which of the [`SCHEDULE_REPORTERS`] has the newest report, from when each last reported: a report of the other is from before the
/// configuration changed. What is later than `now` was written before the machine was started anew, and does not count.
pub fn newest_schedule_report(reported: [Option<Stamp>; SCHEDULE_REPORTERS.len()], now: Stamp) -> Option<usize> {
    let counting = (0..reported.len()).filter(|k| reported[*k].is_some_and(|at| at <= now));
    counting.max_by_key(|k| reported[*k])
}

/// Heartbeats that may be missed: at this many there is no map.
pub const MISSED_HEARTBEATS: u32 = 3;

/// A daemon is silent when its last heartbeat is this old.
pub const SILENT_AFTER: Duration = HEARTBEAT_PERIOD.saturating_mul(MISSED_HEARTBEATS);

/// A newer schedule state without its grids stops the robot after this long.
pub const GRIDS_LATE: Duration = Duration::from_secs(1);

/// Maps are stale when it was unknown for this long whether they are those of the daemons. A consumer takes a check that is
/// older for none, so that a watch that was killed counts as stale at the same age.
pub const FRESH_TOLERANCE: Duration = Duration::from_secs(3);
