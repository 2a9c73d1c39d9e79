//! Files of models: found whole on disk, and named for people.

use daemon::{FileStamp, WholeFiles};
use ingest::SourceFile;
use std::path::PathBuf;

/// Files of models that were found whole.
pub(crate) struct ModelFiles {
    pub(crate) models: Vec<PathBuf>,
    /// What they looked like when they were read.
    pub(crate) stamps: Vec<Option<FileStamp>>,
    pub(crate) sources: Vec<SourceFile>,
}

impl ModelFiles {
    pub(crate) fn of(models: Vec<PathBuf>, whole: WholeFiles) -> Self {
        let source = |(path, bytes): (&PathBuf, Vec<u8>)| SourceFile { path: path.clone(), bytes };
        let sources = models.iter().zip(whole.contents).map(source).collect();
        Self { stamps: whole.stamps, sources, models }
    }
}

/// Names of files for people.
pub(crate) fn names_of(models: &[PathBuf]) -> String {
    let name = |path: &PathBuf| path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
    models.iter().map(name).collect::<Vec<_>>().join(", ")
}
