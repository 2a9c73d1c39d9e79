//! Archive container: preamble, section table, string section.

use crate::archive_kind::ArchiveKind;
use crate::content_hash::ContentHash;
use crate::robot::RobotLimitError;
use bytemuck::{AnyBitPattern, NoUninit, Pod, Zeroable};
use std::ops::Range;
use xxhash_rust::xxh3::{Xxh3Default, xxh3_64};

/// Version of all layouts of this crate; a reader refuses any other.
pub const LAYOUT_VERSION: u32 = 1;

/// An index that points at nothing.
pub const NONE: u32 = u32::MAX;

/// First bytes of every archive.
pub(crate) const MAGIC: u32 = u32::from_le_bytes(*b"GPAR");

/// Sections an archive may have.
const MAX_SECTIONS: usize = 64;

/// 64 bytes at a multiple of 64: the unit in which archives are stored.
#[derive(Debug, Clone, Copy, Zeroable, Pod)]
#[repr(C, align(64))]
pub struct Block(pub(crate) [u8; 64]);

/// The first 64 bytes of an archive.
#[derive(Debug, Clone, Copy, Zeroable, Pod)]
#[repr(C)]
pub struct Preamble {
    /// `GPAR`.
    pub magic: u32,
    /// [`LAYOUT_VERSION`].
    pub layout_version: u32,
    /// [`ArchiveKind`] as a number.
    pub kind: u32,
    /// Entries of the section table.
    pub n_sections: u32,
    /// Length of the archive in bytes, preamble included.
    pub length: u64,
    /// xxh3 of everything behind the preamble; of a grid, xxh3 of the xxh3 of each [`HASHED_BLOCK`] of it.
    pub content_hash: ContentHash,
    /// Zero.
    pub reserved: [u64; 4],
}
const _: () = assert!(size_of::<Preamble>() == 64);

impl Preamble {
    /// The preamble of bytes at a multiple of 64; the content behind it is not validated.
    ///
    /// # Errors
    /// Bytes that do not begin as an archive of the wanted kind and this layout version, or are shorter than it says.
    pub fn of(bytes: &[u8], wanted: ArchiveKind) -> Result<&Self, ArchiveError> {
        if !(bytes.as_ptr() as usize).is_multiple_of(64) {
            return Err(ArchiveError::Misaligned);
        }
        let truncated = |expected| ArchiveError::Truncated { length: bytes.len(), expected };
        let preamble: &Self = bytemuck::from_bytes(bytes.get(..64).ok_or(truncated(64))?);
        if preamble.magic != MAGIC {
            return Err(ArchiveError::NoArchive);
        }
        if preamble.layout_version != LAYOUT_VERSION {
            return Err(ArchiveError::Version { found: preamble.layout_version });
        }
        if preamble.kind != wanted as u32 {
            return Err(ArchiveError::Kind { found: preamble.kind, wanted });
        }
        if preamble.length < 64 || preamble.length > bytes.len() as u64 {
            return Err(truncated(preamble.length));
        }
        Ok(preamble)
    }
}

/// An entry of the section table, which follows the preamble.
#[derive(Debug, Clone, Copy, Zeroable, Pod)]
#[repr(C)]
pub(crate) struct SectionEntry {
    /// Which section; meaning by archive kind.
    pub(crate) id: u32,
    /// Bytes per record.
    pub(crate) record_len: u32,
    /// Offset of the first record from the archive's start, a multiple of 64.
    pub(crate) offset: u64,
    /// Number of records.
    pub(crate) count: u64,
}
const _: () = assert!(size_of::<SectionEntry>() == 24);

/// A text in the archive's string section: UTF-8 bytes `offset..offset + length`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Zeroable, Pod)]
#[repr(C)]
pub struct Text {
    /// First byte.
    pub offset: u32,
    /// Bytes.
    pub length: u32,
}

/// A list of texts: entries `first..first + count` of the archive's section of listed texts.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Zeroable, Pod)]
#[repr(C)]
pub struct TextList {
    /// First entry.
    pub first: u32,
    /// Number of entries.
    pub count: u32,
}

