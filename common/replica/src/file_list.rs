//! Lists of exported files: paths in an output folder, and the blobs that have their bytes.

use crate::index::{BlobEntry, Form};
use messages::ContentId;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

/// Most files of a list.
const MAX_FILES: usize = 1 << 16;

/// Longest path.
const MAX_PATH_BYTES: usize = 512;

/// Most bytes of all files of a list.
const MAX_BYTES: u64 = 64 << 30;

/// The form of lists that this version reads and writes.
const FORMAT: u32 = 1;

/// A longer list is not read.
pub const MAX_FILE_LIST_BYTES: u64 = 48 << 20;

/// Longest file that is exported into a store: a map of the largest grid needs a quarter of it.
pub const MAX_FILE_BYTES: u64 = 1 << 30;

/// Exported files, in the order of their paths.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FileList {
    /// Version of this form.
    format: u32,
    files: Vec<FileEntry>,
}

/// An exported file.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FileEntry {
    /// Path in the output folder, with `/`.
    pub path: String,
    /// sha256 of its bytes, which is the name of its blob.
    pub id: ContentId,
    /// Its length.
    pub bytes: u64,
}

/// A list that cannot be.
#[derive(Debug, thiserror::Error)]
pub enum BadFileList {
    /// Not a list.
    #[error("the list of exported files cannot be read")]
    Json(#[from] serde_json::Error),
    /// Written by another version.
    #[error("the list of exported files has the form {found}, this version reads {FORMAT}")]
    Form {
        /// Its form.
        found: u32,
    },
    /// A path that leads elsewhere, or is that of two files.
    #[error("the list of exported files has a path that no file of it can have: {0:?}")]
    Path(String),
    /// More files, or larger ones, than are exported.
    #[error("the list of exported files has {0}")]
    Size(String),
}

impl FileEntry {
    /// Its blob.
    pub fn blob(&self) -> BlobEntry {
        BlobEntry { id: self.id, bytes: self.bytes }
    }
}

impl FileList {
    /// The list of these files.
    ///
    /// # Errors
    /// Files that no list can have.
    pub fn of(mut files: Vec<FileEntry>) -> Result<Self, BadFileList> {
        files.sort();
        let list = Self { format: FORMAT, files };
        list.check()?;
        Ok(list)
    }

    /// The list of a blob; that the bytes are those that the index names was looked at before.
    ///
    /// # Errors
    /// Bytes that are no list, or one with paths that lead elsewhere.
    pub fn parse(bytes: &[u8]) -> Result<Self, BadFileList> {
        let Form { format: found } = serde_json::from_slice(bytes)?;
        if found != FORMAT {
            return Err(BadFileList::Form { found });
        }
        let list: Self = serde_json::from_slice(bytes)?;
        list.check()?;
        Ok(list)
    }

    fn check(&self) -> Result<(), BadFileList> {
        if self.files.len() > MAX_FILES {
            return Err(BadFileList::Size(format!("{} files, and {MAX_FILES} are the most", self.files.len())));
        }
        if let Some(large) = self.files.iter().find(|file| file.bytes > MAX_FILE_BYTES) {
            let FileEntry { path, bytes, .. } = large;
            return Err(BadFileList::Size(format!("{path:?} with {bytes} bytes, and {MAX_FILE_BYTES} are the most")));
        }
        if self.bytes() > MAX_BYTES {
            return Err(BadFileList::Size(format!("{} bytes, and {MAX_BYTES} are the most", self.bytes())));
        }
        let bad = |path: &str| BadFileList::Path(path.chars().take(MAX_PATH_BYTES).collect());
        let mut folders = BTreeSet::new();
        for (k, FileEntry { path, .. }) in self.files.iter().enumerate() {
            let is_after = k.checked_sub(1).is_none_or(|before| self.files[before].path < *path);
            if !is_after || path.len() > MAX_PATH_BYTES || !path.split('/').all(is_plain_name) {
                return Err(bad(path));
            }
            folders.extend(path.match_indices('/').map(|(at, _)| &path[..at]));
        }
        match self.files.iter().find(|file| folders.contains(file.path.as_str())) {
            Some(file) => Err(bad(&file.path)),
            None => Ok(()),
        }
    }

