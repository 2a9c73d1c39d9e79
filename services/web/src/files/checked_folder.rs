//! The files of a folder with a manifest: each is the one that the manifest lists, or it is refused.
//!
//! Paths lead through folders and to regular files alone, never through a symbolic link: what a link leads to is not what was
//! written here, and may lie anywhere. The folder itself may be named by a link.

use crate::source::SourceError;
use messages::ContentId;
use rustix::fs::{CWD, Mode, OFlags, openat};
use rustix::io::Errno;
use std::collections::BTreeMap;
use std::fs::{File, Metadata};
use std::io::{self, Read};
use std::os::fd::OwnedFd;
use std::os::unix::fs::MetadataExt;
use std::path::{Component, Path, PathBuf};

/// Bytes of the largest file that is read.
const MAX_BYTES: u64 = 4 << 30;

/// A folder that is open: what is read through it stays of it, wherever its name leads meanwhile.
pub(super) struct CheckedFolder {
    path: PathBuf,
    folder: OwnedFd,
    /// sha256 of its files by their path, as the manifest lists them.
    sums: BTreeMap<String, String>,
}

/// Identity of a file and of its content, as far as the file system tells it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct FileStamp {
    place: [u64; 2],
    length: u64,
    times: [i64; 4],
}

impl FileStamp {
    /// Of the file that a path leads to now; `None` if there is none.
    pub(super) fn of(path: &Path) -> Option<Self> {
        std::fs::metadata(path).ok().map(|metadata| Self::of_metadata(&metadata))
    }

    fn of_metadata(file: &Metadata) -> Self {
        let times = [file.mtime(), file.mtime_nsec(), file.ctime(), file.ctime_nsec()];
        Self { place: [file.dev(), file.ino()], length: file.len(), times }
    }
}

impl CheckedFolder {
    /// Opens a folder, of which no file is listed yet.
    ///
    /// # Errors
    /// There is no such folder.
    pub(super) fn open(path: &Path) -> Result<Self, SourceError> {
        let flags = OFlags::RDONLY | OFlags::DIRECTORY | OFlags::CLOEXEC;
        let folder = openat(CWD, path, flags, Mode::empty());
        let folder = folder.map_err(|why| SourceError::Io { path: path.to_owned(), source: why.into() })?;
        Ok(Self { path: path.to_owned(), folder, sums: BTreeMap::new() })
    }

    /// Takes the sums that its manifest lists.
    pub(super) fn list(&mut self, sums: BTreeMap<String, String>) {
        self.sums = sums;
    }

    /// sha256 of a file, as the manifest lists it.
    pub(super) fn sum(&self, path: &str) -> Option<&str> {
        self.sums.get(path).map(String::as_str)
    }

    /// Where it was opened.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// The bytes of a file whatever the manifest lists: the manifest itself.
    ///
    /// # Errors
    /// No regular file, or one behind a symbolic link.
    pub(super) fn read_unlisted(&self, path: &str) -> Result<(Vec<u8>, FileStamp), SourceError> {
        let failed = |source| SourceError::Io { path: self.path.join(path), source };
        let mut file = self.open_file(path)?;
        let stamp = FileStamp::of_metadata(&file.metadata().map_err(failed)?);
        let mut bytes = Vec::new();
        bytes.try_reserve_exact(usize::try_from(stamp.length).unwrap_or(usize::MAX)).map_err(|e| failed(e.into()))?;
        (&mut file).take(MAX_BYTES + 1).read_to_end(&mut bytes).map_err(failed)?;
        if MAX_BYTES < bytes.len() as u64 {
            return Err(failed(io::ErrorKind::FileTooLarge.into()));
        }
        Ok((bytes, stamp))
    }

    /// The bytes of a file, which are those that the manifest lists.
    ///
    /// # Errors
    /// A file that is not listed, is another one, or is no regular file of this folder.
    pub(super) fn read(&self, path: &str) -> Result<(Vec<u8>, FileStamp), SourceError> {
        let altered = |what: &str| SourceError::Altered { path: self.path.join(path), what: what.to_owned() };
        let listed = self.sum(path).ok_or_else(|| altered("is not listed in manifest.json"))?;
        let (bytes, stamp) = self.read_unlisted(path)?;
        if ContentId::of(&bytes).to_string() == listed {
            Ok((bytes, stamp))
        } else {
            Err(altered("is not the file that manifest.json lists"))
        }
    }

    /// Opens a regular file, going through folders alone.
    fn open_file(&self, path: &str) -> Result<File, SourceError> {
        let failed = |errno: Errno| self.refusal(path, errno);
        let mut names = Vec::new();
        for part in Path::new(path).components() {
            let Component::Normal(name) = part else { return Err(failed(Errno::INVAL)) };
            names.push(name);
        }
        let Some((file, folders)) = names.split_last() else { return Err(failed(Errno::INVAL)) };
        let flags = OFlags::RDONLY | OFlags::NOFOLLOW | OFlags::CLOEXEC;
        let mut inner: Option<OwnedFd> = None;
        for name in folders {
            let outer = inner.as_ref().unwrap_or(&self.folder);
            inner = Some(openat(outer, *name, flags | OFlags::DIRECTORY, Mode::empty()).map_err(failed)?);
        }
        // To open a pipe without blocking does not wait for its other end.
        let opened = openat(inner.as_ref().unwrap_or(&self.folder), *file, flags | OFlags::NONBLOCK, Mode::empty());
        let opened = File::from(opened.map_err(failed)?);
        if opened.metadata().is_ok_and(|metadata| metadata.is_file()) { Ok(opened) } else { Err(failed(Errno::INVAL)) }
    }

    /// Why a file is not opened: a link on the way to it is named as what it is.
    fn refusal(&self, path: &str, errno: Errno) -> SourceError {
        let mut way = self.path.clone();
        for part in Path::new(path).components() {
            way.push(part);
            if way.is_symlink() {
                let what = "is a symbolic link, which is not followed".to_owned();
                return SourceError::Altered { path: way, what };
            }
        }
        let path = self.path.join(path);
        if errno == Errno::INVAL {
            return SourceError::Altered { path, what: "is no regular file in the folder of the maps".to_owned() };
        }
        SourceError::Io { path, source: errno.into() }
    }
}
