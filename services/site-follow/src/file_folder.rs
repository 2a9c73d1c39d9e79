//! Exported files on the disk of a robot, for programs beside it: whole sets of them, and a link to the one of the maps that are shown.
//!
//! ```text
//! FOLDER/current          a link to the set of the maps that are shown, to be followed once for all files; none while it is not here
//! FOLDER/sets/SHA256/     the files of a list, by its sha256
//! FOLDER/blobs/SHA256     their bytes, which sets have in common
//! ```

use messages::ContentId;
use replica::{BlobEntry, FileList, RobotFiles};
use std::collections::BTreeSet;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::os::unix::fs::{MetadataExt, OpenOptionsExt, PermissionsExt, symlink};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

const CURRENT: &str = "current";
const SETS: &str = "sets";
const BLOBS: &str = "blobs";

/// Begins the names of what is not whole.
const UNFINISHED: &str = ".new-";

/// Everybody on the machine may read, nobody writes: sets have files in common.
const FILE_MODE: u32 = 0o444;
const FOLDER_MODE: u32 = 0o755;

/// The folder. Sets are made by one thread; the link is set by one.
#[derive(Debug)]
pub struct FileFolder {
    folder: PathBuf,
    /// Why the link could not be set; why files are not here.
    trouble: Mutex<(Option<String>, Option<String>)>,
    /// Blobs that hold what their names say, as this process has seen.
    intact: Mutex<BTreeSet<ContentId>>,
}

impl FileFolder {
    /// The folder. Of the time before nothing is shown, because no maps are yet.
    pub(crate) fn at(folder: &Path) -> Self {
        let files = Self { folder: folder.to_owned(), trouble: Mutex::default(), intact: Mutex::default() };
        if files.shown().is_some() {
            files.tell(files.unlink());
        }
        files
    }

    /// Makes the folder where it is missing.
    ///
    /// # Errors
    /// It cannot be made, or something of others lies in the way.
    pub(crate) fn make(&self) -> io::Result<()> {
        let folder = &self.folder;
        for path in [folder.clone(), folder.join(SETS), folder.join(BLOBS)] {
            if !path.is_dir() {
                fs::create_dir_all(&path)?;
                fs::set_permissions(&path, fs::Permissions::from_mode(FOLDER_MODE))?;
            }
        }
        let link = folder.join(CURRENT);
        if link.symlink_metadata().is_ok_and(|found| !found.is_symlink()) {
            let why = format!("{} is no link of groundplan: move it away", link.display());
            return Err(io::Error::new(io::ErrorKind::AlreadyExists, why));
        }
        Ok(())
    }

    fn set(&self, list: ContentId) -> PathBuf {
        self.folder.join(SETS).join(list.to_string())
    }

    fn blob(&self, id: ContentId) -> PathBuf {
        self.folder.join(BLOBS).join(id.to_string())
    }

    /// True if the files of a list are here as a whole.
    pub(crate) fn has(&self, files: &RobotFiles) -> bool {
        self.set(files.list.id).is_dir()
    }

    /// Puts the files of a list together; `fetch` brings a blob that is not here. What it brings is checked by its sha256.
    ///
    /// # Errors
    /// Those of `fetch`; the disk refuses; bytes with another sha256.
    pub(crate) fn complete<E: From<io::Error>>(
        &self,
        id: ContentId,
        list: &FileList,
        mut fetch: impl FnMut(BlobEntry) -> Result<Vec<u8>, E>,
    ) -> Result<(), E> {
        let blobs: BTreeSet<(ContentId, u64)> = list.files().iter().map(|file| (file.id, file.bytes)).collect();
        for (id, bytes) in blobs {
            if !self.is_intact(id) {
                self.put(id, &fetch(BlobEntry { id, bytes })?)?;
            }
        }
        Ok(self.assemble(id, list)?)
    }

    /// True if a blob is here, and holds what its name says.
    fn is_intact(&self, id: ContentId) -> bool {
        let path = self.blob(id);
        let mut intact = self.intact.lock().unwrap_or_else(PoisonError::into_inner);
        if intact.contains(&id) && path.is_file() {
            return true;
        }
        let is_intact = fs::read(path).is_ok_and(|bytes| ContentId::of(&bytes) == id);
        if is_intact {
            intact.insert(id);
        }
        is_intact
    }

