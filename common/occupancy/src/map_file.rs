//! Maps as map servers write them: a YAML text and an image beside it.
//!
//! Grey 205 of a trinary map is unknown, independent of the threshold: savers write it for that, and with the common
//! `free_thresh: 0.25` a map server reads it as free, so that unobserved walls would seem to be seen through. In a negated map it is 50.

use crate::Cell;
use input_files::read_regular_file;
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// An occupancy map of any resolution, row-major from the lower left corner.
#[derive(Debug, Clone, PartialEq)]
pub struct OccupancyMap {
    /// Cells in a row.
    pub width: usize,
    /// All cells.
    pub cells: Vec<Cell>,
    /// Side of a cell.
    pub resolution_m: f64,
    /// Pose of the lower left corner in the map's frame: x, y in metres, yaw in radians.
    pub origin: [f64; 3],
}

/// The content of a description and of its image: [`OccupancyMap::parse`] makes the map of it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MapFileContent {
    /// The YAML text.
    pub description: String,
    /// The bytes of the image.
    pub image: Vec<u8>,
}

/// Cells that the thresholds of a map leave undecided: neither free nor occupied, and not of the grey that says unknown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UndecidedCells {
    /// Their share of all cells that are not of that grey.
    pub share: f64,
    /// The thresholds.
    pub free_thresh: f64,
    /// See `free_thresh`.
    pub occupied_thresh: f64,
}

impl MapFileContent {
    /// The cells that the thresholds leave undecided; `None` if no cell tells anything, or if it is no map.
    pub fn undecided(&self) -> Option<UndecidedCells> {
        let description = Description::parse(&self.description).ok()?;
        let image = image::load_from_memory(&self.image).ok()?;
        let (has_alpha, unknown) = (image.color().has_alpha(), description.unknown_gray());
        let pixels = image.to_luma_alpha8();
        let told = || pixels.pixels().filter(|pixel| pixel.0[0] != unknown && !(has_alpha && pixel.0[1] < 255));
        let n_told = told().count();
        let n = told().filter(|pixel| description.cell_of(pixel, has_alpha) == Cell::Unknown).count();
        let Description { free_thresh, occupied_thresh, .. } = description;
        (n_told > 0).then(|| UndecidedCells { share: n as f64 / n_told as f64, free_thresh, occupied_thresh })
    }
}

/// Error of a map file.
#[derive(Debug, thiserror::Error)]
#[error("map {}", path.display())]
pub struct MapFileError {
    /// The description.
    pub path: PathBuf,
    /// Why.
    pub source: MapFault,
}

/// Faults of map files.
#[derive(Debug, thiserror::Error)]
pub enum MapFault {
    /// A file cannot be read.
    #[error("{} cannot be read", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The map is too large.
    #[error(
        "it is {wide_m:.0} x {high_m:.0} m: at most {MAX_AREA_M2:.0} m2 can be aligned, cut off cells that were not observed"
    )]
    Extent {
        /// In the direction of its rows.
        wide_m: f64,
        /// In the direction of its columns.
        high_m: f64,
    },
    /// The file is of another kind.
    #[error("this is {0}")]
    OtherKind(&'static str),
    /// The description is no YAML, or lacks a key.
    #[error("its description cannot be used: {0}")]
    Description(String),
    /// The image is none.
    #[error("its image {} cannot be used", path.display())]
    Image {
        /// The image.
        path: PathBuf,
        /// Why.
        source: image::ImageError,
    },
}

/// Of the largest map, with all its margins: 550 x 550 m.
const MAX_AREA_M2: f64 = 300_000.0;

/// Bytes of the largest image, and of a description: one that is an image is told so.
const MAX_IMAGE_BYTES: u64 = 512 << 20;

#[derive(Deserialize)]
struct Description {
    image: PathBuf,
    resolution: f64,
    origin: Vec<f64>,
    #[serde(default)]
    negate: Negate,
    #[serde(default = "occupied_thresh")]
    occupied_thresh: f64,
    #[serde(default = "free_thresh")]
    free_thresh: f64,
    #[serde(default)]
    mode: Mode,
}

fn occupied_thresh() -> f64 {
    0.65
}

fn free_thresh() -> f64 {
    0.25
}

/// 0 and 1 in most files, a boolean in some.
#[derive(Deserialize)]
#[serde(untagged)]
enum Negate {
    Number(u8),
    Word(bool),
}

/// What is given in place of the description of a map, with what to do instead.
fn other_kind(bytes: &[u8]) -> Option<&'static str> {
    let model = "a building model (IFC), not a map: make its maps with `groundplan convert MODEL.ifc -o OUT` and give OUT, or the \
                 localization.yaml of a storey in it";
    let picture = "a picture, not the description of a map: give the .yaml file that the map server saved with it, which has its \
                   resolution and origin";
    match bytes {
        _ if bytes.trim_ascii_start().starts_with(b"ISO-10303-21") => Some(model),
        _ if image::guess_format(bytes).is_ok() => Some(picture),
        _ => None,
    }
}

impl Default for Negate {
    fn default() -> Self {
        Self::Number(0)
    }
}

#[derive(Deserialize, Default, Clone, Copy, PartialEq)]
#[serde(rename_all = "lowercase")]
enum Mode {
    #[default]
    Trinary,
    Scale,
    Raw,
}

impl OccupancyMap {
    /// Reads a description and its image.
    ///
    /// # Errors
    /// A file that cannot be read, a description without what it needs, an image that is none.
    pub fn read(path: &Path) -> Result<Self, MapFileError> {
        Self::read_with_content(path).map(|(map, _)| map)
    }

