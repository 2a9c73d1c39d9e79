//! Warnings and errors about one element, room or task.

use crate::situation::Situation;
use messages::{DiagnosticRecord, Severity, Text};
use schemars::JsonSchema;
use serde::Serialize;

/// Something about the input, or about what was made of it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Finding {
    /// `warning` or `error`.
    pub severity: &'static str,
    /// Stable code for programs.
    pub code: &'static str,
    /// One sentence for people.
    pub message: String,
}

impl Finding {
    /// For people, in a line.
    pub(crate) fn line(&self) -> String {
        format!("{}: {}: {}", self.severity, self.code, self.message)
    }
}

/// Warnings and errors of model, schedule and mission plan about a GlobalId.
pub(crate) fn findings_about(situation: &Situation<'_>, global_id: &str) -> Vec<Finding> {
    let Situation { site, schedule_state, mission_plan, .. } = *situation;
    let mut all = among(global_id, site.diagnostics, |text| site.text(text));
    all.extend(among(global_id, schedule_state.diagnostics, |text| schedule_state.text(text)));
    all.extend(among(global_id, mission_plan.diagnostics, |text| mission_plan.text(text)));
    all
}

fn among<'a>(global_id: &str, diagnostics: &[DiagnosticRecord], text: impl Fn(Text) -> &'a str) -> Vec<Finding> {
    let about = diagnostics.iter().filter(|d| d.severity.get() > Severity::Info && text(d.global_id) == global_id);
    about
        .map(|d| Finding {
            severity: d.severity.get().name(),
            code: d.code.get().name(),
            message: text(d.message).to_owned(),
        })
        .collect()
}
