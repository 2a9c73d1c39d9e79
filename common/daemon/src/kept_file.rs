//! Files of the state folder that are kept twice and recorded: damage and removal of them are told, and mended where one is intact.
//!
//! The record of a file is an empty one of the same name in the folder `kept` of the state folder. Where it is there and the file is
//! not, in neither form, somebody has removed what was saved.

use crate::replaced_file::folder_of;
use crate::sealed_file::{Sealed, read_sealed, remove_sealed, sealed_path, write_sealed};
use crate::state_files::RECORDS;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use tracing::warn;

/// A file of the state folder.
#[derive(Debug, Clone)]
pub struct KeptFile {
    state: PathBuf,
    name: PathBuf,
    finding: OnceLock<String>,
}

/// What is there of a file.
pub(crate) struct Found {
    /// What was saved last; `None` if nothing was, or it was removed.
    pub(crate) content: Option<Vec<u8>>,
    /// A sentence about what was damaged or removed.
    pub(crate) finding: Option<String>,
    /// True if both files are as they were saved.
    is_intact: bool,
}

impl KeptFile {
    /// The file of this name, which may lie in a folder, in the state folder; nothing is made.
    pub fn at(state: &Path, name: impl Into<PathBuf>) -> Self {
        Self { state: state.to_owned(), name: name.into(), finding: OnceLock::new() }
    }

    /// Its path.
    pub fn path(&self) -> PathBuf {
        self.state.join(&self.name)
    }

    /// What was saved last; `None` if nothing was, or it was removed. A file that was damaged or removed is mended, and that is logged.
    ///
    /// # Errors
    /// Both files are damaged ([`io::ErrorKind::InvalidData`]), or the file system refuses.
    pub fn load(&self) -> io::Result<Option<Vec<u8>>> {
        let found = self.look();
        if found.as_ref().is_err_and(|error| error.kind() == io::ErrorKind::InvalidData) {
            self.forget()?;
        }
        let Found { content, finding, is_intact } = found?;
        if let Some(finding) = finding {
            let path = self.path();
            warn!(path = %path.display(), finding, "state was damaged or removed");
            // That of the first time stays: what is told does not change while the process runs.
            let _ = self.finding.set(finding);
        }
        match &content {
            Some(content) if !is_intact => write_sealed(&self.path(), content)?,
            Some(_) => {}
            // It is told once.
            None => self.forget()?,
        }
        if content.is_some() {
            self.record()?;
        }
        Ok(content)
    }

    /// The same, without mending anything.
    ///
    /// # Errors
    /// As [`Self::load`].
    pub(crate) fn look(&self) -> io::Result<Found> {
        let path = self.path();
        let found = |content, finding, is_intact| Ok(Found { content, finding, is_intact });
        match read_sealed(&path)? {
            Sealed::Nothing if self.record_path().exists() => {
                let (name, sealed) = (path.display(), sealed_path(&path));
                let finding = format!("state {name} was removed, and {} too: what was saved is lost", sealed.display());
                found(None, Some(finding), false)
            }
            Sealed::Nothing => found(None, None, true),
            Sealed::Intact(content) => found(Some(content), None, true),
            Sealed::Unfinished(content) | Sealed::Unsealed(content) => found(Some(content), None, false),
            Sealed::Mended(content, finding) => found(Some(content), Some(finding), false),
            Sealed::Damaged(why) => Err(io::Error::new(io::ErrorKind::InvalidData, why)),
        }
    }

    /// What an operator should know of the file as it was loaded.
    pub fn finding(&self) -> Option<&str> {
        self.finding.get().map(String::as_str)
    }

    /// Saves; when this returns it is on disk. The folder must be there.
    ///
    /// # Errors
    /// The file system refuses.
    pub fn save(&self, content: &[u8]) -> io::Result<()> {
        write_sealed(&self.path(), content)?;
        // The last step: a death before it is no removal.
        self.record()
    }

    /// Removes it, if it is there.
    ///
    /// # Errors
    /// The file system refuses.
    pub fn remove(&self) -> io::Result<()> {
        self.forget()?;
        remove_sealed(&self.path())
    }

    fn record(&self) -> io::Result<()> {
        let path = self.record_path();
        if path.exists() {
            return Ok(());
        }
        let folder = folder_of(&path);
        fs::create_dir_all(folder)?;
        File::create(&path)?;
        File::open(folder)?.sync_all()
    }

    /// Its loss is told: whoever removes it from here on does what that asks for.
    pub(crate) fn forget(&self) -> io::Result<()> {
        match fs::remove_file(self.record_path()) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
            _ => Ok(()),
        }
    }

    fn record_path(&self) -> PathBuf {
        records(&self.state).join(&self.name)
    }
}

/// The folder of records in a state folder.
pub(crate) fn records(state: &Path) -> PathBuf {
    state.join(RECORDS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_is_removed_in_both_forms_is_told_once_and_one_that_was_never_there_is_not() {
        let state = tempfile::tempdir().unwrap();
        fs::create_dir(state.path().join("settings")).unwrap();
        let file = || KeptFile::at(state.path(), "settings/robot.json");
        assert_eq!((file().load().unwrap(), file().finding()), (None, None));
        file().save(b"legged").unwrap();
        for path in [file().path(), sealed_path(&file().path())] {
            fs::remove_file(path).unwrap();
        }
        let removed = file();
        assert!(removed.look().unwrap().finding.is_some(), "to look at it changes nothing");
        assert_eq!(removed.load().unwrap(), None);
        let finding = removed.finding().unwrap();
        assert!(finding.contains("robot.json was removed") && finding.ends_with("is lost"), "{finding}");
        let again = file();
        assert_eq!((again.load().unwrap(), again.finding()), (None, None));
        again.save(b"wheeled").unwrap();
        again.remove().unwrap();
        let last = file();
        assert_eq!((last.load().unwrap(), last.finding()), (None, None), "the daemon has removed it itself");
    }

    #[test]
    fn a_damaged_file_may_be_removed_as_its_error_says() {
        let state = tempfile::tempdir().unwrap();
        let file = || KeptFile::at(state.path(), "frame.json");
        file().save(b"{}").unwrap();
        for path in [file().path(), sealed_path(&file().path())] {
            fs::write(path, "{").unwrap();
        }
        assert_eq!(file().load().unwrap_err().kind(), io::ErrorKind::InvalidData);
        remove_sealed(&file().path()).unwrap();
        let last = file();
        assert_eq!((last.load().unwrap(), last.finding()), (None, None));
    }

    #[test]
    fn a_file_that_was_put_there_is_recorded_when_it_is_loaded() {
        let state = tempfile::tempdir().unwrap();
        let file = || KeptFile::at(state.path(), "date.json");
        fs::write(file().path(), "old").unwrap();
        assert_eq!(file().load().unwrap().unwrap(), b"old");
        remove_sealed(&file().path()).unwrap();
        let removed = file();
        assert!(removed.load().unwrap().is_none() && removed.finding().is_some());
    }
}
