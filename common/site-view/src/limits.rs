//! Limits of the rule by which maps may be used.

use bus::{Daemon, HEARTBEAT_PERIOD};
use std::time::Duration;

/// Daemons without which maps grow old unnoticed: they are watched by their heartbeats.
pub const WATCHED: [Daemon; 2] = [Daemon::ScheduleEval, Daemon::Rasterize];

/// Heartbeats that may be missed: at this many there is no map.
pub const MISSED_HEARTBEATS: u32 = 3;

/// A daemon is silent when its last heartbeat is this old.
pub const SILENT_AFTER: Duration = HEARTBEAT_PERIOD.saturating_mul(MISSED_HEARTBEATS);

/// A newer schedule state without its grids stops the robot after this long.
pub const GRIDS_LATE: Duration = Duration::from_secs(1);

/// Maps are stale when it was unknown for this long whether they are those of the daemons. A consumer takes a check that is
/// older for none, so that a watch that was killed counts as stale at the same age.
pub const FRESH_TOLERANCE: Duration = Duration::from_secs(3);
