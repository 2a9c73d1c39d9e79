//! Archives on the disk of a robot, by their sha256: whole ones, and those of which some blocks are here.

use daemon::state_files::FOLLOWED_ARCHIVES;
use messages::{ArchiveBuffer, ContentId};
use replica::{ArchiveEntry, Recipe};
use std::collections::{BTreeSet, HashMap};
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::ops::Range;
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Ends the name of an archive of which some blocks are here.
const PART: &str = "part";

/// Ends the name of the recipe of an archive.
const RECIPE: &str = "recipe";

/// The disk under the archives, which has a word in each change of a file.
pub trait ArchiveDisk: Send + Sync {
    /// Called before each change.
    ///
    /// # Errors
    /// The change fails with this error.
    fn allow(&self, path: &Path) -> io::Result<()>;
}

/// The disk of this machine, which speaks for itself.
#[derive(Debug, Clone, Copy)]
pub struct MachineDisk;

impl ArchiveDisk for MachineDisk {
    fn allow(&self, _: &Path) -> io::Result<()> {
        Ok(())
    }
}

/// The archives of a robot.
#[derive(Clone)]
pub(crate) struct ArchiveFolder {
    folder: PathBuf,
    disk: Arc<dyn ArchiveDisk>,
}

/// An archive that is put together.
pub(crate) struct Part {
    path: PathBuf,
    file: File,
    disk: Arc<dyn ArchiveDisk>,
    /// By block: true if it is here.
    is_here: Vec<bool>,
}

/// Blocks that are here: in which file, and where.
pub(crate) type HeldBlocks = HashMap<ContentId, (PathBuf, Range<u64>)>;

impl ArchiveFolder {
    /// The folder in the state folder, which is made if it is missing.
    ///
    /// # Errors
    /// It cannot be made.
    pub(crate) fn at(state: &Path, disk: Arc<dyn ArchiveDisk>) -> io::Result<Self> {
        let folder = state.join(FOLLOWED_ARCHIVES);
        fs::create_dir_all(&folder)?;
        Ok(Self { folder, disk })
    }

    fn path(&self, id: ContentId) -> PathBuf {
        self.folder.join(id.to_string())
    }

    /// True if an archive is here as a whole.
    pub(crate) fn has(&self, entry: &ArchiveEntry) -> bool {
        fs::metadata(self.path(entry.id)).is_ok_and(|file| file.len() == entry.bytes)
    }

    /// An archive that is here; what it holds is checked when it is opened.
    ///
    /// # Errors
    /// It cannot be read.
    pub(crate) fn read(&self, entry: &ArchiveEntry) -> io::Result<ArchiveBuffer> {
        let length = usize::try_from(entry.bytes).map_err(io::Error::other)?;
        let mut buffer = ArchiveBuffer::zeroed(length);
        File::open(self.path(entry.id))?.read_exact_at(buffer.bytes_mut(), 0)?;
        Ok(buffer)
    }

    /// True if an archive is here, and holds what its name says.
    pub(crate) fn is_intact(&self, entry: &ArchiveEntry) -> bool {
        self.read(entry).is_ok_and(|archive| ContentId::of(archive.bytes()) == entry.id)
    }

    /// Gives up an archive that is damaged.
    pub(crate) fn forget(&self, id: ContentId) {
        for path in [self.path(id), self.path(id).with_extension(RECIPE)] {
            if let Err(why) = self.remove(&path)
                && why.kind() != io::ErrorKind::NotFound
            {
                tracing::warn!(service = "site-follow", path = %path.display(), error = %why, "it cannot be removed");
            }
        }
    }

    /// The blocks of all archives that are here as a whole, by their recipes.
    pub(crate) fn held_blocks(&self) -> HeldBlocks {
        let mut held = HeldBlocks::new();
        for path in fs::read_dir(&self.folder).into_iter().flatten().flatten().map(|entry| entry.path()) {
            let Some(recipe) = path.extension().filter(|end| *end == RECIPE).and_then(|_| fs::read(&path).ok()) else {
                continue;
            };
            let Ok(recipe) = Recipe::parse_any(&recipe) else { continue };
            let archive = path.with_extension("");
            if fs::metadata(&archive).is_ok_and(|file| file.len() == recipe.bytes) {
                for place in 0..recipe.n_blocks() {
                    let (id, range) = recipe.block(place);
                    held.insert(id, (archive.clone(), range));
                }
            }
        }
        held
    }

    /// Begins or resumes an archive: its blocks that are here, in its part or in others, are in their places.
    ///
    /// # Errors
    /// The disk refuses.
    pub(crate) fn begin(&self, recipe: &Recipe, held: &HeldBlocks) -> io::Result<Part> {
        let path = self.path(recipe.id).with_extension(PART);
        self.disk.allow(&path)?;
        let file = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(&path)?;
        self.disk.allow(&path)?;
        file.set_len(recipe.bytes)?;
        let mut part = Part { path, file, disk: Arc::clone(&self.disk), is_here: vec![false; recipe.n_blocks()] };
        for place in 0..recipe.n_blocks() {
            let (id, range) = recipe.block(place);
            let there = read_block(&part.file, &range).filter(|block| ContentId::of(block) == id);
            if there.is_some() {
                part.is_here[place] = true;
                continue;
            }
            let Some((from, at)) = held.get(&id) else { continue };
            let block = File::open(from).ok().and_then(|file| read_block(&file, at));
            if let Some(block) = block.filter(|block| ContentId::of(block) == id) {
                part.put(place, range, &block)?;
            }
        }
        Ok(part)
    }

