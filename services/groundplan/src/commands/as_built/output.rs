//! The files that are written: whole or not at all, and never in the place of what was read.

use crate::failure::Failure;
use as_built::AsBuilt;
use daemon::write_durably;
use std::path::{Path, PathBuf};

/// Absolute paths of the files.
pub(super) struct Outputs {
    model: PathBuf,
    changes: Option<PathBuf>,
}

impl Outputs {
    /// Paths that may be written.
    ///
    /// # Errors
    /// One of them is read, a folder, the same as the other, or there and not to be replaced.
    pub(super) fn of(model: &Path, changes: Option<&Path>, force: bool, inputs: &[&Path]) -> Result<Self, Failure> {
        let model_path = checked(model, "-o", force, inputs)?;
        let changes_path = changes.map(|path| checked(path, "--changes", force, inputs)).transpose()?;
        if changes_path.as_ref() == Some(&model_path) {
            return Err(Failure::usage(format!("--changes {}: it is the new model", model.display())));
        }
        Ok(Self { model: model_path, changes: changes_path })
    }

    /// Writes the model and the list of changes.
    ///
    /// # Errors
    /// The file system refuses; an earlier file stays as it was.
    pub(super) fn write(&self, written: &AsBuilt) -> Result<(), Failure> {
        let write = |path: &Path, bytes: &[u8]| {
            write_durably(path, bytes)
                .map_err(|error| Failure::work(format!("{} cannot be written: {error}", path.display())))
        };
        if let Some(path) = &self.changes {
            let text = serde_json::to_string_pretty(&written.changes).map_err(Failure::work)? + "\n";
            write(path, text.as_bytes())?;
        }
        write(&self.model, &written.bytes)
    }
}

fn checked(path: &Path, option: &str, force: bool, inputs: &[&Path]) -> Result<PathBuf, Failure> {
    let absolute = std::path::absolute(path).map_err(Failure::usage)?;
    // A file that is not there yet is no input.
    let Ok(real) = absolute.canonicalize() else { return Ok(absolute) };
    let refused = |why: &str| Err(Failure::usage(format!("{option} {}: {why}", path.display())));
    if real.is_dir() {
        return refused("it is a folder");
    }
    if inputs.iter().any(|input| input.canonicalize().is_ok_and(|input| input == real)) {
        return refused("it is read; write to another file");
    }
    if !force {
        return refused("it is there already; --force replaces it");
    }
    Ok(real)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_read_is_never_replaced_and_what_is_there_only_if_asked_for() {
        let home = tempfile::tempdir().unwrap();
        let [model, there, new] = ["model.ifc", "there.ifc", "new.ifc"].map(|name| home.path().join(name));
        std::fs::write(&model, "ISO").unwrap();
        std::fs::write(&there, "other").unwrap();
        let check = |out: &Path, changes: Option<&Path>, force: bool| {
            Outputs::of(out, changes, force, &[&model]).map(|_| ()).map_err(|error| error.code())
        };
        assert_eq!(check(&new, None, false), Ok(()));
        assert_eq!((check(&there, None, false), check(&there, None, true)), (Err(2), Ok(())));
        assert_eq!((check(&model, None, true), check(home.path(), None, true)), (Err(2), Err(2)));
        assert_eq!(check(&new, Some(&model), true), Err(2));
        assert_eq!(check(&new, Some(&new), true), Err(2));
    }
}
