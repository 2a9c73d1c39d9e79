//! Persistent state of slam-align.

use crate::stored_map::StoredMap;
use daemon::facts::Pose;
use daemon::{Confirmed, ConfirmedElement, ListedPose};
use deviations::AppliedObservations;
use messages::{PoseEvidence, PoseRecord};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// State that survives a restart.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct PersistedState {
    /// The map in the state of earlier versions.
    #[serde(flatten, skip_serializing)]
    pub(crate) older_map: OlderMap,
    /// Observations that are applied to the maps.
    pub(crate) observed: AppliedObservations,
    /// Who confirmed which absent element when, by GlobalId.
    confirmed: BTreeMap<String, ConfirmedElement>,
    pose: Option<PersistedPose>,
    /// The pose was in effect, and is not: the history says why.
    #[serde(default)]
    pub(crate) is_withdrawn: bool,
    /// The pose before the one that was confirmed last, and who confirmed that.
    before_confirmed: Option<(PersistedPose, Confirmed)>,
}

/// The map in the state of earlier versions, which did not keep it as a setting.
#[derive(Debug, Clone, Default, PartialEq, Eq, Deserialize)]
#[serde(default)]
pub(crate) struct OlderMap {
    /// The file of the last request, of a version that kept no copy.
    pub(crate) map: Option<PathBuf>,
    /// The map that was read last, of which there is a copy.
    pub(crate) stored_map: Option<OlderStoredMap>,
}

/// A map of which there is a copy, in the state of an earlier version.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
pub(crate) struct OlderStoredMap {
    /// The map.
    #[serde(flatten)]
    pub(crate) map: StoredMap,
    /// The file that the configuration named then.
    pub(crate) configured: Option<PathBuf>,
}

/// A pose and its map frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct PersistedPose {
    frame_epoch: u64,
    map_storey: u32,
    map_from_slam: [f64; 3],
    about_m: [f64; 2],
    covariance: [f64; 9],
    /// Score, precision, recall, free.
    evidence: [f64; 4],
    /// Log odds, metres of walls in sight, shares seen through and in walls; zeros in the state of earlier versions.
    #[serde(default)]
    sight: [f64; 4],
    /// Shares outside and of free cells in walls, metres of distinct walls; zeros in the state of earlier versions.
    #[serde(default)]
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
        let unknown = || ConfirmedElement { global_id: global_id.to_owned(), ..ConfirmedElement::default() };
        let is_absent = self.observed.absent().contains(global_id);
        is_absent.then(|| self.confirmed.get(global_id).cloned().unwrap_or_else(unknown))
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
    fn the_state_of_a_version_without_copies_of_maps_is_read() {
        let text = r#"{"map":"/robot.yaml","observed":{"early":{"a":7},"absent":["b"]},"pose":null}"#;
        let read: PersistedState = serde_json::from_str(text).unwrap();
        let OlderMap { map, stored_map } = read.older_map.clone();
        assert_eq!((map.as_deref(), stored_map), (Some(std::path::Path::new("/robot.yaml")), None));
        let text = r#"{"stored_map":{"file":"/robot.yaml","content_hash":7,"configured":"/other.yaml"}}"#;
        let stored = serde_json::from_str::<PersistedState>(text).unwrap().older_map.stored_map.unwrap();
        assert_eq!(
            stored.map,
            StoredMap { file: "/robot.yaml".into(), content_hash: messages::ContentHash::from_bits(7) }
        );
        assert_eq!(stored.configured.as_deref(), Some(std::path::Path::new("/other.yaml")));
        let element = read.confirmed_element("b").unwrap();
        assert!(element.global_id == "b" && element.confirmed.is_none() && read.confirmed_element("a").is_none());
    }
}
