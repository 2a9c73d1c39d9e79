//! Collector of schedule diagnostics.

use messages::{Diagnostic, DiagnosticCode, Named, Report, Severity, Site, TaskRecord, Text};

/// The entity of a diagnostic.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Entity {
    global_id: Text,
    name: Text,
    step_id: u32,
    source: u32,
}

impl Entity {
    pub(crate) fn task(task: &TaskRecord) -> Self {
        Self { global_id: task.global_id, name: task.name, step_id: task.step_id, source: task.source }
    }

    pub(crate) fn of(global_id: Text, name: Text, step_id: u32, source: u32) -> Self {
        Self { global_id, name, step_id, source }
    }
}

/// Collects diagnostics in the order in which they are made.
#[derive(Debug)]
pub(crate) struct ScheduleDiagnostics<'a> {
    site: &'a Site<'a>,
    report: Report,
}

impl<'a> ScheduleDiagnostics<'a> {
    pub(crate) fn new(site: &'a Site<'a>) -> Self {
        Self { site, report: Report::default() }
    }

    pub(crate) fn add(&mut self, severity: Severity, code: DiagnosticCode, entity: Option<Entity>, message: String) {
        let text = |t: Text| self.site.text(t).to_owned();
        let named = |e: Entity| Named { step_id: e.step_id, global_id: text(e.global_id), name: text(e.name) };
        let (source, entity) = (entity.map(|e| e.source), entity.map(named));
        self.report.push(Diagnostic { severity, code, entity, source, message });
    }

    /// All diagnostics, with one line per code for those that were too many.
    pub(crate) fn finish(self) -> Vec<Diagnostic> {
        self.report.finish()
    }
}
