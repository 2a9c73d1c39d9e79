//! The `grid` archive: layers of one map storey, written in place.

use crate::archive::{ArchiveError, HASHED_BLOCK, Preamble, hash_of_blocks, layout, seal, write_preamble, write_table};
use crate::archive_kind::ArchiveKind;
use crate::content_hash::ContentHash;
use crate::declaration::declare_archive;
use crate::site_records::FloorKind;
use crate::tag::{Tag, check_tags};
use bytemuck::{Pod, Zeroable};
use grid::{CellRect, Class, GridSpec};
use std::ops::Range;
use xxhash_rust::xxh3::xxh3_64;

/// Specification and slab of the grid: one record.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Zeroable, Pod)]
#[repr(C)]
pub struct GridHead {
    /// Side of a cell in tenths of a millimetre.
    pub cell_tenths: i32,
    /// Column and row of the lower left cell, counted from the frame's origin.
    pub first_cell: [i32; 2],
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Map storey of the site.
    pub map_storey: u32,
    /// Height of the floor in `map`.
    pub floor_z_tenths: i32,
    /// Bottom and top of the slab above the floor.
    pub slab_tenths: [i32; 2],
    /// Where the floor comes from.
    pub floor: Tag<FloorKind>,
    /// Epoch of the map frame.
    pub frame_epoch: u32,
    /// Zero.
    pub reserved: u32,
}
const _: () = assert!(size_of::<GridHead>() == 48);

impl GridHead {
    /// An empty head, without a floor.
    pub const EMPTY: Self = Self {
        cell_tenths: 0,
        first_cell: [0; 2],
        width: 0,
        height: 0,
        map_storey: 0,
        floor_z_tenths: 0,
        slab_tenths: [0; 2],
        floor: Tag::numbered(FloorKind::Missing as u32),
        frame_epoch: 0,
        reserved: 0,
    };

    /// Where the grid lies.
    pub fn spec(&self) -> GridSpec {
        let Self { cell_tenths, first_cell, width, height, .. } = *self;
        GridSpec { cell_tenths, first_cell, width, height }
    }
}

/// Value of the layer `floor` where floor is built.
pub const FLOOR_BUILT: u8 = 1;
/// Value of the layer `floor` where it is assumed.
pub const FLOOR_ASSUMED: u8 = 2;

/// Value of the layer `elevation` where there is no floor.
pub const NO_HEIGHT: i32 = i32::MIN;
/// Value of the layer `slope` where there is no floor.
pub const NO_SLOPE: u16 = u16::MAX;

declare_archive! {
    /// Layers of one map storey, read in place; row-major from the lower left.
    view Grid;
    /// Layers to be written.
    layers GridLayers;
    sections {
        /// Specification and slab of the grid.
        pub head: one(1, GridHead),
        /// `grid::Class` as a number.
        pub class: many(2, u8),
        /// 0 free, 100 occupied, -1 unknown.
        pub planning: many(3, i8),
        /// 0 free, 100 occupied, -1 unknown.
        pub localization: many(4, i8),
        /// 100 must not enter, -1 elsewhere; never 0, which Nav2's filter would write over unknown cells.
        pub keepout: many(5, i8),
        /// 0 none, [`FLOOR_BUILT`] or [`FLOOR_ASSUMED`].
        pub floor: many(6, u8),
        /// Index of the space plus 1; 0 for none.
        pub space: many(7, u16),
        /// Height of the ground in the middle of a cell in `map`, in tenths of a millimetre; [`NO_HEIGHT`] where there is none. Only of
        /// a storey whose ground is not level.
        pub elevation: if_any(8, i32),
        /// Slope of the ground in milliradians; [`NO_SLOPE`] where there is none. Together with the elevation.
        pub slope: if_any(9, u16),
    }
}

