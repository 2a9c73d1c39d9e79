//! Which bus: a prefix and a folder of this machine, or a double inside this process.

use crate::error::DomainError;
use crate::generation::Place;
use crate::local;
use std::fmt;
use std::path::Path;
use std::sync::Arc;

/// A bus. Domains with another prefix and another folder know nothing of each other.
#[derive(Clone)]
pub struct Domain {
    pub(crate) backend: Backend,
}

#[derive(Clone)]
pub(crate) enum Backend {
    Shared(Place),
    InProcess(Arc<local::Hub>),
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
        Ok(Self { backend: Backend::Shared(Place::new(prefix, root.as_ref())?) })
    }

    /// A double inside this process, for tests and for machines without shared memory. Its clones are the same bus. Loans
    /// and samples take at most `memory_bytes_max` bytes together.
    pub fn in_process(memory_bytes_max: u64) -> Self {
        Self { backend: Backend::InProcess(local::Hub::new(memory_bytes_max)) }
    }
}

impl fmt::Debug for Domain {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.backend {
            Backend::Shared(place) => place.fmt(f),
            Backend::InProcess(_) => f.write_str("InProcess"),
        }
    }
}
