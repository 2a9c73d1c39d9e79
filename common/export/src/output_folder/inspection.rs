//! Compares a folder with its manifest: files written by groundplan and foreign files, which are never deleted.

use input_files::{open_regular_file, read_regular_file};
use messages::ContentId;
use serde::Deserialize;
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::fmt;
use std::fs;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

/// Name of the manifest in an output folder.
pub(super) const MANIFEST: &str = "manifest.json";
/// Bytes of the largest manifest that is read; one that lists 100,000 files has about 15 MB.
const MAX_MANIFEST_BYTES: u64 = 256 << 20;
/// Names in a message.
const MAX_NAMED: usize = 8;

/// sha256 by path, as a manifest lists the files of its folder.
pub(super) type ListedFiles = BTreeMap<String, String>;

/// What is in a folder, by who wrote it. Links are never followed.
#[derive(Debug, Default)]
pub(super) struct Inspection {
    /// Files with the content that the manifest lists, and last the manifest itself; paths inside the folder.
    pub(super) own: Vec<PathBuf>,
    /// Folders that hold listed files or once did, each before those inside it; the first is the folder itself.
    own_folders: Vec<PathBuf>,
    /// All other files, links and empty folders, by path.
    pub(super) foreign: ForeignFiles,
}

/// Files in an output folder that are not as its manifest lists them.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ForeignFiles(Vec<ForeignFile>);

/// A file in an output folder that is not as its manifest lists it.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
struct ForeignFile {
    /// Path inside the folder; that of a folder ends with `/`.
    path: String,
    difference: Difference,
}

/// How a file differs from what a manifest lists.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Difference {
    /// It is not listed.
    Added,
    /// It is listed with another content.
    Altered,
    /// It cannot be compared.
    Unreadable,
}

impl ForeignFiles {
    /// True if there is none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    fn add(&mut self, path: String, difference: Difference) {
        self.0.push(ForeignFile { path, difference });
    }
}

impl fmt::Display for ForeignFiles {
    /// The first names, each with what is different, and the number of the others.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (k, file) in self.0.iter().take(MAX_NAMED).enumerate() {
            let word = match file.difference {
                Difference::Added => "added",
                Difference::Altered => "altered",
                Difference::Unreadable => "unreadable",
            };
            let separator = if k == 0 { "" } else { ", " };
            write!(f, "{separator}{} ({word})", file.path)?;
        }
        match self.0.len().saturating_sub(MAX_NAMED) {
            0 => Ok(()),
            n => write!(f, " and {n} more"),
        }
    }
}

/// The files that the manifest of a folder lists; `None` if it has no manifest of groundplan.
///
/// A manifest that cannot be read or parsed is that of another program.
pub(super) fn listed_files(folder: &Path) -> Option<ListedFiles> {
    #[derive(Deserialize)]
    struct Manifest {
        tool: String,
        #[serde(default)]
        files: ListedFiles,
    }
    let manifest: Manifest = serde_json::from_slice(&manifest_bytes(folder)?).ok()?;
    (manifest.tool == crate::manifest::TOOL).then_some(manifest.files)
}

/// The bytes of the manifest of a folder; `None` if it cannot be read, or is no regular file but a link, a pipe or a device.
pub(super) fn manifest_bytes(folder: &Path) -> Option<Vec<u8>> {
    let path = folder.join(MANIFEST);
    if path.is_symlink() {
        return None;
    }
    read_regular_file(&path, MAX_MANIFEST_BYTES).ok()
}

/// Compares a folder with what its manifest lists; without a list everything in it is foreign.
///
/// # Errors
/// The folder itself cannot be read.
pub(super) fn inspect(folder: &Path, listed: Option<&ListedFiles>) -> io::Result<Inspection> {
    let mut found = Inspection::default();
    let mut has_manifest = false;
    let mut folders = vec![PathBuf::new()];
    while let Some(inside) = folders.pop() {
        let entries = match fs::read_dir(folder.join(&inside)).and_then(Iterator::collect::<io::Result<Vec<_>>>) {
            Ok(entries) => entries,
            Err(error) if inside == Path::new("") => return Err(error),
            Err(_) => {
                found.foreign.add(format!("{}/", inside.display()), Difference::Unreadable);
                continue;
            }
        };
        if inside == Path::new("") || listed.is_some_and(|l| is_parent(&inside, l)) {
            found.own_folders.push(inside.clone());
        } else if entries.is_empty() {
            found.foreign.add(format!("{}/", inside.display()), Difference::Added);
        }
        for entry in entries {
            let path = inside.join(entry.file_name());
            let kind = entry.file_type();
            if kind.as_ref().is_ok_and(fs::FileType::is_dir) {
                folders.push(path);
            } else if listed.is_some() && path == Path::new(MANIFEST) {
                has_manifest = true;
            } else {
                let sum = path.to_str().and_then(|name| listed?.get(name));
                let is_file = kind.is_ok_and(|k| k.is_file());
                match difference(&folder.join(&path), sum, is_file) {
                    None => found.own.push(path),
                    Some(difference) => found.foreign.add(path.display().to_string(), difference),
                }
            }
        }
    }
    found.own.extend(has_manifest.then(|| PathBuf::from(MANIFEST)));
    found.foreign.0.sort();
    Ok(found)
}

/// How a file, or what is in its place, differs from the content with this sum.
fn difference(path: &Path, sum: Option<&String>, is_file: bool) -> Option<Difference> {
    let Some(sum) = sum else { return Some(Difference::Added) };
    if !is_file {
        return Some(Difference::Altered);
    }
    match sha256_of(path) {
        Ok(found) if found == *sum => None,
        Ok(_) => Some(Difference::Altered),
        Err(_) => Some(Difference::Unreadable),
    }
}

fn sha256_of(path: &Path) -> io::Result<String> {
    let mut file = open_regular_file(path)?;
    let (mut sum, mut buffer) = (Sha256::new(), vec![0; 1 << 16]);
    loop {
        match file.read(&mut buffer)? {
            0 => return Ok(ContentId::from_sha256(sum.finalize().into()).to_string()),
            n => sum.update(&buffer[..n]),
        }
    }
}

/// True if a listed file belongs into a folder, or into one inside it.
fn is_parent(folder: &Path, listed: &ListedFiles) -> bool {
    listed.keys().any(|file| Path::new(file).starts_with(folder))
}

/// Deletes the files that groundplan wrote, the manifest last, and the folders that are empty then.
///
/// What cannot be deleted stays.
pub(super) fn delete(folder: &Path, found: &Inspection) {
    for file in &found.own {
        let _ = fs::remove_file(folder.join(file));
    }
    for inside in found.own_folders.iter().rev() {
        let _ = fs::remove_dir(folder.join(inside));
    }
}
