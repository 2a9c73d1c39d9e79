//! Files of an output folder that are written where they are asked for: the simulation world, the cloud and the octree of
//! structure, the ground, what the control of fleets reads, building maps for Open-RMF.

use crate::error::SiteFilesError;
use cloud::{CloudOptions, OctomapOptions};
use export::{ExportFile, ExportInput};
use fleet::FleetFormat;
use ground::SiteGround;
use messages::{ContentHash, Ground, GroundWriter, MapGrids};
use std::sync::{Mutex, PoisonError};
use world::{WorldFiles, WorldOptions};

/// Files that are written beside those of every output, where they are asked for.
#[derive(Debug)]
pub struct OptionalFiles {
    world: Option<WorldOptions>,
    cloud: Option<CloudOptions>,
    octomap: Option<OctomapOptions>,
    with_ground: bool,
    fleet: Vec<FleetFormat>,
    with_open_rmf: bool,
    /// What the site alone says of its ground, with the hash of that site: dates select from it.
    site_ground: Mutex<Option<(ContentHash, SiteGround)>>,
}

impl OptionalFiles {
    /// A world, a cloud and an octree with options, the ground, formats of fleets, and building maps for Open-RMF, where there are to
    /// be any.
    pub fn new(
        world: Option<WorldOptions>,
        cloud: Option<CloudOptions>,
        octomap: Option<OctomapOptions>,
        with_ground: bool,
        fleet: Vec<FleetFormat>,
        with_open_rmf: bool,
    ) -> Self {
        Self { world, cloud, octomap, with_ground, fleet, with_open_rmf, site_ground: Mutex::default() }
    }

    /// True if there are to be any of them.
    pub fn are_asked_for(&self) -> bool {
        let Self { world, cloud, octomap, with_ground, fleet, with_open_rmf, site_ground: _ } = self;
        let is_any =
            [world.is_some(), cloud.is_some(), octomap.is_some(), *with_ground, !fleet.is_empty(), *with_open_rmf];
        is_any.contains(&true)
    }

    /// The files, and what is to be told about the world.
    ///
    /// A world, a cloud and the ground are the whole building with all its grids, whichever of them are written; fleets and Open-RMF
    /// get the storeys that are.
    ///
    /// `is_wanted` is asked between formats: each of a large building takes its time.
    ///
    /// # Errors
    /// A cloud of too many points, an octree of too many cells, a schedule state of another site; files that are not wanted any more.
    pub fn files(
        &self,
        written: &ExportInput<'_>,
        all_grids: &dyn MapGrids,
        is_wanted: &dyn Fn() -> bool,
    ) -> Result<WorldFiles, SiteFilesError> {
        let go_on = || is_wanted().then_some(()).ok_or(SiteFilesError::NotWanted);
        let input = &ExportInput { grids: all_grids, ..*written };
        let mut made = self.world.as_ref().map(|options| world::files(input, options)).unwrap_or_default();
        go_on()?;
        if let Some(options) = &self.cloud {
            made.files.extend(cloud::files(input, options)?);
        }
        go_on()?;
        if let Some(options) = &self.octomap {
            made.files.extend(cloud::octomap_files(input, options)?);
        }
        go_on()?;
        if self.with_ground {
            made.files.extend(self.ground_files(input)?);
        }
        made.files.extend(fleet::files(written, &self.fleet));
        go_on()?;
        if self.with_open_rmf {
            made.files.extend(open_rmf::files(written));
        }
        Ok(made)
    }

    fn ground_files(&self, input: &ExportInput<'_>) -> Result<Vec<ExportFile>, SiteFilesError> {
        let (site, site_hash) = (input.site, input.site.content_hash());
        let mut kept = self.site_ground.lock().unwrap_or_else(PoisonError::into_inner);
        let (_, site_ground) = match kept.take().filter(|(of, _)| *of == site_hash) {
            Some(same) => kept.insert(same),
            None => kept.insert((site_hash, SiteGround::of(site))),
        };
        let mut ground = GroundWriter::default();
        site_ground.at(site, input.schedule_state, &mut ground)?;
        let archive = ground.finish();
        let ground = Ground::open(archive.bytes())?;
        Ok(export::ground_files(site, &ground))
    }
}
