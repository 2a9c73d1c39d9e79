//! The elements of converted models, storey by storey.

use super::section::{Border, around, borders};
use crate::plane::Rectangle;
use crate::wall_grid::WallGrid;
use crate::world::CELL_M;
use occupancy::{Cell, MapFileError, OccupancyMap};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Sections are taken this far above the lidar's plane: faces of storeys and sills lie on round heights.
const ABOVE_PLANE_M: f64 = 1e-4;

/// A storey of a converted model.
#[derive(Debug, Clone)]
pub(crate) struct ModelStorey {
    /// Name of the folder of the model.
    pub(crate) building: String,
    /// Index of the map storey.
    pub(crate) storey: usize,
    /// Floor of the planning map, in cells of the world; no walls.
    pub(crate) grid: WallGrid,
    /// What the lidar's plane meets, in the order of their GlobalIds.
    pub(crate) elements: Vec<Element>,
}

/// An element of a storey at the height of the lidar.
#[derive(Debug, Clone)]
pub(crate) struct Element {
    pub(crate) global_id: String,
    pub(crate) class: String,
    pub(crate) borders: Vec<Border>,
    pub(crate) rectangle: Rectangle,
}

impl Element {
    /// True if most beams pass it.
    pub(crate) fn is_glass(&self) -> bool {
        self.class == "window" || self.class == "curtain_wall"
    }
}

/// Errors of converted models.
#[derive(Debug, thiserror::Error)]
pub enum ModelError {
    /// A map cannot be read.
    #[error(transparent)]
    Map(#[from] MapFileError),
    /// A file cannot be read.
    #[error("{} cannot be read", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A file is not one that the converter writes.
    #[error("{} is not what groundplan convert --with-geometry writes", path.display())]
    Document {
        /// The file.
        path: PathBuf,
        /// Why.
        source: serde_json::Error,
    },
    /// The maps have other cells than the simulated world.
    #[error("{} has other cells than {CELL_M} m: give --resolution {CELL_M} to groundplan convert", path.display())]
    Resolution {
        /// The map.
        path: PathBuf,
    },
}

#[derive(Deserialize)]
struct Manifest {
    robot: Robot,
    storeys: Vec<Storey>,
}

#[derive(Deserialize)]
struct Robot {
    lidar_height_m: f64,
}

#[derive(Deserialize)]
struct Storey {
    index: usize,
    floor_z_m: f64,
    directory: Option<PathBuf>,
}

#[derive(Deserialize)]
struct Semantic {
    elements: BTreeMap<String, SemanticElement>,
}

#[derive(Deserialize)]
struct SemanticElement {
    class: String,
    #[serde(default)]
    vertices: Vec<[f64; 3]>,
    #[serde(default)]
    faces: Vec<[usize; 3]>,
}

impl ModelStorey {
    /// All mapped storeys of a folder that `groundplan convert --with-geometry` wrote.
    ///
    /// # Errors
    /// Files that are missing, or with other cells than those of the world.
    pub(crate) fn read_all(folder: &Path) -> Result<Vec<Self>, ModelError> {
        let manifest: Manifest = document(&folder.join("manifest.json"))?;
        let semantic: Semantic = document(&folder.join("semantic.json"))?;
        let building = folder.file_name().map_or_else(String::new, |name| name.to_string_lossy().replace(' ', "_"));
        let mut storeys = Vec::new();
        for storey in &manifest.storeys {
            let Some(directory) = &storey.directory else { continue };
            let path = folder.join(directory).join("planning.yaml");
            let planning = OccupancyMap::read(&path)?;
            if (planning.resolution_m - CELL_M).abs() > 1e-6 {
                return Err(ModelError::Resolution { path });
            }
            let z = storey.floor_z_m + manifest.robot.lidar_height_m + ABOVE_PLANE_M;
            let of = |(id, element): (&String, &SemanticElement)| {
                let borders = borders(&element.vertices, &element.faces, z);
                let rectangle = around(&borders)?;
                Some(Element { global_id: id.clone(), class: element.class.clone(), borders, rectangle })
            };
            // Doors are hung by the simulation, in the openings.
            let elements = semantic.elements.iter().filter(|(_, e)| e.class != "door").filter_map(of).collect();
            let grid = grid_of(&planning);
            storeys.push(Self { building: building.clone(), storey: storey.index, grid, elements });
        }
        Ok(storeys)
    }
}

fn grid_of(planning: &OccupancyMap) -> WallGrid {
    let (width, height) = (planning.width, planning.cells.len() / planning.width);
    WallGrid {
        width,
        height,
        resolution_m: CELL_M,
        origin: [planning.origin[0], planning.origin[1]],
        walls: vec![false; width * height],
        floor: planning.cells.iter().map(|c| *c == Cell::Free).collect(),
    }
}

fn document<T: for<'de> Deserialize<'de>>(path: &Path) -> Result<T, ModelError> {
    let text = std::fs::read(path).map_err(|source| ModelError::Read { path: path.to_owned(), source })?;
    serde_json::from_slice(&text).map_err(|source| ModelError::Document { path: path.to_owned(), source })
}