    /// Makes a part whose blocks are all here the archive.
    ///
    /// # Errors
    /// The disk refuses, or the whole has another sha256 than its recipe says.
    pub(crate) fn finish(&self, part: Part, recipe: &Recipe) -> io::Result<()> {
        let length = usize::try_from(recipe.bytes).map_err(io::Error::other)?;
        let mut whole = vec![0; length];
        part.file.read_exact_at(&mut whole, 0)?;
        if ContentId::of(&whole) != recipe.id {
            drop(self.remove(&part.path));
            return Err(io::Error::new(
                io::ErrorKind::InvalidData,
                "an archive has another sha256 than its recipe says",
            ));
        }
        part.file.sync_all()?;
        let path = self.path(recipe.id);
        let of_recipe = path.with_extension(RECIPE);
        self.disk.allow(&of_recipe)?;
        let mut file = File::create(&of_recipe)?;
        self.disk.allow(&of_recipe)?;
        file.write_all(&recipe.to_bytes())?;
        file.sync_all()?;
        self.disk.allow(&path)?;
        fs::rename(&part.path, &path)?;
        self.disk.allow(&self.folder)?;
        File::open(&self.folder)?.sync_all()
    }

    fn remove(&self, path: &Path) -> io::Result<()> {
        self.disk.allow(path)?;
        fs::remove_file(path)
    }

    /// Removes all archives and parts but these.
    pub(crate) fn retain(&self, keep: &BTreeSet<ContentId>) {
        for path in fs::read_dir(&self.folder).into_iter().flatten().flatten().map(|entry| entry.path()) {
            let id = path.file_stem().and_then(|name| name.to_str()?.parse::<ContentId>().ok());
            if id.is_none_or(|id| !keep.contains(&id)) {
                drop(self.remove(&path));
            }
        }
    }
}

impl Part {
    /// Puts a block in its place.
    ///
    /// # Errors
    /// The disk refuses.
    pub(crate) fn put(&mut self, place: usize, range: Range<u64>, block: &[u8]) -> io::Result<()> {
        self.disk.allow(&self.path)?;
        self.file.write_all_at(block, range.start)?;
        self.is_here[place] = true;
        Ok(())
    }

    /// True if a block is here.
    pub(crate) fn has(&self, place: usize) -> bool {
        self.is_here[place]
    }
}

fn read_block(file: &File, range: &Range<u64>) -> Option<Vec<u8>> {
    let mut block = vec![0; usize::try_from(range.end - range.start).ok()?];
    file.read_exact_at(&mut block, range.start).ok()?;
    Some(block)
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::ContentHash;
    use replica::{pack, unpack_block};

    const BLOCK: usize = 256 << 10;

    fn noise(seed: u64, length: usize) -> Vec<u8> {
        let mut state = seed;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as u8
        };
        (0..length).map(|_| next()).collect()
    }

    /// Fetches what is missing from a pack, at most so many blocks; how many there were.
    fn fetch(recipe: &Recipe, part: &mut Part, pack: &[u8], at_most: usize) -> usize {
        let mut n = 0;
        for fetch in recipe.missing(|place| part.has(place)) {
            let bytes = &pack[fetch.range.start as usize..fetch.range.end as usize];
            for place in &fetch.blocks {
                if n == at_most {
                    return n;
                }
                let (id, range) = recipe.block(*place);
                let block = unpack_block(recipe.part(&fetch, bytes, *place), range.end - range.start, id).unwrap();
                part.put(*place, range, &block).unwrap();
                n += 1;
            }
        }
        n
    }

    #[test]
    fn what_was_fetched_before_a_death_is_not_fetched_again() {
        let home = tempfile::tempdir().unwrap();
        let folder = ArchiveFolder::at(home.path(), Arc::new(MachineDisk)).unwrap();
        let archive = noise(1, 5 * BLOCK + 3);
        let packed = pack(&archive, None);
        let (recipe, bytes) = (packed.recipe, packed.packs.concat());
        let mut part = folder.begin(&recipe, &folder.held_blocks()).unwrap();
        assert_eq!(fetch(&recipe, &mut part, &bytes, 2), 2);
        drop(part);
        // Another process; one of the blocks was half written.
        let path = home.path().join("followed-archives").join(recipe.id.to_string()).with_extension(PART);
        let file = OpenOptions::new().write(true).open(path).unwrap();
        file.write_all_at(b"torn", BLOCK as u64 + 100).unwrap();
        let mut part = folder.begin(&recipe, &folder.held_blocks()).unwrap();
        let n = fetch(&recipe, &mut part, &bytes, usize::MAX);
        assert!(n < recipe.n_blocks(), "{n}");
        folder.finish(part, &recipe).unwrap();
        assert!(folder.has(&recipe.entry(ContentHash::NONE)));
        assert_eq!(folder.read(&recipe.entry(ContentHash::NONE)).unwrap().bytes(), archive);
    }

    #[test]
    fn blocks_of_other_archives_are_taken_from_the_disk() {
        let home = tempfile::tempdir().unwrap();
        let folder = ArchiveFolder::at(home.path(), Arc::new(MachineDisk)).unwrap();
        let mut archive = noise(2, 4 * BLOCK);
        let first = pack(&archive, None);
        let mut part = folder.begin(&first.recipe, &HeldBlocks::new()).unwrap();
        fetch(&first.recipe, &mut part, &first.packs.concat(), usize::MAX);
        folder.finish(part, &first.recipe).unwrap();
        archive[0] ^= 1;
        let second = pack(&archive, Some(&first.recipe));
        let part = folder.begin(&second.recipe, &folder.held_blocks()).unwrap();
        let missing: Vec<usize> = (0..second.recipe.n_blocks()).filter(|place| !part.has(*place)).collect();
        assert_eq!(missing, [0]);
        folder.retain(&BTreeSet::from([second.recipe.id]));
        assert!(!folder.has(&first.recipe.entry(ContentHash::NONE)), "what no index names goes");
    }
}
