//! Identity of a bus: name prefix and folder on this machine.

use crate::error::DomainError;
use crate::generation::Place;
use std::fs::{File, TryLockError};
use std::io::ErrorKind;
use std::path::Path;

/// A bus. Domains with another prefix and another folder know nothing of each other.
#[derive(Debug, Clone)]
pub struct Domain {
    pub(crate) place: Place,
}

impl Domain {
    /// Prefix of a machine's bus, with the version of the library, whose formats no other version opens.
    pub const DEFAULT_PREFIX: &'static str = "gp010_";

    /// Folder of a machine's bus.
    pub const DEFAULT_ROOT: &'static str = "/run/groundplan";

    /// A bus in shared memory. `prefix` begins the names of its segments: at most 15 letters and digits and an underscore,
    /// so that it is not the beginning of another's. `root` is an absolute folder of at most 48 bytes, because sockets lie
    /// in it, on a file system in memory such as `/run`: the bus library syncs each of its hundreds of files.
    ///
    /// # Errors
    /// A prefix or folder that does not fit.
    pub fn shared(prefix: &str, root: impl AsRef<Path>) -> Result<Self, DomainError> {
        Ok(Self { place: Place::new(prefix, root.as_ref())? })
    }

    /// True if a keeper lives; `None` if this user may not know.
    pub fn has_keeper(&self) -> Option<bool> {
        match File::open(self.place.keeper_lock_path()) {
            Ok(file) => Some(matches!(file.try_lock_shared(), Err(TryLockError::WouldBlock))),
            Err(error) if error.kind() == ErrorKind::NotFound => Some(false),
            Err(_) => None,
        }
    }
}
