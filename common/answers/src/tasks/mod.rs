//! The tasks of a schedule with their dates, what they act on, and what is wrong with them.

mod list;
mod rows;
mod text;

pub use list::{ElementEntry, SpaceEntry, TaskEntry, TaskList, WarningEntry, list};
pub use rows::{TaskRow, rows};
