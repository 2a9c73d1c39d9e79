//! The user who sent a request.

use serde::{Deserialize, Serialize};

/// The user who sent a request, as the system knows the process: nothing that a client says of itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Caller {
    /// Number of the user.
    pub uid: u32,
}

impl Caller {
    /// The user of this process.
    pub fn own() -> Self {
        Self { uid: rustix::process::getuid().as_raw() }
    }
}

impl std::fmt::Display for Caller {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "user {}", self.uid)
    }
}
