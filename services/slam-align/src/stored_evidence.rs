//! Evidence over looks in the state folder.

use crate::job::Evidence;
use daemon::state_files::ALIGNMENT_EVIDENCE;
use daemon::{Failure, KeptFile, Save, chain};
use messages::ArchiveBuffer;
use std::path::Path;
use tracing::warn;

/// The evidence in a state folder, and what an operator should know of it. Where it is lost the next look begins anew, and is worth
/// less.
pub(crate) fn read(state: &Path) -> (Option<Evidence>, Option<String>) {
    let file = KeptFile::at(state, ALIGNMENT_EVIDENCE);
    let read = || -> Result<Option<Evidence>, Failure> {
        let Some(bytes) = file.load()? else { return Ok(None) };
        Ok(Some(Evidence::new(ArchiveBuffer::copy_of(&bytes))?))
    };
    match read() {
        Ok(evidence) => (evidence, file.finding().map(str::to_owned)),
        Err(why) => {
            let finding =
                format!("evidence of earlier looks is lost: {}: {}", file.path().display(), chain(why.as_ref()));
            warn!(service = "slam-align", finding, "the next look begins anew");
            (None, Some(finding))
        }
    }
}

/// Evidence, to be saved.
pub(crate) fn saving(state: &Path, evidence: &Evidence) -> Save {
    KeptFile::at(state, ALIGNMENT_EVIDENCE).saving_anew(evidence.bytes().as_ref().to_vec())
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;
    use messages::{AlignmentEvidenceBuilder, AlignmentEvidenceHead, NONE};

    #[test]
    fn evidence_survives_the_damage_of_one_file_and_that_of_both_is_told() {
        let state = tempfile::tempdir().unwrap();
        assert!(matches!(read(state.path()), (None, None)));
        let head = AlignmentEvidenceHead { n_looks: 3, accepted: NONE, ..Zeroable::zeroed() };
        let evidence = Evidence::new(AlignmentEvidenceBuilder::new(head, Vec::new()).finish()).unwrap();
        saving(state.path(), &evidence).write().unwrap();
        let n_looks = || read(state.path()).0.map(|evidence| evidence.view().head.n_looks);
        assert_eq!(n_looks(), Some(3));
        let [path, sealed] =
            [ALIGNMENT_EVIDENCE.to_owned(), format!("{ALIGNMENT_EVIDENCE}.sealed")].map(|name| state.path().join(name));
        let damage = |path: &Path| {
            let mut bytes = std::fs::read(path).unwrap();
            let last = bytes.len() - 1;
            bytes[last - 64] ^= 1;
            std::fs::write(path, bytes).unwrap();
        };
        damage(&path);
        let (read_again, finding) = read(state.path());
        assert!(read_again.is_some() && finding.unwrap().contains("damaged"));
        assert_eq!((n_looks(), read(state.path()).1), (Some(3), None), "it is mended");
        let whole = std::fs::read(&path).unwrap();
        let mut of_other_layout = whole.clone();
        of_other_layout[4] ^= 0x40;
        let file = KeptFile::at(state.path(), ALIGNMENT_EVIDENCE);
        file.save(&of_other_layout).unwrap();
        let (lost, finding) = read(state.path());
        let finding = finding.unwrap();
        assert!(
            lost.is_none() && finding.contains(ALIGNMENT_EVIDENCE) && finding.contains("layout version 65"),
            "{finding}"
        );
        file.save(&whole).unwrap();
        damage(&path);
        std::fs::write(&sealed, "sha256").unwrap();
        let (lost, finding) = read(state.path());
        assert!(lost.is_none() && finding.unwrap().contains("lost"));
    }
}
