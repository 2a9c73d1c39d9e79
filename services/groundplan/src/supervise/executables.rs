//! The executables of the daemons and their versions.

use crate::failure::Failure;
use bus::Daemon;
use daemon::{SiteConfig, SiteProcess};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

/// An executable beside this one.
///
/// # Errors
/// It is missing.
pub(crate) fn executable(name: &str) -> Result<PathBuf, Failure> {
    let own = std::env::current_exe().map_err(Failure::work)?;
    let path = own.with_file_name(name);
    if path.is_file() {
        Ok(path)
    } else {
        Err(Failure::work(format!("{} is missing: install all of groundplan", path.display())))
    }
}

/// The version that an executable prints.
///
/// # Errors
/// It cannot be run.
pub(crate) fn version_of(path: &Path) -> Result<String, Failure> {
    let output = Command::new(path).arg("--version").output();
    let output = output.map_err(|e| Failure::work(format!("{} cannot be run: {e}", path.display())))?;
    let text = String::from_utf8_lossy(&output.stdout);
    Ok(text.split_whitespace().last().unwrap_or_default().to_owned())
}

/// Checks that all daemons of a site are installed in the version of this program.
///
/// # Errors
/// An executable that is missing, or of another version.
pub(crate) fn check_versions(config: &SiteConfig) -> Result<(), Failure> {
    let own = env!("CARGO_PKG_VERSION");
    let daemons = SiteProcess::supervised(config).filter_map(SiteProcess::daemon);
    for name in daemons.map(Daemon::name).collect::<BTreeSet<_>>() {
        let path = executable(name)?;
        let version = version_of(&path)?;
        if version != own {
            return Err(Failure::work(format!(
                "{} is of version {version:?}, this is {own}: install one version",
                path.display()
            )));
        }
    }
    Ok(())
}
