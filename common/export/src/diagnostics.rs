//! Diagnostics of a site and its schedule, as files have them.

use crate::text::text_or_null;
use messages::{DiagnosticRecord, ScheduleState, Site, Text};
use schemars::JsonSchema;
use serde::Serialize;

#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct Diagnostic {
    /// `info`, `warning` or `error`.
    severity: &'static str,
    /// Stable code for programs.
    code: &'static str,
    /// The file, if one is meant.
    file: Option<String>,
    /// STEP id of the entity meant, e.g. `#123`.
    entity: Option<String>,
    /// GlobalId of the entity meant.
    global_id: Option<String>,
    /// Name of the entity meant.
    name: Option<String>,
    /// One sentence for people.
    message: String,
}

/// What is wrong with the model.
pub(crate) fn site_diagnostics<'s>(site: &'s Site<'_>) -> impl Iterator<Item = Diagnostic> + use<'s> {
    site.diagnostics.iter().map(move |d| Diagnostic::of(site, d, |t| site.text(t)))
}

/// What is wrong with the schedule.
pub(crate) fn schedule_diagnostics<'s>(
    site: &'s Site<'_>,
    schedule_state: &'s ScheduleState<'_>,
) -> impl Iterator<Item = Diagnostic> + use<'s> {
    schedule_state.diagnostics.iter().map(move |d| Diagnostic::of(site, d, |t| schedule_state.text(t)))
}

impl Diagnostic {
    fn of<'a>(site: &Site<'_>, d: &DiagnosticRecord, text: impl Fn(Text) -> &'a str) -> Self {
        let file = site.source_file(d.source);
        Self {
            severity: d.severity.get().name(),
            code: d.code.get().name(),
            file: file.and_then(text_or_null),
            entity: (d.step_id != 0).then(|| format!("#{}", d.step_id)),
            global_id: text_or_null(text(d.global_id)),
            name: text_or_null(text(d.name)),
            message: text(d.message).to_owned(),
        }
    }
}
