//! Model maps as the simulation needs them: walls, floor, furniture of the model, stretches of wall, openings.

use crate::openings::{Opening, openings};
use crate::plane::Vector;
use crate::wall_grid::WallGrid;
use crate::wall_stretches::{WallStretch, wall_stretches};
use grid::squared_distances;
use occupancy::{Cell, MapFileError, OccupancyMap};
use std::path::{Path, PathBuf};

/// Less floor than this is no storey to drive through.
const MIN_FLOOR_M2: f64 = 15.0;
/// Less length of wall faces than this holds no map in place.
const MIN_FACES_M: f64 = 10.0;

/// A storey of a model.
#[derive(Debug, Clone)]
pub struct Reference {
    /// Name of its files.
    pub name: String,
    /// The building that it belongs to.
    pub building: String,
    /// Its walls and its floor.
    pub grid: WallGrid,
    /// The model map itself.
    pub map: OccupancyMap,
    /// Cells of floor on which the model has furniture.
    pub furniture: Vec<bool>,
    /// Straight stretches of wall faces.
    pub stretches: Vec<WallStretch>,
    /// Gaps in walls where doors may be.
    pub openings: Vec<Opening>,
    /// Squared distance from each cell to the nearest wall, in cells.
    pub wall_distances: Vec<u32>,
}

/// Errors of model maps.
#[derive(Debug, thiserror::Error)]
pub enum ReferenceError {
    /// A map cannot be read.
    #[error(transparent)]
    Map(#[from] MapFileError),
    /// A folder cannot be listed.
    #[error("{} cannot be listed", path.display())]
    Folder {
        /// The folder.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A storey is too small, or an empty field.
    #[error("{name} cannot be simulated: {floor_m2:.0} m2 of floor, {faces_m:.0} m of wall faces")]
    TooLittle {
        /// The storey.
        name: String,
        /// Its floor.
        floor_m2: f64,
        /// Length of its walls, each face by itself.
        faces_m: f64,
    },
    /// The axes of the map are not those of its frame.
    #[error("{name}: a model map whose origin has a yaw")]
    Turned {
        /// The storey.
        name: String,
    },
}

impl Reference {
    /// From a model map; `planning` shows what stands on the floor beside walls.
    ///
    /// # Errors
    /// Too little floor or wall, a turned map.
    pub fn new(
        name: String,
        building: String,
        map: OccupancyMap,
        planning: Option<&OccupancyMap>,
    ) -> Result<Self, ReferenceError> {
        let [x, y, yaw] = map.origin;
        if yaw.abs() > 1e-9 {
            return Err(ReferenceError::Turned { name });
        }
        let planning = planning.filter(|p| p.cells.len() == map.cells.len() && p.width == map.width);
        let walls: Vec<bool> = map.cells.iter().map(|&c| c == Cell::Occupied).collect();
        let stands = |k: usize| planning.is_some_and(|p| p.cells[k] == Cell::Occupied) && map.cells[k] == Cell::Unknown;
        let furniture: Vec<bool> = (0..walls.len()).map(stands).collect();
        let is_free = |k: usize| map.cells[k] == Cell::Free || planning.is_some_and(|p| p.cells[k] == Cell::Free);
        let floor = (0..walls.len()).map(|k| !walls[k] && (furniture[k] || is_free(k))).collect();
        let wall_distances = squared_distances(&walls, map.width);
        let (width, height) = (map.width, map.cells.len() / map.width);
        let grid = WallGrid { width, height, resolution_m: map.resolution_m, origin: [x, y], walls, floor };
        let stretches = wall_stretches(&grid);
        let openings = openings(&grid, &stretches);
        let floor_m2 = grid.floor_m2();
        let faces_m = stretches.iter().fold(0.0, |sum, stretch| sum + stretch.length_m());
        if floor_m2 < MIN_FLOOR_M2 || faces_m < MIN_FACES_M {
            return Err(ReferenceError::TooLittle { name, floor_m2, faces_m });
        }
        Ok(Self { name, building, grid, map, furniture, stretches, openings, wall_distances })
    }

    /// All storeys of a converted building, all maps of a folder, or one map; in the order of their names.
    ///
    /// # Errors
    /// A folder that cannot be listed. What cannot be simulated is an error of its own in the list.
    pub fn read_all(path: &Path) -> Result<Vec<Result<Self, ReferenceError>>, ReferenceError> {
        if path.is_file() {
            let name = name_of(&path.with_extension(""));
            return Ok(vec![Self::read(name.clone(), name, path, None)]);
        }
        let storeys = path.join("storeys");
        if storeys.is_dir() {
            let building = name_of(path);
            let of = |storey: PathBuf| {
                let name = format!("{building}-{}", name_of(&storey));
                Self::read(
                    name,
                    building.clone(),
                    &storey.join("localization.yaml"),
                    Some(&storey.join("planning.yaml")),
                )
            };
            return Ok(listed(&storeys)?.into_iter().filter(|p| p.is_dir()).map(of).collect());
        }
        let maps = listed(path)?.into_iter().filter(|p| p.extension().is_some_and(|e| e == "yaml"));
        let of = |map: PathBuf| {
            let name = name_of(&map.with_extension(""));
            Self::read(name.clone(), name, &map, None)
        };
        Ok(maps.map(of).collect())
    }

    fn read(name: String, building: String, map: &Path, planning: Option<&Path>) -> Result<Self, ReferenceError> {
        let planning = planning.filter(|p| p.exists()).map(OccupancyMap::read).transpose()?;
        Self::new(name, building, OccupancyMap::read(map)?, planning.as_ref())
    }

    /// Metres to the nearest wall; without end outside of the map.
    pub(crate) fn wall_distance_m(&self, p: Vector) -> f64 {
        let index = self.grid.index_at(p);
        index.map_or(f64::INFINITY, |k| f64::from(self.wall_distances[k]).sqrt() * self.grid.resolution_m)
    }
}

/// A name that two model maps have.
pub(crate) fn repeated_name(references: &[Reference]) -> Option<&str> {
    let mut names: Vec<&str> = references.iter().map(|r| r.name.as_str()).collect();
    names.sort_unstable();
    names.windows(2).find(|n| n[0] == n[1]).map(|n| n[0])
}

fn name_of(path: &Path) -> String {
    path.canonicalize()
        .unwrap_or_else(|_| path.to_owned())
        .file_name()
        .map_or_else(String::new, |name| name.to_string_lossy().replace(' ', "_"))
}

fn listed(folder: &Path) -> Result<Vec<PathBuf>, ReferenceError> {
    let entries = std::fs::read_dir(folder).and_then(Iterator::collect::<Result<Vec<_>, _>>);
    let entries = entries.map_err(|source| ReferenceError::Folder { path: folder.to_owned(), source })?;
    let mut paths: Vec<PathBuf> = entries.into_iter().map(|entry| entry.path()).collect();
    paths.sort();
    Ok(paths)
}
