//! Tables of progress and deviations with where they come from, of files or of the running site.

use super::compared::ComparedStorey;
use crate::failure::Failure;
use crate::input_document::read_document;
use as_built::{FileEntry, sha256_hex};
use daemon::read_progress;
use frames::PlanTime;
use schedule::Actual;
use std::path::Path;

/// Everything that may be written.
#[derive(Default)]
pub(super) struct Gathered {
    /// Files and tables.
    pub(super) sources: Vec<FileEntry>,
    /// Rows of progress, those that rank first last.
    pub(super) rows: Vec<Row>,
    /// What a robot saw, with its source.
    pub(super) deviations: Option<(ComparedStorey, usize)>,
    /// True if rows may name what the model does not have any more.
    pub(super) is_of_running_site: bool,
}

/// A row of progress.
pub(super) struct Row {
    pub(super) actual: Actual,
    /// Place of its table in the sources.
    pub(super) source: usize,
    pub(super) observer: String,
    /// When it was confirmed, of an absent element.
    pub(super) at: Option<PlanTime>,
}

impl Gathered {
    /// Adds a source; its place.
    pub(super) fn add_source(&mut self, file: &str, bytes: &[u8]) -> usize {
        self.sources.push(FileEntry { file: file.to_owned(), sha256: sha256_hex(bytes) });
        self.sources.len() - 1
    }

    /// Adds a table of reported progress that was read.
    ///
    /// # Errors
    /// It cannot be read again.
    pub(super) fn add_reports(&mut self, path: &Path, actuals: Vec<Actual>) -> Result<(), Failure> {
        let failed = |error| Failure::usage(format!("{}: {error}", path.display()));
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let source = self.add_source(&name, &read_progress(path).map_err(failed)?);
        let row = |actual| Row { actual, source, observer: format!("reported in {name}"), at: None };
        self.rows.extend(actuals.into_iter().map(row));
        Ok(())
    }

    /// Adds deviations.
    ///
    /// # Errors
    /// A file that cannot be read, or is another document.
    pub(super) fn add_deviations(&mut self, path: &Path) -> Result<(), Failure> {
        let failed = |error: String| Failure::usage(format!("{}: {error}", path.display()));
        let bytes = read_document(path).map_err(|error| failed(error.to_string()))?;
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        self.add_compared(&name, &bytes).map_err(failed)
    }

    /// Adds the document of deviations.
    ///
    /// # Errors
    /// What is wrong with it.
    pub(super) fn add_compared(&mut self, name: &str, bytes: &[u8]) -> Result<(), String> {
        let storey = serde_json::from_slice(bytes)
            .map_err(|error| format!("it is no deviations.json of `groundplan deviations`: {error}"))?;
        let source = self.add_source(name, bytes);
        self.deviations = Some((storey, source));
        Ok(())
    }
}
