//! Context shared by the parts of the schedule reader.

use crate::kernel::File;
use diagnostics::{DiagnosticCode, Named, Report, Severity};
use rustc_hash::FxHashMap;

/// Shared inputs of the schedule reader.
pub(super) struct Context<'c, 'a> {
    pub(super) file: &'c File<'a>,
    /// Seconds per time unit of the project, for files that count in it.
    pub(super) time_unit_s: Result<f64, String>,
    pub(super) task_idx: FxHashMap<u32, usize>,
    /// Identities of the tasks.
    pub(super) task_ids: Vec<Named>,
}

/// A diagnostic that names an entity.
pub(super) fn tell(report: &mut Report, severity: Severity, code: DiagnosticCode, id: &Named, message: String) {
    report.add(severity, code, Some(id.clone()), message);
}