impl Grid<'_> {
    fn check(&self) -> Result<(), ArchiveError> {
        let n = u64::from(self.head.width) * u64::from(self.head.height);
        let lengths = self.layer_lengths().map(|l| l as u64);
        let (always, heights) = lengths.split_at(GridLayers::N_ALWAYS - 1);
        let is_level = heights.iter().all(|&l| l == 0);
        let is_whole = always.iter().all(|&l| l == n) && (is_level || heights.iter().all(|&l| l == n));
        if !is_whole || self.head.cell_tenths <= 0 {
            return Err(ArchiveError::Index { what: "a layer" });
        }
        check_tags([self.head.floor], "kind of floor")?;
        check_tags(bytemuck::cast_slice::<u8, Tag<Class>>(self.class).iter().copied(), "class")
    }

    /// Where the grid lies.
    pub fn spec(&self) -> GridSpec {
        self.head.spec()
    }

    /// Height of the ground in the middle of a cell in `map`, in tenths of a millimetre; `None` where there is none. On a level storey
    /// it is that of the floor.
    pub fn height_tenths(&self, cell: usize) -> Option<i32> {
        match self.elevation.get(cell) {
            Some(&height) => Some(height).filter(|&height| height != NO_HEIGHT),
            None => Some(self.head.floor_z_tenths).filter(|_| self.floor[cell] != 0),
        }
    }

    /// Slope of the ground in the middle of a cell, in radians; `None` where there is none. On a level storey it is 0.
    pub fn slope_rad(&self, cell: usize) -> Option<f64> {
        match self.slope.get(cell) {
            Some(&slope) => Some(f64::from(slope) * 0.001).filter(|_| slope != NO_SLOPE),
            None => Some(0.0).filter(|_| self.floor[cell] != 0),
        }
    }

    /// Class of what a cell shows.
    pub fn class_of(&self, cell: usize) -> Class {
        Class::ALL[usize::from(self.class[cell])]
    }

    /// True if a robot's centre must not be in this cell although nothing may stand there.
    pub fn is_keepout(&self, cell: usize) -> bool {
        self.keepout[cell] > 0
    }
}

/// Writes a grid in the memory where it will be read.
#[derive(Debug)]
pub struct GridWriter<'a> {
    out: &'a mut [u8],
    place: Place,
}

/// Where the sections of a grid lie.
#[derive(Debug, Clone)]
struct Place {
    n_sections: usize,
    sections: [Range<usize>; N_SECTIONS],
    length: usize,
}

impl Place {
    fn of(n_cells: usize, n_sections: usize) -> Self {
        let (sections, length) = layout(&GridLayers::layouts(n_cells), n_sections);
        Self { n_sections, sections, length }
    }

    /// The sections of a grid in memory of a length.
    fn in_memory(n_cells: usize, length: usize) -> Self {
        let of_length = [GridLayers::N_ALWAYS, N_SECTIONS].map(|n| Self::of(n_cells, n));
        of_length.into_iter().find(|place| place.length == length).expect("the memory has the grid's length")
    }

    fn head<'a>(&self, grid: &'a [u8]) -> &'a GridHead {
        bytemuck::from_bytes(&grid[self.sections[0].clone()])
    }
}

impl<'a> GridWriter<'a> {
    /// Bytes that a grid of this many cells needs on a level storey.
    pub fn len_of(n_cells: usize) -> usize {
        Place::of(n_cells, GridLayers::N_ALWAYS).length
    }

    /// The same with the heights of its cells.
    pub fn len_with_heights(n_cells: usize) -> usize {
        Place::of(n_cells, N_SECTIONS).length
    }

    /// Begins a grid in memory of exactly [`Self::len_of`] or [`Self::len_with_heights`] bytes at a multiple of 64. Its layers hold
    /// zeros, but for heights and slopes: there are none.
    ///
    /// # Panics
    /// If the memory has another length than the grid needs.
    pub fn new(out: &'a mut [u8], head: &GridHead) -> Self {
        let layouts = GridLayers::layouts(head.spec().n_cells());
        let place = Place::in_memory(head.spec().n_cells(), out.len());
        write_table(out, &layouts[..place.n_sections]);
        out[place.sections[0].clone()].copy_from_slice(bytemuck::bytes_of(head));
        place.sections[1..].iter().for_each(|layer| out[layer.clone()].fill(0));
        let mut writer = Self { out, place };
        let GridLayers { elevation, slope, .. } = writer.layers();
        elevation.fill(NO_HEIGHT);
        slope.fill(NO_SLOPE);
        writer
    }

