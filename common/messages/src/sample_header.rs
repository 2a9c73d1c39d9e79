//! User header of a sample: epoch, stamp, hashes of content and inputs.

use crate::archive::LAYOUT_VERSION;
use crate::archive_kind::ArchiveKind;
use crate::content_hash::ContentHash;
use bytemuck::{Pod, Zeroable};

/// First bytes of every header.
pub(crate) const MAGIC: u32 = u32::from_le_bytes(*b"GPSH");

/// Content hashes of the inputs of a sample; none for those that it does not depend on.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Zeroable, Pod)]
#[repr(C)]
pub struct InputHashes {
    /// The site.
    pub site: ContentHash,
    /// The schedule state.
    pub schedule_state: ContentHash,
    /// The index of the grids.
    pub grids: ContentHash,
    /// The robot profile.
    pub robot: ContentHash,
    /// The robot's own map.
    pub slam_map: ContentHash,
    /// Only that part of the inputs which can change the content; none if the producer does not compute it.
    pub own: ContentHash,
}

/// Header of a sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Zeroable, Pod)]
#[repr(C)]
pub struct SampleHeader {
    /// `GPSH`.
    pub magic: u32,
    /// [`LAYOUT_VERSION`].
    pub layout_version: u32,
    /// [`ArchiveKind`] as a number.
    pub kind: u32,
    /// Zero.
    pub flags: u32,
    /// Counts the samples of a topic over all lives of its producer; never falls.
    pub epoch: u64,
    /// Monotonic time of publication in nanoseconds, of the machine's boot.
    pub stamp_ns: u64,
    /// Length of the archive in bytes.
    pub payload_length: u64,
    /// Hash of the archive's content, as in its preamble.
    pub content_hash: ContentHash,
    /// Counts the changes of the site's map frame.
    pub frame_epoch: u64,
    /// What it was made from.
    pub inputs: InputHashes,
    /// Zero.
    pub reserved: [u64; 3],
}
const _: () = assert!(size_of::<SampleHeader>() == 128 && align_of::<SampleHeader>() == 8);

/// Why a sample is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum SampleError {
    /// Does not begin with `GPSH`.
    #[error("the sample has no groundplan header")]
    NoHeader,
    /// Another layout.
    #[error("the sample has layout version {found}, this program reads {LAYOUT_VERSION}")]
    Version {
        /// As written.
        found: u32,
    },
    /// Another kind of archive.
    #[error("the sample holds an archive of kind {found}, not {wanted:?}")]
    Kind {
        /// As written.
        found: u32,
        /// As asked for.
        wanted: ArchiveKind,
    },
    /// The payload is shorter than the header says.
    #[error("the sample has {length} bytes, its header says {expected}")]
    Truncated {
        /// Bytes at hand.
        length: usize,
        /// As written.
        expected: u64,
    },
}

impl SampleHeader {
    /// Header of an archive of this kind; everything else is zero.
    pub fn of(kind: ArchiveKind) -> Self {
        Self { magic: MAGIC, layout_version: LAYOUT_VERSION, kind: kind as u32, ..Zeroable::zeroed() }
    }

    /// Checks a received header against a payload of `length` bytes.
    ///
    /// # Errors
    /// No header, another layout version, another kind, a payload that is too short.
    pub fn check(&self, wanted: ArchiveKind, length: usize) -> Result<(), SampleError> {
        if self.magic != MAGIC {
            return Err(SampleError::NoHeader);
        }
        if self.layout_version != LAYOUT_VERSION {
            return Err(SampleError::Version { found: self.layout_version });
        }
        if self.kind != wanted as u32 {
            return Err(SampleError::Kind { found: self.kind, wanted });
        }
        if self.payload_length > length as u64 {
            return Err(SampleError::Truncated { length, expected: self.payload_length });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_layout_is_refused_with_both_versions() {
        let header = SampleHeader { layout_version: 99, ..SampleHeader::of(ArchiveKind::MissionPlan) };
        let text = header.check(ArchiveKind::MissionPlan, 0).unwrap_err().to_string();
        assert!(text.contains("99") && text.contains(&LAYOUT_VERSION.to_string()), "{text}");
    }

    #[test]
    fn only_a_header_of_the_kind_and_length_passes() {
        let header = SampleHeader { payload_length: 64, ..SampleHeader::of(ArchiveKind::Grid) };
        assert_eq!(header.check(ArchiveKind::Grid, 64), Ok(()));
        assert_eq!(header.check(ArchiveKind::Grid, 63), Err(SampleError::Truncated { length: 63, expected: 64 }));
        assert!(matches!(header.check(ArchiveKind::MissionPlan, 64), Err(SampleError::Kind { .. })));
        assert_eq!(SampleHeader { magic: 0, ..header }.check(ArchiveKind::Grid, 64), Err(SampleError::NoHeader));
    }
}
