//! Identity of a bus: name prefix and folder on this machine, and the folder of its relay.

use crate::accounts::user_text;
use crate::error::DomainError;
use crate::generation::Place;
use std::fs::{File, TryLockError};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// Names of sockets have 107 bytes; `control.sock` leaves this for the folder.
const MAX_RELAY_BYTES: usize = 94;

/// A bus. Domains with another prefix and another folder know nothing of each other.
#[derive(Debug, Clone)]
pub struct Domain {
    pub(crate) place: Place,
    relay_folder: PathBuf,
}

impl Domain {
    /// Prefix of a machine's bus, with the version of the library, whose formats no other version opens.
    pub const DEFAULT_PREFIX: &'static str = "gp010_";

    /// Folder of a machine's bus.
    pub const DEFAULT_ROOT: &'static str = "/run/groundplan";

    /// A bus in shared memory. `prefix` begins the names of its segments: at most 15 letters and digits and an underscore,
    /// so that it is not the beginning of another's. `root` is an absolute folder of at most 48 bytes, because sockets lie
    /// in it, on a file system in memory such as `/run`: the bus library syncs each of its hundreds of files. It is for the
    /// bus's user alone. The sockets of the relay lie in `<root>-relay`.
    ///
    /// # Errors
    /// A prefix or folder that does not fit.
    pub fn shared(prefix: &str, root: impl AsRef<Path>) -> Result<Self, DomainError> {
        let root = root.as_ref();
        let mut relay_folder = root.as_os_str().to_owned();
        relay_folder.push("-relay");
        Ok(Self { place: Place::new(prefix, root)?, relay_folder: relay_folder.into() })
    }

    /// The same bus with the sockets of its relay in an absolute folder of at most 94 bytes.
    ///
    /// # Errors
    /// A folder that does not fit.
    pub fn with_relay(self, folder: impl Into<PathBuf>) -> Result<Self, DomainError> {
        let relay_folder = folder.into();
        if !relay_folder.is_absolute() || relay_folder.as_os_str().len() > MAX_RELAY_BYTES {
            return Err(DomainError::RelayFolder { folder: relay_folder, max: MAX_RELAY_BYTES });
        }
        Ok(Self { relay_folder, ..self })
    }

    /// The folder of the relay's sockets.
    pub fn relay_folder(&self) -> &Path {
        &self.relay_folder
    }

    /// The user who owns the bus, if that is not the user of this process.
    pub(crate) fn foreign_owner(&self) -> Result<Option<u32>, DomainError> {
        let own = rustix::process::geteuid().as_raw();
        Ok(self.place.owner()?.filter(|owner| *owner != own))
    }

    /// Refuses the bus of another user.
    pub(crate) fn require_own(&self) -> Result<(), DomainError> {
        self.foreign_owner()?.map_or(Ok(()), |owner| Err(DomainError::Foreign { owner: user_text(owner) }))
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
