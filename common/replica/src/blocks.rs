//! Blocks of archives: cut where their content says so, compressed one by one, and known by the sha256 of what they hold.

use fastcdc::v2020::FastCDC;
use messages::ContentId;
use std::ops::{Range, RangeInclusive};
use zstd::bulk;

/// Level of zstd: grids are runs of equal bytes, which higher levels make hardly smaller.
const LEVEL: i32 = 3;

/// From this length on an archive has larger blocks, so that a recipe has thousands of blocks at most.
const LARGE_ARCHIVE: u64 = 512 << 20;

/// How long the blocks of an archive are. The last one may be shorter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct BlockLengths {
    min: usize,
    average: usize,
    max: usize,
}

const SMALL: BlockLengths = BlockLengths { min: 32 << 10, average: 128 << 10, max: 512 << 10 };
const LARGE: BlockLengths = BlockLengths { min: 512 << 10, average: 2 << 20, max: 4 << 20 };

/// A block that is not what it should be.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum BadBlock {
    /// It cannot be unpacked to so many bytes.
    #[error("a block cannot be unpacked to {bytes} bytes")]
    Packed {
        /// Its length.
        bytes: u64,
    },
    /// It holds something else.
    #[error("a block has another sha256 than its recipe says")]
    Content,
}

impl BlockLengths {
    fn of(archive_bytes: u64) -> Self {
        if archive_bytes < LARGE_ARCHIVE { SMALL } else { LARGE }
    }
}

/// Lengths that blocks of an archive of this length can have, but for the last one, which may be shorter.
pub(crate) fn block_lengths(archive_bytes: u64) -> RangeInclusive<u64> {
    let BlockLengths { min, max, .. } = BlockLengths::of(archive_bytes);
    min as u64..=max as u64
}

/// Where an archive is cut: the same bytes around a place are a cut wherever they lie, so that what is inserted or left out changes the
/// blocks around it alone.
pub(crate) fn cut(archive: &[u8]) -> impl Iterator<Item = Range<usize>> + '_ {
    let BlockLengths { min, average, max } = BlockLengths::of(archive.len() as u64);
    FastCDC::new(archive, min, average, max).map(|chunk| chunk.offset..chunk.offset + chunk.length)
}

/// A block, compressed.
pub(crate) fn pack_block(block: &[u8]) -> Vec<u8> {
    bulk::compress(block, LEVEL).expect("zstd compresses any bytes into a buffer of its own")
}

/// What a block holds: exactly so many bytes with this sha256.
///
/// # Errors
/// Other bytes.
pub fn unpack_block(packed: &[u8], bytes: u64, id: ContentId) -> Result<Vec<u8>, BadBlock> {
    let bad = BadBlock::Packed { bytes };
    let capacity = usize::try_from(bytes).ok().filter(|bytes| *bytes <= LARGE.max).ok_or_else(|| bad.clone())?;
    let block = bulk::decompress(packed, capacity).map_err(|_| bad.clone())?;
    if block.len() != capacity {
        return Err(bad);
    }
    if ContentId::of(&block) != id {
        return Err(BadBlock::Content);
    }
    Ok(block)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// Bytes that zstd cannot make small.
    pub(crate) fn noise(seed: u64, length: usize) -> Vec<u8> {
        let mut state = seed.wrapping_mul(2).wrapping_add(1);
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as u8
        };
        (0..length).map(|_| next()).collect()
    }

    #[test]
    fn blocks_are_the_whole_archive_and_as_long_as_they_may_be() {
        for archive in [Vec::new(), vec![7], vec![0; 5 << 20], noise(1, 5 << 20), vec![0; SMALL.min]] {
            let blocks: Vec<Range<usize>> = cut(&archive).collect();
            let joined: Vec<u8> = blocks.iter().flat_map(|block| archive[block.clone()].to_vec()).collect();
            assert!(joined == archive, "{} bytes", archive.len());
            let lengths = block_lengths(archive.len() as u64);
            let (last, others) = blocks.split_last().map_or((0..0, &[][..]), |(last, others)| (last.clone(), others));
            assert!(others.iter().all(|block| lengths.contains(&(block.len() as u64))), "{blocks:?}");
            assert!(last.len() <= SMALL.max && (archive.is_empty() || !last.is_empty()));
            assert_eq!(blocks, cut(&archive).collect::<Vec<_>>());
        }
    }

    #[test]
    fn a_block_that_unpacks_to_more_or_less_is_refused_before_it_has_room() {
        let bomb = pack_block(&vec![0; 1 << 20]);
        assert!(bomb.len() < 1_000);
        let id = ContentId::of(&vec![0; 1 << 20]);
        assert!(unpack_block(&bomb, 1 << 20, id).is_ok());
        for wrong in [0, 1, (1 << 20) - 1, (1 << 20) + 1, LARGE.max as u64 + 1, u64::MAX] {
            assert_eq!(unpack_block(&bomb, wrong, id), Err(BadBlock::Packed { bytes: wrong }));
        }
        assert_eq!(unpack_block(b"no zstd", 7, id), Err(BadBlock::Packed { bytes: 7 }));
        assert_eq!(unpack_block(&pack_block(b"other"), 5, id), Err(BadBlock::Content));
    }
}
