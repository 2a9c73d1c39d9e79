//! The daemon as a process.

#[path = "../../../common/daemon/tests/support/process.rs"]
mod process;
