//! Arguments of `export`.

use crate::args::{OverwriteArgs, SiteArgs, WorldArgs};
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

    /// Go on until SIGTERM: write OUT/epochs/EPOCH for every new set of maps, and let the link OUT/current name the newest
    #[arg(long)]
    pub(super) watch: bool,

    /// Run this program after each swap of the link, with the new folder as its argument
    #[arg(long, value_name = "PROGRAM", requires = "watch")]
    pub(super) on_change: Option<PathBuf>,

    /// Keep this many epochs
    #[arg(long, value_name = "N", default_value_t = 5, requires = "watch")]
    pub(super) keep: usize,

    /// The world.
    #[command(flatten)]
    pub(super) world: WorldArgs,

    /// The site.
    #[command(flatten)]
    pub(super) site: SiteArgs,
}
