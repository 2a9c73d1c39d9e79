//! Layers of a storey as square pictures: one tile grid for all storeys of a site, so that they lie on each other.
//!
//! A tile of level n has 2^n x 2^n cells in a pixel, which shows the strongest of them: an obstacle of one cell is seen at every
//! level. Columns count to the right and rows down, from the upper left corner of the site.

use grid::GridSpec;
use serde::Serialize;
use std::fmt;

/// Pixels of a side of a tile.
pub(crate) const TILE_SIZE: u32 = 512;
/// Levels beyond this one would show a site of more than a hundred kilometres.
const MAX_LEVELS: u32 = 13;

/// A layer of a map storey.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) enum Layer {
    /// 0 unknown, 1 free, 2 occupied.
    Planning,
    /// Classes of elements, by [`strength_of_class`].
    Semantic,
    /// 0 elsewhere, 1 must not enter.
    Keepout,
    /// 0 unknown, 1 free, 2 occupied.
    Localization,
}

impl Layer {
    /// All of them, in the order in which they lie on each other.
    pub(crate) const ALL: [Self; 4] = [Self::Planning, Self::Semantic, Self::Keepout, Self::Localization];

    /// Its name, as in paths.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Planning => "planning",
            Self::Semantic => "semantic",
            Self::Keepout => "keepout",
            Self::Localization => "localization",
        }
    }

    /// The layer with this name.
    pub(crate) fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|layer| layer.name() == name)
    }

    /// Red, green, blue and opacity of its values; a stronger value has a greater number.
    pub(crate) fn palette(self) -> &'static [[u8; 4]] {
        const CLEAR: [u8; 4] = [0; 4];
        match self {
            Self::Planning => &[CLEAR, [255, 255, 255, 255], [44, 48, 56, 255]],
            Self::Keepout => &[CLEAR, [214, 48, 49, 105]],
            Self::Localization => &[CLEAR, [214, 226, 246, 110], [28, 72, 168, 255]],
            Self::Semantic => &[
                CLEAR,
                [176, 176, 170, 120],
                [140, 140, 140, 160],
                [150, 150, 150, 220],
                [150, 110, 160, 220],
                [186, 148, 104, 230],
                [110, 96, 84, 255],
                [238, 214, 90, 255],
                [232, 194, 30, 255],
                [120, 182, 220, 255],
                [96, 158, 200, 255],
                [78, 82, 90, 255],
                [100, 104, 112, 255],
                [46, 174, 84, 255],
            ],
        }
    }
}

/// Place in the palette of a class of `classes.png`: doors over walls over furniture, so that what matters stays where cells of
/// several classes share a pixel.
pub(crate) fn strength_of_class(class: u8) -> u8 {
    // none, wall, column, door, window, stair, ramp, railing, furniture, curtain wall, slab, beam, mep, other
    const STRENGTHS: [u8; 14] = [0, 12, 11, 13, 9, 8, 7, 6, 5, 10, 1, 2, 4, 3];
    STRENGTHS.get(usize::from(class)).copied().unwrap_or(3)
}

/// Strength of a pixel of a map file, 0 occupied, 254 free, 205 unknown, in a layer.
pub(crate) fn strength_of_pixel(layer: Layer, pixel: u8) -> u8 {
    match (layer, pixel) {
        (Layer::Semantic, class) => strength_of_class(class),
        (Layer::Keepout, 0) => 1,
        (Layer::Keepout, _) => 0,
        (_, 0) => 2,
        (_, 254) => 1,
        _ => 0,
    }
}

/// Where the cells of a grid lie.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Extent {
    /// Lower left corner in `map`, metres: a whole number of cells.
    pub(crate) origin_m: [f64; 2],
    /// Columns and rows.
    pub(crate) size_cells: [u32; 2],
}

impl Extent {
    /// Of the specification of a grid.
    pub(crate) fn of(spec: &GridSpec) -> Self {
        Self { origin_m: spec.origin_m(), size_cells: [spec.width, spec.height] }
    }
}