/// Why bytes are not the archive that a reader wants.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ArchiveError {
    /// Shorter than it says, or than a preamble.
    #[error("the archive is cut off: {length} bytes of {expected}")]
    Truncated {
        /// Bytes at hand.
        length: usize,
        /// Bytes needed.
        expected: u64,
    },
    /// Not at a multiple of 64.
    #[error("the archive does not lie at a multiple of 64 bytes")]
    Misaligned,
    /// Does not begin with `GPAR`.
    #[error("these bytes are no groundplan archive")]
    NoArchive,
    /// Another layout.
    #[error("the archive has layout version {found}, this program reads {LAYOUT_VERSION}")]
    Version {
        /// As written.
        found: u32,
    },
    /// Another kind of archive.
    #[error("the archive is of kind {found}, not {wanted:?}")]
    Kind {
        /// As written.
        found: u32,
        /// As asked for.
        wanted: ArchiveKind,
    },
    /// The content does not match its hash.
    #[error("the archive's content does not match its hash")]
    Hash,
    /// A section is missing, out of bounds or of other records.
    #[error("section {id} of the archive is missing or damaged")]
    Section {
        /// The section.
        id: u32,
    },
    /// A section has more records than it may have.
    #[error("section {id} of the archive has more than {max} records")]
    Limit {
        /// The section.
        id: u32,
        /// As many as it may have.
        max: usize,
    },
    /// A record points outside its section.
    #[error("{what} of the archive points outside its section")]
    Index {
        /// Which records.
        what: &'static str,
    },
    /// An enumeration has no such number.
    #[error("the archive has an unknown {what}")]
    Unknown {
        /// Which enumeration.
        what: &'static str,
    },
    /// The robot is none.
    #[error("the robot of the archive: {0}")]
    Robot(RobotLimitError),
}

/// The memory of an archive in the heap.
#[derive(Debug, Clone, Default)]
pub struct ArchiveBuffer {
    blocks: Vec<Block>,
    length: usize,
}

impl ArchiveBuffer {
    /// Zeroed memory for an archive of `length` bytes.
    pub fn zeroed(length: usize) -> Self {
        Self { blocks: vec![Block([0; 64]); length.div_ceil(64)], length }
    }

    /// The archive of `length` bytes in blocks.
    pub(crate) fn of_blocks(blocks: Vec<Block>, length: usize) -> Self {
        assert_eq!(blocks.len(), length.div_ceil(64), "the blocks hold the archive");
        Self { blocks, length }
    }

    /// The blocks in which it lies.
    pub(crate) fn blocks(&self) -> &[Block] {
        &self.blocks
    }

    /// A copy of bytes at a multiple of 64.
    pub fn copy_of(bytes: &[u8]) -> Self {
        let mut buffer = Self::zeroed(bytes.len());
        buffer.bytes_mut().copy_from_slice(bytes);
        buffer
    }

    /// The bytes.
    pub fn bytes(&self) -> &[u8] {
        &bytemuck::cast_slice(&self.blocks)[..self.length]
    }

    /// The bytes, for writing.
    pub fn bytes_mut(&mut self) -> &mut [u8] {
        &mut bytemuck::cast_slice_mut(&mut self.blocks)[..self.length]
    }
}

impl AsRef<[u8]> for ArchiveBuffer {
    fn as_ref(&self) -> &[u8] {
        self.bytes()
    }
}

/// A validated archive: preamble, section table and hash are right, sections lie inside.
#[derive(Debug, Clone, Copy)]
pub struct Archive<'a> {
    bytes: &'a [u8],
    sections: &'a [SectionEntry],
}

impl<'a> Archive<'a> {
    /// Checks the bytes once; views read them in place afterwards.
    ///
    /// # Errors
    /// Anything that is not a whole archive of the wanted kind and this layout version.
    pub fn open(bytes: &'a [u8], wanted: ArchiveKind) -> Result<Self, ArchiveError> {
        let archive = Self::open_unhashed(bytes, wanted)?;
        let is_whole = content_hash(wanted, &archive.bytes[64..]) == archive.content_hash();
        if is_whole { Ok(archive) } else { Err(ArchiveError::Hash) }
    }

