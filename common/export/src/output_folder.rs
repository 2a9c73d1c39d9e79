//! An output folder that appears whole or not at all.

use crate::ExportFile;
use rustix::fs::{CWD, RenameFlags, renameat_with};
use rustix::io::Errno;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Why an output folder could not be written. What stood there before is untouched.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// Something else stands there.
    #[error("{} is no output folder of groundplan (it has no manifest.json of groundplan) and is not empty: choose another", path.display())]
    Foreign {
        /// The path that was asked for.
        path: PathBuf,
    },
    /// A file stands there, or on the way.
    #[error("{} cannot be an output folder, because a file stands there: choose another", path.display())]
    File {
        /// The path that was asked for.
        path: PathBuf,
    },
    /// A folder that cannot be swapped.
    #[error("{} cannot be swapped, because it is a mount point: choose a folder inside it", path.display())]
    MountPoint {
        /// The path that was asked for.
        path: PathBuf,
    },
    /// The file system refused.
    #[error("{} cannot be written", path.display())]
    Io {
        /// What was being written.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
}

/// A place for output, known to be free or to hold earlier output.
#[derive(Debug)]
pub struct OutputFolder {
    /// Without links, if it exists: a swap replaces the folder, not a link to it.
    path: PathBuf,
}

impl OutputFolder {
    /// Looks at the place, writes nothing.
    ///
    /// # Errors
    /// A file, or a folder that holds something else than output of groundplan.
    pub fn at(path: &Path) -> Result<Self, OutputError> {
        let asked = || path.to_owned();
        let mut entries = match fs::read_dir(path) {
            Ok(entries) => entries,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Self { path: asked() }),
            Err(error) if error.kind() == io::ErrorKind::NotADirectory => {
                return Err(OutputError::File { path: asked() });
            }
            Err(source) => return Err(OutputError::Io { path: asked(), source }),
        };
        if entries.next().is_some() && !is_output(path) {
            return Err(OutputError::Foreign { path: asked() });
        }
        let path = fs::canonicalize(path).map_err(|source| OutputError::Io { path: asked(), source })?;
        Ok(Self { path })
    }

    /// Writes the files beside the place, then swaps: no file of an earlier run remains, no half folder is ever seen.
    ///
    /// # Errors
    /// The file system refuses; then the place is as it was.
    pub fn replace(&self, files: &[ExportFile]) -> Result<(), OutputError> {
        let beside = self.begin()?;
        beside.write("", files)?;
        beside.swap_in()
    }

    /// Begins a folder beside the place, for output that is made piece by piece.
    ///
    /// # Errors
    /// The file system refuses; then the place is as it was.
    pub fn begin(&self) -> Result<FolderBeside<'_>, OutputError> {
        let parent = self.parent();
        fs::create_dir_all(parent).map_err(at(parent))?;
        let name = self.path.file_name().map_or_else(|| "out".into(), |n| n.to_string_lossy());
        let path = parent.join(format!(".{name}.new-{}", std::process::id()));
        // A killed run with this process id, common in containers, may have left something.
        let _ = fs::remove_dir_all(&path);
        let beside = FolderBeside { place: self, path };
        fs::create_dir(&beside.path).map_err(at(&beside.path))?;
        Ok(beside)
    }

    fn parent(&self) -> &Path {
        match self.path.parent() {
            Some(parent) if parent != Path::new("") => parent,
            _ => Path::new("."),
        }
    }
}

/// Output in the making; gone with this value unless it is swapped in.
#[derive(Debug)]
pub struct FolderBeside<'a> {
    place: &'a OutputFolder,
    path: PathBuf,
}

impl FolderBeside<'_> {
    /// Writes files into a folder of the output; `""` is the output itself.
    ///
    /// # Errors
    /// The file system refuses.
    pub fn write(&self, folder: &str, files: &[ExportFile]) -> Result<(), OutputError> {
        write_all(&self.path.join(folder), files)
    }

    /// Swaps the output with what stands at its place.
    ///
    /// # Errors
    /// The file system refuses; then the place is as it was.
    pub fn swap_in(self) -> Result<(), OutputError> {
        sync(&self.path)?;
        swap(&self.path, &self.place.path)?;
        sync(self.place.parent())
    }
}

impl Drop for FolderBeside<'_> {
    fn drop(&mut self) {
        // The earlier output, or what a failure left. Best effort: the error that matters is the one at hand.
        let _ = fs::remove_dir_all(&self.path);
    }
}

/// True if a folder has a manifest, and it is not plainly that of another program: a web site has one, too.
fn is_output(folder: &Path) -> bool {
    let Ok(manifest) = fs::read(folder.join("manifest.json")) else { return false };
    serde_json::from_slice::<serde_json::Value>(&manifest).map_or(true, |m| m["tool"] == "groundplan")
}

fn at(path: &Path) -> impl FnOnce(io::Error) -> OutputError + use<> {
    let path = path.to_owned();
    move |source| OutputError::Io { path, source }
}

