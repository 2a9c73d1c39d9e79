//! Presence of an element on a map: absent, worked on, built.

use messages::ElementState;

/// How an element appears on maps, from its effective state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub(crate) enum Presence {
    /// Not built yet, or removed.
    Absent,
    /// Being built or removed: an obstacle, no floor, and the cells below it are keep-out.
    WorkedOn,
    /// Finished.
    Built,
}

impl Presence {
    pub(crate) fn of(state: ElementState) -> Self {
        match state {
            ElementState::NotStarted | ElementState::Removed => Self::Absent,
            ElementState::InProgress | ElementState::BeingRemoved => Self::WorkedOn,
            ElementState::Built => Self::Built,
        }
    }

    pub(crate) fn is_obstacle(self) -> bool {
        self != Self::Absent
    }
}