    fn put(&self, id: ContentId, bytes: &[u8]) -> io::Result<()> {
        if ContentId::of(bytes) != id {
            return Err(io::Error::new(
                io::ErrorKind::InvalidData,
                "an exported file has another sha256 than its list says",
            ));
        }
        let (beside, path) = (self.folder.join(BLOBS).join(format!("{UNFINISHED}{id}")), self.blob(id));
        drop(fs::remove_file(&beside));
        let mut file = OpenOptions::new().write(true).create_new(true).mode(FILE_MODE).open(&beside)?;
        file.set_permissions(fs::Permissions::from_mode(FILE_MODE))?;
        file.write_all(bytes)?;
        file.sync_all()?;
        fs::rename(&beside, &path)
    }

    /// Makes a set of blobs that are all here. It has its name once all of it is on the disk.
    fn assemble(&self, id: ContentId, list: &FileList) -> io::Result<()> {
        let (beside, whole) = (self.folder.join(SETS).join(format!("{UNFINISHED}{id}")), self.set(id));
        if beside.exists() {
            fs::remove_dir_all(&beside)?;
        }
        let mut folders = BTreeSet::from([beside.clone()]);
        for file in list.files() {
            let path = beside.join(&file.path);
            folders.extend(path.ancestors().skip(1).take_while(|above| above.starts_with(&beside)).map(Path::to_owned));
        }
        for folder in &folders {
            fs::create_dir(folder)?;
            fs::set_permissions(folder, fs::Permissions::from_mode(FOLDER_MODE))?;
        }
        for file in list.files() {
            let (blob, path) = (self.blob(file.id), beside.join(&file.path));
            // Not all file systems have links.
            if fs::hard_link(&blob, &path).is_err() {
                fs::copy(&blob, &path)?;
                File::open(&path)?.sync_all()?;
            }
        }
        // What is in a folder first, its name in the one above last.
        for folder in folders.iter().rev() {
            File::open(folder)?.sync_all()?;
        }
        File::open(self.folder.join(BLOBS))?.sync_all()?;
        fs::rename(&beside, &whole)?;
        File::open(self.folder.join(SETS))?.sync_all()
    }

    /// The set that the link names.
    fn shown(&self) -> Option<ContentId> {
        fs::read_link(self.folder.join(CURRENT)).ok()?.file_name()?.to_str()?.parse().ok()
    }

    /// Lets the link name the files of the maps that are shown, if they are here, and nothing else: files of another date never.
    pub(crate) fn show(&self, files: Option<&RobotFiles>) {
        let wanted = files.filter(|files| self.has(files)).map(|files| files.list.id);
        if self.shown() == wanted {
            self.tell(Ok(()));
            return;
        }
        self.tell(match wanted {
            Some(list) => self.link(list),
            None => self.unlink(),
        });
    }

    /// Before maps of another date are shown: the link names no files but those. Maps do not wait for a link that cannot be removed: it
    /// is told.
    pub(crate) fn withdraw_unless(&self, files: Option<&RobotFiles>) {
        let shown = self.shown();
        if shown.is_some() && shown != files.map(|files| files.list.id) {
            self.tell(self.unlink());
        }
    }

    fn tell(&self, linked: io::Result<()>) {
        let why = linked.err().map(|why| format!("{}: {why}", self.folder.join(CURRENT).display()));
        self.lock().0 = why;
    }

    /// Tells why files of an index are not here; `None` if they are.
    pub(crate) fn tell_fetched(&self, why: Option<String>) {
        self.lock().1 = why.map(|why| format!("exported files are not here: {why}"));
    }

    fn lock(&self) -> MutexGuard<'_, (Option<String>, Option<String>)> {
        self.trouble.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn unlink(&self) -> io::Result<()> {
        match fs::remove_file(self.folder.join(CURRENT)) {
            Err(why) if why.kind() != io::ErrorKind::NotFound => Err(why),
            _ => File::open(&self.folder)?.sync_all(),
        }
    }

