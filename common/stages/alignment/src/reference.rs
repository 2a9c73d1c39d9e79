//! Reference maps for alignment: the planned site, sliced at lidar height.

use crate::prepared_map::PreparedMap;
use frames::Map;
use messages::{ArchiveError, ContentHash, Grid, RobotProfile, ScheduleState, Site};
use occupancy::{CELL_M, Cell, OccupancyMap};
use raster::{RasterizeError, Rasterizer};
use std::sync::Arc;

/// The maps of all storeys of a site for a robot, as planned at a schedule state.
///
/// They follow the rule of the localization layer, and the planned states alone: what was observed is compared with
/// them, so that an observation never changes what it is compared with.
pub struct References {
    sources: (ContentHash, RobotProfile),
    rasterizer: Rasterizer,
    /// By map storey, with the hash of the grid that it was made from.
    maps: Vec<(ContentHash, Arc<PreparedMap<Map>>)>,
}

/// Why there is nothing to compare with.
#[derive(Debug, thiserror::Error)]
pub enum ReferenceError {
    /// The site cannot be drawn.
    #[error(transparent)]
    Rasterize(#[from] RasterizeError),
    /// The drawn reference cannot be read.
    #[error("a map of the site as planned")]
    Archive(#[from] ArchiveError),
}

impl References {
    /// Cuts a site for a robot.
    ///
    /// # Errors
    /// A storey too large for a grid.
    pub fn new(site: &Site<'_>, robot: &RobotProfile) -> Result<Self, ReferenceError> {
        let rasterizer = Rasterizer::of_levels(site, robot, CELL_M)?;
        Ok(Self { sources: (site.content_hash(), *robot), rasterizer, maps: Vec::new() })
    }

    /// True if it was made from this site and robot.
    pub fn is_of(&self, site: &Site<'_>, robot: &RobotProfile) -> bool {
        self.sources == (site.content_hash(), *robot)
    }

    /// The maps at a schedule state of the site that it was made from, by map storey: of the levels of buildings, because a map that bends
    /// over slopes is not compared with that of the ground outdoors, which comes after them. Those that look as before are kept.
    ///
    /// # Errors
    /// None that is expected: what was drawn cannot be read.
    pub fn at(
        &mut self,
        site: &Site<'_>,
        schedule_state: &ScheduleState<'_>,
    ) -> Result<impl ExactSizeIterator<Item = Arc<PreparedMap<Map>>>, ReferenceError> {
        self.rasterizer.draw(site, &schedule_state.as_planned());
        for (storey, drawn) in self.rasterizer.drawn().enumerate() {
            if self.maps.get(storey).is_some_and(|(hash, _)| *hash == drawn.content_hash) {
                continue;
            }
            let map = Arc::new(PreparedMap::of_model(&localization(&Grid::open(drawn.archive)?)));
            match self.maps.get_mut(storey) {
                Some(earlier) => *earlier = (drawn.content_hash, map),
                None => self.maps.push((drawn.content_hash, map)),
            }
        }
        Ok(self.maps.iter().map(|(_, map)| map.clone()))
    }
}

/// The localization layer as an occupancy map.
fn localization(grid: &Grid<'_>) -> OccupancyMap {
    let spec = grid.spec();
    let [x, y] = spec.origin_m();
    OccupancyMap {
        width: spec.width as usize,
        cells: grid.localization.iter().map(|&value| Cell::of_occupancy(value)).collect(),
        resolution_m: spec.resolution_m(),
        origin: [x, y, 0.0],
    }
}
