//! Arguments of the output folder, and the policy for foreign files in it.

use crate::failure::Failure;
use export::{ForeignFilePolicy, OutputFolder, SetAside};
use std::path::Path;

/// What becomes of files of others in an output folder.
#[derive(Debug, Clone, Copy, clap::Args)]
pub struct OverwriteArgs {
    /// Replace earlier output although files in it were added or altered since: these are moved to a folder OUT.kept-1 (-2 ..)
    /// beside it. A folder that has no manifest.json of groundplan and is not empty is never replaced
    #[arg(long)]
    force: bool,
}

impl OverwriteArgs {
    /// The folder, known to be free or to hold earlier output.
    ///
    /// # Errors
    /// A file, a folder of others, or output in which files were added or altered, unless `--force` is given.
    pub(crate) fn folder_at(self, path: &Path) -> Result<OutputFolder, Failure> {
        let policy = if self.force { ForeignFilePolicy::SetAside } else { ForeignFilePolicy::Refuse };
        OutputFolder::at(path, policy).map_err(Failure::usage)
    }
}

/// Reports on standard error which foreign files were moved where.
pub(crate) fn report_set_aside(set_aside: Option<SetAside>) {
    if let Some(SetAside { folder, files }) = set_aside {
        eprintln!("groundplan: files that it did not write are now in {}: {files}", folder.display());
    }
}
