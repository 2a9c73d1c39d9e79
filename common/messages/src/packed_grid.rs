//! Grids in the heap, as they are or packed: the outside of a site and the inside of rooms are the same word over many cells.

use crate::archive::{ArchiveBuffer, ArchiveError, Block};
use crate::checked::Checked;
use crate::content_hash::ContentHash;
use crate::grid_archive::{Grid, GridHead};
use crate::payload::{self, Payload};

/// The grid of a map storey in the heap.
#[derive(Debug)]
pub struct HeldGrid {
    head: GridHead,
    content_hash: ContentHash,
    archive: HeldArchive,
}

#[derive(Debug)]
enum HeldArchive {
    Open(Checked<payload::Grid>),
    Packed(PackedGrid),
}

impl HeldGrid {
    /// Validates an archive and keeps it.
    ///
    /// # Errors
    /// Those of [`Grid::open`].
    pub fn open(archive: ArchiveBuffer) -> Result<Self, ArchiveError> {
        let checked = Checked::<payload::Grid>::new(archive)?;
        let (head, content_hash) = (*checked.view().head, checked.content_hash());
        Ok(Self { head, content_hash, archive: HeldArchive::Open(checked) })
    }

    /// Validates an archive and packs it.
    ///
    /// # Errors
    /// Those of [`Grid::open`].
    pub fn packed(archive: ArchiveBuffer) -> Result<Self, ArchiveError> {
        let grid = Grid::open(archive.bytes())?;
        let (head, content_hash) = (*grid.head, grid.content_hash());
        Ok(Self { head, content_hash, archive: HeldArchive::Packed(PackedGrid::of(&archive)) })
    }

    /// Specification and slab.
    pub fn head(&self) -> &GridHead {
        &self.head
    }

    /// Hash of the content.
    pub fn content_hash(&self) -> ContentHash {
        self.content_hash
    }

    /// Calls `work` with the view.
    pub fn view(&self, work: &mut dyn FnMut(&Grid<'_>)) {
        match &self.archive {
            HeldArchive::Open(checked) => work(&checked.view()),
            HeldArchive::Packed(packed) => {
                let archive = packed.unpacked();
                let grid = payload::Grid::view(archive.bytes());
                work(&grid.expect("the archive was validated before it was packed"));
            }
        }
    }
}

/// The archive of a grid, in which blocks of one repeated word take no room.
#[derive(Debug)]
struct PackedGrid {
    /// Bytes of the archive.
    length: usize,
    stretches: Vec<Stretch>,
    /// The blocks that do not repeat a word, in their order.
    mixed: Vec<Block>,
}

/// Blocks that repeat a word, then blocks that do not.
#[derive(Debug, Clone, Copy)]
struct Stretch {
    word: u64,
    n_even: u32,
    n_mixed: u32,
}

impl PackedGrid {
    fn of(archive: &ArchiveBuffer) -> Self {
        let mut stretches: Vec<Stretch> = Vec::new();
        let mut mixed = Vec::new();
        for block in archive.blocks() {
            match (repeated_word(block), stretches.last_mut()) {
                (Some(word), Some(last)) if last.n_mixed == 0 && last.word == word && last.n_even < u32::MAX => {
                    last.n_even += 1;
                }
                (Some(word), _) => stretches.push(Stretch { word, n_even: 1, n_mixed: 0 }),
                (None, Some(last)) if last.n_mixed < u32::MAX => {
                    last.n_mixed += 1;
                    mixed.push(*block);
                }
                (None, _) => {
                    stretches.push(Stretch { word: 0, n_even: 0, n_mixed: 1 });
                    mixed.push(*block);
                }
            }
        }
        stretches.shrink_to_fit();
        mixed.shrink_to_fit();
        Self { length: archive.bytes().len(), stretches, mixed }
    }

    fn unpacked(&self) -> ArchiveBuffer {
        let mut blocks = Vec::with_capacity(self.length.div_ceil(size_of::<Block>()));
        let mut mixed = self.mixed.as_slice();
        for stretch in &self.stretches {
            let even = Block(bytemuck::cast([stretch.word; WORDS]));
            blocks.resize(blocks.len() + stretch.n_even as usize, even);
            let (own, rest) = mixed.split_at(stretch.n_mixed as usize);
            blocks.extend_from_slice(own);
            mixed = rest;
        }
        ArchiveBuffer::of_blocks(blocks, self.length)
    }
}

/// Words of a block.
const WORDS: usize = size_of::<Block>() / size_of::<u64>();

/// The word that a block repeats.
fn repeated_word(block: &Block) -> Option<u64> {
    let words: [u64; WORDS] = bytemuck::cast(block.0);
    words.iter().all(|word| *word == words[0]).then_some(words[0])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid_archive::GridWriter;
    use proptest::prelude::*;

    /// A grid of runs of values, cell after cell.
    fn grid(width: u32, height: u32, runs: &[(u8, usize)]) -> ArchiveBuffer {
        let head = GridHead { cell_tenths: 500, width, height, ..GridHead::EMPTY };
        let mut buffer = ArchiveBuffer::zeroed(GridWriter::len_of(head.spec().n_cells()));
        let mut writer = GridWriter::new(buffer.bytes_mut(), &head);
        let layers = writer.layers();
        let mut cells = 0..layers.class.len();
        for (value, n) in runs {
            for cell in cells.by_ref().take(*n) {
                (layers.class[cell], layers.planning[cell]) = (*value, -(*value as i8));
                (layers.floor[cell], layers.space[cell]) = (*value, u16::from(*value) * 300);
            }
        }
        writer.seal();
        buffer
    }

    proptest! {
        #[test]
        fn a_packed_grid_is_unpacked_to_the_same_bytes(
            size in (1u32..70, 1u32..40),
            runs in prop::collection::vec((0u8..4, 0usize..400), 0..20),
        ) {
            let archive = grid(size.0, size.1, &runs);
            let unpacked = PackedGrid::of(&archive).unpacked();
            prop_assert_eq!(unpacked.bytes(), archive.bytes());
            let whole = Grid::open(archive.bytes()).unwrap();
            let packed = HeldGrid::packed(archive.clone()).unwrap();
            prop_assert_eq!((packed.head(), packed.content_hash()), (whole.head, whole.content_hash()));
            let mut n_views = 0;
            packed.view(&mut |grid| {
                n_views += 1;
                assert_eq!((grid.class, grid.space), (whole.class, whole.space));
            });
            prop_assert_eq!(n_views, 1);
        }
    }

    #[test]
    fn what_is_even_takes_no_room() {
        let archive = grid(500, 400, &[(3, 1_000)]);
        let n_bytes = archive.bytes().len();
        let packed = PackedGrid::of(&archive);
        assert!(packed.mixed.len() * size_of::<Block>() < n_bytes / 1_000, "{} blocks", packed.mixed.len());
    }

    #[test]
    fn a_damaged_grid_is_refused() {
        let mut archive = grid(20, 20, &[]);
        let last = archive.bytes().len() - 1;
        archive.bytes_mut()[last] ^= 1;
        assert!(HeldGrid::packed(archive).is_err());
    }
}
