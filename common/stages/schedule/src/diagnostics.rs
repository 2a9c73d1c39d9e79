//! Collector of schedule diagnostics.

use messages::{Diagnostic, DiagnosticCode, NONE, Named, Report, ScheduleText, Severity, Site, TaskRecord, Text};

/// The entity of a diagnostic.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Entity {
    global_id: Text,
    name: Text,
    step_id: u64,
    source: u32,
    /// Its texts are those of the work schedule.
    is_of_schedule: bool,
}

impl Entity {
    pub(crate) fn task(task: &TaskRecord) -> Self {
        Self::of_schedule(task.global_id, task.name, task.step_id, task.source)
    }

    /// Something of the work schedule.
    pub(crate) fn of_schedule(global_id: ScheduleText, name: ScheduleText, step_id: u64, source: u32) -> Self {
        Self { global_id: global_id.0, name: name.0, step_id, source, is_of_schedule: true }
    }

    /// Something of the model.
    pub(crate) fn of(global_id: Text, name: Text, step_id: u64, source: u32) -> Self {
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
    /// Begins with what is wrong with schedule files and links.
    pub(crate) fn new(site: &'a Site<'a>) -> Self {
        let mut report = Report::default();
        let schedule = &site.schedule;
        // Files are numbered on behind those of the models.
        let first_source = site.sources.len() as u32;
        for d in schedule.diagnostics {
            let text = |t: Text| schedule.text(t.into()).to_owned();
            let named = Named { step_id: d.step_id, global_id: text(d.global_id), name: text(d.name) };
            let entity = Some(named).filter(|named| !named.global_id.is_empty());
            let source = Some(d.source).filter(|source| *source != NONE).map(|source| first_source + source);
            let (severity, code) = (d.severity.get(), d.code.get());
            report.push(Diagnostic { severity, code, entity, source, message: text(d.message) });
        }
        Self { site, report }
    }

    pub(crate) fn add(&mut self, severity: Severity, code: DiagnosticCode, entity: Option<Entity>, message: String) {
        let named = |e: Entity| {
            let of_schedule = |t: Text| self.site.schedule.text(t.into());
            let text = |t: Text| if e.is_of_schedule { of_schedule(t) } else { self.site.text(t) }.to_owned();
            Named { step_id: e.step_id, global_id: text(e.global_id), name: text(e.name) }
        };
        let first = |e: Entity| {
            if e.is_of_schedule && !self.site.schedule.tasks_hash.is_none() { self.site.sources.len() } else { 0 }
        };
        let (source, entity) = (entity.map(|e| e.source + first(e) as u32), entity.map(named));
        self.report.push(Diagnostic { severity, code, entity, source, message });
    }

    /// All diagnostics, with one line per code for those that were too many.
    pub(crate) fn finish(self) -> Vec<Diagnostic> {
        self.report.finish()
    }
}
