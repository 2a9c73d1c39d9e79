//! The record of a diagnostic, the same in `site`, `schedule-state` and `mission-plan`.

use crate::archive::{ArchiveError, NONE, Text};
use crate::tag::{Tag, check_tags};
use crate::text_pool::TextPool;
use bytemuck::{Pod, Zeroable};
use diagnostics::{Diagnostic, DiagnosticCode, Severity};

/// Something about the input, or about what was made of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Zeroable, Pod)]
#[repr(C)]
pub struct DiagnosticRecord {
    /// STEP id of the entity meant, or 0.
    pub step_id: u64,
    /// GlobalId of the entity meant, or empty.
    pub global_id: Text,
    /// Name of the entity meant, or empty.
    pub name: Text,
    /// One sentence for people.
    pub message: Text,
    /// What it is.
    pub code: Tag<DiagnosticCode>,
    /// How bad it is.
    pub severity: Tag<Severity>,
    /// Index of the file, or `NONE`.
    pub source: u32,
    /// Zero.
    pub reserved: u32,
}
const _: () = assert!(size_of::<DiagnosticRecord>() == 48);

impl DiagnosticRecord {
    /// The record of a diagnostic, with its texts in an archive to be.
    pub fn of(diagnostic: &Diagnostic, texts: &mut TextPool) -> Self {
        Self {
            global_id: texts.add(diagnostic.global_id()),
            name: texts.add(diagnostic.name()),
            message: texts.add(&diagnostic.message),
            code: diagnostic.code.into(),
            severity: diagnostic.severity.into(),
            step_id: diagnostic.entity.as_ref().map_or(0, |entity| entity.step_id),
            source: diagnostic.source.unwrap_or(NONE),
            reserved: 0,
        }
    }

    /// Its texts.
    pub(crate) fn texts(&self) -> [Text; 3] {
        [self.global_id, self.name, self.message]
    }
}

/// Checks codes and severities.
pub(crate) fn check_diagnostics(diagnostics: &[DiagnosticRecord]) -> Result<(), ArchiveError> {
    check_tags(diagnostics.iter().map(|d| d.code), "code of a diagnostic")?;
    check_tags(diagnostics.iter().map(|d| d.severity), "severity")
}
