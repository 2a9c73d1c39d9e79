//! Persistent state of a daemon: JSON files and sample epochs, written durably.

use crate::failure::chain;
use crate::kept_file::KeptFile;
use crate::replaced_file::folder_of;
use crate::sealed_file::sealed_path;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};
use tracing::warn;

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
    #[error(
        "state {} is damaged or has another layout: remove it and {} to start anew",
        path.display(),
        sealed_path(path).display()
    )]
    Damaged {
        /// The file.
        path: PathBuf,
        /// Why.
        source: serde_json::Error,
    },
}

/// A JSON file that is replaced whole: what was saved is there after a power cut, and never half.
///
/// It is kept twice, as it is and sealed with its hash: what is damaged, or removed as it is, is mended from the sealed one. That both
/// were removed is told. A file without the sealed one, as of a backup, counts as it is.
#[derive(Debug, Clone)]
pub struct StateFile {
    pub(crate) file: KeptFile,
    is_read_only: bool,
}

impl StateFile {
    /// The file of this name in the state folder, or in a folder of it, which is made if it is missing.
    ///
    /// # Errors
    /// The folder cannot be made.
    pub fn at(state: &Path, name: &str) -> Result<Self, StateError> {
        let file = KeptFile::at(state, name);
        let path = file.path();
        let folder = folder_of(&path);
        fs::create_dir_all(folder).map_err(|source| StateError::Io { path: folder.to_owned(), source })?;
        Ok(Self { file, is_read_only: false })
    }

    /// The same, to be read only: nothing is made or mended.
    pub(crate) fn of(state: &Path, name: &str) -> Self {
        Self { file: KeptFile::at(state, name), is_read_only: true }
    }

    /// What an operator should know of the file as it was loaded: that it was damaged, or removed.
    pub fn finding(&self) -> Option<&str> {
        self.file.finding()
    }

    /// What was saved last; `None` if nothing was, or it was removed. A file that was damaged or removed is mended, and that is logged.
    ///
    /// # Errors
    /// A file that cannot be read, or holds something else.
    pub fn load<T: DeserializeOwned>(&self) -> Result<Option<T>, StateError> {
        self.load_and_tell().map(|(state, _)| state)
    }

    /// As [`Self::load`], for state that can be made anew: where it is damaged there is none, and that is logged.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn load_unless_damaged<T: DeserializeOwned>(&self) -> Result<Option<T>, StateError> {
        match self.load() {
            Err(why @ StateError::Damaged { .. }) => {
                let (path, error) = (self.file.path(), chain(&why));
                warn!(path = %path.display(), error, "state is damaged and is made anew");
                Ok(None)
            }
            loaded => loaded,
        }
    }

    /// As [`Self::load`], with a sentence about a file that was mended or removed.
    ///
    /// # Errors
    /// A file that cannot be read, or holds something else.
    pub(crate) fn load_and_tell<T: DeserializeOwned>(&self) -> Result<(Option<T>, Option<String>), StateError> {
        let failed = |source: io::Error| match source.kind() {
            io::ErrorKind::InvalidData => self.damaged(<serde_json::Error as serde::de::Error>::custom(source)),
            _ => self.failed(source),
        };
        // What holds something else is not mended, and its loss is told: who removes it then does what the error asks for.
        let looked = self.file.look().map_err(failed).and_then(|found| {
            let state = found.content.as_deref().map(serde_json::from_slice).transpose();
            Ok((state.map_err(|source| self.damaged(source))?, found.finding))
        });
        if !self.is_read_only {
            match &looked {
                Ok(_) => drop(self.file.load().map_err(failed)?),
                Err(_) => self.file.forget().map_err(|source| self.failed(source))?,
            }
        }
        looked
    }

    /// Removes the file, if it is there.
    ///
    /// # Errors
    /// The file system refuses.
    pub fn remove(&self) -> Result<(), StateError> {
        self.file.remove().map_err(|source| self.failed(source))
    }

    /// Saves; when this returns it is on disk.
    ///
    /// # Errors
    /// The file system refuses; what was saved before stays.
    pub fn save<T: Serialize>(&self, state: &T) -> Result<(), StateError> {
        let bytes = serde_json::to_vec(state).map_err(|source| self.damaged(source))?;
        self.file.save(&bytes).map_err(|source| self.failed(source))
    }

    pub(crate) fn damaged(&self, source: serde_json::Error) -> StateError {
        StateError::Damaged { path: self.file.path(), source }
    }

    fn failed(&self, source: io::Error) -> StateError {
        StateError::Io { path: self.file.path(), source }
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
    /// The numbers of a daemon, from its file in the state folder. Where that is damaged or was removed they go on above all that can
    /// have been taken: at the microseconds since 1970, of which no daemon takes one each.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn at(state: &Path, name: &str) -> Result<Self, StateError> {
        let file = StateFile::at(state, name)?;
        let (kept, why) = match file.load_and_tell::<u64>() {
            Ok(found) => found,
            Err(why @ StateError::Damaged { .. }) => (None, Some(chain(&why))),
            Err(why) => return Err(why),
        };
        let next = match (kept, why) {
            (Some(next), _) => next,
            (None, None) => 1,
            (None, Some(error)) => {
                let next = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_micros());
                let next = u64::try_from(next).unwrap_or(u64::MAX / 2);
                let path = file.file.path();
                warn!(path = %path.display(), error, next, "epochs are lost and go on above all earlier ones");
                next
            }
        };
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
        fs::write(home.path().join("state.json"), "8").unwrap();
        assert_eq!(file.load::<u64>().unwrap(), Some(7), "the sealed one counts");
        assert_eq!(fs::read_to_string(home.path().join("state.json")).unwrap(), "7", "it is mended");
        for name in ["state.json", "state.json.sealed"] {
            fs::write(home.path().join(name), "8").unwrap();
        }
        assert!(matches!(file.load::<u64>(), Err(StateError::Damaged { .. })));
        assert!(file.load_unless_damaged::<u64>().unwrap().is_none());
        file.remove().unwrap();
        let file = StateFile::at(home.path(), "state.json").unwrap();
        assert!(file.load::<u64>().unwrap().is_none() && file.finding().is_none());
    }

    #[test]
    fn epochs_never_fall_where_their_files_are_truncated_or_removed() {
        let home = tempfile::tempdir().unwrap();
        let take = || Epochs::at(home.path(), "epochs.json").unwrap().take().unwrap();
        let (path, sealed) = (home.path().join("epochs.json"), home.path().join("epochs.json.sealed"));
        let mut last = take();
        let mut rises = || {
            let epoch = take();
            assert!(last < epoch, "{last} {epoch}");
            last = epoch;
        };
        rises();
        fs::write(&path, "1").unwrap();
        rises();
        fs::write(&path, "").unwrap();
        rises();
        fs::remove_file(&path).unwrap();
        rises();
        fs::remove_file(&sealed).unwrap();
        rises();
        fs::write(&path, "1").unwrap();
        fs::write(&sealed, "sha256").unwrap();
        rises();
        fs::remove_file(&path).unwrap();
        fs::remove_file(&sealed).unwrap();
        rises();
    }

    #[test]
    fn state_of_a_backup_is_taken_over() {
        let home = tempfile::tempdir().unwrap();
        fs::write(home.path().join("state.json"), "7").unwrap();
        let file = StateFile::at(home.path(), "state.json").unwrap();
        assert_eq!(file.load::<u64>().unwrap(), Some(7));
        fs::write(home.path().join("state.json"), "5").unwrap();
        assert_eq!(file.load::<u64>().unwrap(), Some(7), "it has a hash from then on");
    }
}
