//! Arguments of the simulation world.

use crate::failure::Failure;
use daemon::WorldConfig;
use std::path::PathBuf;
use world::{DoorMode, Materials, WorldOptions};

/// The simulation world.
#[derive(Debug, Clone, clap::Args)]
pub(super) struct WorldArgs {
    /// Write the simulation world too, with the options of a file [default: see config/world.toml]
    #[arg(long, value_name = "FILE", num_args = 0..=1, require_equals = true)]
    world: Option<Option<PathBuf>>,

    /// What the world's doors are
    #[arg(long, value_name = "HOW", requires = "world", value_parser = ["movable", "open", "closed", "passable"])]
    doors: Option<String>,

    /// Close the passages to blocked spaces by thin walls in the world
    #[arg(long, requires = "world")]
    barriers: bool,

    /// Where the world's colours come from
    #[arg(long, value_name = "WHERE", requires = "world", value_parser = ["semantic", "model"])]
    materials: Option<String>,

    /// How far corners of what the world shows may be moved to make it lighter, in metres
    #[arg(long, value_name = "METRES", requires = "world")]
    lod: Option<f64>,

    /// Show the waypoints in the world
    #[arg(long, requires = "world")]
    markers: bool,

    /// Write the world as USD with UsdPhysics, too: world/site.usda
    #[arg(long, requires = "world")]
    usd: bool,
}

impl WorldArgs {
    /// What the world is like; `None` if neither the command line nor the configuration asks for one.
    ///
    /// # Errors
    /// A file that cannot be read, or values that no world can have.
    pub(crate) fn options(&self, configured: &WorldConfig) -> Result<Option<WorldOptions>, Failure> {
        if self.world.is_none() && !configured.write {
            return Ok(None);
        }
        let file = self.world.as_ref().and_then(Option::as_deref).or(configured.options.as_deref());
        let read = |path| daemon::read_parsed("options of worlds", path, WorldOptions::parse);
        let mut options = file.map_or_else(|| Ok(WorldOptions::default()), read).map_err(Failure::usage)?;
        let doors = |name: &String| DoorMode::ALL.into_iter().find(|m| m.name() == name);
        let materials = |name: &String| Materials::ALL.into_iter().find(|m| m.name() == name);
        options.doors = self.doors.as_ref().and_then(doors).unwrap_or(options.doors);
        options.materials = self.materials.as_ref().and_then(materials).unwrap_or(options.materials);
        options.lod_m = self.lod.unwrap_or(options.lod_m);
        options.barriers |= self.barriers;
        options.markers |= self.markers;
        options.usd |= self.usd;
        options.check().map_err(Failure::usage)?;
        Ok(Some(options))
    }
}
