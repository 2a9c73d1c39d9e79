//! A revision that could take effect, and what is to become of it.

use crate::revision_reader::ReadRevision;
use daemon::Asked;
use messages::ContentId;
use std::sync::Arc;

/// What is to become of a revision that could take effect.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Intent {
    /// It is compared only.
    Compare,
    /// It takes effect, or waits for an operator.
    Load,
    /// It takes effect.
    Force,
    /// It takes effect if its files are those with these hashes; else as with `Load`.
    Confirm(Vec<ContentId>),
}

/// A revision that can be read, and what is to become of it once it is known to have a schedule.
#[derive(Clone)]
pub(crate) struct Proposal {
    pub(crate) revision: Arc<ReadRevision>,
    pub(crate) intent: Intent,
    /// The client that waits for it; `None` for files that nobody asked for.
    pub(crate) asked: Option<Asked>,
    /// Since when it is on the bus, by the machine's count since its boot, in milliseconds.
    pub(crate) since_boot_ms: i64,
    /// Why it has no schedule with the rules, files and progress that were in force; it takes effect once it has one.
    pub(crate) refused: Option<String>,
}
