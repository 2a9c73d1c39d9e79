//! The content of a file that a setting names: kept, so that a setting outlives its file.

use crate::config_file::ConfigFileError;
use crate::failure::Failure;
use crate::setting::Configured;
use input_files::{MAX_CONFIGURATION_BYTES, read_regular_text};
use serde::{Deserialize, Serialize};
use std::error::Error;
use std::path::{Path, PathBuf};

/// A file as it was read.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FileText {
    /// Where it was read.
    pub path: PathBuf,
    /// Its content.
    pub text: String,
}

impl FileText {
    /// Reads a file whose text `parse` understands; `what` names what it configures, for errors.
    ///
    /// # Errors
    /// A file that cannot be read, or whose text `parse` refuses.
    pub fn read<T, E: Error + Send + Sync + 'static>(
        what: &'static str,
        path: &Path,
        parse: impl FnOnce(&str) -> Result<T, E>,
    ) -> Result<(Self, T), ConfigFileError> {
        let file = Self::read_up_to(what, path, MAX_CONFIGURATION_BYTES)?;
        let parsed = file.parse(what, parse)?;
        Ok((file, parsed))
    }

    /// Reads a file of at most `max_bytes`, to be parsed by a daemon: who names a file reads it, with rights and mounts of their own.
    ///
    /// # Errors
    /// A file that cannot be read, or is no text.
    pub fn read_up_to(what: &'static str, path: &Path, max_bytes: u64) -> Result<Self, ConfigFileError> {
        let io = |source| ConfigFileError::Io { what, path: path.to_owned(), source };
        Ok(Self { path: std::path::absolute(path).map_err(io)?, text: read_regular_text(path, max_bytes).map_err(io)? })
    }

    /// What the text says.
    ///
    /// # Errors
    /// `parse` refuses it.
    pub fn parse<T, E: Error + Send + Sync + 'static>(
        &self,
        what: &'static str,
        parse: impl FnOnce(&str) -> Result<T, E>,
    ) -> Result<T, ConfigFileError> {
        let content = |source: E| ConfigFileError::Content { what, path: self.path.clone(), source: source.into() };
        parse(&self.text).map_err(content)
    }

    /// The value of a setting in words: the path of its file, or what is in force without one.
    pub fn words(file: Option<&Self>, without: &str) -> String {
        file.map_or_else(|| without.to_owned(), |file| file.path.display().to_string())
    }

    /// What a key of `site.toml` says that names a file, or names none.
    pub fn configured<T, E: Error + Send + Sync + 'static>(
        what: &'static str,
        path: Option<&Path>,
        parse: impl FnOnce(&str) -> Result<T, E>,
    ) -> Configured<Option<Self>> {
        let read = |path| Self::read(what, path, parse).map(|(file, _)| file);
        Configured { file: path.map(Path::to_owned), value: path.map(read).transpose().map_err(Failure::from) }
    }
}
