//! Options for what the content of a file leaves open.

use frames::written_date::DateOrder;
use serde::Deserialize;
use std::collections::BTreeMap;

/// How to read a schedule file; all of it is for CSV, as the other formats say it themselves.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ReadOptions {
    /// Headings of columns, where they are not the usual ones. A heading that is named here is that of no other column.
    pub columns: BTreeMap<CsvColumn, String>,
    /// Order of day, month and year. Without it the dates themselves decide, if they can be read in one order only.
    pub date_format: Option<DateOrder>,
}

/// What a column of a CSV holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Deserialize)]
#[serde(rename_all = "snake_case")]
#[expect(missing_docs, reason = "the names are those of the fields of a task")]
pub enum CsvColumn {
    Id,
    Code,
    Wbs,
    /// The id of the task it is nested in.
    Parent,
    /// From 1.
    OutlineLevel,
    Name,
    /// Task, summary or milestone; other words are fields.
    Type,
    /// Yes or no.
    Milestone,
    /// Yes or no.
    Active,
    Start,
    Finish,
    PlannedStart,
    PlannedFinish,
    EarlyStart,
    EarlyFinish,
    LateStart,
    LateFinish,
    ActualStart,
    ActualFinish,
    BaselineStart,
    BaselineFinish,
    Duration,
    RemainingDuration,
    PercentComplete,
    PhysicalPercentComplete,
    /// `12FS+3d;14SS`.
    Predecessors,
}