/// The tiles of a site.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct TileGrid {
    /// Upper left corner of all storeys in `map`, metres.
    pub(crate) origin_m: [f64; 2],
    /// Pixels of a side.
    pub(crate) size: u32,
    /// Levels; the last one has the whole site in a tile.
    pub(crate) levels: u32,
}

impl TileGrid {
    /// Around these grids of one resolution.
    pub(crate) fn around(extents: &[Extent], resolution_m: f64) -> Self {
        let top = |e: &Extent| e.origin_m[1] + f64::from(e.size_cells[1]) * resolution_m;
        let left_m = extents.iter().map(|e| e.origin_m[0]).fold(f64::INFINITY, f64::min);
        let top_m = extents.iter().map(top).fold(f64::NEG_INFINITY, f64::max);
        let mut grid = Self { origin_m: [left_m, top_m], size: TILE_SIZE, levels: 1 };
        if extents.is_empty() {
            grid.origin_m = [0.0, 0.0];
        }
        let ends = extents.iter().map(|extent| {
            let [column, row] = grid.offset(extent, resolution_m);
            (column + u64::from(extent.size_cells[0])).max(row + u64::from(extent.size_cells[1]))
        });
        let cells = ends.max().unwrap_or(0);
        while grid.levels < MAX_LEVELS && u64::from(TILE_SIZE) << (grid.levels - 1) < cells {
            grid.levels += 1;
        }
        grid
    }

    /// Cells from the corner of the site to the upper left corner of a grid, to the right and down.
    pub(crate) fn offset(&self, extent: &Extent, resolution_m: f64) -> [u64; 2] {
        let top_m = extent.origin_m[1] + f64::from(extent.size_cells[1]) * resolution_m;
        let cells = |length_m: f64| (length_m / resolution_m).round().max(0.0) as u64;
        [cells(extent.origin_m[0] - self.origin_m[0]), cells(self.origin_m[1] - top_m)]
    }

    /// The tiles that meet a grid, level by level.
    pub(crate) fn tiles_of(&self, extent: &Extent, resolution_m: f64) -> Vec<TilePlace> {
        let [left, top] = self.offset(extent, resolution_m);
        let [width, height] = extent.size_cells.map(u64::from);
        let mut places = Vec::new();
        for level in 0..self.levels {
            let side = u64::from(self.size) << level;
            let range = |from: u64, n: u64| from / side..(from + n).div_ceil(side);
            for row in range(top, height) {
                for column in range(left, width) {
                    places.push(TilePlace { level, column: column as u32, row: row as u32 });
                }
            }
        }
        places
    }
}

/// A tile of the tile grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct TilePlace {
    /// 2^level cells a pixel.
    pub(crate) level: u32,
    /// From the left.
    pub(crate) column: u32,
    /// From the top.
    pub(crate) row: u32,
}

impl fmt::Display for TilePlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}/{}", self.level, self.column, self.row)
    }
}

/// The values of a layer of a grid.
pub(crate) struct LayerCells<'a, F> {
    /// Which layer.
    pub(crate) layer: Layer,
    /// Where the cells lie.
    pub(crate) extent: Extent,
    /// Cells from the corner of the site to the upper left corner of the grid.
    pub(crate) offset: [u64; 2],
    /// Strength of the cell in a column, counted from the left, and a row, counted from the top.
    pub(crate) strength: &'a F,
}

impl<F: Fn(u32, u32) -> u8> LayerCells<'_, F> {
    /// The picture of a tile: a PNG file.
    ///
    /// `None` for a tile that does not meet the grid.
    pub(crate) fn tile(&self, grid: &TileGrid, place: TilePlace) -> Option<Vec<u8>> {
        if place.level >= grid.levels {
            return None;
        }
        let side = u64::from(grid.size) << place.level;
        let corner = [u64::from(place.column) * side, u64::from(place.row) * side];
        let mut from = [0_u64; 2];
        let mut to = [0_u64; 2];
        for k in 0..2 {
            from[k] = corner[k].max(self.offset[k]);
            to[k] = (corner[k] + side).min(self.offset[k] + u64::from(self.extent.size_cells[k]));
            if to[k] <= from[k] {
                return None;
            }
        }
        let width = grid.size as usize;
        let mut pixels = vec![0_u8; width * width];
        for y in from[1]..to[1] {
            let row = &mut pixels[((y - corner[1]) >> place.level) as usize * width..][..width];
            for x in from[0]..to[0] {
                let value = (self.strength)((x - self.offset[0]) as u32, (y - self.offset[1]) as u32);
                let pixel = &mut row[((x - corner[0]) >> place.level) as usize];
                *pixel = (*pixel).max(value);
            }
        }
        Some(indexed_png(grid.size, &pixels, self.layer.palette()))
    }
}

