//! The commands, a file or folder for each: arguments, help, what it does, tests.

pub mod changes;
pub mod convert;
pub mod states;
pub mod tasks;
