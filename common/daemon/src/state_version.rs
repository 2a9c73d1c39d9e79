//! The version of groundplan that last wrote a state folder: versions that cannot read it do not touch it.
//!
//! The layout of a state folder has the number of the first part of the version, and starts at 1: state of 1.x is read by every
//! later 1.x. An earlier version, or one of another layout, refuses it and leaves it as it is.

use crate::replaced_file::{remove_left_files, write_durably};
use crate::state::StateError;
use crate::state_files::VERSION;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// The version of this program.
const OWN: &str = env!("CARGO_PKG_VERSION");

/// A state folder that this version must not write.
#[derive(Debug, thiserror::Error)]
pub enum StateVersionError {
    /// A later version has written it.
    #[error(
        "the state in {} was written by version {found}, which version {OWN} cannot read: install version {found}, or \
         choose another state folder",
        folder.display()
    )]
    Newer {
        /// The state folder.
        folder: PathBuf,
        /// The version.
        found: String,
    },
    /// A version with another layout of the state has written it.
    #[error(
        "the state in {} was written by version {found}, and has another layout than that of version {OWN}: choose another state folder, \
         or move this one away to start anew",
        folder.display()
    )]
    OtherLayout {
        /// The state folder.
        folder: PathBuf,
        /// The version.
        found: String,
    },
    /// The file cannot be read or written.
    #[error(transparent)]
    State(#[from] StateError),
}

/// Marks the state folder as one of this version, which reads the state of every earlier one with the same layout. The file
/// `version` in it is also read by the package, which refuses to go back.
///
/// # Errors
/// State of a later version or of another layout, a folder that cannot be written.
pub fn claim_state(folder: &Path) -> Result<(), StateVersionError> {
    claim(folder, OWN)
}

fn claim(folder: &Path, own: &str) -> Result<(), StateVersionError> {
    let path = folder.join(VERSION);
    let failed = |source| StateError::Io { path: path.clone(), source };
    let found = match fs::read_to_string(&path) {
        Ok(text) => text.trim().to_owned(),
        Err(error) if error.kind() == io::ErrorKind::NotFound => String::new(),
        Err(error) => return Err(failed(error).into()),
    };
    remove_left_files(folder);
    if found == own {
        return Ok(());
    }
    if numbers(own) < numbers(&found) {
        return Err(StateVersionError::Newer { folder: folder.to_owned(), found });
    }
    if !found.is_empty() && numbers(own).first() != numbers(&found).first() {
        return Err(StateVersionError::OtherLayout { folder: folder.to_owned(), found });
    }
    fs::create_dir_all(folder).map_err(failed)?;
    // Daemons start at the same time: the last one stays.
    Ok(write_durably(&path, format!("{own}\n").as_bytes()).map_err(failed)?)
}

/// The numbers of a version, which are compared one after the other; what is no number counts as 0. A pre-release has the state
/// of its release.
fn numbers(version: &str) -> Vec<u64> {
    let release = version.split(['-', '+', '~']).next().unwrap_or_default();
    release.split('.').map(|part| part.parse().unwrap_or(0)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn state_goes_on_to_later_versions_and_not_back() {
        let home = tempfile::tempdir().unwrap();
        let folder = home.path().join("state");
        claim(&folder, "0.2.0").unwrap();
        claim(&folder, "0.2.0").unwrap();
        claim(&folder, "0.10.0-rc.1").unwrap();
        claim(&folder, "0.10.0").unwrap();
        let refused = claim(&folder, "0.9.3").unwrap_err().to_string();
        assert!(refused.contains("written by version 0.10.0, which version"), "{refused}");
        let refused = claim(&folder, "1.0.0").unwrap_err().to_string();
        assert!(refused.contains("by version 0.10.0, and has another layout"), "{refused}");
        assert_eq!(fs::read_to_string(folder.join("version")).unwrap(), "0.10.0\n");
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 1, "nothing stays beside it");
    }
}
