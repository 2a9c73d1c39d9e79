//! Inputs of the evaluation of a schedule beside the site: rules and tables of progress. `schedule-eval`, the page and the client
//! read them here, so that they evaluate alike.

use crate::config::SiteConfig;
use crate::config_file::ConfigFileError;
use crate::failure::{Failure, joined};
use crate::file_text::FileText;
use crate::kept_file::KeptFile;
use crate::observed_tables::{ObservedTables, observed_tables_file};
use crate::reported_progress::{ReportedProgress, mended};
use crate::save::Save;
use crate::sealed_file::sealed_content;
use crate::setting::{SettingKey, would_be_in_force};
use crate::state_files::OBSERVED;
use input_files::read_regular_file;
use std::error::Error;
use std::io;
use std::path::{Path, PathBuf};

/// Bytes of the largest table of progress.
pub const MAX_TABLE_BYTES: u64 = 16 << 20;

/// The rules that are in force once the configuration was read: those of the file that it names, with their earlier content
/// where the file cannot be used any more, or the default ones.
///
/// # Errors
/// A file that cannot be read, or whose text `parse` refuses.
pub fn rules_in_force<R: Default, E: Error + Send + Sync + 'static>(
    config: &SiteConfig,
    parse: impl Fn(&str) -> Result<R, E>,
) -> Result<R, Failure> {
    let configured = FileText::configured("rules", config.schedule.rules.as_deref(), &parse);
    let kept = would_be_in_force(&config.site_state, SettingKey::Rules, configured)?;
    kept.value().as_ref().map_or_else(|| Ok(R::default()), |file| Ok(file.parse("rules", &parse)?))
}

/// A table of observed progress, to be saved.
pub fn saving_observed(state: &Path, table: Vec<u8>) -> Save {
    KeptFile::at(state, OBSERVED).saving(table)
}

/// Mends tables of progress that were damaged or removed, reported and observed; for the daemon that writes them, at its start. The
/// answer is what an operator should know.
///
/// # Errors
/// The file system refuses.
pub fn mend_progress(config: &SiteConfig) -> io::Result<Option<String>> {
    let state = &config.site_state;
    let observed = match config.observers().is_empty() {
        true => KeptFile::at(state, OBSERVED),
        false => observed_tables_file(state),
    };
    Ok(joined([ReportedProgress::at(state).mend()?, mended(&observed)?].into_iter().flatten()))
}

/// Bytes of a table of progress.
///
/// # Errors
/// A file that cannot be read, or is larger than any table.
pub fn read_progress(path: &Path) -> io::Result<Vec<u8>> {
    read_regular_file(path, MAX_TABLE_BYTES)
}

/// Progress that is in force, of both sources, as `parse` reads a table; of robots with names that of all of them.
///
/// # Errors
/// A table that cannot be read or parsed, with its name.
pub fn progress_in_force<A, E: Error + Send + Sync + 'static>(
    config: &SiteConfig,
    parse: impl Fn(&[u8]) -> Result<Vec<A>, E>,
) -> Result<[Vec<A>; 2], ConfigFileError> {
    let state = &config.site_state;
    let read = |path: PathBuf| {
        let bytes = match sealed_content(&path) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
            Err(source) => return Err(ConfigFileError::Io { what: "progress", path, source }),
        };
        parse(&bytes).map_err(|source| ConfigFileError::Content { what: "progress", path, source: source.into() })
    };
    let failed = |source| ConfigFileError::Io { what: "progress", path: state.clone(), source };
    let [reported, _] = ReportedProgress::at(state).tables().map_err(failed)?;
    let reported = reported.map_or_else(|| Ok(Vec::new()), read)?;
    let observers = config.observers();
    if observers.is_empty() {
        return Ok([reported, read(state.join(OBSERVED))?]);
    }
    let (what, path) = ("observed progress", observed_tables_file(state).path());
    let tables = ObservedTables::load(state, &observers);
    let tables = tables.map_err(|source| ConfigFileError::Io { what, path: path.clone(), source })?;
    let observed = parse(&tables.in_force());
    let observed = observed.map_err(|source| ConfigFileError::Content { what, path, source: source.into() })?;
    Ok([reported, observed])
}
