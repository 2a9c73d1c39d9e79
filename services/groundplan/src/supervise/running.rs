//! The process that supervises a site, by a lock in the state folder.
//!
//! The kernel drops the lock however its process dies: a number that was left, of a process that is gone, that is a zombie, or
//! that is another program by now, names none.

use crate::failure::Failure;
use daemon::state_files::UP_PROCESS;
use rustix::process::Pid;
use std::fs::{self, File, TryLockError};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};

/// The lock of this process; the file has its number.
pub(crate) struct Running {
    path: PathBuf,
    _lock: File,
}

impl Running {
    /// Locks the site for this process.
    ///
    /// # Errors
    /// A site that is up already, a folder that cannot be written.
    pub(crate) fn claim(state: &Path) -> Result<Self, Failure> {
        let failed = |path: &Path, error: std::io::Error| Failure::work(format!("{}: {error}", path.display()));
        fs::create_dir_all(state).map_err(|e| failed(state, e))?;
        let path = path_in(state);
        // Not truncated before it is locked: the number in it may be that of the process that holds it.
        let opened = File::options().create(true).truncate(false).read(true).write(true).open(&path);
        let mut lock = opened.map_err(|e| failed(&path, e))?;
        match lock.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                let process =
                    running(state).map_or_else(String::new, |pid| format!(": process {}", pid.as_raw_nonzero()));
                return Err(Failure::work(format!("the site is up already{process}")));
            }
            Err(TryLockError::Error(error)) => return Err(failed(&path, error)),
        }
        let written = lock.set_len(0).and_then(|()| lock.write_all(std::process::id().to_string().as_bytes()));
        written.map_err(|e| failed(&path, e))?;
        Ok(Self { path, _lock: lock })
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        // A file that stays is not locked any more.
        let _ = fs::remove_file(&self.path);
    }
}

/// The process that supervises a site.
pub(crate) fn running(state: &Path) -> Option<Pid> {
    let mut file = File::open(path_in(state)).ok()?;
    if !matches!(file.try_lock_shared(), Err(TryLockError::WouldBlock)) {
        return None;
    }
    let mut text = String::new();
    file.read_to_string(&mut text).ok()?;
    Pid::from_raw(text.trim().parse().ok()?)
}

fn path_in(state: &Path) -> PathBuf {
    state.join(UP_PROCESS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_that_was_left_names_no_process() {
        let state = tempfile::tempdir().unwrap();
        assert!(running(state.path()).is_none());
        // A process of groundplan that lives, and does not hold the lock: this one.
        fs::write(path_in(state.path()), std::process::id().to_string()).unwrap();
        assert!(running(state.path()).is_none());
        let own = claimed(state.path());
        let own_id = i32::try_from(std::process::id()).unwrap();
        assert_eq!(running(state.path()).map(|pid| pid.as_raw_nonzero().get()), Some(own_id));
        let refused = Running::claim(state.path()).err().unwrap().to_string();
        assert_eq!(refused, format!("the site is up already: process {own_id}"));
        drop(own);
        claimed(state.path());
    }

    /// The claim, once no child that another test has just forked holds the lock: until it begins its program it has all open files.
    fn claimed(state: &Path) -> Running {
        let attempt = |_| {
            let own = Running::claim(state).ok();
            own.or_else(|| {
                std::thread::sleep(std::time::Duration::from_millis(10));
                None
            })
        };
        (0..500).find_map(attempt).unwrap()
    }
}
