//! Generations of a domain in the file system: the current one, its members, and removal of dead ones.
//!
//! A process killed at the wrong moment of a creation leaves a service, or a whole domain of the bus library, that can
//! neither be opened nor removed. Nothing is repaired in place: the keeper makes the next generation under another
//! prefix and folder, and a generation without members is removed.
//!
//! | file in the domain's folder | what |
//! |---|---|
//! | `keeper.lock` | held exclusively by the keeper |
//! | `generation` | number, layout version and library of the current generation, and the keeper's build; renamed into place |
//! | `<n>.lock` | held shared by every process that lives in generation n |
//! | `<n>/` | the bus library's files of generation n |
//! | `renew` | a participant's wish for the generation after n, because something of it was deleted |
//! | `board/` | what daemons report about themselves |

use crate::error::DomainError;
use crate::file_lock::{Lock, try_lock};
use crate::program_build::{is_same_build, own_build};
use crate::segments::{close_segments, files_of_all_users, remove_empty_segments, remove_segments, segments};
use messages::LAYOUT_VERSION;
use rustix::fs::FlockOperation;
use std::collections::BTreeSet;
use std::fs::{self, Permissions};
use std::io;
use std::os::unix::fs::{DirBuilderExt, MetadataExt, PermissionsExt};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// The library whose formats a domain has; formats of one version do not open those of another.
pub(crate) const LIBRARY: &str = "iceoryx2-0.10.0";

/// Name of the file that says which generation is current.
pub(crate) const CURRENT: &str = "generation";

/// The build in files of keepers that wrote none.
const EARLIER: &str = "of a version before 1.0";

/// Name of the file that asks the keeper for a new generation.
const RENEW: &str = "renew";

/// Names of sockets have 107 bytes; what the bus library and the generation append leaves this for the folder.
const MAX_ROOT_BYTES: usize = 48;

/// Mode of the domain's folder: its user alone takes part.
const ROOT_MODE: u32 = 0o700;

/// Prefix and folder of a domain.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Place {
    prefix: String,
    root: PathBuf,
}

impl Place {
    pub(crate) fn new(prefix: &str, root: &Path) -> Result<Self, DomainError> {
        // One underscore, at the end: no prefix is then the beginning of another.
        let plain = prefix.strip_suffix('_').is_some_and(|p| p.bytes().all(|b| b.is_ascii_alphanumeric()));
        if !plain || prefix.len() < 2 || prefix.len() > 16 {
            return Err(DomainError::Prefix { prefix: prefix.to_owned() });
        }
        if !root.is_absolute() || root.to_str().is_none_or(|r| r.len() > MAX_ROOT_BYTES) {
            return Err(DomainError::Root { root: root.to_owned(), max: MAX_ROOT_BYTES });
        }
        Ok(Self { prefix: prefix.to_owned(), root: root.to_owned() })
    }

    pub(crate) fn root(&self) -> &Path {
        &self.root
    }

    /// Prefix of the shared memory of a generation.
    pub(crate) fn prefix_of(&self, generation: u64) -> String {
        format!("{}{generation}_", self.prefix)
    }

    /// Folder of the bus library's files of a generation.
    pub(crate) fn folder_of(&self, generation: u64) -> PathBuf {
        self.root.join(generation.to_string())
    }

    /// The lock of a generation's members.
    pub(crate) fn lock_path(&self, generation: u64) -> PathBuf {
        self.root.join(format!("{generation}.lock"))
    }

    /// The file that says which generation is current.
    pub(crate) fn current_path(&self) -> PathBuf {
        self.root.join(CURRENT)
    }

    /// The keeper's lock.
    pub(crate) fn keeper_lock_path(&self) -> PathBuf {
        self.root.join("keeper.lock")
    }

