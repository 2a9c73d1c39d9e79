//! Conclusions from a daemon's last report.

use daemon::Report;
use site_view::SILENT_AFTER;

/// True if a daemon has not reported for so long that it hangs, or is gone.
pub(super) fn is_silent<F>(report: &Report<F>) -> bool {
    report.age() >= SILENT_AFTER
}

/// True if a daemon makes its output at the moment; those behind it wait for it.
pub(super) fn is_at_work<F>(report: &Report<F>) -> bool {
    ["reading", "meshing", "writing"].contains(&report.activity.as_str())
}
