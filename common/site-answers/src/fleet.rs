//! The robots of a site, as its server knows them.

use bus::Daemon;
use daemon::{FleetDocument, Report, SiteConfig, StatusBoard, state_files};
use input_files::read_regular_file;
use serde::de::IgnoredAny;
use std::path::PathBuf;

/// A larger document is none of a fleet.
const MAX_BYTES: u64 = 64 << 20;

/// Why the document of the fleet cannot be told.
#[derive(Debug, thiserror::Error)]
pub enum FleetError {
    /// It is not there yet, or cannot be read.
    #[error("{} cannot be read", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// It is something else.
    #[error("{} is no document of a fleet", path.display())]
    Json {
        /// The file.
        path: PathBuf,
        /// Why.
        source: serde_json::Error,
    },
}

/// The document of the fleet; `None` for a site without a link with robots. Where its server does not run, it says so.
///
/// # Errors
/// A document that cannot be read, or is not there yet.
pub fn fleet_document(config: &SiteConfig) -> Result<Option<FleetDocument>, FleetError> {
    if config.serve.as_ref().is_none_or(|serve| serve.link.is_none()) {
        return Ok(None);
    }
    let path = config.site_state.join(state_files::FLEET);
    let io = |source| FleetError::Io { path: path.clone(), source };
    let bytes = read_regular_file(&path, MAX_BYTES).map_err(io)?;
    let json = |source| FleetError::Json { path: path.clone(), source };
    let mut document: FleetDocument = serde_json::from_slice(&bytes).map_err(json)?;
    let report: Option<Report<IgnoredAny>> = StatusBoard::of_own(config).report(Daemon::SiteServer);
    if report.is_none_or(|report| report.is_silent()) {
        document.error = Some("site-server does not run: this is of before".to_owned());
    }
    Ok(Some(document))
}
