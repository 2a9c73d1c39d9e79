//! Stretches of cells in a row.

/// Cells `start..end` of a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Run {
    /// Row.
    pub row: u32,
    /// First column.
    pub start: u32,
    /// First column behind the run.
    pub end: u32,
}
