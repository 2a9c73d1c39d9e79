//! Files that are replaced whole: written under a name of their own beside, renamed, and flushed where they must survive a power cut.

use std::fs::{File, Permissions};
use std::io::{self, Write};
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::time::Duration;
use std::{fs, time};
use tempfile::NamedTempFile;

/// Names of files that are being written begin and end so; what is between is drawn until it is nobody's.
const PREFIX: &str = ".groundplan-";
const SUFFIX: &str = ".new";
/// No file is written for so long: one that is older was left by a process that died.
const LEFT_AFTER: Duration = Duration::from_secs(3_600);

/// Replaces a file whole: when this returns it is on disk.
///
/// The path may be a bare name. A link is replaced by the file, not followed.
///
/// # Errors
/// The file system refuses; the file stays as it was, and nothing stays beside it.
pub fn write_durably(path: &Path, bytes: &[u8]) -> io::Result<()> {
    write_ahead(path, bytes)?;
    File::open(folder_of(path))?.sync_all()
}

/// Writes a file that [`rename_durably`] gives its name: its bytes are on disk when this returns, its name when the next file of
/// its folder is written durably.
///
/// # Errors
/// The file system refuses.
pub(crate) fn write_ahead(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let beside = written_beside(path, bytes)?;
    beside.as_file().sync_all()?;
    beside.persist(path).map(drop).map_err(|e| e.error)
}

/// Renames a file in its folder: when this returns that is on disk.
///
/// # Errors
/// The file system refuses.
pub(crate) fn rename_durably(from: &Path, to: &Path) -> io::Result<()> {
    fs::rename(from, to)?;
    File::open(folder_of(to))?.sync_all()
}

/// Replaces a file whole, for readers that must not meet half of it. It may be lost in a power cut.
///
/// # Errors
/// The file system refuses; the file stays as it was, and nothing stays beside it.
pub fn replace_file(path: &Path, bytes: &[u8]) -> io::Result<()> {
    written_beside(path, bytes)?.persist(path).map(drop).map_err(|e| e.error)
}

/// Removes what processes that died have left half written in a folder of groundplan's own.
pub(crate) fn remove_left_files(folder: &Path) {
    let is_old = |path: &Path| {
        let modified = fs::symlink_metadata(path).and_then(|file| file.modified());
        modified.is_ok_and(|at| time::SystemTime::now().duration_since(at).is_ok_and(|age| LEFT_AFTER < age))
    };
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        if name.starts_with(PREFIX) && name.ends_with(SUFFIX) && is_old(&entry.path()) {
            // It only takes room.
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// The bytes in a new file of the same folder, which is removed when it is dropped.
fn written_beside(path: &Path, bytes: &[u8]) -> io::Result<NamedTempFile> {
    // As of any new file: the mask of the process takes its bits away.
    let mut names = tempfile::Builder::new();
    names.prefix(PREFIX).suffix(SUFFIX).permissions(Permissions::from_mode(0o666));
    let mut beside = names.tempfile_in(folder_of(path))?;
    beside.write_all(bytes)?;
    Ok(beside)
}

/// The folder of a path; that of a bare name is the working folder.
pub fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_stays_beside_a_file_that_cannot_be_replaced() {
        let home = tempfile::tempdir().unwrap();
        let path = home.path().join("site");
        fs::create_dir_all(path.join("in it")).unwrap();
        write_durably(&path, b"content").unwrap_err();
        replace_file(&path, b"content").unwrap_err();
        assert_eq!(fs::read_dir(home.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_file_of_a_user_beside_it_stays() {
        let home = tempfile::tempdir().unwrap();
        let (path, other) = (home.path().join("pose.yaml"), home.path().join("pose.new"));
        fs::write(&other, "a user's").unwrap();
        write_durably(&path, b"content").unwrap();
        replace_file(&path, b"content").unwrap();
        assert_eq!(fs::read_to_string(other).unwrap(), "a user's");
        assert_eq!(fs::read_dir(home.path()).unwrap().count(), 2);
    }

    #[test]
    fn the_folder_of_a_bare_name_is_the_working_folder() {
        assert_eq!(folder_of(Path::new("drive")), Path::new("."));
        assert_eq!(folder_of(Path::new("a/drive")), Path::new("a"));
    }

    #[test]
    fn a_new_file_has_the_permissions_of_any_other() {
        let home = tempfile::tempdir().unwrap();
        let (ours, other) = (home.path().join("ours"), home.path().join("other"));
        write_durably(&ours, b"").unwrap();
        fs::write(&other, "").unwrap();
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode();
        assert_eq!(mode(&ours), mode(&other));
    }

    #[test]
    fn only_old_files_of_processes_that_died_are_removed() {
        let home = tempfile::tempdir().unwrap();
        let file = |name: &str| home.path().join(name);
        for name in [".groundplan-a.new", ".groundplan-b.new", "mine.new"] {
            fs::write(file(name), "").unwrap();
        }
        let long_ago = time::SystemTime::now() - 2 * LEFT_AFTER;
        for name in [".groundplan-a.new", "mine.new"] {
            File::options().write(true).open(file(name)).unwrap().set_modified(long_ago).unwrap();
        }
        remove_left_files(home.path());
        assert!(!file(".groundplan-a.new").exists());
        assert!(file(".groundplan-b.new").exists() && file("mine.new").exists());
    }
}
