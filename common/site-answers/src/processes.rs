//! Processes of a site as its status board has them.

use answers::processes::{SeenProcess, SeenReport};
use daemon::{Report, SiteProcess, StatusBoard};
use serde::de::IgnoredAny;

/// A process of a site for questions about it.
pub fn seen_process(board: &StatusBoard, process: SiteProcess) -> SeenProcess {
    let report: Option<Report<IgnoredAny>> = board.report(process);
    let report = report.map(|report| SeenReport {
        age: report.age(),
        is_overdue: report.is_silent(),
        process_id: report.process_id,
        restarts: report.restarts,
        memory_bytes: report.memory_bytes,
        busy: report.busy.as_ref().map(|busy| (busy.job.clone(), busy.duration())),
        activity: report.activity,
        error: report.error,
        warning: report.warning,
    });
    SeenProcess { name: process.to_string(), is_alive: board.is_alive(process), report }
}
