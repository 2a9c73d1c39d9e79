//! Locks on files, and the identity of what a path names.

use crate::error::DomainError;
use rustix::fs::{FlockOperation, flock};
use rustix::io::Errno;
use std::fs::{self, File, Metadata};
use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::Path;

/// A lock that the kernel drops however its process dies.
#[derive(Debug)]
pub(crate) struct Lock {
    file: File,
}

/// What a path names, whatever it is called: a file that was deleted and made again is another one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct FileIdentity {
    device: u64,
    inode: u64,
}

impl FileIdentity {
    /// What is there; `None` if nothing is.
    pub(crate) fn at(path: &Path) -> Result<Option<Self>, DomainError> {
        match fs::symlink_metadata(path) {
            Ok(metadata) => Ok(Some(Self::of(&metadata))),
            Err(e) if matches!(e.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory) => Ok(None),
            Err(source) => Err(DomainError::File { path: path.to_owned(), source }),
        }
    }

    fn of(metadata: &Metadata) -> Self {
        Self { device: metadata.dev(), inode: metadata.ino() }
    }
}

impl Lock {
    /// What is locked.
    pub(crate) fn identity(&self) -> io::Result<FileIdentity> {
        Ok(FileIdentity::of(&self.file.metadata()?))
    }

    /// Makes a shared lock exclusive if nobody else holds one; otherwise the shared one may be lost.
    pub(crate) fn make_exclusive(&self) -> bool {
        flock(&self.file, FlockOperation::NonBlockingLockExclusive).is_ok()
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        // Closing is not enough: a process that was forked meanwhile has the file open until it becomes another program.
        let _ = flock(&self.file, FlockOperation::Unlock);
    }
}

/// `None` if others hold the lock and the operation does not wait.
pub(crate) fn try_lock(path: &Path, operation: FlockOperation) -> Result<Option<Lock>, DomainError> {
    let failed = |source| DomainError::File { path: path.to_owned(), source };
    let file = File::options().create(true).append(true).open(path).map_err(failed)?;
    loop {
        match flock(&file, operation) {
            Ok(()) => return Ok(Some(Lock { file })),
            Err(Errno::INTR) => {}
            Err(Errno::WOULDBLOCK) => return Ok(None),
            Err(errno) => return Err(failed(errno.into())),
        }
    }
}
