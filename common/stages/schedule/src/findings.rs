//! Collector of schedule diagnostics.

use messages::{DiagnosticRecord, NONE, Site, TaskRecord, Text, TextPool};

/// Findings of one code that are kept; the rest is counted.
const MAX_PER_CODE: usize = 1_000;

/// Something that somebody should know.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Finding {
    /// How bad it is.
    pub severity: Severity,
    /// Stable word for programs, e.g. `task_cycle`.
    pub code: &'static str,
    /// GlobalId of the entity meant; may be empty.
    pub global_id: String,
    /// Name of the entity meant; may be empty.
    pub name: String,
    /// One sentence for people, a lower-case phrase without a full stop.
    pub message: String,
    pub(crate) step_id: u32,
    pub(crate) source: u32,
}

/// How bad a finding is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u32)]
pub enum Severity {
    /// For the record.
    Info = 0,
    /// The result is right, but somebody should look.
    Warning = 1,
    /// Something could not be used.
    Error = 2,
}

/// Whom a finding is about.
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

/// Collects findings in the order in which they are made.
#[derive(Debug)]
pub(crate) struct Findings<'a> {
    site: &'a Site<'a>,
    list: Vec<Finding>,
    counts: std::collections::BTreeMap<&'static str, (usize, Severity)>,
}

impl<'a> Findings<'a> {
    pub(crate) fn new(site: &'a Site<'a>) -> Self {
        Self { site, list: Vec::new(), counts: std::collections::BTreeMap::new() }
    }

    pub(crate) fn add(&mut self, severity: Severity, code: &'static str, entity: Option<Entity>, message: String) {
        let (count, worst) = self.counts.entry(code).or_insert((0, severity));
        *count += 1;
        *worst = (*worst).max(severity);
        if *count > MAX_PER_CODE {
            return;
        }
        let text = |t: Text| self.site.text(t).to_owned();
        self.list.push(Finding {
            severity,
            code,
            global_id: entity.map(|e| text(e.global_id)).unwrap_or_default(),
            name: entity.map(|e| text(e.name)).unwrap_or_default(),
            message,
            step_id: entity.map_or(0, |e| e.step_id),
            source: entity.map_or(NONE, |e| e.source),
        });
    }

    /// All findings, with one line per code for those that were too many.
    pub(crate) fn finish(mut self) -> Vec<Finding> {
        for (&code, &(count, severity)) in &self.counts {
            if count > MAX_PER_CODE {
                let message = format!("{} more of this kind are not listed", count - MAX_PER_CODE);
                let (global_id, name) = (String::new(), String::new());
                self.list.push(Finding { severity, code, global_id, name, message, step_id: 0, source: NONE });
            }
        }
        self.list
    }
}

impl Finding {
    pub(crate) fn record(&self, texts: &mut TextPool) -> DiagnosticRecord {
        DiagnosticRecord {
            code: texts.add(self.code),
            global_id: texts.add(&self.global_id),
            name: texts.add(&self.name),
            message: texts.add(&self.message),
            severity: self.severity as u32,
            step_id: self.step_id,
            source: self.source,
            reserved: 0,
        }
    }
}
