//! Persistent state of slam-align.

use deviations::AppliedObservations;
use messages::{PoseEvidence, PoseRecord};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// State that survives a restart.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct PersistedState {
    /// The map file of the last request.
    pub(crate) map: Option<PathBuf>,
    /// Observations that are applied to the maps.
    pub(crate) observed: AppliedObservations,
    pose: Option<PersistedPose>,
}

/// The last valid pose.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct PersistedPose {
    frame_epoch: u64,
    map_storey: u32,
    map_from_slam: [f64; 3],
    about_m: [f64; 2],
    covariance: [f64; 9],
    /// Score, precision, recall, free.
    evidence: [f64; 4],
}

/// A pose is saved again when it has moved by this much.
const MIN_MOVE_M: f64 = 0.01;
const MIN_TURN_RAD: f64 = 0.002;

impl PersistedState {
    pub(crate) fn pose(&self) -> Option<PoseRecord> {
        let persisted = self.pose.as_ref()?;
        let [score, precision, recall, free] = persisted.evidence;
        Some(PoseRecord {
            map_from_slam: persisted.map_from_slam,
            covariance: persisted.covariance,
            about_m: persisted.about_m,
            evidence: PoseEvidence { score, precision, recall, free },
            map_storey: persisted.map_storey,
            reserved: 0,
        })
    }

    pub(crate) fn set_pose(&mut self, pose: &PoseRecord, frame_epoch: u64) {
        let PoseEvidence { score, precision, recall, free } = pose.evidence;
        self.pose = Some(PersistedPose {
            frame_epoch,
            map_storey: pose.map_storey,
            map_from_slam: pose.map_from_slam,
            about_m: pose.about_m,
            covariance: pose.covariance,
            evidence: [score, precision, recall, free],
        });
    }

    pub(crate) fn forget_pose(&mut self) {
        self.pose = None;
    }

    /// True if there is a pose, and its map frame is another than this.
    pub(crate) fn is_of_another_frame(&self, frame_epoch: u64) -> bool {
        self.pose.as_ref().is_some_and(|pose| pose.frame_epoch != frame_epoch)
    }

    /// True if a pose differs from the one that was saved.
    pub(crate) fn is_worth_saving(&self, pose: &PoseRecord) -> bool {
        self.pose().is_none_or(|persisted| {
            let [a, b] = [&persisted, pose].map(|p| p.map_from_slam().apply(pose.about_m));
            persisted.map_storey != pose.map_storey
                || libm::hypot(a[0] - b[0], a[1] - b[1]) > MIN_MOVE_M
                || libm::fabs(persisted.map_from_slam[2] - pose.map_from_slam[2]) > MIN_TURN_RAD
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pose_survives_and_only_what_moves_is_saved_again() {
        let pose = PoseRecord { map_from_slam: [1.0, 2.0, 0.3], map_storey: 1, ..PoseRecord::NONE };
        let mut persisted = PersistedState::default();
        assert!(persisted.is_worth_saving(&pose) && !persisted.is_of_another_frame(7));
        persisted.set_pose(&pose, 7);
        let read: PersistedState = serde_json::from_str(&serde_json::to_string(&persisted).unwrap()).unwrap();
        assert_eq!((read.pose(), read.is_of_another_frame(8), read.is_of_another_frame(7)), (Some(pose), true, false));
        assert!(!read.is_worth_saving(&PoseRecord { map_from_slam: [1.004, 2.0, 0.3], ..pose }));
        assert!(read.is_worth_saving(&PoseRecord { map_from_slam: [1.02, 2.0, 0.3], ..pose }));
    }
}
