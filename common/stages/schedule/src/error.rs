//! Errors of the evaluation of a schedule.

/// Why a schedule cannot be evaluated.
#[derive(Debug, thiserror::Error)]
pub enum EvaluateError {
    /// Dates that fit two orders, and nothing decides between them.
    #[error(transparent)]
    AmbiguousDates(Box<AmbiguousDates>),
    /// Dates of both orders.
    #[error(
        "{file}: {dmy:?} can only be day/month/year, {mdy:?} only month/day/year: set date_format in the schedule rules"
    )]
    ContradictingDates {
        /// Name of the file.
        file: String,
        /// A date that has no reading as month/day/year.
        dmy: String,
        /// A date that has no reading as day/month/year.
        mdy: String,
    },
    /// A delay of a task that does not exist.
    #[error("there is no task with the GlobalId, identification or name {wanted:?}{nearest}")]
    NoSuchTask {
        /// As asked for.
        wanted: String,
        /// The nearest names, as the end of the message; may be empty.
        nearest: String,
    },
    /// A delay of one of several.
    #[error("{n} tasks are called {wanted:?}: use the GlobalId")]
    SeveralTasks {
        /// As asked for.
        wanted: String,
        /// How many.
        n: usize,
    },
    /// Reported progress that cannot be used.
    #[error("reported progress of {id} (line {line}): {why}")]
    Reported {
        /// Line of the table.
        line: u64,
        /// As reported.
        id: String,
        /// What is wrong with it.
        why: String,
    },
}

/// Dates of a file that fit two orders: one of them with both readings.
#[derive(Debug, thiserror::Error)]
#[error(
    "{file}: {text:?} ({property} of {global_id}) is {dmy} as day/month/year and {mdy} as month/day/year, and all {n_dates} text \
     dates of the file fit both: set date_format = \"dmy\" or \"mdy\" in the schedule rules"
)]
pub struct AmbiguousDates {
    /// Name of the file.
    pub file: String,
    /// A date as written.
    pub text: String,
    /// Set and property.
    pub property: String,
    /// Its owner.
    pub global_id: String,
    /// Its reading as day/month/year.
    pub dmy: String,
    /// Its reading as month/day/year.
    pub mdy: String,
    /// Number of text dates of the file.
    pub n_dates: usize,
}
