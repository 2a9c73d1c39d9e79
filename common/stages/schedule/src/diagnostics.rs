//! Collector of schedule diagnostics.

use messages::{Diagnostic, DiagnosticCode, Named, Report, ScheduleText, Severity, Site, TaskRecord, Text};

/// The entity of a diagnostic.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Entity {
    global_id: Text,
    name: Text,
    step_id: u32,
    source: u32,
    /// Its texts are those of the work schedule.
    is_of_schedule: bool,
}

impl Entity {
    pub(crate) fn task(task: &TaskRecord) -> Self {
        Self::of_schedule(task.global_id, task.name, task.step_id, task.source)
    }

    /// Something of the work schedule.
    pub(crate) fn of_schedule(global_id: ScheduleText, name: ScheduleText, step_id: u32, source: u32) -> Self {
        Self { global_id: global_id.0, name: name.0, step_id, source, is_of_schedule: true }
    }

    /// Something of the model.
    pub(crate) fn of(global_id: Text, name: Text, step_id: u32, source: u32) -> Self {
        Self { global_id, name, step_id, source, is_of_schedule: false }
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
        let named = |e: Entity| {
            let of_schedule = |t: Text| self.site.schedule.text(t.into());
            let text = |t: Text| if e.is_of_schedule { of_schedule(t) } else { self.site.text(t) }.to_owned();
            Named { step_id: e.step_id, global_id: text(e.global_id), name: text(e.name) }
        };
        let (source, entity) = (entity.map(|e| e.source), entity.map(named));
        self.report.push(Diagnostic { severity, code, entity, source, message });
    }

    /// All diagnostics, with one line per code for those that were too many.
    pub(crate) fn finish(self) -> Vec<Diagnostic> {
        self.report.finish()
    }
}
