//! Schedules of planners' tools: bytes of a file of any format.

#[path = "../../../../common/schedule-files/tests/support/mod.rs"]
mod support;

use schedule_files::{ReadOptions, read};

/// Reads the file; what is read hangs together.
pub fn run(bytes: &[u8]) {
    if let Ok(plan) = read("plan", bytes, &ReadOptions::default()) {
        support::check(&plan);
    }
}
