//! Files of models: how they look on disk without being read, and their bytes.

use daemon::Failure;
use ingest::{MAX_MODEL_BYTES, SourceFile};
use input_files::read_regular_file;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

/// How a file looks without reading it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct FileStamp {
    length: u64,
    modified_ns: u64,
}

/// How files look now; `None` for a file that is not there.
pub(crate) fn stamps_of(models: &[PathBuf]) -> Vec<Option<FileStamp>> {
    models.iter().map(|path| stamp(path)).collect()
}

fn stamp(path: &Path) -> Option<FileStamp> {
    let metadata = std::fs::metadata(path).ok()?;
    let modified = metadata.modified().ok()?.duration_since(UNIX_EPOCH).ok()?;
    Some(FileStamp { length: metadata.len(), modified_ns: u64::try_from(modified.as_nanos()).ok()? })
}

/// The bytes of files.
///
/// # Errors
/// A file that cannot be read, is no regular one or is too large, with its path.
pub(crate) fn read_files(models: &[PathBuf]) -> Result<Vec<SourceFile>, Failure> {
    let read = |path: &PathBuf| -> Result<SourceFile, Failure> {
        let bytes =
            read_regular_file(path, MAX_MODEL_BYTES).map_err(|e| format!("{} cannot be read: {e}", path.display()))?;
        Ok(SourceFile { path: path.clone(), bytes })
    };
    models.iter().map(read).collect()
}

/// Names of files for people.
pub(crate) fn names_of(models: &[PathBuf]) -> String {
    let name = |path: &PathBuf| path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
    models.iter().map(name).collect::<Vec<_>>().join(", ")
}
