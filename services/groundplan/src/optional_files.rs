//! Files of an output folder that are written where they are asked for: the simulation world, the cloud of structure.

use crate::failure::Failure;
use cloud::CloudOptions;
use export::ExportInput;
use world::{WorldFiles, WorldOptions};

/// Files that are written beside those of every output, where they are asked for.
#[derive(Debug, Clone, Default)]
pub(crate) struct OptionalFiles {
    /// The simulation world.
    pub(crate) world: Option<WorldOptions>,
    /// The points of what stands.
    pub(crate) cloud: Option<CloudOptions>,
}

impl OptionalFiles {
    /// The files, and what is to be told about the world.
    ///
    /// # Errors
    /// A cloud of too many points.
    pub(crate) fn files(&self, input: &ExportInput<'_>) -> Result<WorldFiles, Failure> {
        let Self { world, cloud } = self;
        let mut made = world.as_ref().map(|options| world::files(input, options)).unwrap_or_default();
        if let Some(options) = cloud {
            made.files.extend(cloud::files(input, options).map_err(Failure::work)?);
        }
        Ok(made)
    }
}
