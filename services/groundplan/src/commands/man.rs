//! `groundplan man`: manual pages.

use crate::failure::Failure;
use crate::run::Outcome;
use std::path::PathBuf;

/// Arguments of `man`.
#[derive(Debug, Clone, clap::Args)]
pub struct Args {
    /// Where to
    #[arg(value_name = "FOLDER")]
    folder: PathBuf,
}

impl Args {
    /// Writes a manual page for the program and each of its commands.
    ///
    /// # Errors
    /// A folder that cannot be written.
    pub(crate) fn write(&self, program: clap::Command) -> Result<Outcome, Failure> {
        let at = |e: std::io::Error| Failure::work(format!("{}: {e}", self.folder.display()));
        std::fs::create_dir_all(&self.folder).map_err(at)?;
        clap_mangen::generate_to(program, &self.folder).map_err(at)?;
        Ok(Outcome::silent())
    }
}
