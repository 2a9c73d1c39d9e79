//! Schedule files that cannot be used at all.

/// Why a schedule file cannot be read. What is wrong with single tasks is a [`crate::Finding`] instead.
#[derive(Debug, thiserror::Error)]
pub enum PlanFileError {
    /// It is none of the formats.
    #[error("{0}")]
    NoSchedule(String),
    /// A file of a product that has to be saved in another format.
    #[error("files of {product} are not read; {how}")]
    SaveAs {
        /// The product.
        product: &'static str,
        /// How to save it.
        how: &'static str,
    },
    /// Its declared encoding does not exist, or its bytes are not in it.
    #[error("its text is not in the encoding {0:?}")]
    Encoding(String),
    /// XML that is not well-formed, or nests or expands without end.
    #[error("line {line}: {why}")]
    Xml {
        /// From 1.
        line: usize,
        /// What is wrong.
        why: String,
    },
    /// A table that is cut off, or lacks a column that is needed.
    #[error("line {line}: {why}")]
    Table {
        /// From 1.
        line: usize,
        /// What is wrong.
        why: String,
    },
    /// A sheet of a workbook that cannot be read.
    #[error("sheet {sheet:?}: {why}")]
    Sheet {
        /// Its name.
        sheet: String,
        /// What is wrong, with the cell.
        why: String,
    },
    /// Dates that can be read in two ways.
    #[error(
        "its dates can be read in two ways: {text:?} is {as_dmy} or {as_mdy}; say which with date_format in the schedule rules"
    )]
    AmbiguousDates {
        /// The first of them.
        text: String,
        /// It as day, month and year.
        as_dmy: String,
        /// It as month, day and year.
        as_mdy: String,
    },
    /// Dates that are in two orders.
    #[error(
        "its dates contradict each other: {dmy:?} is day, month and year, {mdy:?} is month, day and year; say which with date_format in \
         the schedule rules"
    )]
    ContradictingDates {
        /// The first that is day, month and year alone.
        dmy: String,
        /// The first that is month, day and year alone.
        mdy: String,
    },
    /// More of something than a schedule of a site has.
    #[error("it has more than {max} {what}")]
    TooMany {
        /// The limit.
        max: usize,
        /// Of what.
        what: &'static str,
    },
}
