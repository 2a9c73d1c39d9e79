//! Arguments of `export`.

use crate::args::{CloudArgs, FleetArgs, OctomapArgs, OverwriteArgs, SiteOfRobotArgs, WorldArgs};
use crate::failure::Failure;
use daemon::SiteConfig;
use site_files::OptionalFiles;
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

    /// Write the surface that can be walked or driven on too: ground.ply, ground.json
    #[arg(long)]
    pub(super) with_ground: bool,

    /// Write building map, site and navigation graph for Open-RMF too: levels, lanes that this robot can take, doors, lifts
    #[arg(long)]
    pub(super) open_rmf: bool,

    /// The world.
    #[command(flatten)]
    pub(super) world: WorldArgs,

    /// The cloud.
    #[command(flatten)]
    pub(super) cloud: CloudArgs,

    /// The octree.
    #[command(flatten)]
    pub(super) octomap: OctomapArgs,

    /// Fleets.
    #[command(flatten)]
    pub(super) fleet: FleetArgs,

    /// The site.
    #[command(flatten)]
    pub(super) site: SiteOfRobotArgs,
}

impl Args {
    /// What is written beside the files of every output.
    ///
    /// # Errors
    /// Options that cannot be used.
    pub(super) fn optional_files(&self, config: &SiteConfig) -> Result<OptionalFiles, Failure> {
        Ok(OptionalFiles::new(
            self.world.options(&config.world)?,
            self.cloud.options()?,
            self.octomap.options(&self.cloud)?,
            self.with_ground,
            self.fleet.formats(),
            self.open_rmf,
        ))
    }
}
