//! Progress of tasks in the planner's own file: what is told of the tasks is changed, everything else stays byte for byte.

use std::collections::BTreeMap;

/// Progress of a task.
#[derive(Debug, Clone, PartialEq)]
pub struct TaskUpdate {
    /// Per cent that is done, from 0 to 100; `None` leaves what the file has.
    pub percent: Option<f64>,
    /// When it began, as `YYYY-MM-DDTHH:MM:SS`; `None` leaves what the file has.
    pub start: Option<String>,
    /// When it ended, in the same form; then it is done. `None` leaves what the file has.
    pub finish: Option<String>,
}

/// Progress by what identifies a task in its file: `task_id` of XER, `ObjectId` of P6 XML.
pub type TaskUpdates = BTreeMap<String, TaskUpdate>;

/// A file that cannot be changed.
#[derive(Debug, thiserror::Error)]
pub enum PlannerFileError {
    /// A table of an XER file lacks a column.
    #[error("its table TASK has no column {column}, without which progress cannot be written")]
    Column {
        /// The column.
        column: &'static str,
    },
    /// No tasks.
    #[error("it has no table TASK")]
    NoTasks,
    /// Another encoding than that of P6.
    #[error("it is not in UTF-8, as P6 XML is")]
    Encoding,
    /// XML that is none.
    #[error("it is no XML that can be read")]
    Xml(#[from] quick_xml::Error),
}

/// What changes of a task that P6 has.
pub(crate) struct Changed {
    pub(crate) is_done: bool,
    /// Per cent, where it is known.
    pub(crate) percent: Option<f64>,
    pub(crate) start: Option<String>,
    pub(crate) finish: Option<String>,
}

impl Changed {
    /// What an update says of a task; `None` if it has not begun, which is what the file says then.
    pub(crate) fn of(update: &TaskUpdate) -> Option<Self> {
        let is_done = update.finish.is_some();
        let percent = if is_done { Some(100.0) } else { update.percent };
        // A task that is not begun has no actual start, and P6 knows no task at work without one.
        let is_begun = is_done || update.start.is_some();
        is_begun.then(|| Self { is_done, percent, start: update.start.clone(), finish: update.finish.clone() })
    }

    /// What remains of a duration in hours.
    pub(crate) fn remaining_h(&self, planned_h: f64) -> Option<f64> {
        let left = (100.0 - self.percent?).clamp(0.0, 100.0) / 100.0;
        Some((planned_h * left * 100.0).round() / 100.0)
    }
}

/// A number as people write it, with this decimal separator.
pub(crate) fn number(value: f64, separator: char) -> String {
    // Rust writes whole numbers without a point.
    format!("{value}").replace('.', &separator.to_string())
}
