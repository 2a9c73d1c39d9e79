//! Sites of IFC text, without progress reports.

use ingest::{IngestError, IngestOptions, SourceFile};
use messages::ArchiveBuffer;

/// The site of one file.
pub(super) fn of_bytes(bytes: &[u8]) -> Result<ArchiveBuffer, IngestError> {
    let file = SourceFile { path: "fuzzed.ifc".into(), bytes: bytes.to_vec() };
    let options = IngestOptions {
        frame: None,
        frame_of: None,
        frame_epoch: 1,
        places: &[],
        prefer_last: false,
        allow_boxes: true,
        isolation: None,
        cache: None,
        pool: None,
        progress: &|_| {},
    };
    ingest::ingest(&[file], &options)
}

/// Two rooms with a door between them, a stair, an upper floor, and tasks.
pub(super) fn house() -> ArchiveBuffer {
    of_bytes(include_bytes!("../../corpus/ifc/house.ifc")).expect("the house is a whole file")
}
