//! Conversion of alignments and occupancy maps to archives.

use crate::alignment::{AlignedPose, Alignment};
use messages::{
    AlignmentBuilder, AlignmentHead, AlignmentVerdict, ArchiveBuffer, NONE, PoseRecord, PoseState, PoseValidity, Text,
};

/// The inputs of an alignment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AlignmentSources {
    /// Content hash of the site; 0 for maps without one.
    pub site_hash: u64,
    /// Content hash of the newest SLAM map.
    pub slam_map_hash: u64,
    /// Content hash of the SLAM map that was searched; 0 if none was.
    pub searched_map_hash: u64,
    /// Plan time of the reference.
    pub plan_time_s: i64,
}

/// The published pose, its state, and a pending pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseStatus {
    /// The published pose.
    pub pose: Option<PoseRecord>,
    /// State of the published pose.
    pub state: PoseState,
    /// A pose that waits for confirmation by an operator.
    pub waiting: Option<PoseRecord>,
    /// Verdict of a search for the newest map wherever it may lie; `None` while it waits for one.
    pub verdict: Option<AlignmentVerdict>,
}

impl PoseStatus {
    /// What the published pose is worth.
    ///
    /// A pose that is tracked stays effective where the search is ambiguous: in a building that repeats itself, a hint told
    /// once which place it is.
    pub fn validity(&self) -> PoseValidity {
        match (self.verdict, self.state) {
            _ if self.waiting.is_some() => PoseValidity::WaitsForConfirm,
            (Some(AlignmentVerdict::Refused), _) => PoseValidity::Refused,
            (_, PoseState::Found | PoseState::Tracked) => PoseValidity::Effective,
            (_, PoseState::Held) | (None, PoseState::None) => PoseValidity::Held,
            (Some(_), PoseState::None) => PoseValidity::Refused,
        }
    }
}

impl AlignedPose {
    /// As a record; `storeys` are those of the references, [`NONE`] for a map without a site.
    pub fn record(&self, storeys: &[u32]) -> PoseRecord {
        let rows = self.covariance.rows();
        PoseRecord {
            map_from_slam: self.map_from_slam.x_y_yaw(),
            covariance: std::array::from_fn(|k| rows[k / 3][k % 3]),
            about_m: self.about_m,
            evidence: self.evidence,
            map_storey: storeys.get(self.reference).copied().unwrap_or(NONE),
            reserved: 0,
        }
    }
}

impl Alignment {
    /// The status without tracking: the best pose is published if it is accepted.
    pub fn pose_status(&self, storeys: &[u32]) -> PoseStatus {
        let pose = self.poses.first().filter(|_| self.verdict == AlignmentVerdict::Accepted).map(|p| p.record(storeys));
        let state = if pose.is_some() { PoseState::Found } else { PoseState::None };
        PoseStatus { pose, state, waiting: None, verdict: Some(self.verdict) }
    }

    /// The `alignment` archive.
    pub fn archive(&self, storeys: &[u32], pose_status: &PoseStatus, sources: AlignmentSources) -> ArchiveBuffer {
        let candidates: Vec<PoseRecord> = self.poses.iter().map(|p| p.record(storeys)).collect();
        let head = AlignmentHead {
            site_hash: sources.site_hash,
            slam_map_hash: sources.slam_map_hash,
            searched_map_hash: sources.searched_map_hash,
            plan_time_s: sources.plan_time_s,
            pose: pose_status.pose.unwrap_or(PoseRecord::NONE),
            waiting: pose_status.waiting.unwrap_or(PoseRecord::NONE),
            scale: self.scale.map_or(1.0, |s| s.value),
            // Nothing is known of a scale that nothing holds.
            scale_deviation: self.scale.map_or(1.0, |s| s.deviation.min(1.0)),
            reason: Text::default(),
            verdict: self.verdict.into(),
            state: pose_status.state.into(),
            is_waiting: u32::from(pose_status.waiting.is_some()),
            validity: pose_status.validity().into(),
        };
        AlignmentBuilder { head, reason: &self.reason, candidates: &candidates }.finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_pose_that_the_newest_map_bears_out_is_effective() {
        use AlignmentVerdict::{Accepted, Ambiguous, Refused};
        let validity = |state, is_waiting: bool, verdict| {
            let waiting = is_waiting.then_some(PoseRecord::NONE);
            PoseStatus { pose: Some(PoseRecord::NONE), state, waiting, verdict }.validity()
        };
        for (state, verdict, expected) in [
            (PoseState::Found, Some(Accepted), PoseValidity::Effective),
            (PoseState::Tracked, Some(Accepted), PoseValidity::Effective),
            (PoseState::Tracked, Some(Ambiguous), PoseValidity::Effective),
            (PoseState::Tracked, None, PoseValidity::Effective),
            (PoseState::Tracked, Some(Refused), PoseValidity::Refused),
            (PoseState::Held, Some(Accepted), PoseValidity::Held),
            (PoseState::Held, Some(Ambiguous), PoseValidity::Held),
            (PoseState::Held, Some(Refused), PoseValidity::Refused),
            (PoseState::Held, None, PoseValidity::Held),
            (PoseState::None, None, PoseValidity::Held),
            (PoseState::None, Some(Ambiguous), PoseValidity::Refused),
            (PoseState::None, Some(Refused), PoseValidity::Refused),
        ] {
            assert_eq!(validity(state, false, verdict), expected, "{state:?} {verdict:?}");
            assert_eq!(validity(state, true, verdict), PoseValidity::WaitsForConfirm, "{state:?} {verdict:?}");
        }
    }
}
