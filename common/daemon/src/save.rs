//! A change of one file of the state folder that is decided, and not written yet.

use crate::kept_file::KeptFile;
use crate::replaced_file::write_durably;
use crate::state::{StateError, StateFile};
use serde::Serialize;
use std::fmt;
use std::io;
use std::path::PathBuf;
use std::sync::Arc;

/// What a file of the state folder is to hold; whoever commits a decision writes it.
#[derive(Debug, Clone)]
#[must_use = "nothing is on disk before it is written"]
pub struct Save(Change);

#[derive(Clone)]
enum Change {
    /// The file is to hold this; without content it is to be removed. The last says whether it can be made anew: where it is damaged
    /// there is nothing to go back to.
    Kept(KeptFile, Option<Vec<u8>>, bool),
    /// A file that can be made anew, and says itself of what it is.
    Derived(PathBuf, Arc<dyn AsRef<[u8]> + Send + Sync>),
}

impl fmt::Debug for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Kept(file, Some(content), _) => write!(f, "{} ({} bytes)", file.path().display(), content.len()),
            Self::Kept(file, None, _) => write!(f, "{} (removed)", file.path().display()),
            Self::Derived(path, _) => write!(f, "{}", path.display()),
        }
    }
}

impl Save {
    /// A file that can be made anew, and says itself of what it is, is to hold this. There is no way back to what it holds.
    pub fn derived(path: PathBuf, content: Arc<dyn AsRef<[u8]> + Send + Sync>) -> Self {
        Self(Change::Derived(path, content))
    }

    /// Writes it: when this returns it is on disk.
    ///
    /// # Errors
    /// The file system refuses; what was saved before stays.
    pub fn write(&self) -> Result<(), StateError> {
        let written = match &self.0 {
            Change::Kept(file, Some(content), _) => file.save(content),
            Change::Kept(file, None, _) => file.remove(),
            Change::Derived(path, content) => write_durably(path, (**content).as_ref()),
        };
        written.map_err(|source| self.failed(source))
    }

    /// The change that goes back to what is there now; none from a derived file ([`Self::derived`]).
    ///
    /// # Errors
    /// A file that cannot be read, or is damaged.
    pub fn way_back(&self) -> Result<Option<Self>, StateError> {
        let Change::Kept(file, _, can_be_made_anew) = &self.0 else { return Ok(None) };
        let content = match file.look() {
            Ok(found) => found.content,
            Err(why) if *can_be_made_anew && why.kind() == io::ErrorKind::InvalidData => None,
            Err(why) => return Err(self.failed(why)),
        };
        Ok(Some(Self(Change::Kept(file.clone(), content, *can_be_made_anew))))
    }

    fn failed(&self, source: io::Error) -> StateError {
        let path = match &self.0 {
            Change::Kept(file, ..) => file.path(),
            Change::Derived(path, _) => path.clone(),
        };
        StateError::Io { path, source }
    }
}

impl KeptFile {
    /// This content, to be saved.
    pub fn saving(&self, content: Vec<u8>) -> Save {
        Save(Change::Kept(self.clone(), Some(content), false))
    }

    /// The same for a file that can be made anew: what is damaged is replaced.
    pub fn saving_anew(&self, content: Vec<u8>) -> Save {
        Save(Change::Kept(self.clone(), Some(content), true))
    }

    /// Its removal, to be done.
    pub fn removing(&self) -> Save {
        Save(Change::Kept(self.clone(), None, false))
    }
}

impl StateFile {
    /// This state, to be saved.
    ///
    /// # Errors
    /// State that has no JSON, such as a path that is no UTF-8.
    pub fn saving<T: Serialize>(&self, state: &T) -> Result<Save, StateError> {
        let bytes = serde_json::to_vec(state).map_err(|source| self.damaged(source))?;
        Ok(self.file.saving(bytes))
    }
}
