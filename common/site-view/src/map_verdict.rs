//! The verdict on a robot's maps, and the reasons for which there are none.

use crate::limits::MISSED_HEARTBEATS;
use crate::plan_clock::utc_text;
use bus::Daemon;

/// How a robot may use the maps.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum MapVerdict {
    /// They are of the newest schedule state: use them.
    Current,
    /// A newer schedule state is here, its grids are not yet: use the maps, but do not enter what that state blocks.
    Overtaken,
    /// The grids of the newest schedule state are late: stand still.
    Hold,
    /// There is no map.
    NoMap(NoMapReason),
}

/// Why there is no map.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum NoMapReason {
    /// Schedule state, index and grids have never matched yet.
    #[error("grids, index and schedule state have not come together yet")]
    Incomplete,
    /// The plan time has passed the end of the newest schedule state.
    #[error("the plan time is past the validity of the schedule state, and no newer schedule state has come")]
    Expired,
    /// The same, told by when the next schedule state was due.
    #[error("{}: the next one was due at {}", Self::Expired, utc_text(*.due_ms))]
    Overdue {
        /// Milliseconds since 1970 in UTC.
        due_ms: i64,
    },
    /// The plan time does not follow the machine's clock: nothing tells when the schedule state runs out.
    #[error("{why}")]
    ClockDistrust {
        /// Why it does not.
        why: String,
    },
    /// A daemon that keeps the map up to date is silent.
    #[error("{daemon} has missed {MISSED_HEARTBEATS} heartbeats")]
    Silent {
        /// Which.
        daemon: Daemon,
    },
}
