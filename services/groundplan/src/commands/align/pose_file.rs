//! Files for robots that hold a pose, written only while that may be used.

use crate::failure::Failure;
use crate::input_document::read_document;
use daemon::write_durably;
use messages::{Alignment, PoseRecord};
use std::path::{Path, PathBuf};

/// A kind of file.
pub(super) struct PoseFile {
    /// What people call its content.
    pub(super) what: &'static str,
    /// Every such file that this program wrote begins so.
    pub(super) first_words: &'static str,
}

impl PoseFile {
    /// Writes the text of a pose that may be used, around the robot if its place in its map is known; of no other. A
    /// robot must not start with an earlier pose instead: a file of one that is at the path is renamed, and standard error tells.
    ///
    /// # Errors
    /// A file that cannot be written or renamed; what was there stays.
    pub(super) fn write(
        &self,
        path: &Path,
        alignment: &Alignment<'_>,
        robot_m: Option<[f64; 2]>,
        text: impl FnOnce(&PoseRecord) -> String,
    ) -> Result<(), Failure> {
        let failed = |error| Failure::work(format!("{}: {error}", path.display()));
        match alignment.usable(robot_m) {
            Ok(pose) => write_durably(path, text(&pose).as_bytes()).map_err(failed),
            Err(_) => {
                let why = alignment.why_not_usable(robot_m).unwrap_or_default();
                let set_aside = self.set_aside(path).map_err(failed)?;
                let earlier =
                    set_aside.map(|to| format!("; the {} of an earlier pose is now {}", self.what, to.display()));
                eprintln!("groundplan: {} is not written: {why}{}", path.display(), earlier.unwrap_or_default());
                Ok(())
            }
        }
    }

    /// Renames an earlier file of this program to its new name; files of others stay.
    fn set_aside(&self, path: &Path) -> std::io::Result<Option<PathBuf>> {
        if !read_document(path).is_ok_and(|bytes| bytes.starts_with(self.first_words.as_bytes())) {
            return Ok(None);
        }
        let mut name = path.as_os_str().to_owned();
        name.push(".stale");
        std::fs::rename(path, &name)?;
        Ok(Some(name.into()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use alignment::{Alignment as Found, AlignmentSources, MaxUncertainty, PoseStatus};
    use messages::{AlignmentVerdict, ContentHash, PoseState, ScheduleStateHead};

    const FILE: PoseFile = PoseFile { what: "pose", first_words: "# A pose" };

    fn archive(verdict: AlignmentVerdict, state: PoseState, waiting: Option<PoseRecord>) -> messages::ArchiveBuffer {
        let found = Found { verdict, reason: "why".to_owned(), ..Found::nothing_yet() };
        let plan_time_s = ScheduleStateHead::NO_TIME;
        let sources = AlignmentSources {
            site_hash: ContentHash::from_bits(1),
            slam_map_hash: ContentHash::from_bits(2),
            searched_map_hash: ContentHash::from_bits(2),
            plan_time_s,
        };
        let max_uncertainty = MaxUncertainty::in_degrees(0.1, 1.0);
        let (pose, verdict) = (Some(PoseRecord::NONE), Some(verdict));
        let pose_status = PoseStatus { pose, state, waiting, verdict, max_uncertainty, field: None, robot_m: None };
        found.archive(&[], &pose_status, sources)
    }

    fn write_of(path: &Path, verdict: AlignmentVerdict, state: PoseState, waiting: Option<PoseRecord>) {
        let archive = archive(verdict, state, waiting);
        FILE.write(path, &Alignment::open(archive.bytes()).unwrap(), None, |_| "# A pose 1 2".to_owned()).unwrap();
    }

    #[test]
    fn only_a_pose_that_may_be_used_is_written_and_an_earlier_one_does_not_stay_where_a_robot_reads_it() {
        use AlignmentVerdict::{Accepted, Ambiguous, Refused};
        let home = tempfile::tempdir().unwrap();
        let (path, stale) = (home.path().join("site_map.yaml"), home.path().join("site_map.yaml.stale"));
        for (verdict, state, waiting) in [
            (Accepted, PoseState::Held, None),
            (Accepted, PoseState::Tracked, Some(PoseRecord::NONE)),
            (Ambiguous, PoseState::Held, None),
            (Ambiguous, PoseState::None, None),
            (Refused, PoseState::Tracked, None),
        ] {
            write_of(&path, Accepted, PoseState::Found, None);
            assert!(path.exists());
            write_of(&path, verdict, state, waiting);
            assert!(!path.exists() && stale.exists(), "{verdict:?} {state:?}");
            std::fs::remove_file(&stale).unwrap();
        }
        // In a building that repeats itself, a hint told once which place it is.
        write_of(&path, Ambiguous, PoseState::Tracked, None);
        assert!(path.exists());
        std::fs::write(&path, "of a person").unwrap();
        write_of(&path, Refused, PoseState::None, None);
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "of a person");
    }
}
