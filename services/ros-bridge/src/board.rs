//! Reads the status board for the freshness of maps: which daemons are alive, and when the next schedule state is due.

use bus::{Daemon, Stamp};
use daemon::facts::ScheduleFacts;
use daemon::{FRESH_TOLERANCE, Freshness, Report, StatusBoard};
use serde::de::IgnoredAny;

/// Takes what the daemons report.
pub(crate) fn read_board(freshness: &mut Freshness, board: &StatusBoard) {
    let now = Stamp::now();
    for daemon in [Daemon::ScheduleEval, Daemon::Rasterize] {
        let report: Option<Report<IgnoredAny>> = board.report(daemon);
        if board.is_alive(daemon) && report.is_some_and(|report| report.age() < FRESH_TOLERANCE) {
            freshness.on_heartbeat(now, daemon);
        }
    }
    let facts: Option<Report<ScheduleFacts>> = board.report(Daemon::ScheduleEval);
    if let Some(Report { facts, .. }) = facts {
        freshness.set_next_update(facts.next_update_ms);
        freshness.set_clock_distrust(facts.clock_distrust);
    }
}