    /// Makes the domain's folder, or keeps others out of the one that is there.
    pub(crate) fn make_root(&self) -> Result<(), DomainError> {
        let failed = |source| DomainError::File { path: self.root.clone(), source };
        fs::DirBuilder::new().recursive(true).mode(ROOT_MODE).create(&self.root).map_err(failed)?;
        let metadata = fs::metadata(&self.root).map_err(failed)?;
        if metadata.permissions().mode() & 0o777 == ROOT_MODE {
            return Ok(());
        }
        // A folder that is named by mistake, such as `/run`, is not taken away from its other users.
        for entry in fs::read_dir(&self.root).map_err(failed)? {
            let name = entry.map_err(failed)?.file_name();
            if !is_own_file(&name.to_string_lossy()) {
                return Err(DomainError::RootInUse { root: self.root.clone(), other: name.into() });
            }
        }
        fs::set_permissions(&self.root, Permissions::from_mode(ROOT_MODE)).map_err(failed)
    }

    /// The user who owns the domain's folder; `None` if there is no folder.
    pub(crate) fn owner(&self) -> Result<Option<u32>, DomainError> {
        match fs::metadata(&self.root) {
            Ok(metadata) => Ok(Some(metadata.uid())),
            Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(source) => Err(DomainError::File { path: self.root.clone(), source }),
        }
    }

    /// Becomes the keeper; `None` if there is one.
    pub(crate) fn lock_as_keeper(&self) -> Result<Option<Lock>, DomainError> {
        try_lock(&self.keeper_lock_path(), FlockOperation::NonBlockingLockExclusive)
    }

    /// The current generation; `None` if there is none.
    pub(crate) fn current(&self) -> Result<Option<u64>, DomainError> {
        let path = self.current_path();
        let text = match fs::read_to_string(&path) {
            Ok(text) => text,
            Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(source) => return Err(DomainError::File { path, source }),
        };
        let value = |key| value_in(&text, key);
        let damaged = || DomainError::Damaged { path: path.clone() };
        let found: u32 = value("layout").and_then(|v| v.parse().ok()).ok_or_else(damaged)?;
        let library = value("library").ok_or_else(damaged)?;
        let generation = value("generation").and_then(|v| v.parse().ok()).ok_or_else(damaged)?;
        if found != LAYOUT_VERSION {
            return Err(DomainError::Version { found });
        }
        if library != LIBRARY {
            return Err(DomainError::Library { found: library.to_owned(), wanted: LIBRARY });
        }
        Ok(Some(generation))
    }

    /// Refuses the current generation if its keeper is of another build than this program.
    pub(crate) fn require_own_build(&self) -> Result<(), DomainError> {
        let path = self.current_path();
        let text = fs::read_to_string(&path).map_err(|source| DomainError::File { path, source })?;
        let found = value_in(&text, "build").unwrap_or(EARLIER);
        if is_same_build(found, own_build()) { Ok(()) } else { Err(DomainError::Build { found: found.to_owned() }) }
    }

    /// Makes a generation the current one: participants of others see that and follow.
    pub(crate) fn announce(&self, generation: u64) -> Result<(), DomainError> {
        let path = self.current_path();
        let beside = self.root.join("generation.new");
        let build = own_build();
        let text = format!("generation={generation}\nlayout={LAYOUT_VERSION}\nlibrary={LIBRARY}\nbuild={build}\n");
        let written = fs::write(&beside, text).and_then(|()| fs::rename(&beside, &path));
        written.map_err(|source| {
            // What is half written helps nobody.
            let _ = fs::remove_file(&beside);
            DomainError::File { path, source }
        })
    }

    /// Asks the keeper for the generation after this one, because something of it is missing.
    pub(crate) fn ask_for_renewal(&self, generation: u64, missing: &Path) -> Result<(), DomainError> {
        let path = self.root.join(RENEW);
        let text = format!("{generation}\n{}\n", missing.display());
        fs::write(&path, text).map_err(|source| DomainError::File { path, source })
    }

