//! What the schedule of a site is evaluated with beside the site: rules and tables of progress. Whoever evaluates it reads them
//! here, so that all daemons evaluate alike.

use crate::config::SiteConfig;
use crate::config_file::{ConfigFileError, read_parsed};
use crate::requests::ActualsSource;
use std::error::Error;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

/// Bytes of the largest table of progress.
const MAX_TABLE_BYTES: u64 = 16 << 20;

/// The rules in force: those that the configuration names, or the default ones.
///
/// # Errors
/// A file that cannot be read, or whose text `parse` refuses.
pub fn rules_in_force<R: Default, E: Error + Send + Sync + 'static>(
    config: &SiteConfig,
    parse: impl FnOnce(&str) -> Result<R, E>,
) -> Result<R, ConfigFileError> {
    let Some(path) = &config.schedule.rules else { return Ok(R::default()) };
    read_parsed("rules", path, parse)
}

/// The table of progress of a source, in the state folder of a site; a table that is not there is empty.
pub fn progress_table(state: &Path, source: ActualsSource) -> PathBuf {
    state.join(match source {
        ActualsSource::Reported => "actuals.csv",
        ActualsSource::Observed => "observed.csv",
    })
}

/// Bytes of a table of progress.
///
/// # Errors
/// A file that cannot be read, or is larger than any table.
pub fn read_progress(path: &Path) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    std::fs::File::open(path)?.take(MAX_TABLE_BYTES + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > MAX_TABLE_BYTES {
        return Err(io::Error::other(format!("it has more than {MAX_TABLE_BYTES} bytes")));
    }
    Ok(bytes)
}

/// Progress that is in force, of both sources, as `parse` reads a table.
///
/// # Errors
/// A table that cannot be read or parsed, with its name.
pub fn progress_in_force<A, E: Error + Send + Sync + 'static>(
    state: &Path,
    parse: impl Fn(&[u8]) -> Result<Vec<A>, E>,
) -> Result<[Vec<A>; 2], ConfigFileError> {
    let read = |source| {
        let path = progress_table(state, source);
        let bytes = match read_progress(&path) {
            // Earlier versions wrote no columns where nothing was reported.
            Ok(bytes) if bytes.is_empty() => return Ok(Vec::new()),
            Ok(bytes) => bytes,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
            Err(source) => return Err(ConfigFileError::Io { what: "progress", path, source }),
        };
        parse(&bytes).map_err(|source| ConfigFileError::Content { what: "progress", path, source: source.into() })
    };
    Ok([read(ActualsSource::Reported)?, read(ActualsSource::Observed)?])
}
