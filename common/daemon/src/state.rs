//! Persistent state of a daemon: JSON files and sample epochs, written durably.

use crate::replaced_file::write_durably;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// State that cannot be read or written.
#[derive(Debug, thiserror::Error)]
pub enum StateError {
    /// The file system refuses.
    #[error("state {} cannot be read or written", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The file holds something else.
    #[error("state {} is damaged: remove it to start anew", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// Why.
        source: serde_json::Error,
    },
}

/// A JSON file that is replaced whole: what was saved is there after a power cut, and never half.
#[derive(Debug)]
pub struct StateFile {
    path: PathBuf,
}

impl StateFile {
    /// The file of this name in the state folder, which is made if it is missing.
    ///
    /// # Errors
    /// The folder cannot be made.
    pub fn at(folder: &Path, name: &str) -> Result<Self, StateError> {
        fs::create_dir_all(folder).map_err(|source| StateError::Io { path: folder.to_owned(), source })?;
        Ok(Self::of(folder, name))
    }

    /// The same, to be read only: nothing is made.
    pub(crate) fn of(folder: &Path, name: &str) -> Self {
        Self { path: folder.join(name) }
    }

    /// What was saved last; `None` if nothing was.
    ///
    /// # Errors
    /// A file that cannot be read, or holds something else.
    pub fn load<T: DeserializeOwned>(&self) -> Result<Option<T>, StateError> {
        let path = || self.path.clone();
        match fs::read(&self.path) {
            Ok(bytes) => {
                let parsed = serde_json::from_slice(&bytes);
                parsed.map(Some).map_err(|source| StateError::Damaged { path: path(), source })
            }
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(source) => Err(StateError::Io { path: path(), source }),
        }
    }

    /// Removes the file, if it is there.
    ///
    /// # Errors
    /// The file system refuses.
    pub fn remove(&self) -> Result<(), StateError> {
        match fs::remove_file(&self.path) {
            Err(source) if source.kind() != io::ErrorKind::NotFound => {
                Err(StateError::Io { path: self.path.clone(), source })
            }
            _ => Ok(()),
        }
    }

    /// Saves; when this returns it is on disk.
    ///
    /// # Errors
    /// The file system refuses; what was saved before stays.
    pub fn save<T: Serialize>(&self, state: &T) -> Result<(), StateError> {
        let path = || self.path.clone();
        let bytes = serde_json::to_vec(state).map_err(|source| StateError::Damaged { path: path(), source })?;
        write_durably(&self.path, &bytes).map_err(|source| StateError::Io { path: path(), source })
    }
}

/// Epochs of a daemon. They never fall, also across crashes: they are reserved on disk before they are used.
#[derive(Debug)]
pub struct Epochs {
    file: StateFile,
    next: u64,
    reserved: u64,
}

/// Epochs reserved at a time: a crash loses at most so many.
const BLOCK: u64 = 1_024;

impl Epochs {
    /// The numbers of a daemon, from its file in the state folder.
    ///
    /// # Errors
    /// A file that cannot be read, or holds something else.
    pub fn at(folder: &Path, name: &str) -> Result<Self, StateError> {
        let file = StateFile::at(folder, name)?;
        let next = file.load::<u64>()?.unwrap_or(1);
        Ok(Self { file, next, reserved: next })
    }

    /// All numbers that were ever taken are below this one.
    pub fn reserved(&self) -> u64 {
        self.reserved
    }

    /// The next number.
    ///
    /// # Errors
    /// It cannot be reserved on disk.
    pub fn take(&mut self) -> Result<u64, StateError> {
        if self.next == self.reserved {
            self.file.save(&(self.reserved + BLOCK))?;
            self.reserved += BLOCK;
        }
        self.next += 1;
        Ok(self.next - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn epochs_never_fall() {
        let home = tempfile::tempdir().unwrap();
        let mut last = 0;
        for _ in 0..3 {
            // A new process each time.
            let mut epochs = Epochs::at(home.path(), "epochs.json").unwrap();
            for _ in 0..1_500 {
                let epoch = epochs.take().unwrap();
                assert!(last < epoch);
                last = epoch;
            }
        }
    }

    #[test]
    fn damaged_state_is_an_error_and_not_taken_for_none() {
        let home = tempfile::tempdir().unwrap();
        let file = StateFile::at(home.path(), "state.json").unwrap();
        assert!(file.load::<u64>().unwrap().is_none());
        file.save(&7u64).unwrap();
        assert_eq!(file.load::<u64>().unwrap(), Some(7));
        std::fs::write(home.path().join("state.json"), "{").unwrap();
        assert!(matches!(file.load::<u64>(), Err(StateError::Damaged { .. })));
    }
}
