//! Schedules of planners' tools: bytes of a file of any format.

#[path = "../../../../common/schedule-files/tests/support/mod.rs"]
mod support;
#[path = "../../../../common/schedule-files/tests/workbook/mod.rs"]
mod workbook;

use schedule_files::{ReadOptions, read};

/// Reads the file; what is read hangs together. Bytes behind `sheet:` are the content of a sheet in a workbook, since changes of a
/// container end at its checksums.
pub fn run(bytes: &[u8]) {
    let container;
    let bytes = match bytes.strip_prefix(b"sheet:").map(String::from_utf8_lossy) {
        Some(content) => {
            container = workbook::workbook(&[("Plan", &content)], bytes.len().is_multiple_of(2));
            &container
        }
        None => bytes,
    };
    if let Ok(plan) = read("plan", bytes, &ReadOptions::default()) {
        support::check(&plan);
    }
}
