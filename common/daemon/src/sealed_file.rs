//! Files that are kept twice: as people and programs read them, and sealed beside with a hash.
//!
//! The sealed file is `NAME.sealed`: a line with the SHA-256 of the content, and the content. What it says counts. Any damage of
//! one of the two files, also its removal, is mended from the other. A file without a sealed one, as of a backup, counts as it is.
//!
//! The next sealed file is written first, as `NAME.next`; then the open one is replaced, and `NAME.next` becomes the sealed one.
//! An open file that is as `NAME.next` says was not changed by anybody: its writer died between the two.

use crate::replaced_file::{folder_of, rename_durably, write_ahead, write_durably};
use sha2::{Digest, Sha256};
use std::ffi::OsString;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

/// What the two files say.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Sealed {
    /// Neither is there.
    Nothing,
    /// The content, as both have it.
    Intact(Vec<u8>),
    /// The content of a writer that died before it was sealed.
    Unfinished(Vec<u8>),
    /// The content, of which there is no sealed file: somebody has put it there.
    Unsealed(Vec<u8>),
    /// The content of the file that is intact, and a sentence about the other.
    Mended(Vec<u8>, String),
    /// Neither is known to be intact; why, in a sentence.
    Damaged(String),
}

/// Replaces both files: when this returns they are on disk. After a death on the way either content counts, and nothing is told.
///
/// # Errors
/// The file system refuses.
pub(crate) fn write_sealed(path: &Path, content: &[u8]) -> io::Result<()> {
    let next = next_path(path);
    write_ahead(&next, &[hash_line(content).as_bytes(), content].concat())?;
    write_durably(path, content)?;
    rename_durably(&next, &sealed_path(path))
}

/// What was written last. Nothing is written.
///
/// # Errors
/// The file system refuses.
pub(crate) fn read_sealed(path: &Path) -> io::Result<Sealed> {
    let mut files = Files::read(path)?;
    // While another process writes they may disagree: what is told of them was read twice.
    loop {
        let sealed = files.sealed(path);
        if matches!(sealed, Sealed::Intact(_)) {
            return Ok(sealed);
        }
        let again = Files::read(path)?;
        if again == files {
            return Ok(sealed);
        }
        files = again;
    }
}

/// The bytes of the three files; `None` for one that is not there.
#[derive(PartialEq)]
struct Files {
    open: Option<Vec<u8>>,
    sealed: Option<Vec<u8>>,
    next: Option<Vec<u8>>,
}

impl Files {
    fn read(path: &Path) -> io::Result<Self> {
        Ok(Self { open: existing(path)?, sealed: existing(&sealed_path(path))?, next: existing(&next_path(path))? })
    }

    /// What they say of the file of this path.
    fn sealed(&self, path: &Path) -> Sealed {
        let (line, content) = match (&self.open, &self.sealed) {
            (None, None) => return Sealed::Nothing,
            (Some(open), None) if !self.is_next(open) => return Sealed::Unsealed(open.clone()),
            (_, sealed) => split(sealed.as_deref().unwrap_or_default()),
        };
        let is_sealed = |content: &[u8]| hash_line(content).as_bytes() == line;
        match &self.open {
            Some(open) if is_sealed(open) && open == content => Sealed::Intact(open.clone()),
            Some(open) if self.is_next(open) => Sealed::Unfinished(open.clone()),
            open if is_sealed(content) => {
                let what = if open.is_some() { "was changed or damaged" } else { "was removed" };
                Sealed::Mended(content.to_vec(), format!("state {} {what}: what was saved last stays", path.display()))
            }
            Some(open) if is_sealed(open) || (open == content && is_hash_line(line)) => {
                let name = sealed_path(path);
                Sealed::Mended(open.clone(), format!("state {} was damaged: what was saved last stays", name.display()))
            }
            _ => Sealed::Damaged(format!("neither it nor {} is what was saved", sealed_path(path).display())),
        }
    }

