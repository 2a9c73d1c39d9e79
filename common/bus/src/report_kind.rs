//! Reports of a site that a relay gives to other users, beside the bus.

/// A report of a site.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u64)]
pub enum ReportKind {
    /// What its processes say of themselves.
    Status = 0,
    /// What was done to it.
    History = 1,
}

impl ReportKind {
    /// All of them, in the order of their numbers.
    pub const ALL: [Self; 2] = [Self::Status, Self::History];

    pub(crate) fn from_id(id: u64) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| *kind as u64 == id)
    }
}
