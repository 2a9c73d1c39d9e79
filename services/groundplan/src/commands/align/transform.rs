//! The static transform of an alignment, as a file for robots.

use crate::alignment_report::{why_not_accepted, why_not_effective};
use crate::failure::Failure;
use daemon::write_durably;
use messages::{Alignment, AlignmentVerdict, PoseRecord};
use std::path::{Path, PathBuf};

/// Every transform that this program wrote begins so.
const FIRST_WORDS: &str = "# ros2 run tf2_ros static_transform_publisher";

/// Writes the transform of a pose that is accepted and effective; of no other. A robot must not start with an earlier pose
/// instead: the transform of one that is at the path is renamed, and standard error tells.
///
/// # Errors
/// A file that cannot be written or renamed; what was there stays.
pub(super) fn write(path: &Path, alignment: &Alignment<'_>) -> Result<(), Failure> {
    let failed = |error| Failure::work(format!("{}: {error}", path.display()));
    // The folder of the path is flushed, too.
    let absolute = std::path::absolute(path).map_err(failed)?;
    let is_accepted = alignment.verdict() == AlignmentVerdict::Accepted;
    let why = why_not_effective(alignment).or_else(|| (!is_accepted).then(|| why_not_accepted(alignment)));
    match (why, alignment.pose()) {
        (None, Some(pose)) => write_durably(&absolute, transform(pose).as_bytes()).map_err(failed),
        (why, _) => {
            let why = why.unwrap_or_else(|| "there is no pose".to_owned());
            let set_aside = set_aside(&absolute).map_err(failed)?;
            let earlier = set_aside.map(|to| format!("; the transform of an earlier pose is now {}", to.display()));
            eprintln!("groundplan: {} is not written: {why}{}", path.display(), earlier.unwrap_or_default());
            Ok(())
        }
    }
}

/// Renames an earlier transform of this program to its new name; files of others stay.
fn set_aside(path: &Path) -> std::io::Result<Option<PathBuf>> {
    if !std::fs::read(path).is_ok_and(|bytes| bytes.starts_with(FIRST_WORDS.as_bytes())) {
        return Ok(None);
    }
    let mut name = path.as_os_str().to_owned();
    name.push(".stale");
    std::fs::rename(path, &name)?;
    Ok(Some(name.into()))
}

/// A static transform as ROS writes one: where the model's frame lies in the robot's.
fn transform(pose: &PoseRecord) -> String {
    let [x_m, y_m, yaw_rad] = pose.map_from_slam().inverse().x_y_yaw();
    let (sin, cos) = libm::sincos(yaw_rad / 2.0);
    format!(
        "{FIRST_WORDS} --x {x_m} --y {y_m} --yaw {yaw_rad} --frame-id map \\\n\
         #   --child-frame-id site_map\n\
         header:\n  frame_id: map\nchild_frame_id: site_map\n\
         transform:\n  translation: {{x: {x_m}, y: {y_m}, z: 0.0}}\n  rotation: {{x: 0.0, y: 0.0, z: {sin}, w: {cos}}}\n"
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use alignment::{Alignment as Found, AlignmentSources, PoseStatus};
    use messages::{PoseState, ScheduleStateHead};

    fn archive(verdict: AlignmentVerdict, state: PoseState, waiting: Option<PoseRecord>) -> messages::ArchiveBuffer {
        let found = Found { verdict, reason: "why".to_owned(), ..Found::nothing_yet() };
        let plan_time_s = ScheduleStateHead::NO_TIME;
        let sources = AlignmentSources { site_hash: 1, slam_map_hash: 2, searched_map_hash: 2, plan_time_s };
        let pose_status = PoseStatus { pose: Some(PoseRecord::NONE), state, waiting, verdict: Some(verdict) };
        found.archive(&[], &pose_status, sources)
    }

    fn write_of(path: &Path, verdict: AlignmentVerdict, state: PoseState, waiting: Option<PoseRecord>) {
        write(path, &Alignment::open(archive(verdict, state, waiting).bytes()).unwrap()).unwrap();
    }

    #[test]
    fn only_an_accepted_effective_pose_is_written_and_an_earlier_one_does_not_stay_where_a_robot_reads_it() {
        use AlignmentVerdict::{Accepted, Ambiguous, Refused};
        let home = tempfile::tempdir().unwrap();
        let (path, stale) = (home.path().join("site_map.yaml"), home.path().join("site_map.yaml.stale"));
        for (verdict, state, waiting) in [
            (Accepted, PoseState::Held, None),
            (Accepted, PoseState::Tracked, Some(PoseRecord::NONE)),
            (Ambiguous, PoseState::Tracked, None),
            (Refused, PoseState::Tracked, None),
        ] {
            write_of(&path, Accepted, PoseState::Found, None);
            assert!(path.exists());
            write_of(&path, verdict, state, waiting);
            assert!(!path.exists() && stale.exists(), "{verdict:?} {state:?}");
            std::fs::remove_file(&stale).unwrap();
        }
        std::fs::write(&path, "of a person").unwrap();
        write_of(&path, Refused, PoseState::None, None);
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "of a person");
    }
}