    /// True if the open file is what its writer was about to seal.
    fn is_next(&self, open: &[u8]) -> bool {
        let Some((line, content)) = self.next.as_deref().map(split) else { return false };
        open == content && hash_line(content).as_bytes() == line
    }
}

/// The content of a file that another daemon may write at this moment: what it wrote last counts.
///
/// # Errors
/// There is no such file, it is damaged, or the file system refuses.
pub(crate) fn sealed_content(path: &Path) -> io::Result<Vec<u8>> {
    match read_sealed(path)? {
        Sealed::Nothing => Err(io::ErrorKind::NotFound.into()),
        Sealed::Intact(content)
        | Sealed::Unfinished(content)
        | Sealed::Unsealed(content)
        | Sealed::Mended(content, _) => Ok(content),
        Sealed::Damaged(why) => Err(io::Error::new(io::ErrorKind::InvalidData, why)),
    }
}

/// Removes the files, if they are there: when this returns that is on disk.
///
/// # Errors
/// The file system refuses.
pub(crate) fn remove_sealed(path: &Path) -> io::Result<()> {
    let mut was_there = false;
    // What is sealed would bring the other one back.
    for path in [&next_path(path), &sealed_path(path), path] {
        match fs::remove_file(path) {
            Ok(()) => was_there = true,
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            Err(error) => return Err(error),
        }
    }
    if was_there { File::open(folder_of(path))?.sync_all() } else { Ok(()) }
}

/// The sealed file of a file.
pub(crate) fn sealed_path(path: &Path) -> PathBuf {
    with_suffix(path, ".sealed")
}

/// What the sealed file is until the open one is replaced.
fn next_path(path: &Path) -> PathBuf {
    with_suffix(path, ".next")
}

fn with_suffix(path: &Path, suffix: &str) -> PathBuf {
    let mut name = OsString::from(path);
    name.push(suffix);
    PathBuf::from(name)
}

fn hash_line(content: &[u8]) -> String {
    let digits: String = Sha256::digest(content).iter().map(|byte| format!("{byte:02x}")).collect();
    format!("sha256 {digits}\n")
}

/// True for a line of the length of one with a hash: a file that was cut off has none.
fn is_hash_line(line: &[u8]) -> bool {
    line.len() == hash_line(b"").len()
}

/// The line with the hash, or what there is of it, and what follows.
fn split(sealed: &[u8]) -> (&[u8], &[u8]) {
    sealed.split_at(sealed.len().min(hash_line(b"").len()))
}

