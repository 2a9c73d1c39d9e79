//! The tasks of a schedule with their dates, what they act on, what is wrong with them, and their progress.

mod list;
mod progress;
mod rows;
mod text;

pub use list::{ElementEntry, SpaceEntry, TaskEntry, TaskList, WarningEntry, list, status_at};
pub use progress::{ElementProgress, Progress, ProgressDates, TaskProgress, progress};
pub use rows::{TaskRow, rows};
