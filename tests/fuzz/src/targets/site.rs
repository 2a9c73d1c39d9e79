//! Sites of IFC text, without progress reports.

use ingest::{IngestError, IngestOptions, SourceFile};
use messages::ArchiveBuffer;

/// The site of one file.
pub(super) fn of_bytes(bytes: &[u8]) -> Result<ArchiveBuffer, IngestError> {
    let file = SourceFile { path: "fuzzed.ifc".into(), bytes: bytes.to_vec() };
    let options = IngestOptions { allow_boxes: true, ..IngestOptions::default() };
    ingest::ingest(&[file], &options)
}

/// Two rooms with a door between them, a stair, an upper floor, and tasks.
pub(super) fn house() -> ArchiveBuffer {
    of_bytes(include_bytes!("../../corpus/ifc/house.ifc")).expect("the house is a whole file")
}
