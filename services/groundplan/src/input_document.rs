//! Files of configuration and documents that a command reads as they are named.

use input_files::read_regular_file;
use std::io;
use std::path::Path;

/// Bytes of the largest document: `semantic.json` of a large site has a tenth of it.
pub(crate) const MAX_DOCUMENT_BYTES: u64 = 1 << 30;

/// The bytes of a document: of a regular file, so that a command neither waits nor fills the memory.
///
/// # Errors
/// A file that cannot be read, is no regular one or is too large.
pub(crate) fn read_document(path: &Path) -> io::Result<Vec<u8>> {
    read_regular_file(path, MAX_DOCUMENT_BYTES)
}
