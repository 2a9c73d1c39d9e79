//! Files that others write: read only once they are whole, which is when two looks at them find the same.

use crate::failure::Failure;
use crate::machine_time::{Clock, MachineClock, MachineTime};
use input_files::read_regular_file;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::fs::Metadata;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// Two looks at files are so far apart, in milliseconds.
const SETTLE_MS: i64 = 1_000;
/// Files that are asked for are waited for so long.
const WAIT_MAX: Duration = Duration::from_secs(30);
/// Interval of looks while a client waits.
const LOOK_INTERVAL: Duration = Duration::from_millis(250);

/// How a file looks on disk without being read. Whatever writes to it, or replaces it, changes this, unless it sets the clock back.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FileStamp {
    length: u64,
    modified_ns: i64,
    /// When its content or its attributes changed, which no program can set.
    changed_ns: i64,
    /// Its number in the file system.
    inode: u64,
}

impl FileStamp {
    /// How a file looks now; `None` if it is not there.
    pub fn of(path: &Path) -> Option<Self> {
        std::fs::metadata(path).ok().map(|metadata| Self::of_metadata(&metadata))
    }

    fn of_metadata(metadata: &Metadata) -> Self {
        let ns = |seconds: i64, ns: i64| seconds.saturating_mul(1_000_000_000).saturating_add(ns);
        Self {
            length: metadata.len(),
            modified_ns: ns(metadata.mtime(), metadata.mtime_nsec()),
            changed_ns: ns(metadata.ctime(), metadata.ctime_nsec()),
            inode: metadata.ino(),
        }
    }

    /// True if nothing has been written to it for as long as two looks are apart.
    fn is_quiet(&self, now_ns: i64) -> bool {
        let settle_ns = SETTLE_MS * 1_000_000;
        [self.modified_ns, self.changed_ns].into_iter().all(|at| at.saturating_add(settle_ns) <= now_ns)
    }
}

/// Files that were found whole.
#[derive(Debug)]
pub struct WholeFiles {
    /// How each looked before and after it was read.
    pub stamps: Vec<Option<FileStamp>>,
    /// The bytes of each.
    pub contents: Vec<Vec<u8>>,
}

/// Waits for files that are being written.
#[derive(Debug, Clone)]
pub struct FileWatch {
    /// Bytes of the largest file that is read.
    max_bytes: u64,
    last_look: Option<Look>,
}

/// What a look at files found.
#[derive(Debug, Clone)]
struct Look {
    at: MachineTime,
    paths: Vec<PathBuf>,
    stamps: Vec<Option<FileStamp>>,
    /// Of each file's content; `None` for one that cannot be read.
    sha256: Vec<Option<[u8; 32]>>,
}

impl FileWatch {
    /// For regular files up to this size.
    pub fn new(max_bytes: u64) -> Self {
        Self { max_bytes, last_look: None }
    }

    /// Looks at files when the machine tells `now`. They are whole if they look, and hold, what they did at a look a second or more ago;
    /// `None` until then.
    ///
    /// # Errors
    /// A file that could not be read both times, with its path.
    pub fn look(&mut self, paths: &[PathBuf], now: MachineTime) -> Option<Result<WholeFiles, Failure>> {
        let stamps = stamps_of(paths);
        let since = |last: &Look| now.since_boot_ms.saturating_sub(last.at.since_boot_ms);
        let is_early = |last: &Look| last.paths == paths && last.stamps == stamps && since(last) <= SETTLE_MS;
        if self.last_look.as_ref().is_some_and(is_early) {
            return None;
        }
        let read: Vec<_> = paths.iter().map(|path| self.read(path)).collect();
        let sha256: Vec<_> =
            read.iter().map(|read| read.as_ref().ok().map(|bytes| Sha256::digest(bytes).into())).collect();
        let look = Look { at: now, paths: paths.to_vec(), stamps, sha256 };
        let is_same =
            |last: &Look| last.paths == look.paths && last.stamps == look.stamps && last.sha256 == look.sha256;
        // While they were read they may have changed.
        let is_whole = self.last_look.as_ref().is_some_and(is_same) && stamps_of(paths) == look.stamps;
        if !is_whole {
            self.last_look = Some(look);
            return None;
        }
        self.last_look = None;
        let contents = read.into_iter().collect::<Result<_, _>>();
        Some(contents.map(|contents| WholeFiles { stamps: look.stamps, contents }))
    }

