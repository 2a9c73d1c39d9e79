//! Options for what the content of a file leaves open.

use frames::written_date::DateOrder;
use serde::Deserialize;
use std::collections::BTreeMap;

/// How to read a schedule file, where its format does not say it itself.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ReadOptions {
    /// Headings of columns of CSV and workbooks, where they are not the usual ones. A heading that is named here is that of no other column.
    pub columns: BTreeMap<CsvColumn, String>,
    /// Order of day, month and year in CSV and in texts of workbooks. Without it the dates themselves decide, if they can be read in one order only.
    pub date_format: Option<DateOrder>,
    /// Label of the encoding of XER and CSV files that are not in UTF-8, as [`is_encoding`] knows it. Without it their bytes decide.
    pub encoding: Option<String>,
    /// Name of the sheet of a workbook. Without it the only one that has the columns of a schedule is read.
    pub sheet: Option<String>,
}

/// True for labels of encodings that files can be in: `windows-1250`, `big5`, `shift_jis`.
pub fn is_encoding(label: &str) -> bool {
    encoding_rs::Encoding::for_label(label.as_bytes()).is_some()
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
