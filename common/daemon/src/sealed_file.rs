//! Files that are kept twice: as people and programs read them, and sealed beside with a hash.
//!
//! The sealed file is `NAME.sealed`: a line with the SHA-256 of the content, and the content. It is written last, and what it
//! says counts. Any damage of one of the two files, also its removal, is mended from the other. A file without a sealed one is
//! of an earlier version.

use crate::replaced_file::write_durably;
use sha2::{Digest, Sha256};
use std::ffi::OsString;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// What the two files say.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Sealed {
    /// Neither is there.
    Nothing,
    /// The content, as both have it.
    Intact(Vec<u8>),
    /// The content, as an earlier version wrote it: there is no sealed file.
    OfEarlierVersion(Vec<u8>),
    /// The content of the file that is intact, and a sentence about the other.
    Mended(Vec<u8>, String),
    /// Neither is known to be intact; why, in a sentence.
    Damaged(String),
}

/// Replaces both files: when this returns they are on disk. After a death between the two the earlier content counts.
///
/// # Errors
/// The file system refuses; the earlier content counts.
pub(crate) fn write_sealed(path: &Path, content: &[u8]) -> io::Result<()> {
    write_durably(path, content)?;
    write_durably(&sealed_path(path), &[hash_line(content).as_bytes(), content].concat())
}

/// What was written last. Nothing is written.
///
/// # Errors
/// The file system refuses.
pub(crate) fn read_sealed(path: &Path) -> io::Result<Sealed> {
    let sealed_path = sealed_path(path);
    let (open, sealed) = (existing(path)?, existing(&sealed_path)?);
    let name = path.display();
    let (line, content) = match (&open, &sealed) {
        (None, None) => return Ok(Sealed::Nothing),
        (Some(open), None) => return Ok(Sealed::OfEarlierVersion(open.clone())),
        (_, Some(sealed)) => split(sealed),
    };
    let is_sealed = |content: &[u8]| hash_line(content).as_bytes() == line;
    Ok(match open {
        Some(open) if is_sealed(&open) && open == content => Sealed::Intact(open),
        open if is_sealed(content) => {
            let what = if open.is_some() { "was changed or damaged" } else { "was removed" };
            Sealed::Mended(content.to_vec(), format!("state {name} {what}: what was saved last stays"))
        }
        Some(open) if is_sealed(&open) || (open == content && is_hash_line(line)) => {
            Sealed::Mended(open, format!("state {} was damaged: what was saved last stays", sealed_path.display()))
        }
        _ => Sealed::Damaged(format!("neither it nor {} is what was saved", sealed_path.display())),
    })
}

/// The content of a file that another daemon may write at this moment: what it wrote last counts.
///
/// # Errors
/// There is no such file, it is damaged, or the file system refuses.
pub(crate) fn sealed_content(path: &Path) -> io::Result<Vec<u8>> {
    match read_sealed(path)? {
        Sealed::Nothing => Err(io::ErrorKind::NotFound.into()),
        Sealed::Intact(content) | Sealed::OfEarlierVersion(content) | Sealed::Mended(content, _) => Ok(content),
        Sealed::Damaged(why) => Err(io::Error::new(io::ErrorKind::InvalidData, why)),
    }
}

/// Removes both files, if they are there.
///
/// # Errors
/// The file system refuses.
pub(crate) fn remove_sealed(path: &Path) -> io::Result<()> {
    // What is sealed would bring the other one back.
    for path in [&sealed_path(path), path] {
        match fs::remove_file(path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
            _ => {}
        }
    }
    Ok(())
}

/// The sealed file of a file.
pub(crate) fn sealed_path(path: &Path) -> PathBuf {
    let mut name = OsString::from(path);
    name.push(".sealed");
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
    fn a_removed_file_comes_back_and_that_of_an_earlier_version_counts() {
        let home = tempfile::tempdir().unwrap();
        let path = home.path().join("date.json");
        assert_eq!(read_sealed(&path).unwrap(), Sealed::Nothing);
        fs::write(&path, "old").unwrap();
        assert_eq!(read_sealed(&path).unwrap(), Sealed::OfEarlierVersion(b"old".to_vec()));
        write_sealed(&path, b"new").unwrap();
        fs::remove_file(&path).unwrap();
        let Sealed::Mended(content, why) = read_sealed(&path).unwrap() else { panic!() };
        assert!(content == b"new" && why.contains("was removed"), "{why}");
        remove_sealed(&path).unwrap();
        assert_eq!(read_sealed(&path).unwrap(), Sealed::Nothing);
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
