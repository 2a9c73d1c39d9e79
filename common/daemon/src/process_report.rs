//! Reports of a process of a site that is no participant of the bus: the keeper, the relay.

use crate::self_report::resident_bytes;
use crate::site_process::SiteProcess;
use crate::status_board::{BoardEntry, Report};
use bus::Stamp;
use std::collections::BTreeMap;
use std::path::Path;

/// What such a process tells of itself: to the status board, and to the watchdog of systemd.
#[derive(Debug)]
pub struct ProcessReport {
    entry: BoardEntry,
}

impl ProcessReport {
    /// Of this process, beside the bus with this folder.
    pub fn of(bus_root: &Path, process: SiteProcess) -> Self {
        Self { entry: BoardEntry::new(bus_root, process) }
    }

    /// It lives and does this; `error` is what it tries in vain. To be called once a second.
    pub fn alive(&mut self, activity: &str, error: Option<String>) {
        crate::systemd::alive(error.as_deref().unwrap_or(activity));
        let report = Report {
            build: bus::own_build().to_owned(),
            process_id: std::process::id(),
            restarts: self.entry.restarts(),
            stamp_ns: Stamp::now().0,
            activity: activity.to_owned(),
            memory_bytes: resident_bytes(),
            error,
            warning: None,
            epochs: BTreeMap::new(),
            output_stamp_ns: None,
            latency_s: None,
            outputs: Vec::new(),
            busy: None,
            facts: serde_json::Value::Null,
        };
        self.entry.put(&report);
    }

    /// It leaves in order.
    pub fn leave(&mut self) {
        crate::systemd::stopping();
        self.entry.remove();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::status_board::StatusBoard;
    use serde::de::IgnoredAny;

    #[test]
    fn a_process_is_on_the_board_until_it_leaves_and_after_its_death() {
        let root = tempfile::tempdir().unwrap();
        let board = StatusBoard::of(root.path());
        let mut keeper = ProcessReport::of(root.path(), SiteProcess::Keeper);
        keeper.alive("holds the bus", None);
        keeper.alive("holds the bus", Some("the disk is full".to_owned()));
        let report = board.report::<IgnoredAny>(SiteProcess::Keeper).unwrap();
        assert_eq!((report.activity.as_str(), report.error.as_deref()), ("holds the bus", Some("the disk is full")));
        assert!(board.is_alive(SiteProcess::Keeper) && !board.is_alive(SiteProcess::Relay));
        drop(keeper);
        assert!(!board.is_alive(SiteProcess::Keeper) && board.report::<IgnoredAny>(SiteProcess::Keeper).is_some());
        let mut keeper = ProcessReport::of(root.path(), SiteProcess::Keeper);
        keeper.alive("holds the bus", None);
        assert_eq!(board.report::<IgnoredAny>(SiteProcess::Keeper).unwrap().restarts, 1);
        keeper.leave();
        assert!(!board.is_alive(SiteProcess::Keeper) && board.report::<IgnoredAny>(SiteProcess::Keeper).is_none());
    }
}
