//! The change list: every line that is changed or new, the observation behind it, and what was not written and why.

use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeSet;

/// What was written into a model, and what was not.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ChangeList {
    /// The model that was read.
    pub model: FileEntry,
    /// The model that was written.
    pub as_built: FileEntry,
    /// FILE_SCHEMA: `IFC2X3`, `IFC4` or `IFC4X3`.
    pub schema: String,
    /// Files and tables that observations come from.
    pub sources: Vec<FileEntry>,
    /// Observations that were written, by their numbers from 0.
    pub observations: Vec<WrittenObservation>,
    /// Lines that are changed or new, by id; all others are byte for byte those of the model.
    pub lines: Vec<LineChange>,
    /// Observations that were not written.
    pub not_written: Vec<NotWritten>,
}

/// A file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct FileEntry {
    /// Base name, or what a table of the running site is called.
    pub file: String,
    /// sha256 of its bytes, in hex.
    pub sha256: String,
}

/// An observation that was written.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct WrittenObservation {
    /// `task`, `built`, `in_progress`, `absent`, `displaced` or `additional`.
    pub kind: String,
    /// GlobalId of the task or element; of an additional one the new element's.
    pub global_id: String,
    /// Place in `sources`.
    pub source: usize,
    /// Row of the source: `line 3` of a table, a GlobalId or `obstacle 1` of deviations.
    pub row: String,
    /// Who observed, reported or confirmed it.
    pub observer: String,
    /// When, at the site; null if the source tells no time.
    pub at: Option<String>,
    /// What goes with it: elements that move along, what the height of an additional element is.
    pub notes: Vec<String>,
}

/// A line of the file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct LineChange {
    /// Number of the instance.
    pub id: u64,
    /// Whether it is changed or new.
    pub change: LineChangeKind,
    /// GlobalId of the element or task that it is about; null for what all share.
    pub element: Option<String>,
    /// As it was; null for a new one.
    pub old: Option<String>,
    /// As it is.
    pub new: String,
    /// Numbers of the observations behind it.
    pub observations: BTreeSet<usize>,
}

/// What happened to a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum LineChangeKind {
    /// It is another one.
    Changed,
    /// It is new.
    Added,
}

/// An observation that was not written.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct NotWritten {
    /// Place in `sources`.
    pub source: usize,
    /// Row of the source.
    pub row: String,
    /// GlobalId of the task or element, or what the row names; null for what is no element of the model.
    pub id: Option<String>,
    /// Why.
    pub reason: String,
}
