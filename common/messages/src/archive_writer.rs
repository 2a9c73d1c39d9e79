//! Writers of archives, each with its kind as a type.

use crate::archive::ArchiveBuffer;
use crate::content_hash::ContentHash;
use crate::payload::Payload;

/// A writer of an archive into given memory: in the heap, or in shared memory.
pub trait ArchiveWriter {
    /// The kind of archive that it writes.
    type Payload: Payload;

    /// Bytes of the archive.
    fn length(&self) -> usize;

    /// Writes every byte of the archive into memory of exactly [`Self::length`] bytes at a multiple of 64; its content hash.
    ///
    /// # Panics
    /// If the memory has another length.
    fn write(&self, out: &mut [u8]) -> ContentHash;

    /// Writes the archive into the heap.
    fn to_buffer(&self) -> ArchiveBuffer {
        let mut buffer = ArchiveBuffer::zeroed(self.length());
        self.write(buffer.bytes_mut());
        buffer
    }
}