    /// Goes on with a grid of `n_cells` that was begun in this memory, sealed or not.
    ///
    /// # Panics
    /// If the memory has another length than the grid needs.
    pub fn resume(out: &'a mut [u8], n_cells: usize) -> Self {
        let place = Place::in_memory(n_cells, out.len());
        Self { out, place }
    }

    /// The layers, as they were written so far.
    pub fn layers(&mut self) -> GridLayers<'_> {
        GridLayers::of(self.out, &self.place.sections)
    }

    /// Makes it an archive; returns its content hash.
    pub fn seal(self) -> ContentHash {
        seal(self.out, ArchiveKind::Grid, self.place.n_sections)
    }

    /// The same, after nothing but cells in these rectangles changed since the hashes were made; all are made if there are none.
    pub fn seal_changed(self, hashes: &mut BlockHashes, changed: &[CellRect]) -> ContentHash {
        let content = &self.out[64..];
        let BlockHashes { hashes, is_changed } = hashes;
        is_changed.clear();
        is_changed.resize(content.len().div_ceil(HASHED_BLOCK), hashes.is_empty());
        hashes.resize(is_changed.len(), 0);
        let spec = self.place.head(self.out).spec();
        for bytes in changed.iter().flat_map(|rect| cell_bytes(spec, &self.place.sections, rect)) {
            is_changed[(bytes.start - 64) / HASHED_BLOCK..=(bytes.end - 1 - 64) / HASHED_BLOCK].fill(true);
        }
        let blocks = content.chunks(HASHED_BLOCK).zip(hashes.iter_mut()).zip(&*is_changed);
        blocks.filter(|(_, changed)| **changed).for_each(|((block, hash), _)| *hash = xxh3_64(block));
        let content_hash = hash_of_blocks(hashes.iter().copied());
        write_preamble(self.out, ArchiveKind::Grid, self.place.n_sections, content_hash);
        content_hash
    }
}

/// Hashes of the blocks of a grid, kept from one version to the next.
#[derive(Debug, Default)]
pub struct BlockHashes {
    hashes: Vec<u64>,
    /// Buffer of [`GridWriter::seal_changed`].
    is_changed: Vec<bool>,
}

/// Where the cells of a rectangle lie in a grid, in all layers. They are not empty.
fn cell_bytes<'a>(
    spec: GridSpec,
    sections: &'a [Range<usize>; N_SECTIONS],
    rect: &CellRect,
) -> impl Iterator<Item = Range<usize>> + use<'a> {
    let rect = *rect;
    sections[1..].iter().filter(|layer| !layer.is_empty()).flat_map(move |layer| {
        let (start, size) = (layer.start, layer.len() / spec.n_cells().max(1));
        let rows = rect.rows(spec.width as usize).filter(|row| !row.is_empty());
        rows.map(move |row| start + row.start * size..start + row.end * size)
    })
}

/// Makes of a copy of an earlier version of a grid one of this version, of which nothing but cells in these rectangles differs. The
/// copy is no archive until it is whole.
///
/// # Panics
/// If the two have other lengths.
pub fn copy_changed<'a>(grid: &[u8], copy: &mut [u8], changed: impl Iterator<Item = &'a CellRect>) {
    assert_eq!(grid.len(), copy.len(), "both are versions of one grid");
    copy[..64].fill(0);
    let n_sections = if Preamble::of(grid, ArchiveKind::Grid).is_ok_and(|p| p.n_sections as usize == N_SECTIONS) {
        N_SECTIONS
    } else {
        GridLayers::N_ALWAYS
    };
    // The head is the first section, however many cells follow.
    let spec = Place::of(0, n_sections).head(grid).spec();
    let Place { sections, .. } = Place::of(spec.n_cells(), n_sections);
    let before_layers = 64..sections[1].start;
    copy[before_layers.clone()].copy_from_slice(&grid[before_layers]);
    for bytes in changed.flat_map(|rect| cell_bytes(spec, &sections, rect)) {
        copy[bytes.clone()].copy_from_slice(&grid[bytes]);
    }
    copy[..64].copy_from_slice(&grid[..64]);
}

