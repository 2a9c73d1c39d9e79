//! Collector of diagnostics, with a limit per code.

use crate::{Diagnostic, DiagnosticCode, Named, Severity};
use std::collections::BTreeMap;

/// Collects diagnostics in the order in which they are made.
#[derive(Debug, Default)]
pub struct Report {
    diagnostics: Vec<Diagnostic>,
    /// By the names of codes: number of diagnostics, worst severity.
    counts: BTreeMap<&'static str, (DiagnosticCode, usize, Severity)>,
}

impl Report {
    /// Diagnostics of one code that are listed; the others are counted.
    pub const MAX_PER_CODE: usize = 1_000;

    /// Adds a diagnostic of the only file.
    pub fn add(&mut self, severity: Severity, code: DiagnosticCode, entity: Option<Named>, message: String) {
        self.push(Diagnostic { severity, code, entity, source: None, message });
    }

    /// Adds a diagnostic.
    pub fn push(&mut self, diagnostic: Diagnostic) {
        let Diagnostic { severity, code, .. } = diagnostic;
        let (_, count, worst) = self.counts.entry(code.name()).or_insert((code, 0, severity));
        *count += 1;
        *worst = (*worst).max(severity);
        if *count <= Self::MAX_PER_CODE {
            self.diagnostics.push(diagnostic);
        }
    }

    /// All diagnostics, with one line per code for those that were too many.
    pub fn finish(mut self) -> Vec<Diagnostic> {
        for &(code, count, severity) in self.counts.values() {
            if count > Self::MAX_PER_CODE {
                let message = format!("{} more of this kind are not listed", count - Self::MAX_PER_CODE);
                self.diagnostics.push(Diagnostic { severity, code, entity: None, source: None, message });
            }
        }
        self.diagnostics
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn too_many_of_one_code_are_counted_with_the_worst_severity() {
        let mut report = Report::default();
        report.add(Severity::Info, DiagnosticCode::TaskCycle, None, "another".to_owned());
        for k in 0..Report::MAX_PER_CODE + 3 {
            let severity = if k == 1_001 { Severity::Error } else { Severity::Warning };
            report.add(severity, DiagnosticCode::DuplicateId, None, k.to_string());
        }
        let found = report.finish();
        let last = found.last().unwrap();
        assert_eq!((found.len(), last.severity), (Report::MAX_PER_CODE + 2, Severity::Error));
        assert_eq!(last.message, "3 more of this kind are not listed");
    }
}