fn existing(path: &Path) -> io::Result<Option<Vec<u8>>> {
    match fs::read(path) {
        Ok(bytes) => Ok(Some(bytes)),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn any_flipped_bit_of_one_file_changes_nothing_and_is_told() {
        let home = tempfile::tempdir().unwrap();
        let path = home.path().join("robot.json");
        write_sealed(&path, b"{\"robot\":\"legged\"}").unwrap();
        for file in [path.clone(), sealed_path(&path)] {
            let intact = fs::read(&file).unwrap();
            for bit in 0..8 * intact.len() {
                let mut bytes = intact.clone();
                bytes[bit / 8] ^= 1 << (bit % 8);
                fs::write(&file, bytes).unwrap();
                let Sealed::Mended(content, why) = read_sealed(&path).unwrap() else { panic!("bit {bit}") };
                assert_eq!(content, b"{\"robot\":\"legged\"}");
                assert!(why.contains(file.to_str().unwrap()), "{why}");
            }
            fs::write(&file, intact).unwrap();
        }
        assert!(matches!(read_sealed(&path).unwrap(), Sealed::Intact(_)));
    }

    #[test]
    fn a_removed_file_comes_back_and_one_that_is_put_there_counts() {
        let home = tempfile::tempdir().unwrap();
        let path = home.path().join("date.json");
        assert_eq!(read_sealed(&path).unwrap(), Sealed::Nothing);
        fs::write(&path, "old").unwrap();
        assert_eq!(read_sealed(&path).unwrap(), Sealed::Unsealed(b"old".to_vec()));
        write_sealed(&path, b"new").unwrap();
        fs::remove_file(&path).unwrap();
        let Sealed::Mended(content, why) = read_sealed(&path).unwrap() else { panic!() };
        assert!(content == b"new" && why.contains("was removed"), "{why}");
        remove_sealed(&path).unwrap();
        assert_eq!(read_sealed(&path).unwrap(), Sealed::Nothing);
    }

    /// The files of a state in which a writer of "new" died after so many of its steps; "old" was saved before.
    fn died_after(steps: usize) -> (tempfile::TempDir, PathBuf) {
        let home = tempfile::tempdir().unwrap();
        let path = home.path().join("plan_time.json");
        write_sealed(&path, b"old").unwrap();
        let writes: [&dyn Fn(); 3] = [
            &|| write_ahead(&next_path(&path), &[hash_line(b"new").as_bytes(), b"new"].concat()).unwrap(),
            &|| write_durably(&path, b"new").unwrap(),
            &|| rename_durably(&next_path(&path), &sealed_path(&path)).unwrap(),
        ];
        writes[..steps].iter().for_each(|write| write());
        (home, path)
    }

    #[test]
    fn a_writer_that_dies_at_any_step_leaves_no_damage_to_tell_of() {
        let old_and_new = [0, 1, 2, 3].map(|steps| {
            let (_home, path) = died_after(steps);
            read_sealed(&path).unwrap()
        });
        let content = |content: &[u8]| content.to_vec();
        let (old, new) = (Sealed::Intact(content(b"old")), Sealed::Intact(content(b"new")));
        assert_eq!(old_and_new, [old.clone(), old, Sealed::Unfinished(content(b"new")), new]);
    }

    #[test]
    fn what_an_operator_writes_after_such_a_death_is_told() {
        for steps in [1, 2] {
            let (_home, path) = died_after(steps);
            fs::write(&path, "by hand").unwrap();
            let Sealed::Mended(content, why) = read_sealed(&path).unwrap() else { panic!("{steps}") };
            assert!(content == b"old" && why.contains("was changed"), "{why}");
        }
    }

    #[test]
    fn a_reader_beside_a_writer_never_tells_of_damage() {
        let home = tempfile::tempdir().unwrap();
        let path = home.path().join("plan_time.json");
        write_sealed(&path, b"0").unwrap();
        std::thread::scope(|scope| {
            let writer =
                scope.spawn(|| (1..200).for_each(|n: u32| write_sealed(&path, n.to_string().as_bytes()).unwrap()));
            while !writer.is_finished() {
                let read = read_sealed(&path).unwrap();
                assert!(matches!(read, Sealed::Intact(_) | Sealed::Unfinished(_)), "{read:?}");
            }
        });
    }

    proptest! {
        #[test]
        fn nothing_but_what_was_saved_is_read(
            content in prop::collection::vec(any::<u8>(), 0..40),
            open in prop::option::of(prop::collection::vec(any::<u8>(), 0..40)),
            n_sealed in 0_usize..120,
        ) {
            let home = tempfile::tempdir().unwrap();
            let path = home.path().join("x");
            write_sealed(&path, &content).unwrap();
            match &open {
                Some(open) => fs::write(&path, open).unwrap(),
                None => fs::remove_file(&path).unwrap(),
            }
            let sealed = fs::read(sealed_path(&path)).unwrap();
            fs::write(sealed_path(&path), &sealed[..n_sealed.min(sealed.len())]).unwrap();
            match read_sealed(&path).unwrap() {
                Sealed::Intact(read) | Sealed::Mended(read, _) => {
                    let is_as_in_the_other = open.as_ref() == Some(&read) && sealed[..n_sealed.min(sealed.len())].ends_with(&read);
                    prop_assert!(read == content || is_as_in_the_other);
                }
                Sealed::Damaged(_) => {}
                other => prop_assert!(false, "{:?}", other),
            }
        }
    }
}
