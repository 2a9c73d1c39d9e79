//! Presence of an element on a map: absent, worked on, built.

use messages::ElementState;

/// What of an element's state can be seen on a map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub(crate) enum Look {
    /// Not there yet, or no longer.
    Absent,
    /// Being built or removed: an obstacle, no floor, and nobody must be below it.
    WorkedOn,
    /// Finished.
    Built,
}

impl Look {
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
