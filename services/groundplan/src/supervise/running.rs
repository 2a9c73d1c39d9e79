//! The process that supervises a site, by its file in the state folder.

use crate::failure::Failure;
use rustix::process::{Pid, test_kill_process};
use std::path::{Path, PathBuf};

/// The file with the id of the process that supervises a site; removed with this value.
pub(crate) struct Running(PathBuf);

impl Running {
    /// Names this process.
    ///
    /// # Errors
    /// A site that is up already, a folder that cannot be written.
    pub(crate) fn claim(state: &Path) -> Result<Self, Failure> {
        std::fs::create_dir_all(state).map_err(|e| Failure::work(format!("{}: {e}", state.display())))?;
        if let Some(pid) = running(state) {
            return Err(Failure::work(format!("the site is up already: process {}", pid.as_raw_nonzero())));
        }
        let path = state.join("up.pid");
        daemon::write_durably(&path, std::process::id().to_string().as_bytes()).map_err(Failure::work)?;
        Ok(Self(path))
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        // What is left names a process that is gone, and is not taken seriously.
        let _ = std::fs::remove_file(&self.0);
    }
}

/// The process that supervises a site.
pub(crate) fn running(state: &Path) -> Option<Pid> {
    let pid: i32 = std::fs::read_to_string(state.join("up.pid")).ok()?.trim().parse().ok()?;
    let is_ours = std::fs::read_to_string(format!("/proc/{pid}/comm")).is_ok_and(|name| name.trim() == "groundplan");
    Pid::from_raw(pid).filter(|pid| is_ours && test_kill_process(*pid).is_ok())
}
