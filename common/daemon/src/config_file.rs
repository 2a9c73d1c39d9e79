//! Files of configuration: reading, parsing, and errors that name the file.

use input_files::{MAX_CONFIGURATION_BYTES, read_regular_text};
use std::error::Error;
use std::path::{Path, PathBuf};

/// A configuration file that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum ConfigFileError {
    /// It cannot be read.
    #[error("{what} {} cannot be read", path.display())]
    Io {
        /// What the file configures.
        what: &'static str,
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// Its content cannot be used.
    #[error("{what} {}", path.display())]
    Content {
        /// What the file configures.
        what: &'static str,
        /// The file.
        path: PathBuf,
        /// Why.
        source: Box<dyn Error + Send + Sync>,
    },
}

/// Reads a configuration file; `what` names what it configures, for errors.
///
/// # Errors
/// A file that cannot be read, or whose text `parse` refuses.
pub fn read_parsed<T, E: Error + Send + Sync + 'static>(
    what: &'static str,
    path: &Path,
    parse: impl FnOnce(&str) -> Result<T, E>,
) -> Result<T, ConfigFileError> {
    let text = read_regular_text(path, MAX_CONFIGURATION_BYTES).map_err(|source| ConfigFileError::Io {
        what,
        path: path.to_owned(),
        source,
    })?;
    parse(&text).map_err(|source| ConfigFileError::Content { what, path: path.to_owned(), source: source.into() })
}