    /// As [`Self::open`], of bytes whose content was compared with its hash before.
    pub(crate) fn open_unhashed(bytes: &'a [u8], wanted: ArchiveKind) -> Result<Self, ArchiveError> {
        let preamble = Preamble::of(bytes, wanted)?;
        let bytes = &bytes[..preamble.length as usize];
        let length = bytes.len();
        let n_sections = preamble.n_sections as usize;
        let table_end = 64 + n_sections.min(MAX_SECTIONS + 1) * size_of::<SectionEntry>();
        if n_sections > MAX_SECTIONS || table_end > length {
            return Err(ArchiveError::Truncated { length, expected: table_end as u64 });
        }
        let sections: &[SectionEntry] = bytemuck::cast_slice(&bytes[64..table_end]);
        for entry in sections {
            let end = entry.count.checked_mul(u64::from(entry.record_len)).and_then(|l| l.checked_add(entry.offset));
            // A section in the preamble or the table would be read as records.
            let is_behind_table = table_end as u64 <= entry.offset;
            if !is_behind_table || !entry.offset.is_multiple_of(64) || end.is_none_or(|end| end > preamble.length) {
                return Err(ArchiveError::Section { id: entry.id });
            }
        }
        Ok(Self { bytes, sections })
    }

    /// Hash of the content, as in the preamble.
    pub fn content_hash(&self) -> ContentHash {
        content_hash_of(self.bytes)
    }

    /// All bytes of the archive.
    pub fn bytes(&self) -> &'a [u8] {
        self.bytes
    }

    /// The records of a section.
    ///
    /// # Errors
    /// No such section, or records of another size.
    pub fn section<T: AnyBitPattern + NoUninit>(&self, id: u32) -> Result<&'a [T], ArchiveError> {
        let damaged = ArchiveError::Section { id };
        let entry = self.sections.iter().find(|s| s.id == id).ok_or(damaged.clone())?;
        if entry.record_len as usize != size_of::<T>() {
            return Err(damaged);
        }
        // Bounds were checked when the archive was opened.
        let bytes = &self.bytes[entry.offset as usize..][..entry.count as usize * size_of::<T>()];
        bytemuck::try_cast_slice(bytes).map_err(|_| damaged)
    }

    /// The records of a section; none if the archive does not have it.
    ///
    /// # Errors
    /// Records of another size or alignment.
    pub fn optional_section<T: AnyBitPattern + NoUninit>(&self, id: u32) -> Result<&'a [T], ArchiveError> {
        if self.has(id) { self.section(id) } else { Ok(&[]) }
    }

    /// The records of a section that has no more than `max`.
    ///
    /// # Errors
    /// No such section, records of another size, or more of them.
    pub fn section_of_at_most<T: AnyBitPattern + NoUninit>(
        &self,
        id: u32,
        max: usize,
    ) -> Result<&'a [T], ArchiveError> {
        let records = self.section(id)?;
        if records.len() <= max { Ok(records) } else { Err(ArchiveError::Limit { id, max }) }
    }

    /// True if there is such a section.
    pub fn has(&self, id: u32) -> bool {
        self.sections.iter().any(|s| s.id == id)
    }

    /// The only record of a section.
    ///
    /// # Errors
    /// No such section, or not exactly one record.
    pub fn record<T: AnyBitPattern + NoUninit>(&self, id: u32) -> Result<&'a T, ArchiveError> {
        match self.section(id)? {
            [one] => Ok(one),
            _ => Err(ArchiveError::Section { id }),
        }
    }

    /// The text section, which must be UTF-8.
    ///
    /// # Errors
    /// No such section, or not UTF-8.
    pub fn strings(&self, id: u32) -> Result<&'a str, ArchiveError> {
        std::str::from_utf8(self.section::<u8>(id)?).map_err(|_| ArchiveError::Section { id })
    }
}

