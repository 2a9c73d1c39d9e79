//! An output folder that appears whole or not at all.

use crate::ExportFile;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Why an output folder could not be written. What stood there before is untouched.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// Something else stands there.
    #[error("{} is no output folder of groundplan (it has no manifest.json) and is not empty: choose another", path.display())]
    Foreign {
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
    path: PathBuf,
}

impl OutputFolder {
    /// Looks at the place, writes nothing.
    ///
    /// # Errors
    /// A file, or a folder that holds something else than output of groundplan.
    pub fn at(path: &Path) -> Result<Self, OutputError> {
        let foreign = || OutputError::Foreign { path: path.to_owned() };
        match fs::read_dir(path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            Err(_) => return Err(foreign()),
            Ok(mut entries) => {
                if entries.next().is_some() && !path.join("manifest.json").is_file() {
                    return Err(foreign());
                }
            }
        }
        Ok(Self { path: path.to_owned() })
    }

    /// Writes the files beside the place, then swaps: no file of an earlier run remains, no half folder is ever seen.
    ///
    /// # Errors
    /// The file system refuses; then the place is as it was.
    pub fn replace(&self, files: &[ExportFile]) -> Result<(), OutputError> {
        let parent = match self.path.parent() {
            Some(parent) if parent != Path::new("") => parent.to_owned(),
            _ => PathBuf::from("."),
        };
        fs::create_dir_all(&parent).map_err(|source| OutputError::Io { path: parent.clone(), source })?;
        let name = self.path.file_name().map_or_else(|| "out".into(), |n| n.to_string_lossy().into_owned());
        let beside = |what: &str| parent.join(format!(".{name}.{what}-{}", std::process::id()));
        let (new, old) = (beside("new"), beside("old"));
        let swapped = write_all(&new, files).and_then(|()| swap(&new, &self.path, &old));
        if swapped.is_err() {
            // Best effort: the error that matters is the one at hand.
            let _ = fs::remove_dir_all(&new);
        }
        swapped
    }
}

fn write_all(folder: &Path, files: &[ExportFile]) -> Result<(), OutputError> {
    let at = |path: &Path| {
        let path = path.to_owned();
        move |source| OutputError::Io { path, source }
    };
    fs::create_dir(folder).map_err(at(folder))?;
    for file in files {
        let path = folder.join(&file.path);
        if let Some(parent) = path.parent() {
            fs::create_dir_all(parent).map_err(at(parent))?;
        }
        let mut out = File::create(&path).map_err(at(&path))?;
        out.write_all(&file.bytes).and_then(|()| out.sync_data()).map_err(at(&path))?;
    }
    Ok(())
}

/// Puts `new` in the place of `path`; what stood there goes by way of `old`, and comes back if the swap fails.
fn swap(new: &Path, path: &Path, old: &Path) -> Result<(), OutputError> {
    let failed = |source| OutputError::Io { path: path.to_owned(), source };
    let had_old = path.exists();
    if had_old {
        fs::rename(path, old).map_err(failed)?;
    }
    if let Err(error) = fs::rename(new, path) {
        if had_old {
            fs::rename(old, path).map_err(failed)?;
        }
        return Err(failed(error));
    }
    if had_old {
        fs::remove_dir_all(old).map_err(failed)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn files(names: &[&str]) -> Vec<ExportFile> {
        names.iter().map(|n| ExportFile::new(*n, *n)).collect()
    }

    #[test]
    fn a_second_run_leaves_nothing_of_the_first() {
        let home = tempfile::tempdir().unwrap();
        let out = home.path().join("deep/out");
        OutputFolder::at(&out).unwrap().replace(&files(&["manifest.json", "a/old.pgm"])).unwrap();
        OutputFolder::at(&out).unwrap().replace(&files(&["manifest.json", "a/new.pgm"])).unwrap();
        assert!(out.join("a/new.pgm").exists() && !out.join("a/old.pgm").exists());
        assert_eq!(fs::read_dir(out.parent().unwrap()).unwrap().count(), 1, "nothing is left beside");
    }

    #[test]
    fn a_folder_of_somebody_else_is_refused() {
        let home = tempfile::tempdir().unwrap();
        fs::write(home.path().join("thesis.tex"), "precious").unwrap();
        assert!(matches!(OutputFolder::at(home.path()), Err(OutputError::Foreign { .. })));
        assert!(matches!(OutputFolder::at(&home.path().join("thesis.tex")), Err(OutputError::Foreign { .. })));
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
        assert_eq!(fs::read_dir(home.path()).unwrap().count(), 1, "nothing is left beside");
    }
}
