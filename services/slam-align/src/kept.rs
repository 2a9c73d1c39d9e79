//! Persistent state of slam-align.

use deviations::AppliedObservations;
use messages::{PoseEvidence, PoseRecord};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// What a restarted daemon goes on from.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct Kept {
    /// The map file that somebody gave last.
    pub(crate) map: Option<PathBuf>,
    /// What counts of what was seen.
    pub(crate) observed: AppliedObservations,
    pose: Option<KeptPose>,
}

/// The pose that counted last.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct KeptPose {
    frame_epoch: u64,
    map_storey: u32,
    map_from_slam: [f64; 3],
    about_m: [f64; 2],
    covariance: [f64; 9],
    /// Score, precision, recall, free.
    evidence: [f64; 4],
}

/// A pose is saved again when it has moved so far.
const WORTH_M: f64 = 0.01;
const WORTH_RAD: f64 = 0.002;

impl Kept {
    pub(crate) fn pose(&self) -> Option<PoseRecord> {
        let kept = self.pose.as_ref()?;
        let [score, precision, recall, free] = kept.evidence;
        Some(PoseRecord {
            map_from_slam: kept.map_from_slam,
            covariance: kept.covariance,
            about_m: kept.about_m,
            evidence: PoseEvidence { score, precision, recall, free },
            map_storey: kept.map_storey,
            reserved: 0,
        })
    }

    pub(crate) fn set_pose(&mut self, pose: &PoseRecord, frame_epoch: u64) {
        let PoseEvidence { score, precision, recall, free } = pose.evidence;
        self.pose = Some(KeptPose {
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
    pub(crate) fn is_worth_keeping(&self, pose: &PoseRecord) -> bool {
        self.pose().is_none_or(|kept| {
            let [a, b] = [&kept, pose].map(|p| p.map_from_slam().apply(pose.about_m));
            kept.map_storey != pose.map_storey
                || libm::hypot(a[0] - b[0], a[1] - b[1]) > WORTH_M
                || libm::fabs(kept.map_from_slam[2] - pose.map_from_slam[2]) > WORTH_RAD
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pose_survives_and_only_what_moves_is_saved_again() {
        let pose = PoseRecord { map_from_slam: [1.0, 2.0, 0.3], map_storey: 1, ..PoseRecord::NONE };
        let mut kept = Kept::default();
        assert!(kept.is_worth_keeping(&pose) && !kept.is_of_another_frame(7));
        kept.set_pose(&pose, 7);
        let read: Kept = serde_json::from_str(&serde_json::to_string(&kept).unwrap()).unwrap();
        assert_eq!((read.pose(), read.is_of_another_frame(8), read.is_of_another_frame(7)), (Some(pose), true, false));
        assert!(!read.is_worth_keeping(&PoseRecord { map_from_slam: [1.004, 2.0, 0.3], ..pose }));
        assert!(read.is_worth_keeping(&PoseRecord { map_from_slam: [1.02, 2.0, 0.3], ..pose }));
    }
}
