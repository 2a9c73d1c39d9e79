//! Arguments of `export`.

use crate::args::{OptionalFilesArgs, OverwriteArgs, SiteOfRobotArgs};
use std::path::PathBuf;

/// Arguments of `export`.
#[derive(Debug, Clone, clap::Args)]
pub struct Args {
    /// Output folder; earlier output in it is replaced as a whole, unless files in it were added or altered since
    #[arg(value_name = "OUT")]
    pub(super) out: PathBuf,

    /// What becomes of files of others in it.
    #[command(flatten)]
    pub(super) overwrite: OverwriteArgs,

    /// Go on until SIGTERM: write OUT/epochs/EPOCH for every new set of maps, let the link OUT/current name the newest, and keep
    /// OUT/fresh: maps may be used while that file says fresh, is younger than 3 s, and does not list their storey
    #[arg(long)]
    pub(super) watch: bool,

    /// Run this program when new maps may be used, and when maps may be used again after they were stale, with their folder
    /// as its argument
    #[arg(long, value_name = "PROGRAM", requires = "watch")]
    pub(super) on_change: Option<PathBuf>,

    /// Run this program when maps become stale, with the reason as its argument. A program that fails is run again after 1 s,
    /// 2 s .. 60 s while its occasion holds, one that has not ended after 60 s is killed; they never overlap
    #[arg(long, value_name = "PROGRAM", requires = "watch")]
    pub(super) on_stale: Option<PathBuf>,

    /// Keep this many epochs
    #[arg(long, value_name = "N", default_value_t = 5, requires = "watch")]
    pub(super) keep: usize,

    /// Files beside those of every output.
    #[command(flatten)]
    pub(super) optional_files: OptionalFilesArgs,

    /// The site.
    #[command(flatten)]
    pub(super) site: SiteOfRobotArgs,
}
