//! Reports of the site that clients ask for. Each client gets the same bytes for a while: who asks without end does not keep
//! the relay busy with making them.

use crate::report_kind::ReportKind;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// A report is passed on for this long before it is made anew.
const KEPT_FOR: Duration = Duration::from_millis(200);

/// Makes the bytes of a report.
pub(super) type MakeReport = Box<dyn Fn(ReportKind) -> Vec<u8> + Send>;

/// Makes and keeps the reports.
pub(super) struct Reports {
    make: MakeReport,
    last: [Option<(Instant, Arc<[u8]>)>; ReportKind::ALL.len()],
}

impl Reports {
    pub(super) fn new(make: MakeReport) -> Self {
        Self { make, last: [const { None }; ReportKind::ALL.len()] }
    }

    /// A report as it is, or was a moment ago.
    pub(super) fn get(&mut self, kind: ReportKind) -> Arc<[u8]> {
        let last = &mut self.last[kind as usize];
        let kept = last.take().filter(|(made, _)| made.elapsed() < KEPT_FOR);
        let (made, bytes) = kept.unwrap_or_else(|| (Instant::now(), (self.make)(kind).into()));
        *last = Some((made, Arc::clone(&bytes)));
        bytes
    }
}