/// The content hash in the preamble of an archive.
pub(crate) fn content_hash_of(archive: &[u8]) -> ContentHash {
    bytemuck::from_bytes::<Preamble>(&archive[..64]).content_hash
}

/// Layout of a section: its id, the size of a record, their number.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SectionLayout {
    pub(crate) id: u32,
    pub(crate) record_len: usize,
    pub(crate) count: usize,
}

/// Byte ranges of the first `n` of these sections, empty ones of the others, and the archive's length.
pub(crate) fn layout<const N: usize>(sections: &[SectionLayout; N], n: usize) -> ([Range<usize>; N], usize) {
    let mut end = table_end(n);
    let ranges = std::array::from_fn(|k| if k < n { place(&sections[k], &mut end) } else { 0..0 });
    (ranges, end)
}

fn table_end(n_sections: usize) -> usize {
    64 + n_sections * size_of::<SectionEntry>()
}

/// Where a section lies, if the one before ended at `end`.
fn place(section: &SectionLayout, end: &mut usize) -> Range<usize> {
    let start = end.next_multiple_of(64);
    *end = start + section.record_len * section.count;
    start..*end
}

/// Writes the section table and zeroes the gaps before sections; `out` has the length that [`layout`] gave.
pub(crate) fn write_table(out: &mut [u8], sections: &[SectionLayout]) {
    let mut end = table_end(sections.len());
    for (k, layout) in sections.iter().enumerate() {
        let end_before = end;
        let range = place(layout, &mut end);
        out[end_before..range.start].fill(0);
        let entry = SectionEntry {
            id: layout.id,
            record_len: layout.record_len as u32,
            offset: range.start as u64,
            count: layout.count as u64,
        };
        out[table_end(k)..table_end(k + 1)].copy_from_slice(bytemuck::bytes_of(&entry));
    }
}

/// Grids are hashed in blocks of so many bytes, so that what changes little is hashed little.
pub const HASHED_BLOCK: usize = 1 << 15;

fn content_hash(kind: ArchiveKind, content: &[u8]) -> ContentHash {
    match kind {
        ArchiveKind::Grid => hash_of_blocks(content.chunks(HASHED_BLOCK).map(xxh3_64)),
        _ => ContentHash::of(content),
    }
}

/// The content hash of an archive that is hashed in blocks.
pub(crate) fn hash_of_blocks(hashes: impl Iterator<Item = u64>) -> ContentHash {
    let mut all = Xxh3Default::new();
    hashes.for_each(|hash| all.update(&hash.to_le_bytes()));
    ContentHash::from_bits(all.digest())
}

/// Hashes the content and writes the preamble: the last step. Returns the hash.
pub(crate) fn seal(out: &mut [u8], kind: ArchiveKind, n_sections: usize) -> ContentHash {
    let content_hash = content_hash(kind, &out[64..]);
    write_preamble(out, kind, n_sections, content_hash);
    content_hash
}

/// Writes the preamble of content with this hash.
pub(crate) fn write_preamble(out: &mut [u8], kind: ArchiveKind, n_sections: usize, content_hash: ContentHash) {
    let preamble = Preamble {
        magic: MAGIC,
        layout_version: LAYOUT_VERSION,
        kind: kind as u32,
        n_sections: n_sections as u32,
        length: out.len() as u64,
        content_hash,
        reserved: [0; 4],
    };
    out[..64].copy_from_slice(bytemuck::bytes_of(&preamble));
}

/// Sections of an archive that is written in one go from records at hand. Allocates nothing.
pub(crate) struct SectionList<'a> {
    layouts: [SectionLayout; MAX_SECTIONS],
    contents: [&'a [u8]; MAX_SECTIONS],
    n: usize,
}

impl Default for SectionList<'_> {
    fn default() -> Self {
        let nothing = SectionLayout { id: 0, record_len: 0, count: 0 };
        Self { layouts: [nothing; MAX_SECTIONS], contents: [&[]; MAX_SECTIONS], n: 0 }
    }
}

