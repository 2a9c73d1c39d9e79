//! The executables of the daemons and their builds.

use crate::failure::Failure;
use bus::{Daemon, is_same_build, own_build};
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

/// The build that an executable prints.
///
/// # Errors
/// It cannot be run.
fn build_of(path: &Path) -> Result<String, Failure> {
    let output = Command::new(path).arg("--version").output();
    let output = output.map_err(|e| Failure::work(format!("{} cannot be run: {e}", path.display())))?;
    let text = String::from_utf8_lossy(&output.stdout);
    // The name is before it.
    Ok(text.trim().split_once(' ').map_or("", |(_, build)| build).to_owned())
}

/// An executable beside this one, of the build of this program.
///
/// # Errors
/// It is missing, cannot be run, or is of another build.
pub(crate) fn executable_of_own_build(name: &str) -> Result<PathBuf, Failure> {
    let (path, own) = (executable(name)?, own_build());
    let build = build_of(&path)?;
    if !is_same_build(&build, own) {
        let path = path.display();
        return Err(Failure::work(format!(
            "{path} is of groundplan {build:?}, and this program is of {own}: install all programs from one build"
        )));
    }
    Ok(path)
}

/// Checks that all daemons of a site are installed in the build of this program.
///
/// # Errors
/// An executable that is missing, or of another build.
pub(crate) fn check_builds(config: &SiteConfig) -> Result<(), Failure> {
    let daemons = SiteProcess::supervised(config).filter_map(SiteProcess::daemon);
    let names: BTreeSet<&str> = daemons.map(Daemon::name).collect();
    names.into_iter().try_for_each(|name| executable_of_own_build(name).map(drop))
}
