//! Collector of diagnostics, with a limit per code.

use std::collections::BTreeMap;

use crate::{Diagnostic, Named, Severity};

/// Diagnostics of one code that are kept; the rest is counted.
const PER_CODE_MAX: usize = 1000;

/// Collects diagnostics.
#[derive(Default)]
pub(crate) struct Report {
    diagnostics: Vec<Diagnostic>,
    counts: BTreeMap<&'static str, (usize, Severity)>,
}

impl Report {
    pub(crate) fn add(&mut self, severity: Severity, code: &'static str, entity: Option<Named>, message: String) {
        let (count, worst) = self.counts.entry(code).or_insert((0, severity));
        *count += 1;
        *worst = (*worst).max(severity);
        if *count <= PER_CODE_MAX {
            self.diagnostics.push(Diagnostic { severity, code, entity, message });
        }
    }

    /// All diagnostics, with one line per code for those that were too many.
    pub(crate) fn finish(mut self) -> Vec<Diagnostic> {
        for (&code, &(count, severity)) in &self.counts {
            if count > PER_CODE_MAX {
                let message = format!("{} more of this kind are not listed", count - PER_CODE_MAX);
                self.diagnostics.push(Diagnostic { severity, code, entity: None, message });
            }
        }
        self.diagnostics
    }
}

/// An entity of which only the id is known.
pub(crate) fn bare(step_id: u32) -> Option<Named> {
    Some(Named { step_id, ..Named::default() })
}
