//! Names of pictures and models of a running site: of all that they are made of. Of a site and its
//! grids that are their content hashes: they change while the page is watched, and are too large to be hashed anew for each tile.

use crate::source::{ContentName, TilesOfGrid};
use crate::tiles::{Extent, Layer, TileGrid};
use bus::CheckedSample;
use daemon::{SiteConfig, read_parsed};
use messages::{ContentHash, Grid};
use site_view::SiteSet;
use std::convert::Infallible;
use std::path::Path;

/// Of the tiles of a layer.
pub(super) fn tiles_name(layer: Layer, grid: &Grid<'_>, tiles: &TileGrid) -> ContentName {
    let spec = grid.spec();
    let place = TilesOfGrid { tiles, extent: &Extent::of(&spec), resolution_m: spec.resolution_m() };
    ContentName::of_tiles(layer, grid.head.map_storey, &grid.content_hash().to_le_bytes(), &place)
}

/// Of the model of what stands.
pub(super) fn model_name(config: &SiteConfig, set: &SiteSet<'_>) -> ContentName {
    let plan = set.mission_plan.map_or(ContentHash::NONE, CheckedSample::content_hash);
    let hashes = [set.site.content_hash(), set.state.content_hash(), set.index.content_hash(), plan];
    // Options that cannot be read are told when the model is asked for.
    let read = |path: &Path| read_parsed("options of worlds", path, |text| Ok::<_, Infallible>(text.to_owned())).ok();
    let options = config.world.options.as_deref().and_then(read).unwrap_or_default();
    ContentName::of_parts(&[hashes.map(ContentHash::to_le_bytes).as_flattened(), options.as_bytes()])
}

/// Of what is made of one archive alone.
pub(super) fn name_of(archive: &[u8]) -> ContentName {
    ContentName::of_parts(&[archive])
}
