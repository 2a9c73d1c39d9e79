//! The files that are written: whole or not at all, and never in the place of what was read.

use crate::failure::Failure;
use crate::output_file::OutputFile;
use as_built::AsBuilt;
use std::path::{Path, PathBuf};

/// The new model and the list of changes.
pub(super) struct Outputs {
    model: OutputFile,
    changes: Option<OutputFile>,
}

impl Outputs {
    /// Files that may be written.
    ///
    /// # Errors
    /// One of them is read, a folder, the same as the other, or there and not to be replaced.
    pub(super) fn of(model: &Path, changes: Option<&Path>, force: bool, inputs: &[PathBuf]) -> Result<Self, Failure> {
        let checked = |option, path| {
            let file = OutputFile::of(option, path, inputs)?;
            if !force {
                file.refuse_existing(option)?;
            }
            Ok::<OutputFile, Failure>(file)
        };
        let model_file = checked("-o", model)?;
        let changes_file = changes.map(|path| checked("--changes", path)).transpose()?;
        if changes_file.as_ref() == Some(&model_file) {
            return Err(Failure::usage(format!("--changes {}: it is the new model", model.display())));
        }
        Ok(Self { model: model_file, changes: changes_file })
    }

    /// Writes the model and the list of changes.
    ///
    /// # Errors
    /// The file system refuses; an earlier file stays as it was.
    pub(super) fn write(&self, written: &AsBuilt) -> Result<(), Failure> {
        let changes = serde_json::to_string_pretty(&written.changes).map_err(Failure::work)? + "\n";
        // A list of changes never tells of a model that is not there.
        self.model.write(&written.bytes)?;
        self.changes.iter().try_for_each(|file| file.write(changes.as_bytes()))
    }
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
            Outputs::of(out, changes, force, std::slice::from_ref(&model)).map(|_| ()).map_err(|error| error.code())
        };
        assert_eq!(check(&new, None, false), Ok(()));
        assert_eq!((check(&there, None, false), check(&there, None, true)), (Err(2), Ok(())));
        assert_eq!((check(&model, None, true), check(home.path(), None, true)), (Err(2), Err(2)));
        assert_eq!(check(&new, Some(&model), true), Err(2));
        assert_eq!(check(&new, Some(&new), true), Err(2));
    }
}
