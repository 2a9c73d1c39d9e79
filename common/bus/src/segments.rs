//! Segments in shared memory: regular files of this user whose names begin with a prefix.
//!
//! Everybody may put files into the folder of shared memory. What another user has there is no segment, whatever its name.

use crate::error::DomainError;
use std::fs::{self, Permissions};
use std::io;
use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// The folder of POSIX shared memory.
pub(crate) const SHARED_MEMORY: &str = "/dev/shm";

/// Segments whose names begin so.
pub(crate) fn segments(prefix: &str) -> Result<Vec<PathBuf>, DomainError> {
    let own = rustix::process::geteuid().as_raw();
    let mut found = files_of_all_users(prefix)?;
    // One that is gone is none.
    found.retain(|path| fs::symlink_metadata(path).is_ok_and(|m| m.file_type().is_file() && m.uid() == own));
    Ok(found)
}

/// Everything whose name begins so, whoever made it.
pub(crate) fn files_of_all_users(prefix: &str) -> Result<Vec<PathBuf>, DomainError> {
    let folder = Path::new(SHARED_MEMORY);
    let failed = |source| DomainError::File { path: folder.to_owned(), source };
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).map_err(failed)? {
        let name = entry.map_err(failed)?.file_name();
        found.extend(name.to_str().filter(|n| n.starts_with(prefix)).map(|n| folder.join(n)));
    }
    Ok(found)
}

/// Removes segments whose names begin so.
///
/// # Errors
/// The first that cannot be removed; all others are.
pub(crate) fn remove_segments(prefix: &str) -> Result<(), DomainError> {
    for_each(prefix, |segment| fs::remove_file(segment))
}

/// Removes segments that have been empty for `age`: their creators died before they set a size.
///
/// # Errors
/// As [`remove_segments`].
pub(crate) fn remove_empty_segments(prefix: &str, age: Duration) -> Result<(), DomainError> {
    for_each(prefix, |segment| {
        let metadata = fs::symlink_metadata(segment)?;
        // One that was made in the future by a clock that was set is young.
        let old = metadata.modified().ok().and_then(|at| at.elapsed().ok()).is_some_and(|elapsed| elapsed >= age);
        if metadata.len() == 0 && old { fs::remove_file(segment) } else { Ok(()) }
    })
}

/// Takes the rights of group and others from segments. The bits of the owner stay: they tell that a segment is not
/// finished.
///
/// # Errors
/// The first that cannot be closed; all others are.
pub(crate) fn close_segments(prefix: &str) -> Result<(), DomainError> {
    for_each(prefix, |segment| {
        let mode = fs::symlink_metadata(segment)?.mode();
        if mode & 0o077 == 0 { Ok(()) } else { fs::set_permissions(segment, Permissions::from_mode(mode & 0o700)) }
    })
}

/// Does something with each segment, also behind one with which it fails. One that is gone needs nothing.
fn for_each(prefix: &str, mut act: impl FnMut(&Path) -> io::Result<()>) -> Result<(), DomainError> {
    let mut first = Ok(());
    for segment in segments(prefix)? {
        match act(&segment) {
            Err(source) if source.kind() != io::ErrorKind::NotFound => {
                first = first.and(Err(DomainError::File { path: segment, source }));
            }
            _ => {}
        }
    }
    first
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::foreign_files::foreign_file;

    fn segment(prefix: &str, name: &str) -> PathBuf {
        Path::new(SHARED_MEMORY).join(format!("{prefix}{name}"))
    }

    #[test]
    fn only_empty_segments_that_are_old_enough_are_removed() {
        let prefix = format!("gse{:x}_", std::process::id());
        fs::write(segment(&prefix, "1_empty"), "").unwrap();
        fs::write(segment(&prefix, "1_full"), "x").unwrap();
        remove_empty_segments(&prefix, Duration::from_secs(3600)).unwrap();
        assert_eq!(segments(&prefix).unwrap().len(), 2, "a young one may be about to grow");
        remove_empty_segments(&prefix, Duration::ZERO).unwrap();
        assert_eq!(segments(&prefix).unwrap(), [segment(&prefix, "1_full")]);
        remove_segments(&prefix).unwrap();
        assert!(segments(&prefix).unwrap().is_empty());
    }

    #[test]
    fn files_of_other_users_and_links_are_no_segments() {
        let prefix = format!("gsf{:x}_", std::process::id());
        let target = tempfile::NamedTempFile::new().unwrap();
        fs::set_permissions(target.path(), Permissions::from_mode(0o644)).unwrap();
        let link = segment(&prefix, "1_link");
        std::os::unix::fs::symlink(target.path(), &link).unwrap();
        fs::create_dir(segment(&prefix, "1_folder")).unwrap();
        let foreign = foreign_file(&segment(&prefix, "2_x"), 0o644);
        close_segments(&prefix).unwrap();
        remove_empty_segments(&prefix, Duration::ZERO).unwrap();
        remove_segments(&prefix).unwrap();
        assert_eq!(target.path().metadata().unwrap().mode() & 0o777, 0o644);
        assert!(segments(&prefix).unwrap().is_empty() && link.is_symlink());
        if foreign.is_some() {
            assert_eq!(fs::metadata(segment(&prefix, "2_x")).unwrap().mode() & 0o777, 0o644);
        }
        fs::remove_file(link).unwrap();
        fs::remove_dir(segment(&prefix, "1_folder")).unwrap();
    }

    #[test]
    fn a_segment_that_cannot_be_handled_does_not_save_those_behind_it() {
        let prefix = format!("gsg{:x}_", std::process::id());
        for name in ["1_a", "1_b", "1_c"] {
            fs::write(segment(&prefix, name), "x").unwrap();
        }
        let mut n_tried = 0;
        let done = for_each(&prefix, |path| {
            n_tried += 1;
            if n_tried == 1 { Err(io::ErrorKind::PermissionDenied.into()) } else { fs::remove_file(path) }
        });
        assert!(matches!(done, Err(DomainError::File { .. })));
        assert_eq!((n_tried, segments(&prefix).unwrap().len()), (3, 1));
        remove_segments(&prefix).unwrap();
    }
}