    /// The same, with the content of both files.
    ///
    /// # Errors
    /// As [`OccupancyMap::read`].
    pub fn read_with_content(path: &Path) -> Result<(Self, MapFileContent), MapFileError> {
        read(path).map_err(|source| MapFileError { path: path.to_owned(), source })
    }

    /// The map of a description and of the bytes of its image.
    ///
    /// # Errors
    /// A description without what it needs, an image that is none.
    pub fn parse(description: &str, image: &[u8]) -> Result<Self, MapFault> {
        let description = Description::parse(description)?;
        let path = description.image.clone();
        description.map_of(image, path)
    }

    /// Refuses a map that is too large to be compared.
    ///
    /// # Errors
    /// A map of too large an area.
    pub fn check_extent(&self) -> Result<(), MapFault> {
        let height = self.cells.len().checked_div(self.width).unwrap_or(0);
        let [wide_m, high_m] = [self.width, height].map(|n| n as f64 * self.resolution_m);
        if wide_m * high_m <= MAX_AREA_M2 { Ok(()) } else { Err(MapFault::Extent { wide_m, high_m }) }
    }

    /// The same map with all its lengths divided.
    #[must_use]
    pub fn divided_by(&self, scale: f64) -> Self {
        let [x, y, yaw] = self.origin;
        Self {
            cells: self.cells.clone(),
            resolution_m: self.resolution_m / scale,
            origin: [x / scale, y / scale, yaw],
            ..*self
        }
    }
}

fn read(path: &Path) -> Result<(OccupancyMap, MapFileContent), MapFault> {
    let io = |source| MapFault::Io { path: path.to_owned(), source };
    let bytes = read_regular_file(path, MAX_IMAGE_BYTES).map_err(io)?;
    if let Some(what) = other_kind(&bytes) {
        return Err(MapFault::OtherKind(what));
    }
    let text = String::from_utf8(bytes).map_err(|why| io(std::io::Error::new(std::io::ErrorKind::InvalidData, why)))?;
    let description = Description::parse(&text)?;
    let at = path.parent().unwrap_or(Path::new("")).join(&description.image);
    let bytes = read_regular_file(&at, MAX_IMAGE_BYTES).map_err(|source| MapFault::Io { path: at.clone(), source })?;
    let map = description.map_of(&bytes, at)?;
    Ok((map, MapFileContent { description: text, image: bytes }))
}

impl Description {
    /// Reads the YAML text; its numbers are usable.
    fn parse(text: &str) -> Result<Self, MapFault> {
        let fault = |what: &str| Err(MapFault::Description(what.to_owned()));
        let description: Self = serde_saphyr::from_str(text).map_err(|e| MapFault::Description(e.to_string()))?;
        if !(0.001..=10.0).contains(&description.resolution) {
            return fault("resolution is not between 0.001 and 10 m");
        }
        if description.origin.len() < 2 {
            return fault("origin is not [x, y] or [x, y, yaw]");
        }
        if !description.origin.iter().take(3).all(|v| v.is_finite() && v.abs() < 1e7) {
            return fault("origin is not finite");
        }
        Ok(description)
    }

    /// The map of the image; `path` is where its bytes are from.
    fn map_of(&self, bytes: &[u8], path: PathBuf) -> Result<OccupancyMap, MapFault> {
        let image = image::load_from_memory(bytes).map_err(|source| MapFault::Image { path, source })?;
        let has_alpha = image.color().has_alpha();
        let pixels = image.to_luma_alpha8();
        let (width, height) = (pixels.width() as usize, pixels.height() as usize);
        let mut cells = Vec::with_capacity(width * height);
        for row in (0..height as u32).rev() {
            cells.extend((0..width as u32).map(|column| self.cell_of(pixels.get_pixel(column, row), has_alpha)));
        }
        let [x, y, yaw] = [0, 1, 2].map(|k| self.origin.get(k).copied().unwrap_or(0.0));
        let map = OccupancyMap { width, cells, resolution_m: self.resolution, origin: [x, y, yaw] };
        map.check_extent()?;
        Ok(map)
    }

    fn is_negated(&self) -> bool {
        matches!(self.negate, Negate::Word(true) | Negate::Number(1..))
    }

    /// The grey that savers write for unknown cells.
    fn unknown_gray(&self) -> u8 {
        if self.is_negated() { u8::MAX - grid::UNKNOWN } else { grid::UNKNOWN }
    }

    /// The cell of a pixel.
    fn cell_of(&self, &image::LumaA([gray, alpha]): &image::LumaA<u8>, has_alpha: bool) -> Cell {
        if self.mode == Mode::Raw {
            return match gray {
                0..=100 if f64::from(gray) >= self.occupied_thresh * 100.0 => Cell::Occupied,
                0..=100 if f64::from(gray) <= self.free_thresh * 100.0 => Cell::Free,
                _ => Cell::Unknown,
            };
        }
        if self.mode == Mode::Trinary && gray == self.unknown_gray() {
            return Cell::Unknown;
        }
        let share = f64::from(gray) / 255.0;
        let occupied = if self.is_negated() { share } else { 1.0 - share };
        if self.mode == Mode::Scale && has_alpha && alpha < 255 {
            Cell::Unknown
        } else if occupied > self.occupied_thresh {
            Cell::Occupied
        } else if occupied < self.free_thresh {
            Cell::Free
        } else {
            Cell::Unknown
        }
    }
}
