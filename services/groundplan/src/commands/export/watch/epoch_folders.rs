//! A folder for each epoch of the maps, and a link to the newest. Nothing is deleted but epochs as they were written, and the
//! link.

use crate::args::{OverwriteArgs, report_set_aside};
use crate::failure::Failure;
use export::{ExportFile, OutputError, OutputFolder};
use std::collections::BTreeSet;
use std::io;
use std::path::{Path, PathBuf};

/// Where epochs are written.
#[derive(Debug, Clone)]
pub(super) struct EpochFolders {
    epochs: PathBuf,
    current: PathBuf,
    overwrite: OverwriteArgs,
}

impl EpochFolders {
    /// In an output folder, which is made if it is not there.
    ///
    /// # Errors
    /// A folder that cannot be made, something else than a link in the place of the link.
    pub(super) fn at(out: &Path, overwrite: OverwriteArgs) -> Result<Self, Failure> {
        let folders = Self { epochs: out.join("epochs"), current: out.join("current"), overwrite };
        folders.check_link()?;
        std::fs::create_dir_all(&folders.epochs).map_err(|e| at(&folders.epochs, &e))?;
        Ok(folders)
    }

    /// The link.
    pub(super) fn link(&self) -> &Path {
        &self.current
    }

    /// The link is replaced for every epoch: what has its name must be one.
    fn check_link(&self) -> Result<(), Failure> {
        match std::fs::symlink_metadata(&self.current) {
            Ok(metadata) if !metadata.is_symlink() => Err(Failure::usage(format!(
                "{} is no link to an epoch, and is not replaced: choose another folder, or move it away",
                self.current.display()
            ))),
            _ => Ok(()),
        }
    }

    /// Writes an epoch, unless a run before this one did, and makes it the current one. Its folder.
    ///
    /// # Errors
    /// The file system refuses, or files of others are in the way.
    pub(super) fn write(&self, epoch: u64, files: &[ExportFile]) -> Result<PathBuf, Failure> {
        let folder = self.epochs.join(epoch.to_string());
        // Epochs are counted anew where the state of a site was deleted: a folder of this number may hold other maps.
        if !OutputFolder::holds(&folder, files) {
            let place = self.overwrite.folder_at(&folder)?;
            report_set_aside(place.replace(files).map_err(Failure::work)?);
        }
        let target = Path::new("epochs").join(epoch.to_string());
        if std::fs::read_link(&self.current).is_ok_and(|current| current == target) {
            return Ok(folder);
        }
        self.check_link()?;
        let beside = self.current.with_file_name(format!(".current.new-{}", std::process::id()));
        // A killed run with this process id may have left one.
        if beside.is_symlink() {
            std::fs::remove_file(&beside).map_err(|e| at(&beside, &e))?;
        }
        std::os::unix::fs::symlink(&target, &beside).map_err(|e| at(&beside, &e))?;
        std::fs::rename(&beside, &self.current).map_err(|e| at(&self.current, &e))?;
        print_now(&folder);
        Ok(folder)
    }

    /// Deletes the oldest epochs beyond the newest `keep`, but for those in use and those with files of others, which are
    /// reported once.
    ///
    /// # Errors
    /// A folder of epochs that cannot be read.
    pub(super) fn forget(&self, keep: usize, in_use: &[&Path], reported: &mut BTreeSet<u64>) -> Result<(), Failure> {
        let entries = std::fs::read_dir(&self.epochs).map_err(|e| at(&self.epochs, &e))?;
        let mut epochs: Vec<u64> = entries.filter_map(|e| e.ok()?.file_name().to_str()?.parse().ok()).collect();
        epochs.sort_unstable();
        let n_old = epochs.len().saturating_sub(keep);
        for epoch in &epochs[..n_old] {
            let folder = self.epochs.join(epoch.to_string());
            if in_use.contains(&folder.as_path()) {
                continue;
            }
            let why = match OutputFolder::delete(&folder) {
                Ok(()) => continue,
                Err(OutputError::Altered { files, .. }) => format!("it holds files of others: {files}"),
                Err(error) => error.to_string(),
            };
            if reported.insert(*epoch) {
                eprintln!("groundplan: {} is not deleted: {why}", folder.display());
            }
        }
        Ok(())
    }
}

/// A line for each epoch; a closed standard output is no error.
fn print_now(folder: &Path) {
    use std::io::Write;
    let _ = writeln!(io::stdout(), "{}", folder.display());
}

fn at(path: &Path, error: &io::Error) -> Failure {
    Failure::work(format!("{}: {error}", path.display()))
}
