//! Persistent state of slam-align.

use daemon::facts::Pose;
use daemon::{Confirmed, ConfirmedElement, ListedPose};
use deviations::AppliedObservations;
use messages::{PoseEvidence, PoseRecord};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// State that survives a restart.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PersistedState {
    /// Observations that are applied to the maps.
    pub(crate) observed: AppliedObservations,
    /// Who confirmed which absent element when, by GlobalId.
    confirmed: BTreeMap<String, ConfirmedElement>,
    pose: Option<PersistedPose>,
    /// The pose was in effect, and is not: the history says why.
    pub(crate) is_withdrawn: bool,
    /// The pose before the one that was confirmed last, and who confirmed that.
    before_confirmed: Option<(PersistedPose, Confirmed)>,
}

/// A pose and its map frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct PersistedPose {
    frame_epoch: u64,
    map_storey: u32,
    map_from_slam: [f64; 3],
    about_m: [f64; 2],
    covariance: [f64; 9],
    /// Score, precision, recall, free.
    evidence: [f64; 4],
    /// Log odds, metres of walls in sight, shares seen through and in walls.
    sight: [f64; 4],
    /// Shares outside and of free cells in walls, metres of distinct walls.
    walls: [f64; 3],
}

impl PersistedPose {
    fn of(pose: &PoseRecord, frame_epoch: u64) -> Self {
        let e = pose.evidence;
        Self {
            frame_epoch,
            map_storey: pose.map_storey,
            map_from_slam: pose.map_from_slam,
            about_m: pose.about_m,
            covariance: pose.covariance,
            evidence: [e.score, e.precision, e.recall, e.free],
            sight: [e.log_odds, e.seen_m, e.seen_through, e.in_walls],
            walls: [e.outside, e.free_in_walls, e.distinct_m],
        }
    }

    fn record(&self) -> PoseRecord {
        let ([score, precision, recall, free], [log_odds, seen_m, seen_through, in_walls]) =
            (self.evidence, self.sight);
        let [outside, free_in_walls, distinct_m] = self.walls;
        PoseRecord {
            map_from_slam: self.map_from_slam,
            covariance: self.covariance,
            about_m: self.about_m,
            evidence: PoseEvidence {
                log_odds,
                score,
                precision,
                recall,
                free,
                seen_m,
                seen_through,
                in_walls,
                outside,
                free_in_walls,
                distinct_m,
            },
            map_storey: self.map_storey,
            reserved: 0,
        }
    }
}

/// A pose is saved again when it has moved by this much.
const MIN_MOVE_M: f64 = 0.01;
const MIN_TURN_RAD: f64 = 0.002;

impl PersistedState {
    pub(crate) fn pose(&self) -> Option<PoseRecord> {
        self.pose.as_ref().map(PersistedPose::record)
    }

    pub(crate) fn set_pose(&mut self, pose: &PoseRecord, frame_epoch: u64) {
        self.pose = Some(PersistedPose::of(pose, frame_epoch));
    }

    /// The map frame is another: no pose is one any more.
    pub(crate) fn forget_poses(&mut self) {
        (self.pose, self.is_withdrawn, self.before_confirmed) = (None, false, None);
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

    /// Records that an operator confirmed `pose` in the place of `before`.
    pub(crate) fn confirm_pose(&mut self, pose: &PoseRecord, before: &PoseRecord, frame_epoch: u64, by: Confirmed) {
        self.before_confirmed = Some((PersistedPose::of(before, frame_epoch), by));
        self.set_pose(pose, frame_epoch);
    }

    /// The pose before the one that was confirmed last.
    pub(crate) fn before_confirmed(&self) -> Option<(PoseRecord, Confirmed)> {
        self.before_confirmed.as_ref().map(|(pose, by)| (pose.record(), *by))
    }

    /// Takes the confirmation of a pose back.
    pub(crate) fn undo_confirmed_pose(&mut self) {
        if let Some((pose, _)) = self.before_confirmed.take() {
            self.pose = Some(pose);
        }
    }

    /// Records who confirmed elements; `observed` already has them.
    pub(crate) fn set_observed(&mut self, observed: AppliedObservations, confirmed: &[ConfirmedElement]) {
        self.confirmed.extend(confirmed.iter().map(|element| (element.global_id.clone(), element.clone())));
        self.confirmed.retain(|id, _| observed.absent().contains(id));
        self.observed = observed;
    }

    /// An element that was confirmed to be absent.
    pub(crate) fn confirmed_element(&self, global_id: &str) -> Option<ConfirmedElement> {
        self.confirmed.get(global_id).cloned()
    }
}

/// A pose as lists show it.
pub(crate) fn listed(pose: &PoseRecord) -> ListedPose {
    ListedPose { storey: pose.map_storey, map_from_slam: Pose::of(pose.map_from_slam) }
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

    #[test]
    fn state_of_another_layout_is_not_read() {
        let whole = serde_json::to_value(PersistedState::default()).unwrap();
        let read = |of: &serde_json::Value| serde_json::from_value::<PersistedState>(of.clone());
        assert_eq!(read(&whole).unwrap(), PersistedState::default());
        let (mut more, mut less) = (whole.clone(), whole);
        more["map"] = "/robot.yaml".into();
        less.as_object_mut().unwrap().remove("observed");
        assert!(read(&more).is_err() && read(&less).is_err());
    }
}
