//! The table of links as a file: whole or not at all, and never in the place of what was read.

use crate::failure::Failure;
use daemon::write_durably;
use std::path::{Path, PathBuf};

/// The absolute path of a table to be written.
///
/// # Errors
/// It is one of the inputs, or a folder.
pub(super) fn output<'p>(path: &Path, mut inputs: impl Iterator<Item = &'p Path>) -> Result<PathBuf, Failure> {
    let absolute = std::path::absolute(path).map_err(Failure::usage)?;
    // A table that is not there yet is no input.
    if let Ok(real) = absolute.canonicalize() {
        if real.is_dir() {
            return Err(Failure::usage(format!("--csv {}: it is a folder", path.display())));
        }
        if let Some(input) = inputs.find(|input| input.canonicalize().is_ok_and(|input| input == real)) {
            let input = input.display();
            return Err(Failure::usage(format!("--csv {}: {input} is read; write to another file", path.display())));
        }
        return Ok(real);
    }
    Ok(absolute)
}

/// Writes a table.
///
/// # Errors
/// The file system refuses; an earlier file stays as it was.
pub(super) fn write(path: &Path, table: &str) -> Result<(), Failure> {
    write_durably(path, table.as_bytes())
        .map_err(|error| Failure::work(format!("{} cannot be written: {error}", path.display())))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_never_replaces_what_was_read() {
        let home = tempfile::tempdir().unwrap();
        let [plan, table] = ["plan.csv", "table.csv"].map(|name| home.path().join(name));
        std::fs::write(&plan, "id").unwrap();
        assert!(output(&table, [plan.as_path()].into_iter()).is_ok());
        let around = home.path().join(".").join("plan.csv");
        for path in [&plan, &around, &home.path().to_owned()] {
            assert_eq!(output(path, [plan.as_path()].into_iter()).unwrap_err().code(), 2, "{}", path.display());
        }
    }
}