fn write_all(folder: &Path, files: &[ExportFile]) -> Result<(), OutputError> {
    fs::create_dir_all(folder).map_err(at(folder))?;
    let mut folders = vec![folder.to_owned()];
    for file in files {
        let path = folder.join(&file.path);
        if let Some(parent) = path.parent().filter(|p| !folders.iter().any(|f| f == p)) {
            fs::create_dir_all(parent).map_err(at(parent))?;
            folders.push(parent.to_owned());
        }
        let mut out = File::create(&path).map_err(at(&path))?;
        out.write_all(&file.bytes).and_then(|()| out.sync_all()).map_err(at(&path))?;
    }
    folders.iter().rev().try_for_each(|folder| sync(folder))
}

/// Makes the names in a folder survive a power cut.
fn sync(folder: &Path) -> Result<(), OutputError> {
    File::open(folder).and_then(|f| f.sync_all()).map_err(at(folder))
}

/// Puts `new` in the place of `path`, and what stood there in the place of `new`.
fn swap(new: &Path, path: &Path) -> Result<(), OutputError> {
    if !path.exists() {
        return fs::rename(new, path).map_err(at(path));
    }
    match renameat_with(CWD, new, CWD, path, RenameFlags::EXCHANGE) {
        Ok(()) => Ok(()),
        Err(Errno::BUSY | Errno::XDEV) => Err(OutputError::MountPoint { path: path.to_owned() }),
        // Some file systems cannot exchange, e.g. NFS: two renames, with a moment in between.
        Err(Errno::INVAL | Errno::NOSYS | Errno::OPNOTSUPP) => swap_in_two_steps(new, path),
        Err(error) => Err(at(path)(error.into())),
    }
}

fn swap_in_two_steps(new: &Path, path: &Path) -> Result<(), OutputError> {
    let old = new.with_extension("old");
    fs::rename(path, &old).map_err(at(path))?;
    if let Err(error) = fs::rename(new, path) {
        fs::rename(&old, path).map_err(at(path))?;
        return Err(at(path)(error));
    }
    fs::rename(&old, new).map_err(at(&old))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn files(names: &[&str]) -> Vec<ExportFile> {
        names.iter().map(|n| ExportFile::new(*n, *n)).collect()
    }

    fn n_entries(folder: &Path) -> usize {
        fs::read_dir(folder).unwrap().count()
    }

    #[test]
    fn a_second_run_leaves_nothing_of_the_first() {
        let home = tempfile::tempdir().unwrap();
        let out = home.path().join("deep/out");
        OutputFolder::at(&out).unwrap().replace(&files(&["manifest.json", "a/old.pgm"])).unwrap();
        OutputFolder::at(&out).unwrap().replace(&files(&["manifest.json", "a/new.pgm"])).unwrap();
        assert!(out.join("a/new.pgm").exists() && !out.join("a/old.pgm").exists());
        assert_eq!(n_entries(out.parent().unwrap()), 1, "nothing is left beside");
    }

    #[test]
    fn two_renames_do_what_an_exchange_does() {
        let home = tempfile::tempdir().unwrap();
        let (new, out) = (home.path().join(".out.new-1"), home.path().join("out"));
        fs::create_dir(&new).unwrap();
        fs::create_dir(&out).unwrap();
        fs::write(new.join("a"), "").unwrap();
        swap_in_two_steps(&new, &out).unwrap();
        assert!(out.join("a").exists() && new.is_dir() && n_entries(home.path()) == 2);
    }

    #[test]
    fn what_belongs_to_somebody_else_is_refused() {
        let home = tempfile::tempdir().unwrap();
        fs::write(home.path().join("thesis.tex"), "precious").unwrap();
        assert!(matches!(OutputFolder::at(home.path()), Err(OutputError::Foreign { .. })));
        fs::write(home.path().join("manifest.json"), r#"{"name": "a web site"}"#).unwrap();
        assert!(matches!(OutputFolder::at(home.path()), Err(OutputError::Foreign { .. })));
        fs::write(home.path().join("manifest.json"), r#"{"tool": "groundplan"}"#).unwrap();
        assert!(OutputFolder::at(home.path()).is_ok());
        for at in ["thesis.tex", "thesis.tex/out"] {
            assert!(matches!(OutputFolder::at(&home.path().join(at)), Err(OutputError::File { .. })));
        }
    }

    #[test]
    fn the_folder_behind_a_link_is_replaced_and_the_link_stays() {
        let home = tempfile::tempdir().unwrap();
        let (real, link) = (home.path().join("real"), home.path().join("link"));
        fs::create_dir(&real).unwrap();
        std::os::unix::fs::symlink(&real, &link).unwrap();
        OutputFolder::at(&link).unwrap().replace(&files(&["manifest.json"])).unwrap();
        assert!(link.is_symlink() && real.join("manifest.json").is_file());
    }

    #[test]
    fn a_failed_write_leaves_the_earlier_output() {
        let home = tempfile::tempdir().unwrap();
        let out = home.path().join("out");
        OutputFolder::at(&out).unwrap().replace(&files(&["manifest.json"])).unwrap();
        // A file where a folder is needed makes the write fail half way.
        let broken = files(&["manifest.json", "storeys", "storeys/x.pgm"]);
        assert!(OutputFolder::at(&out).unwrap().replace(&broken).is_err());
        assert_eq!(fs::read_to_string(out.join("manifest.json")).unwrap(), "manifest.json");
        assert_eq!(n_entries(home.path()), 1, "nothing is left beside");
    }
}
