//! Files of another user, for tests.

use std::fs::{self, Permissions};
use std::io::Write;
use std::os::unix::fs::{PermissionsExt, chown};
use std::path::{Path, PathBuf};

/// Number of a user whom the machine does not know.
const OTHER_UID: u32 = 12_345;

/// A file of another user; removed when dropped.
pub(crate) struct ForeignFile(PathBuf);

impl Drop for ForeignFile {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.0);
    }
}

/// Makes an empty file that belongs to another user; `None`, and a loud word, for a user who cannot.
pub(crate) fn foreign_file(path: &Path, mode: u32) -> Option<ForeignFile> {
    if !rustix::process::geteuid().is_root() {
        // Past the test harness, which would capture it: a test that was skipped passes, and must still be seen.
        std::io::stderr().write_all(b"\n** SKIPPED: only root can make files of other users\n").unwrap();
        return None;
    }
    fs::write(path, "").unwrap();
    fs::set_permissions(path, Permissions::from_mode(mode)).unwrap();
    chown(path, Some(OTHER_UID), Some(OTHER_UID)).unwrap();
    Some(ForeignFile(path.to_owned()))
}