    /// What is missing of this generation in the eyes of a participant; the request is taken away.
    pub(crate) fn take_renewal_request(&self, generation: u64) -> Result<Option<PathBuf>, DomainError> {
        let path = self.root.join(RENEW);
        let Ok(text) = fs::read_to_string(&path) else { return Ok(None) };
        remove(&path, fs::remove_file(&path))?;
        let (number, missing) = text.split_once('\n').unwrap_or_default();
        Ok((number.parse() == Ok(generation)).then(|| PathBuf::from(missing.trim_end())))
    }

    /// Says that there is no generation to join.
    pub(crate) fn withdraw(&self) -> Result<(), DomainError> {
        let path = self.current_path();
        remove(&path, fs::remove_file(&path))
    }

    /// Joins a generation as a member for as long as the lock is held.
    pub(crate) fn join_members(&self, generation: u64) -> Result<Lock, DomainError> {
        let path = self.lock_path(generation);
        let lock = try_lock(&path, FlockOperation::LockShared)?;
        lock.ok_or_else(|| DomainError::File { path, source: io::ErrorKind::WouldBlock.into() })
    }

    /// True if the generation has a member.
    pub(crate) fn has_members(&self, generation: u64) -> Result<bool, DomainError> {
        let path = self.lock_path(generation);
        Ok(path.exists() && try_lock(&path, FlockOperation::NonBlockingLockExclusive)?.is_none())
    }

    /// All generations of which something is left.
    pub(crate) fn numbers(&self) -> Result<Vec<u64>, DomainError> {
        let failed = |source| DomainError::File { path: self.root.clone(), source };
        let mut numbers = Vec::new();
        for entry in fs::read_dir(&self.root).map_err(failed)? {
            let name = entry.map_err(failed)?.file_name();
            numbers.extend(number_of(&name.to_string_lossy()));
        }
        // A folder that was deleted leaves segments behind.
        numbers.extend(segments(&self.prefix)?.iter().filter_map(|segment| self.number_of_segment(segment)));
        numbers.sort_unstable();
        numbers.dedup();
        Ok(numbers)
    }

    /// The number of a new generation: above every one of which something is left, and above `last`. A number is skipped
    /// if any user has files under its prefix, which could be in the way of segments.
    pub(crate) fn next_number(&self, last: Option<u64>) -> Result<u64, DomainError> {
        let files = files_of_all_users(&self.prefix)?;
        let in_the_way: BTreeSet<u64> = files.iter().filter_map(|file| self.number_of_segment(file)).collect();
        let mut number = self.numbers()?.into_iter().chain(last).max().unwrap_or(0) + 1;
        while in_the_way.contains(&number) {
            number += 1;
        }
        Ok(number)
    }

    fn number_of_segment(&self, path: &Path) -> Option<u64> {
        let name = path.file_name()?.to_str()?;
        name.strip_prefix(&self.prefix)?.split_once('_')?.0.parse().ok()
    }

    /// Removes segments that have been empty for `age`: their creators died before they set a size.
    ///
    /// The bus library waits without end for such a segment to grow, in every process that opens it or cleans up.
    pub(crate) fn remove_empty_segments(&self, age: Duration) -> Result<(), DomainError> {
        remove_empty_segments(&self.prefix, age)
    }

    /// Keeps other users out: service managers open the folder to a group at every start of a unit, and the bus library makes
    /// a segment that all may write.
    pub(crate) fn keep_others_out(&self) -> Result<(), DomainError> {
        if self.root.exists() {
            self.make_root()?;
        }
        close_segments(&self.prefix)
    }

    /// Segments of a generation whose names end so.
    pub(crate) fn segments_of(&self, generation: u64, suffix: &str) -> Result<Vec<PathBuf>, DomainError> {
        let mut found = segments(&self.prefix_of(generation))?;
        found.retain(|segment| segment.to_string_lossy().ends_with(suffix));
        Ok(found)
    }

    /// Removes the files of a generation, which the caller knows to have no members.
    pub(crate) fn remove_files(&self, generation: u64) -> Result<(), DomainError> {
        // Both, also if one of them fails: segments are memory.
        let removed = remove_segments(&self.prefix_of(generation));
        let folder = self.folder_of(generation);
        remove(&folder, fs::remove_dir_all(&folder)).and(removed)
    }