    fn link(&self, list: ContentId) -> io::Result<()> {
        let beside = self.folder.join(format!("{UNFINISHED}{CURRENT}"));
        drop(fs::remove_file(&beside));
        symlink(Path::new(SETS).join(list.to_string()), &beside)?;
        fs::rename(&beside, self.folder.join(CURRENT))?;
        File::open(&self.folder)?.sync_all()
    }

    /// Why the link, or what it is to name, is not as it should be.
    pub(crate) fn trouble(&self) -> Option<String> {
        let trouble = self.lock();
        trouble.0.clone().or(trouble.1.clone())
    }

    /// Removes all sets but these and the one that is shown, then blobs that no set has. What has other names is not its own.
    pub(crate) fn retain(&self, keep: &BTreeSet<ContentId>) {
        let shown = self.shown();
        // Its entries with what they hold; of what is not whole there is nothing to say.
        let own = |folder: &str| {
            let entries = fs::read_dir(self.folder.join(folder)).into_iter().flatten().flatten();
            let own = entries.filter_map(|entry| {
                let (name, path) = (entry.file_name(), entry.path());
                let name = name.to_str()?;
                let id: Option<ContentId> = name.parse().ok();
                (id.is_some() || name.starts_with(UNFINISHED)).then_some((id, path))
            });
            own.collect::<Vec<_>>()
        };
        for (list, path) in own(SETS) {
            if list.is_none_or(|list| !keep.contains(&list) && shown != Some(list)) {
                drop(fs::remove_dir_all(path));
            }
        }
        for (_, path) in own(BLOBS) {
            if path.symlink_metadata().is_ok_and(|file| file.nlink() == 1) {
                drop(fs::remove_file(path));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use replica::FileEntry;
    use std::collections::BTreeMap;

    struct Fixture {
        home: tempfile::TempDir,
        store: BTreeMap<ContentId, Vec<u8>>,
        fetched: usize,
    }

    impl Fixture {
        fn new() -> (Self, FileFolder) {
            let home = tempfile::tempdir().unwrap();
            let folder = FileFolder::at(&home.path().join("files"));
            folder.make().unwrap();
            (Self { home, store: BTreeMap::new(), fetched: 0 }, folder)
        }

        fn current(&self) -> PathBuf {
            self.home.path().join("files/current")
        }

        /// A list of files in the store.
        fn list(&mut self, files: &[(&str, &str)]) -> (RobotFiles, FileList) {
            let mut entries = Vec::new();
            for (path, text) in files {
                let (id, bytes) = (ContentId::of(text.as_bytes()), text.len() as u64);
                self.store.insert(id, text.as_bytes().to_vec());
                entries.push(FileEntry { path: (*path).to_owned(), id, bytes });
            }
            let list = FileList::of(entries).unwrap();
            let blob = BlobEntry { id: ContentId::of(&list.to_bytes()), bytes: list.to_bytes().len() as u64 };
            let (bytes, made_with) = (list.bytes(), ContentId::of(b""));
            (RobotFiles { list: blob, bytes, made_with, vda5050_maps: None }, list)
        }

        fn complete(&mut self, folder: &FileFolder, files: &RobotFiles, list: &FileList) -> io::Result<()> {
            folder.complete(files.list.id, list, |blob| {
                self.fetched += 1;
                self.store.get(&blob.id).cloned().ok_or_else(|| io::Error::other("the store has lost it"))
            })
        }
    }

    #[test]
    fn the_link_names_the_files_of_the_maps_that_are_shown_or_none() {
        let (mut f, folder) = Fixture::new();
        let (first, list) = f.list(&[("manifest.json", "1"), ("storeys/00/planning.pgm", "wall")]);
        folder.show(Some(&first));
        assert!(!f.current().is_symlink(), "they are not here");
        f.complete(&folder, &first, &list).unwrap();
        assert!(!f.current().exists(), "what is here is not shown by that");
        folder.show(Some(&first));
        assert_eq!(fs::read_to_string(f.current().join("storeys/00/planning.pgm")).unwrap(), "wall");
        // The next date shares a file.
        let (second, list) = f.list(&[("manifest.json", "2"), ("storeys/00/planning.pgm", "wall")]);
        f.fetched = 0;
        f.complete(&folder, &second, &list).unwrap();
        assert_eq!(f.fetched, 1);
        folder.withdraw_unless(Some(&first));
        assert!(f.current().exists(), "the same maps again");
        folder.withdraw_unless(Some(&second));
        assert!(!f.current().is_symlink(), "between two dates there are none");
        folder.show(Some(&second));
        assert_eq!(fs::read_to_string(f.current().join("manifest.json")).unwrap(), "2");
        folder.show(None);
        assert!(!f.current().is_symlink());
        assert_eq!(folder.trouble(), None);
    }

    #[test]
    fn what_breaks_off_is_no_set_and_is_taken_up_again() {
        let (mut f, folder) = Fixture::new();
        let (files, list) = f.list(&[("a", "one"), ("b/c", "two")]);
        // Blobs are fetched in the order of their names: the last one is lost.
        let (last, bytes) = f.store.pop_last().unwrap();
        assert!(f.complete(&folder, &files, &list).is_err() && !folder.has(&files));
        // A death while the set was assembled.
        fs::create_dir_all(f.home.path().join(format!("files/sets/{UNFINISHED}{}/b", files.list.id))).unwrap();
        f.store.insert(last, b"other".to_vec());
        let why = f.complete(&folder, &files, &list).unwrap_err().to_string();
        assert!(why.contains("another sha256"), "{why}");
        f.store.insert(last, bytes);
        f.fetched = 0;
        f.complete(&folder, &files, &list).unwrap();
        assert!(folder.has(&files) && f.fetched == 1);
    }

    #[test]
    fn blobs_that_were_changed_are_fetched_again() {
        let (mut f, folder) = Fixture::new();
        let (first, list) = f.list(&[("a", "one")]);
        f.complete(&folder, &first, &list).unwrap();
        let blob = f.home.path().join("files/blobs").join(ContentId::of(b"one").to_string());
        fs::remove_file(&blob).unwrap();
        fs::write(&blob, "uno").unwrap();
        let (second, list) = f.list(&[("a", "one"), ("b", "two")]);
        f.complete(&folder, &second, &list).unwrap();
        folder.show(Some(&second));
        assert_eq!(fs::read_to_string(f.current().join("a")).unwrap(), "one");
    }

    #[test]
    fn what_no_index_names_goes_but_never_what_is_shown() {
        let (mut f, folder) = Fixture::new();
        let (first, list) = f.list(&[("a", "one"), ("b", "both")]);
        f.complete(&folder, &first, &list).unwrap();
        let (second, list) = f.list(&[("a", "two"), ("b", "both")]);
        f.complete(&folder, &second, &list).unwrap();
        folder.show(Some(&first));
        folder.retain(&BTreeSet::from([second.list.id]));
        assert!(folder.has(&first) && folder.has(&second));
        folder.show(Some(&second));
        folder.retain(&BTreeSet::from([second.list.id]));
        assert!(!folder.has(&first) && folder.has(&second));
        assert_eq!(fs::read_dir(f.home.path().join("files/blobs")).unwrap().count(), 2);
    }

    #[test]
    fn a_folder_of_others_is_refused() {
        let home = tempfile::tempdir().unwrap();
        fs::create_dir(home.path().join(CURRENT)).unwrap();
        assert!(FileFolder::at(home.path()).make().unwrap_err().to_string().contains("no link of groundplan"));
    }

    #[test]
    fn a_link_that_cannot_be_set_is_told_until_it_can() {
        let (mut f, folder) = Fixture::new();
        let (files, list) = f.list(&[("a", "one")]);
        f.complete(&folder, &files, &list).unwrap();
        fs::create_dir(f.current()).unwrap();
        folder.withdraw_unless(None);
        folder.show(Some(&files));
        assert!(folder.trouble().unwrap().contains("files/current"), "{:?}", folder.trouble());
        fs::remove_dir(f.current()).unwrap();
        folder.show(Some(&files));
        assert_eq!((folder.trouble(), f.current().join("a").is_file()), (None, true));
        folder.tell_fetched(Some("the store has lost it".to_owned()));
        assert_eq!(folder.trouble().unwrap(), "exported files are not here: the store has lost it");
    }
}