    /// Its bytes as a blob.
    pub fn to_bytes(&self) -> Vec<u8> {
        serde_json::to_vec(self).expect("a list has no keys but texts")
    }

    /// The files, in the order of their paths.
    pub fn files(&self) -> &[FileEntry] {
        &self.files
    }

    /// The file at a path.
    pub fn file(&self, path: &str) -> Option<&FileEntry> {
        self.files.binary_search_by(|file| file.path.as_str().cmp(path)).ok().map(|place| &self.files[place])
    }

    /// Bytes of all files.
    pub fn bytes(&self) -> u64 {
        self.files.iter().fold(0, |sum, file| sum.saturating_add(file.bytes))
    }
}

/// True if a part of a path names something in its folder, which nobody hides.
fn is_plain_name(name: &str) -> bool {
    !name.is_empty()
        && name.len() < 256
        && !name.starts_with('.')
        && !name.contains(['\\', '\0'])
        && !name.contains(char::is_control)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(path: &str) -> FileEntry {
        FileEntry { path: path.to_owned(), id: ContentId::of(path.as_bytes()), bytes: 3 }
    }

    #[test]
    fn a_list_survives_its_text_in_the_order_of_its_paths() {
        let list = FileList::of(["b.json", "a/c.pgm", "a/b.pgm"].map(file).to_vec()).unwrap();
        let paths: Vec<&str> = list.files().iter().map(|file| file.path.as_str()).collect();
        assert_eq!((paths, list.bytes()), (vec!["a/b.pgm", "a/c.pgm", "b.json"], 9));
        assert_eq!(FileList::parse(&list.to_bytes()).unwrap(), list);
        assert_eq!(list.file("a/c.pgm"), Some(&file("a/c.pgm")));
        assert_eq!(list.file("a"), None);
    }

    #[test]
    fn paths_that_lead_elsewhere_or_are_of_two_files_are_refused() {
        let long = "x".repeat(MAX_PATH_BYTES + 1);
        for bad in ["", "/etc/passwd", "../a", "a/../b", "a//b", "a/", ".hidden", "a/.b", "a\\b", "a\0", "a\nb", &long]
        {
            assert!(matches!(FileList::of(vec![file(bad)]), Err(BadFileList::Path(_))), "{bad:?}");
        }
        for two in [["a", "a"], ["a", "a/b"]] {
            assert!(matches!(FileList::of(two.map(file).to_vec()), Err(BadFileList::Path(_))), "{two:?}");
        }
        // Between a file and what would lie in it there may be others.
        assert!(FileList::of(["a", "a-b", "a/b"].map(file).to_vec()).is_err());
        let unordered = FileList { format: FORMAT, files: ["b", "a"].map(file).to_vec() };
        assert!(FileList::parse(&unordered.to_bytes()).is_err());
    }

    #[test]
    fn lists_of_too_much_or_of_another_form_are_refused() {
        let large = FileEntry { bytes: MAX_FILE_BYTES + 1, ..file("a") };
        assert!(FileList::of(vec![large]).unwrap_err().to_string().contains("\"a\" with 1073741825 bytes"));
        let many = (0..=MAX_FILES).map(|k| file(&format!("{k:06}"))).collect();
        assert!(matches!(FileList::of(many), Err(BadFileList::Size(_))));
        let all = (0..70).map(|k| FileEntry { bytes: MAX_FILE_BYTES, ..file(&format!("{k}")) }).collect();
        assert!(matches!(FileList::of(all), Err(BadFileList::Size(_))));
        let newer = br#"{"format":9,"folders":[]}"#;
        assert!(matches!(FileList::parse(newer), Err(BadFileList::Form { found: 9 })));
        assert!(matches!(FileList::parse(b"[]"), Err(BadFileList::Json(_))));
    }
}