    /// Removes a generation without members; false if it has one.
    pub(crate) fn remove(&self, generation: u64) -> Result<bool, DomainError> {
        let path = self.lock_path(generation);
        let Some(_lock) = try_lock(&path, FlockOperation::NonBlockingLockExclusive)? else { return Ok(false) };
        self.remove_files(generation)?;
        // Last: while the lock file exists, the number is not taken for that of a removed generation.
        remove(&path, fs::remove_file(&path))?;
        Ok(true)
    }
}

/// The generation that a file of the domain's folder belongs to.
fn number_of(name: &str) -> Option<u64> {
    name.strip_suffix(".lock").unwrap_or(name).parse().ok()
}

/// True for files that the bus and its daemons put into the domain's folder.
fn is_own_file(name: &str) -> bool {
    ["keeper.lock", CURRENT, "generation.new", RENEW, "board"].contains(&name) || number_of(name).is_some()
}

/// What is not there needs no removal.
fn remove(path: &Path, done: io::Result<()>) -> Result<(), DomainError> {
    match done {
        Err(source) if source.kind() != io::ErrorKind::NotFound => {
            Err(DomainError::File { path: path.to_owned(), source })
        }
        _ => Ok(()),
    }
}

/// The value of a key in the text of the file that says which generation is current.
fn value_in<'t>(text: &'t str, key: &str) -> Option<&'t str> {
    text.lines().find_map(|line| line.split_once('=').filter(|(found, _)| *found == key)).map(|(_, value)| value)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::foreign_files::foreign_file;
    use crate::segments::SHARED_MEMORY;

    fn place(folder: &tempfile::TempDir) -> Place {
        Place::new("gpgen_", folder.path()).unwrap()
    }

    #[test]
    fn prefixes_that_could_be_the_start_of_another_are_refused() {
        for prefix in ["", "_", "gp", "gp/_", "gp_3_", "aPrefixThatIsTooLong_"] {
            assert!(matches!(Place::new(prefix, Path::new("/tmp/x")), Err(DomainError::Prefix { .. })), "{prefix}");
        }
        assert!(matches!(Place::new("gp_", Path::new("relative")), Err(DomainError::Root { .. })));
        assert!(matches!(Place::new("gp_", Path::new(&"/x".repeat(40))), Err(DomainError::Root { .. })));
    }

    #[test]
    fn the_announced_generation_is_current_until_it_is_withdrawn() {
        let folder = tempfile::tempdir().unwrap();
        let place = place(&folder);
        assert_eq!(place.current().unwrap(), None);
        place.announce(3).unwrap();
        assert_eq!(place.current().unwrap(), Some(3));
        place.withdraw().unwrap();
        place.withdraw().unwrap();
        assert_eq!(place.current().unwrap(), None);
    }

    #[test]
    fn an_announcement_that_fails_leaves_no_file() {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join(CURRENT)).unwrap();
        assert!(matches!(place(&folder).announce(3), Err(DomainError::File { .. })));
        assert!(!folder.path().join("generation.new").exists());
    }

    #[test]
    fn segments_of_generations_without_a_folder_count() {
        let folder = tempfile::tempdir().unwrap();
        let prefix = format!("gpn{:x}_", std::process::id());
        let place = Place::new(&prefix, folder.path()).unwrap();
        let segment = Path::new(SHARED_MEMORY).join(format!("{prefix}41_left"));
        fs::write(&segment, "x").unwrap();
        assert_eq!(place.numbers().unwrap(), [41]);
        assert!(place.remove(41).unwrap() && !segment.exists());
    }

    #[test]
    fn a_folder_that_cannot_be_removed_keeps_no_segments() {
        let folder = tempfile::tempdir().unwrap();
        let prefix = format!("gpk{:x}_", std::process::id());
        let place = Place::new(&prefix, folder.path()).unwrap();
        let segment = Path::new(SHARED_MEMORY).join(format!("{prefix}5_left"));
        fs::write(&segment, "x").unwrap();
        fs::write(place.folder_of(5), "no folder").unwrap();
        assert!(matches!(place.remove(5), Err(DomainError::File { .. })) && !segment.exists());
    }

    #[test]
    fn another_layout_or_library_is_refused_with_both_versions() {
        let folder = tempfile::tempdir().unwrap();
        let place = place(&folder);
        let check = |text: &str, found: &str, wanted: &str| {
            fs::write(folder.path().join(CURRENT), text).unwrap();
            let error = place.current().unwrap_err().to_string();
            assert!(error.contains(found) && error.contains(wanted), "{error}");
        };
        check("generation=1\nlayout=77\nlibrary=iceoryx2-0.10.0\n", "77", &LAYOUT_VERSION.to_string());
        let other = format!("generation=1\nlayout={LAYOUT_VERSION}\nlibrary=other-9\n");
        check(&other, "other-9", LIBRARY);
        check("nonsense", "generation", "current");
    }

    #[test]
    fn the_keeper_of_another_build_is_told_with_both_builds() {
        let folder = tempfile::tempdir().unwrap();
        let place = place(&folder);
        place.announce(4).unwrap();
        place.require_own_build().unwrap();
        let own = fs::read_to_string(folder.path().join(CURRENT)).unwrap();
        for other in ["build=0.9.3 (commit unknown)\n", ""] {
            let line = format!("build={}\n", own_build());
            fs::write(folder.path().join(CURRENT), own.replace(&line, other)).unwrap();
            let error = place.require_own_build().unwrap_err().to_string();
            let found = if other.is_empty() { EARLIER } else { "0.9.3 (commit unknown)" };
            assert!(error.contains(found) && error.contains(own_build()), "{error}");
            assert_eq!(place.current().unwrap(), Some(4), "a robot's own program may use it");
        }
    }

    #[test]
    fn a_generation_is_removed_only_when_it_has_no_member() {
        let folder = tempfile::tempdir().unwrap();
        let place = place(&folder);
        fs::create_dir(place.folder_of(7)).unwrap();
        let member_lock = place.join_members(7).unwrap();
        assert!(place.has_members(7).unwrap() && !place.remove(7).unwrap());
        assert_eq!(place.numbers().unwrap(), [7]);
        drop(member_lock);
        assert!(!place.has_members(7).unwrap() && place.remove(7).unwrap());
        assert_eq!(place.numbers().unwrap(), []);
    }

    #[test]
    fn files_of_other_users_are_no_part_of_a_generation_and_not_in_its_way() {
        let folder = tempfile::tempdir().unwrap();
        let prefix = format!("gpf{:x}_", std::process::id());
        let place = Place::new(&prefix, folder.path()).unwrap();
        let path = |name: &str| Path::new(SHARED_MEMORY).join(format!("{prefix}{name}"));
        let names = ["9_x", "1_x.dynamic", "2_x", "18446744073709551615_x"];
        let Some(_files) = names.map(|name| foreign_file(&path(name), 0o644)).into_iter().collect::<Option<Vec<_>>>()
        else {
            return;
        };
        assert_eq!((place.numbers().unwrap(), place.next_number(None).unwrap()), (vec![], 3));
        assert_eq!(place.next_number(Some(8)).unwrap(), 10);
        assert!(place.segments_of(1, ".dynamic").unwrap().is_empty());
        place.keep_others_out().unwrap();
        place.remove_empty_segments(Duration::ZERO).unwrap();
        assert!(place.remove(9).unwrap());
        for name in names {
            assert_eq!(fs::metadata(path(name)).unwrap().mode() & 0o777, 0o644, "{name}");
        }
    }

    #[test]
    fn there_is_one_keeper() {
        let folder = tempfile::tempdir().unwrap();
        let place = place(&folder);
        let keeper = place.lock_as_keeper().unwrap();
        assert!(keeper.is_some() && place.lock_as_keeper().unwrap().is_none());
        drop(keeper);
        assert!(place.lock_as_keeper().unwrap().is_some());
    }
}
