//! Arguments of the files that are written beside those of every output.

use super::cloud::CloudArgs;
use super::fleet::FleetArgs;
use super::octomap::OctomapArgs;
use super::world::WorldArgs;
use crate::failure::Failure;
use daemon::WorldConfig;
use site_files::OptionalFiles;

/// Files beside those of every output.
#[derive(Debug, Clone, clap::Args)]
pub struct OptionalFilesArgs {
    /// Write the surface that can be walked or driven on too, terrain, ramps and stairs with floors: ground.ply, ground.json
    #[arg(long)]
    with_ground: bool,

    /// Write building map, site and navigation graph for Open-RMF too: levels, lanes that this robot can take, doors, lifts
    #[arg(long)]
    open_rmf: bool,

    /// The world.
    #[command(flatten)]
    world: WorldArgs,

    /// The cloud.
    #[command(flatten)]
    cloud: CloudArgs,

    /// The octree.
    #[command(flatten)]
    octomap: OctomapArgs,

    /// Fleets.
    #[command(flatten)]
    fleet: FleetArgs,
}

impl OptionalFilesArgs {
    /// What is asked for, with worlds as a site configures them.
    ///
    /// # Errors
    /// Options that cannot be used.
    pub(crate) fn options(&self, world: &WorldConfig) -> Result<OptionalFiles, Failure> {
        Ok(OptionalFiles::new(
            self.world.options(world)?,
            self.cloud.options()?,
            self.octomap.options(&self.cloud)?,
            self.with_ground,
            self.fleet.formats(),
            self.open_rmf,
        ))
    }
}
