//! Why there is no map.

use grid::{Class, GridSpecError};
use messages::{Grid, Site};

/// Why there is no map.
#[derive(Debug, thiserror::Error)]
pub enum RasterizeError {
    /// The grid of a storey cannot be; the outermost elements are named, because they are usually misplaced.
    #[error("storey {storey:?} has no grid; its outermost elements are {outermost}")]
    Spec {
        /// Name of the storey.
        storey: String,
        /// Entities and GlobalIds of the elements at its bounds.
        outermost: String,
        /// Why.
        source: GridSpecError,
    },
    /// A margin of more cells than the distance that margins are counted in.
    #[error("a margin of {margin_m} m is more than {max_cells} cells of {resolution_m} m: take a coarser resolution")]
    Margin {
        /// As the robot's profile has it.
        margin_m: f64,
        /// The most that is possible.
        max_cells: f64,
        /// As asked for.
        resolution_m: f64,
    },
    /// Nothing at all would be drawn.
    #[error("the map would be blank: no storey has an obstacle or a floor; --allow-empty writes it all the same")]
    Blank,
    /// Rooms without walls.
    #[error("storey {storey:?} has {n_spaces} spaces and no obstacle; --allow-empty writes it all the same")]
    NoObstacle {
        /// Name of the storey.
        storey: String,
        /// Number of its spaces.
        n_spaces: usize,
    },
}

/// Refuses the map of a complete model that nobody should trust.
///
/// # Errors
/// All storeys blank or none at all, or a storey with spaces and without any obstacle.
pub fn check_not_blank(site: &Site<'_>, grids: &[Grid<'_>]) -> Result<(), RasterizeError> {
    let has_obstacle = |g: &Grid<'_>| g.class.iter().any(|&c| c != Class::None.id());
    if !grids.iter().any(|g| has_obstacle(g) || g.floor.iter().any(|&f| f != 0)) {
        return Err(RasterizeError::Blank);
    }
    for grid in grids.iter().filter(|g| !has_obstacle(g)) {
        let n_spaces = site.spaces.iter().filter(|s| s.map_storey == grid.head.map_storey).count();
        if n_spaces > 0 {
            let storey = site.text(site.map_storeys[grid.head.map_storey as usize].name).to_owned();
            return Err(RasterizeError::NoObstacle { storey, n_spaces });
        }
    }
    Ok(())
}
