//! Kinds of replies to a command.

/// What kind of reply.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub(crate) enum ReplyKind {
    Progress = 1,
    Done = 2,
    Failed = 3,
}

impl ReplyKind {
    pub(crate) fn from_id(id: u32) -> Option<Self> {
        [Self::Progress, Self::Done, Self::Failed].into_iter().find(|&k| k as u32 == id)
    }
}