    fn read(&self, path: &Path) -> Result<Vec<u8>, Failure> {
        read_regular_file(path, self.max_bytes).map_err(|e| format!("{} cannot be read: {e}", path.display()).into())
    }

    /// Waits until files are whole. Those that nothing was written to for a second are so at the first look.
    ///
    /// # Errors
    /// A file that cannot be read, with its path; files that change all the time.
    pub fn wait(&mut self, paths: &[PathBuf], waits: impl Fn()) -> Result<WholeFiles, Failure> {
        let (begun, clock) = (Instant::now(), MachineClock::of_this_boot());
        loop {
            let stamps = stamps_of(paths);
            if stamps.iter().flatten().all(|stamp| stamp.is_quiet(now_ns())) {
                let contents = paths.iter().map(|path| self.read(path)).collect::<Result<_, _>>()?;
                if stamps_of(paths) == stamps {
                    return Ok(WholeFiles { stamps, contents });
                }
            } else if let Some(found) = self.look(paths, clock.now()) {
                return found;
            }
            if WAIT_MAX <= begun.elapsed() {
                let names: Vec<String> = paths.iter().map(|path| path.display().to_string()).collect();
                return Err(format!("{} is still being written: try again once it is whole", names.join(" or ")).into());
            }
            waits();
            std::thread::sleep(LOOK_INTERVAL);
        }
    }
}

/// How files look now; `None` for a file that is not there.
pub fn stamps_of(paths: &[PathBuf]) -> Vec<Option<FileStamp>> {
    paths.iter().map(|path| FileStamp::of(path)).collect()
}

fn now_ns() -> i64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |now| now.as_nanos() as i64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;
    use std::io::Write;

    fn now() -> MachineTime {
        MachineClock::of_this_boot().now()
    }

    fn settle() -> Duration {
        Duration::from_millis(SETTLE_MS as u64)
    }

    /// Looks until files are whole, or a few seconds long.
    fn found(watch: &mut FileWatch, paths: &[PathBuf]) -> Option<Result<WholeFiles, Failure>> {
        let begun = Instant::now();
        while begun.elapsed() < Duration::from_secs(3) {
            if let Some(found) = watch.look(paths, now()) {
                return Some(found);
            }
        }
        None
    }

    #[test]
    fn a_file_is_whole_when_two_looks_a_second_apart_find_the_same() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.ifc");
        fs::write(&path, "first").unwrap();
        let (mut watch, paths, begun) = (FileWatch::new(1_000), [path.clone()], Instant::now());
        assert!(watch.look(&paths, now()).is_none());
        let whole = found(&mut watch, &paths).unwrap().unwrap();
        assert!(begun.elapsed() >= settle());
        assert_eq!((whole.contents, whole.stamps), (vec![b"first".to_vec()], stamps_of(&paths)));
    }

    #[test]
    fn a_file_that_is_written_in_place_is_not_whole_also_where_its_time_is_set_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.ifc");
        fs::write(&path, vec![b'a'; 100]).unwrap();
        let old = fs::metadata(&path).unwrap().modified().unwrap();
        let (mut watch, paths) = (FileWatch::new(1_000), [path.clone()]);
        for n in 1..6 {
            assert!(watch.look(&paths, now()).is_none(), "after {n} blocks");
            std::thread::sleep(settle() / 2);
            let mut file = fs::OpenOptions::new().write(true).open(&path).unwrap();
            file.write_all(&vec![b'b'; 10 * n]).unwrap();
            file.set_modified(old).unwrap();
        }
        assert_eq!(found(&mut watch, &paths).unwrap().unwrap().contents[0][..50], vec![b'b'; 50]);
    }

    #[test]
    fn a_file_that_is_not_there_is_an_error_once_it_stays_away() {
        let paths = [PathBuf::from("/nowhere/a.ifc")];
        let mut watch = FileWatch::new(1_000);
        assert!(watch.look(&paths, now()).is_none());
        let why = found(&mut watch, &paths).unwrap().unwrap_err().to_string();
        assert!(why.contains("/nowhere/a.ifc"), "{why}");
        assert!(watch.wait(&paths, || {}).is_err());
    }
}
