//! Wake-up events: one event service per daemon and one for the status stream.

use crate::names::Daemon;

/// Whose bell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum BellName {
    /// Samples from, newcomers at, commands to and replies from a daemon.
    Of(Daemon),
    /// The status stream.
    Status,
}

impl BellName {
    pub(crate) fn text(self) -> &'static str {
        match self {
            Self::Of(daemon) => daemon.name(),
            Self::Status => "status",
        }
    }
}

/// Why a bell rings; numbers of events.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub(crate) enum Ring {
    /// The daemon published a sample; on the status bell: somebody did.
    Data = 0,
    /// A subscriber has come and needs the last samples.
    Newcomer = 1,
    /// A participant that could ring this bell has died.
    Dead = 2,
    /// A command for the daemon.
    Command = 3,
    /// A reply of the daemon.
    Reply = 4,
}

/// Rings since the last look.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Rings(pub(crate) u8);

impl Rings {
    pub(crate) fn add(&mut self, number: usize) {
        self.0 |= 1u8.checked_shl(number as u32).unwrap_or(0);
    }

    pub(crate) fn any(self, rings: &[Ring]) -> bool {
        rings.iter().any(|&r| self.0 & (1 << r as u8) != 0)
    }
}
