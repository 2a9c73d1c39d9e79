//! Blocks of archives: compressed one by one, and known by the sha256 of what they hold.

use messages::ContentId;
use zstd::bulk;

/// Level of zstd: grids are runs of equal bytes, which higher levels make hardly smaller.
const LEVEL: i32 = 3;

/// Bytes of a block of an archive up to [`LARGE_ARCHIVE`].
const SMALL_BLOCK: u64 = 256 << 10;

/// From here on blocks are larger, so that a recipe has thousands of blocks at most.
const LARGE_ARCHIVE: u64 = 512 << 20;

/// Bytes of a block of a large archive.
const LARGE_BLOCK: u64 = 2 << 20;

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

/// Bytes of the blocks of an archive of this length.
pub(crate) fn block_bytes(archive_bytes: u64) -> u64 {
    if archive_bytes < LARGE_ARCHIVE { SMALL_BLOCK } else { LARGE_BLOCK }
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
    let capacity = usize::try_from(bytes).ok().filter(|_| bytes <= LARGE_BLOCK).ok_or_else(|| bad.clone())?;
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
mod tests {
    use super::*;

    #[test]
    fn a_block_that_unpacks_to_more_or_less_is_refused_before_it_has_room() {
        let bomb = pack_block(&vec![0; 1 << 20]);
        assert!(bomb.len() < 1_000);
        let id = ContentId::of(&vec![0; 1 << 20]);
        assert!(unpack_block(&bomb, 1 << 20, id).is_ok());
        for wrong in [0, 1, (1 << 20) - 1, (1 << 20) + 1, LARGE_BLOCK + 1, u64::MAX] {
            assert_eq!(unpack_block(&bomb, wrong, id), Err(BadBlock::Packed { bytes: wrong }));
        }
        assert_eq!(unpack_block(b"no zstd", 7, id), Err(BadBlock::Packed { bytes: 7 }));
        assert_eq!(unpack_block(&pack_block(b"other"), 5, id), Err(BadBlock::Content));
    }
}
