//! Errors of what is simulated in references and written as files.

use std::path::PathBuf;

/// Errors of simulated drives that are written as files.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// A file cannot be written.
    #[error("{} cannot be written", path.display())]
    Write {
        /// The file or the folder of the map.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// No reference can be simulated.
    #[error("no reference can be simulated")]
    NoReference,
    /// Two references would be written to the same files.
    #[error("two references are named {name}")]
    SameName {
        /// Their name.
        name: String,
    },
}
