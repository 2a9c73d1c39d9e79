//! The output folder that the command line names, and what is said of files of others in it.

use crate::cli::OverwriteArgs;
use crate::failure::Failure;
use export::{ForeignFilePolicy, OutputFolder, SetAside};
use std::path::Path;

/// The folder, known to be free or to hold earlier output.
///
/// # Errors
/// A file, a folder of others, or output in which files were added or altered, unless `--force` is given.
pub(crate) fn folder_at(path: &Path, arguments: OverwriteArgs) -> Result<OutputFolder, Failure> {
    let policy = if arguments.force { ForeignFilePolicy::SetAside } else { ForeignFilePolicy::Refuse };
    OutputFolder::at(path, policy).map_err(Failure::usage)
}

/// Says on standard error which files of others were moved where.
pub(crate) fn tell(set_aside: Option<SetAside>) {
    if let Some(SetAside { folder, files }) = set_aside {
        eprintln!("groundplan: files that it did not write are now in {}: {files}", folder.display());
    }
}
