//! A file that a command writes beside its answer: whole or not at all, and never in the place of what was read.

use crate::failure::Failure;
use daemon::write_durably;
use std::path::{Path, PathBuf};

/// Where it is written.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct OutputFile(PathBuf);

impl OutputFile {
    /// The file of an option.
    ///
    /// # Errors
    /// It is one of the inputs, or a folder.
    pub(crate) fn of(option: &str, path: &Path, inputs: &[PathBuf]) -> Result<Self, Failure> {
        let absolute = std::path::absolute(path).map_err(Failure::usage)?;
        // A file that is not there yet is no input.
        let Ok(real) = absolute.canonicalize() else { return Ok(Self(absolute)) };
        if real.is_dir() {
            return Err(Failure::usage(format!("{option} {}: it is a folder", path.display())));
        }
        if let Some(input) = inputs.iter().find(|input| input.canonicalize().is_ok_and(|input| input == real)) {
            let input = input.display();
            return Err(Failure::usage(format!("{option} {}: {input} is read; write to another file", path.display())));
        }
        Ok(Self(real))
    }

    /// Refuses to replace a file that is there.
    ///
    /// # Errors
    /// It is there.
    pub(crate) fn refuse_existing(&self, option: &str) -> Result<(), Failure> {
        let path = self.0.display();
        let refused = || Failure::usage(format!("{option} {path}: it is there already; --force replaces it"));
        if self.0.exists() { Err(refused()) } else { Ok(()) }
    }

    /// Writes it.
    ///
    /// # Errors
    /// The file system refuses; an earlier file stays as it was.
    pub(crate) fn write(&self, content: &[u8]) -> Result<(), Failure> {
        let refused = |error| Failure::work(format!("{} cannot be written: {error}", self.0.display()));
        write_durably(&self.0, content).map_err(refused)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_output_never_replaces_what_was_read() {
        let home = tempfile::tempdir().unwrap();
        let [plan, table] = ["plan.csv", "table.csv"].map(|name| home.path().join(name));
        std::fs::write(&plan, "id").unwrap();
        let of = |path: &Path| OutputFile::of("--csv", path, std::slice::from_ref(&plan));
        assert!(of(&table).is_ok());
        for path in [&plan, &home.path().join(".").join("plan.csv"), &home.path().to_owned()] {
            assert_eq!(of(path).unwrap_err().code(), 2, "{}", path.display());
        }
    }
}