fn indexed_png(side: u32, pixels: &[u8], palette: &[[u8; 4]]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, side, side);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Fast);
    encoder.set_palette(palette.iter().flat_map(|[r, g, b, _]| [*r, *g, *b]).collect::<Vec<u8>>());
    encoder.set_trns(palette.iter().map(|colour| colour[3]).collect::<Vec<u8>>());
    let mut writer = encoder.write_header().expect("memory takes all bytes");
    writer.write_image_data(pixels).expect("there is a byte for each pixel");
    writer.finish().expect("memory takes all bytes");
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    const LOWER: Extent = Extent { origin_m: [-1.0, -2.0], size_cells: [600, 300] };
    const UPPER: Extent = Extent { origin_m: [0.0, 3.0], size_cells: [100, 300] };

    fn pixels(png: &[u8]) -> Vec<u8> {
        let mut reader = png::Decoder::new(std::io::Cursor::new(png)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut pixels).unwrap();
        pixels
    }

    #[test]
    fn the_tiles_of_all_storeys_begin_at_one_corner() {
        let grid = TileGrid::around(&[LOWER, UPPER], 0.05);
        assert_eq!((grid.origin_m, grid.levels), ([-1.0, 18.0], 2));
        assert_eq!([LOWER, UPPER].map(|e| grid.offset(&e, 0.05)), [[0, 100], [20, 0]]);
        let lower: Vec<String> = grid.tiles_of(&LOWER, 0.05).iter().map(TilePlace::to_string).collect();
        assert_eq!(lower, ["0/0/0", "0/1/0", "1/0/0"]);
        assert_eq!(grid.tiles_of(&UPPER, 0.05).len(), 2);
    }

    #[test]
    fn a_cell_is_in_its_pixel_at_every_level_and_an_obstacle_of_one_cell_is_seen() {
        let grid = TileGrid::around(&[LOWER, UPPER], 0.05);
        let strength = |x: u32, y: u32| if (x, y) == (597, 299) { 2 } else { 1 };
        let offset = grid.offset(&LOWER, 0.05);
        let cells = LayerCells { layer: Layer::Planning, extent: LOWER, offset, strength: &strength };
        let tile = |level, column, row| cells.tile(&grid, TilePlace { level, column, row });
        let right = pixels(&tile(0, 1, 0).unwrap());
        assert_eq!(
            (right[399 * 512 + 85], right[399 * 512 + 84], right[399 * 512 + 88], right[99 * 512]),
            (2, 1, 0, 0)
        );
        let far = pixels(&tile(1, 0, 0).unwrap());
        assert_eq!((far[199 * 512 + 298], far[199 * 512 + 297], far[200 * 512]), (2, 1, 0));
        assert!(tile(0, 2, 0).is_none() && tile(0, 0, 1).is_none() && tile(2, 0, 0).is_none());
    }

    #[test]
    fn a_site_without_maps_has_no_tiles() {
        assert_eq!(TileGrid::around(&[], 0.05), TileGrid { origin_m: [0.0, 0.0], size: 512, levels: 1 });
    }

    #[test]
    fn every_strength_has_a_colour() {
        for class in 0..=255 {
            assert!(usize::from(strength_of_class(class)) < Layer::Semantic.palette().len());
        }
        let strongest = |layer| [0, 205, 254].map(|pixel| strength_of_pixel(layer, pixel));
        assert_eq!(strongest(Layer::Planning), [2, 0, 1]);
        assert_eq!(strongest(Layer::Keepout), [1, 0, 0]);
    }
}
