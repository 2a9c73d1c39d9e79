//! Diagnostics of imperfect input that does not stop the work.
//!
//! A [`Diagnostic`] has a [`Severity`], a [`DiagnosticCode`] for programs, the entity that it is about, and a sentence for
//! people. A [`Report`] collects them with a limit per code. Codes are one enumeration for all stages, because files and
//! archives show them side by side.
//!
//! What sentences for people have in common is here, too: counts with their noun ([`counted`]), what people mean by a word
//! ([`called`]), and the names that come nearest to a mistyped one ([`nearest_names`]).
//!
//! # Guarantees
//!
//! - Codes are one enumeration for all stages: a code that is not in it does not compile, and an archive with one is refused.

mod code;
mod counted;
mod names;
mod nearest_names;
mod report;

pub use code::DiagnosticCode;
pub use counted::counted;
pub use names::{Called, NothingCalled, called};
pub use nearest_names::{nearest_names, nearest_names_hint};
pub use report::Report;

use bytemuck::{CheckedBitPattern, NoUninit};

/// A diagnostic of the input, or of a result.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Diagnostic {
    /// How bad it is.
    pub severity: Severity,
    /// What it is.
    pub code: DiagnosticCode,
    /// The entity, if one is meant.
    pub entity: Option<Named>,
    /// Index of the file among those of the site, where there are several to tell apart.
    pub source: Option<u32>,
    /// One sentence for people, a lower-case phrase without a full stop.
    pub message: String,
}

impl Diagnostic {
    /// GlobalId of the entity; empty without one.
    pub fn global_id(&self) -> &str {
        self.entity.as_ref().map_or("", |entity| &entity.global_id)
    }

    /// Name of the entity; empty without one.
    pub fn name(&self) -> &str {
        self.entity.as_ref().map_or("", |entity| &entity.name)
    }
}

/// How bad a diagnostic is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, CheckedBitPattern, NoUninit)]
#[repr(u32)]
pub enum Severity {
    /// For the record.
    Info = 0,
    /// The result is right, but should be checked.
    Warning = 1,
    /// Something is missing from the result, or could not be used.
    Error = 2,
}

impl Severity {
    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Info => "info",
            Self::Warning => "warning",
            Self::Error => "error",
        }
    }
}

/// An IfcRoot by its identity.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Named {
    /// STEP id in its file; 0 if it is not known.
    pub step_id: u64,
    /// GlobalId, 22 characters; empty if it is not known.
    pub global_id: String,
    /// Name; empty if absent.
    pub name: String,
}

impl Named {
    /// An entity of which only the STEP id is known.
    pub fn of_id(step_id: u64) -> Self {
        Self { step_id, ..Self::default() }
    }
}
