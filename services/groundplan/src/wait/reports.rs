//! Conclusions from a daemon's last report.

use daemon::Report;

/// True if a daemon makes its output at the moment; those behind it wait for it.
pub(super) fn is_at_work<F>(report: &Report<F>) -> bool {
    ["reading", "meshing", "writing"].contains(&report.activity.as_str())
}
