//! Evidence over looks in the state folder.

use crate::job::Evidence;
use daemon::{Failure, write_durably};
use messages::ArchiveBuffer;
use std::io::ErrorKind;
use std::path::Path;
use tracing::warn;

const NAME: &str = "alignment-evidence.gpar";

/// The evidence in a state folder. What cannot be read is told: the next look begins anew, and is worth less.
pub(crate) fn read(state: &Path) -> Option<Evidence> {
    let path = state.join(NAME);
    let lost = |why: &dyn std::fmt::Display| {
        warn!(service = "slam-align", error = %why, "evidence of earlier looks is lost");
    };
    match std::fs::read(&path) {
        Ok(bytes) => Evidence::new(ArchiveBuffer::copy_of(&bytes)).inspect_err(|why| lost(why)).ok(),
        Err(why) if why.kind() == ErrorKind::NotFound => None,
        Err(why) => {
            lost(&why);
            None
        }
    }
}

/// Writes evidence; on disk when this returns.
///
/// # Errors
/// The file system refuses.
pub(crate) fn write(state: &Path, evidence: &Evidence) -> Result<(), Failure> {
    let path = state.join(NAME);
    write_durably(&path, evidence.bytes().as_ref()).map_err(|why| format!("{}: {why}", path.display()).into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;
    use messages::{AlignmentEvidenceBuilder, AlignmentEvidenceHead, NONE};

    #[test]
    fn evidence_survives_and_what_is_damaged_begins_anew() {
        let state = tempfile::tempdir().unwrap();
        assert!(read(state.path()).is_none());
        let head = AlignmentEvidenceHead { n_looks: 3, accepted: NONE, ..Zeroable::zeroed() };
        let evidence = Evidence::new(AlignmentEvidenceBuilder::new(head, Vec::new()).finish()).unwrap();
        write(state.path(), &evidence).unwrap();
        assert_eq!(read(state.path()).unwrap().view().head.n_looks, 3);
        let path = state.path().join(NAME);
        let mut bytes = std::fs::read(&path).unwrap();
        let last = bytes.len() - 1;
        bytes[last - 64] ^= 1;
        std::fs::write(&path, bytes).unwrap();
        assert!(read(state.path()).is_none());
    }
}
