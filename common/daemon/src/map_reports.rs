//! Reports on the status board that the rule of usable maps takes: the last word of each watched daemon, and the time of the next
//! schedule state.

use crate::facts::ScheduleFacts;
use crate::status_board::{Report, StatusBoard};
use bus::Stamp;
use serde::de::IgnoredAny;
use site_view::{FOLLOWER, Freshness, NextState, SCHEDULE_REPORTERS, WATCHED, newest_schedule_report};

/// Tells what the watched daemons report: for a process that does not take their heartbeats from the bus. A report counts at the
/// time at which it was written, as the heartbeat that goes with it. What there is no report of stays as it was.
pub fn hear_daemons(board: &StatusBoard, freshness: &mut Freshness) {
    for daemon in WATCHED.into_iter().chain([FOLLOWER]) {
        let report: Option<Report<IgnoredAny>> = board.report(daemon);
        // One of the future was written before the machine was started anew.
        if let Some(at) = report.map(|report| Stamp(report.stamp_ns)).filter(|at| *at <= Stamp::now()) {
            freshness.on_heartbeat(at, daemon);
        }
    }
    if let Some(next) = next_state(board) {
        freshness.set_next_state(next);
    }
}

/// What is told of the schedule: by schedule-eval, or by what follows a server in its place.
pub fn schedule_report(board: &StatusBoard) -> Option<Report<ScheduleFacts>> {
    let mut reports = SCHEDULE_REPORTERS.map(|daemon| board.report(daemon));
    let stamps = reports.each_ref().map(|report: &Option<Report<_>>| report.as_ref().map(|r| Stamp(r.stamp_ns)));
    reports[newest_schedule_report(stamps, Stamp::now())?].take()
}

/// When the next schedule state is due; `None` without a report of schedule-eval, or of what follows a server in its place.
pub fn next_state(board: &StatusBoard) -> Option<NextState> {
    let report = schedule_report(board)?;
    let ScheduleFacts { next_update_ms, clock_distrust, .. } = report.facts;
    Some(match (clock_distrust, next_update_ms) {
        (Some(why), _) => NextState::Unknown { why },
        (None, Some(utc_ms)) => NextState::Due { utc_ms },
        (None, None) => NextState::None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::status_board::BoardEntry;
    use messages::{ContentHash, GridsHead, RobotProfile, ScheduleStateBuilder};
    use site_view::{MapState, MapsInUse, SILENT_AFTER};

    /// A board on which both daemons reported at a time, with facts of schedule-eval.
    fn reported(root: &std::path::Path, at: Stamp, facts: serde_json::Value) -> StatusBoard {
        for daemon in WATCHED {
            let report = Report { stamp_ns: at.0, facts: facts.clone(), ..Report::default() };
            BoardEntry::new(root, daemon).put(&report);
        }
        StatusBoard::of(root)
    }

    fn fresh(joined: Stamp) -> Freshness {
        let mut freshness = Freshness::default();
        let head = GridsHead {
            site_hash: ContentHash::from_bits(1),
            schedule_state_hash: ContentHash::from_bits(7),
            plan_time_s: 0,
            robot: RobotProfile::DEFAULT,
        };
        freshness.joined(joined);
        freshness.on_schedule_state(
            joined,
            ContentHash::from_bits(7),
            &ScheduleStateBuilder::everything_built(ContentHash::from_bits(1), 0, 0).head,
        );
        freshness.on_index(joined, &head, Vec::new());
        freshness.on_maps(MapsInUse { epoch: 1, site_hash: ContentHash::from_bits(1), grids: Vec::new() });
        freshness
    }

    #[test]
    fn a_report_is_a_heartbeat_at_the_time_at_which_it_was_written() {
        let root = tempfile::tempdir().unwrap();
        let now = Stamp::now();
        let joined = Stamp(now.0.saturating_sub(4_000_000_000));
        let at = |ms: u64| joined + std::time::Duration::from_millis(ms);
        let board = reported(root.path(), at(2_000), serde_json::json!({}));
        let mut freshness = fresh(joined);
        assert!(matches!(freshness.state(at(3_000), 0), MapState::Stale { .. }), "nothing was heard");
        hear_daemons(&board, &mut freshness);
        assert!(matches!(freshness.state(at(4_999), 0), MapState::Fresh { .. }));
        assert!(matches!(freshness.state(at(2_000) + SILENT_AFTER, 0), MapState::Stale { .. }));
    }

    #[test]
    fn facts_of_schedule_eval_tell_when_the_next_state_is_due() {
        let root = tempfile::tempdir().unwrap();
        assert_eq!(next_state(&StatusBoard::of(root.path())), None);
        std::fs::create_dir(root.path().join("board")).unwrap();
        let says = |facts| next_state(&reported(root.path(), Stamp::now(), facts)).unwrap();
        assert_eq!(says(serde_json::json!({})), NextState::None);
        assert_eq!(says(serde_json::json!({"next_update_ms": 5})), NextState::Due { utc_ms: 5 });
        let distrusted = serde_json::json!({"next_update_ms": 5, "clock_distrust": "clock_untrusted"});
        assert_eq!(says(distrusted), NextState::Unknown { why: "clock_untrusted".to_owned() });
        let later =
            Report { stamp_ns: Stamp::now().0, facts: serde_json::json!({"next_update_ms": 7}), ..Report::default() };
        BoardEntry::new(root.path(), FOLLOWER).put(&later);
        assert_eq!(next_state(&StatusBoard::of(root.path())), Some(NextState::Due { utc_ms: 7 }), "it runs now");
    }
}