const N_SECTIONS: usize = GridLayers::N_SECTIONS;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ArchiveBuffer;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_grid_of_which_cells_changed_is_sealed_and_copied_as_if_it_were_new(
            size in [1u32..300, 1u32..120],
            has_heights in any::<bool>(),
            changes in prop::collection::vec(([0.0..1.0f64, 0.0..1.0], [0.0..0.3f64, 0.0..0.3]), 1..5),
        ) {
            let [width, height] = size;
            let head = GridHead { cell_tenths: 500, width, height, ..GridHead::EMPTY };
            let n_cells = head.spec().n_cells();
            let len_of = if has_heights { GridWriter::len_with_heights } else { GridWriter::len_of };
            let mut grid = ArchiveBuffer::zeroed(len_of(n_cells));
            let mut hashes = BlockHashes::default();
            GridWriter::new(grid.bytes_mut(), &head).seal_changed(&mut hashes, &[]);
            let mut copy = ArchiveBuffer::zeroed(grid.bytes().len());
            copy.bytes_mut().copy_from_slice(grid.bytes());
            for (at, extent) in changes {
                let min = [0, 1].map(|k| (at[k] * f64::from(size[k])) as u32);
                let max = [0, 1].map(|k| (min[k] + (extent[k] * f64::from(size[k])) as u32).min(size[k]));
                let rect = CellRect { min, max };
                let mut writer = GridWriter::resume(grid.bytes_mut(), n_cells);
                let layers = writer.layers();
                for cell in rect.rows(width as usize).flatten() {
                    (layers.class[cell], layers.planning[cell], layers.space[cell]) = (3, 100, layers.space[cell] + 259);
                    layers.elevation.get_mut(cell).into_iter().for_each(|z| *z = 7_000);
                }
                let hash = writer.seal_changed(&mut hashes, &[rect]);
                prop_assert_eq!(GridWriter::resume(grid.bytes_mut(), n_cells).seal(), hash);
                prop_assert!(Grid::open(grid.bytes()).is_ok());
                copy_changed(grid.bytes(), copy.bytes_mut(), [rect].iter());
                prop_assert!(copy.bytes() == grid.bytes());
            }
        }
    }

    #[test]
    #[should_panic(expected = "versions of one grid")]
    fn a_copy_of_another_size_is_none() {
        let (small, mut large) = (ArchiveBuffer::zeroed(64), ArchiveBuffer::zeroed(128));
        copy_changed(small.bytes(), large.bytes_mut(), [].iter());
    }

    #[test]
    fn layers_are_written_in_place_and_read_back() {
        let head = GridHead { cell_tenths: 500, width: 3, height: 5, ..GridHead::EMPTY };
        let mut buffer = ArchiveBuffer::zeroed(GridWriter::len_of(15));
        buffer.bytes_mut().fill(0xAA);
        let mut writer = GridWriter::new(buffer.bytes_mut(), &head);
        let layers = writer.layers();
        layers.class[14] = 3;
        layers.planning.fill(-1);
        layers.space[0] = 513;
        let hash = writer.seal();
        let grid = Grid::open(buffer.bytes()).unwrap();
        assert_eq!((grid.class[14], grid.planning[7], grid.space[0], grid.floor[3]), (3, -1, 513, 0));
        assert_eq!(grid.content_hash(), hash);

        let mut writer = GridWriter::resume(buffer.bytes_mut(), 15);
        writer.layers().floor[3] = 1;
        assert_ne!(writer.seal(), hash);
        let grid = Grid::open(buffer.bytes()).unwrap();
        assert_eq!((grid.class[14], grid.planning[7], grid.space[0], grid.floor[3]), (3, -1, 513, 1));
    }
}
