//! A schedule file with its identity.

use schedule_files::{PlanFile, PlanFileError, ReadOptions};
use sha2::{Digest, Sha256};

/// Bytes of the largest schedule file or table of links.
pub const MAX_SCHEDULE_FILE_BYTES: u64 = 512 << 20;

/// A schedule file that was read.
#[derive(Debug, Clone, PartialEq)]
pub struct ScheduleFile {
    /// Base name of the file.
    pub file: String,
    /// sha256 of its bytes.
    pub sha256: [u8; 32],
    /// What it holds.
    pub plan: PlanFile,
}

/// A schedule file that cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("schedule file {file} cannot be read")]
pub struct ScheduleFileError {
    /// Base name of the file.
    pub file: String,
    /// Why.
    pub source: PlanFileError,
}

impl ScheduleFile {
    /// Reads MS Project XML, XER, P6 XML, CSV or XLSX.
    ///
    /// # Errors
    /// Another format, or a file that is damaged.
    pub fn read(file: &str, bytes: &[u8], options: &ReadOptions) -> Result<Self, ScheduleFileError> {
        let plan = schedule_files::read(file, bytes, options)
            .map_err(|source| ScheduleFileError { file: file.to_owned(), source })?;
        Ok(Self { file: file.to_owned(), sha256: Sha256::digest(bytes).into(), plan })
    }
}