impl<'a> SectionList<'a> {
    pub(crate) fn add<T: NoUninit>(&mut self, id: u32, records: &'a [T]) {
        self.layouts[self.n] = SectionLayout { id, record_len: size_of::<T>(), count: records.len() };
        self.contents[self.n] = bytemuck::cast_slice(records);
        self.n += 1;
    }

    /// As [`Self::add`], unless there are no records.
    pub(crate) fn add_if_any<T: NoUninit>(&mut self, id: u32, records: &'a [T]) {
        if !records.is_empty() {
            self.add(id, records);
        }
    }

    pub(crate) fn length(&self) -> usize {
        let mut end = table_end(self.n);
        for section in &self.layouts[..self.n] {
            place(section, &mut end);
        }
        end
    }

    /// Writes the archive into memory of exactly [`Self::length`] bytes; its content hash.
    pub(crate) fn write(&self, out: &mut [u8], kind: ArchiveKind) -> ContentHash {
        assert_eq!(out.len(), self.length(), "the memory has the archive's length");
        let layouts = &self.layouts[..self.n];
        write_table(out, layouts);
        let mut end = table_end(self.n);
        for (section, content) in layouts.iter().zip(self.contents) {
            out[place(section, &mut end)].copy_from_slice(content);
        }
        seal(out, kind, self.n)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn sample() -> ArchiveBuffer {
        let mut list = SectionList::default();
        list.add(1, &[1u32, 2, 3]);
        list.add(2, "grüße".as_bytes());
        list.add::<u64>(3, &[]);
        let mut buffer = ArchiveBuffer::zeroed(list.length());
        list.write(buffer.bytes_mut(), ArchiveKind::MissionPlan);
        buffer
    }

    #[test]
    fn what_is_written_is_read() {
        let buffer = sample();
        let archive = Archive::open(buffer.bytes(), ArchiveKind::MissionPlan).unwrap();
        assert_eq!(archive.section::<u32>(1).unwrap(), [1, 2, 3]);
        assert_eq!(archive.strings(2).unwrap(), "grüße");
        assert!(archive.section::<u64>(3).unwrap().is_empty());
        assert_eq!(archive.section::<u64>(1), Err(ArchiveError::Section { id: 1 }), "other records");
        assert_eq!(archive.section::<u8>(9), Err(ArchiveError::Section { id: 9 }));
    }

    #[test]
    fn another_kind_version_or_start_is_refused() {
        let mut buffer = sample();
        assert!(matches!(Archive::open(buffer.bytes(), ArchiveKind::Site), Err(ArchiveError::Kind { .. })));
        buffer.bytes_mut()[4] += 1;
        assert!(matches!(Archive::open(buffer.bytes(), ArchiveKind::MissionPlan), Err(ArchiveError::Version { .. })));
        buffer.bytes_mut()[0] += 1;
        assert_eq!(Archive::open(buffer.bytes(), ArchiveKind::MissionPlan).unwrap_err(), ArchiveError::NoArchive);
        assert_eq!(
            Archive::open(&buffer.bytes()[1..], ArchiveKind::MissionPlan).unwrap_err(),
            ArchiveError::Misaligned
        );
    }

    proptest! {
        #[test]
        fn damaged_bytes_are_refused_and_never_panic(at in 0usize..300, value in any::<u8>(), length in 0usize..300) {
            let whole = sample();
            let mut buffer = whole.clone();
            let at = at % buffer.bytes().len();
            let changed = buffer.bytes()[at] != value;
            buffer.bytes_mut()[at] = value;
            // Only the reserved words are not read.
            let opened = Archive::open(buffer.bytes(), ArchiveKind::MissionPlan);
            prop_assert_eq!(opened.is_err(), changed && !(32..64).contains(&at));
            let cut = ArchiveBuffer::copy_of(&whole.bytes()[..length.min(whole.bytes().len() - 1)]);
            prop_assert!(Archive::open(cut.bytes(), ArchiveKind::MissionPlan).is_err());
        }
    }
}
