//! Conversion of alignments and occupancy maps to archives.

use crate::alignment::{AlignedPose, Alignment};
use crate::decision::{Decision, NamedPlace};
use crate::exclusion::Exclusion;
use crate::pose_field::{BLOCK_M, Blocks, LocalPose, PoseExtent, PoseField};
use frames::PoseCovariance;
use messages::{
    AlignmentBuilder, AlignmentHead, AlignmentVerdict, ArchiveBuffer, ContentHash, DecidingPlaceRecord, HintRecord,
    LocalPoseRecord, LocalPosesHead, LocalPosesParts, NONE, OutlineRingRecord, PlacedRecord, PosePairRecord,
    PoseRecord, PoseState, PoseValidity, Text, flat,
};

/// The inputs of an alignment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AlignmentSources {
    /// Content hash of the site; 0 for maps without one.
    pub site_hash: ContentHash,
    /// Content hash of the newest SLAM map.
    pub slam_map_hash: ContentHash,
    /// Content hash of the SLAM map that was searched; 0 if none was.
    pub searched_map_hash: ContentHash,
    /// Plan time of the reference.
    pub plan_time_s: i64,
}

/// The published pose, its state, and a pending pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseStatus<'a> {
    /// The published pose.
    pub pose: Option<PoseRecord>,
    /// State of the published pose.
    pub state: PoseState,
    /// A pose that waits for confirmation by an operator.
    pub waiting: Option<PoseRecord>,
    /// Verdict of a search for the newest map wherever it may lie; `None` while it waits for one.
    pub verdict: Option<AlignmentVerdict>,
    /// How well the pose must be known to be used.
    pub max_uncertainty: MaxUncertainty,
    /// The pose from place to place in the newest map; `None` while that is not known.
    pub field: Option<&'a PoseField>,
    /// Where the robot is in its map, in metres; `None` if nobody told it: then a pose must be known well anywhere in the map.
    pub robot_m: Option<[f64; 2]>,
}

/// Maximum standard deviations of a pose that may be used.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MaxUncertainty {
    /// Of where the robot is, or anywhere in its map, in the direction that is held worst, in metres.
    pub m: f64,
    /// Of yaw.
    pub rad: f64,
}

impl MaxUncertainty {
    /// From metres and degrees.
    pub fn in_degrees(m: f64, deg: f64) -> Self {
        Self { m, rad: deg.to_radians() }
    }

    /// True if a pose is known less well.
    fn is_exceeded_by(&self, covariance: &PoseCovariance) -> bool {
        let [_, _, yaw_rad] = covariance.deviations();
        covariance.worst_m() > self.m || yaw_rad > self.rad
    }
}

impl PoseStatus<'_> {
    /// What the published pose is worth.
    ///
    /// A pose that is tracked stays effective where the search is ambiguous: in a building that repeats itself, a hint told
    /// once which place it is.
    pub fn validity(&self) -> PoseValidity {
        let is_uncertain = self.pose.is_some_and(|pose| self.is_uncertain(&pose));
        match (self.verdict, self.state) {
            _ if self.waiting.is_some() => PoseValidity::WaitsForConfirm,
            (Some(AlignmentVerdict::Refused), _) => PoseValidity::Refused,
            (_, PoseState::Found | PoseState::Tracked) if is_uncertain => PoseValidity::Uncertain,
            (_, PoseState::Found | PoseState::Tracked) => PoseValidity::Effective,
            (_, PoseState::Held) | (None, PoseState::None) => PoseValidity::Held,
            (Some(_), PoseState::None) => PoseValidity::Refused,
        }
    }

    /// The pose with the covariance of its place by all of the map: how well that is known, and how far off the pose is there.
    fn published_pose(&self) -> Option<PoseRecord> {
        let pose = self.pose?;
        let covariance = self.field.and_then(|field| field.covariance_at(pose.about_m, &pose.map_from_slam()));
        Some(covariance.map_or(pose, |covariance| PoseRecord { covariance: flat(&covariance), ..pose }))
    }

    /// True if the pose is known too little: where the robot is, or anywhere in its map.
    fn is_uncertain(&self, pose: &PoseRecord) -> bool {
        let is_exceeded =
            |covariance: Option<PoseCovariance>| covariance.is_none_or(|c| self.max_uncertainty.is_exceeded_by(&c));
        match (self.field, self.robot_m) {
            (None, _) => is_exceeded(Some(pose.pose_covariance())),
            (Some(field), Some(robot_m)) => is_exceeded(field.at(robot_m).map(|local| local.covariance)),
            (Some(field), None) => is_exceeded(field.covariance_of(&pose.map_from_slam())),
        }
    }
}

impl AlignedPose {
    /// As a record; `storeys` are those of the references, [`NONE`] for a map without a site.
    pub fn record(&self, storeys: &[u32]) -> PoseRecord {
        PoseRecord {
            map_from_slam: self.map_from_slam.x_y_yaw(),
            covariance: flat(&self.covariance),
            about_m: self.about_m,
            evidence: self.evidence,
            map_storey: storeys.get(self.reference).copied().unwrap_or(NONE),
            reserved: 0,
        }
    }
}

impl Alignment {
    /// The status without tracking: the best pose is published if it is accepted, or the pose of the map around the robot if its place
    /// is known.
    pub fn pose_status(
        &self,
        storeys: &[u32],
        max_uncertainty: MaxUncertainty,
        robot_m: Option<[f64; 2]>,
    ) -> PoseStatus<'_> {
        let best = self.poses.first().filter(|_| self.verdict == AlignmentVerdict::Accepted);
        let local = self.field.as_ref().zip(robot_m).and_then(|(field, robot_m)| field.at(robot_m));
        let pose = best.map(|best| match local {
            Some(LocalPose { map_from_slam, covariance, about_m, .. }) => {
                AlignedPose { map_from_slam, covariance, about_m, ..*best }.record(storeys)
            }
            None => best.record(storeys),
        });
        let state = if pose.is_some() { PoseState::Found } else { PoseState::None };
        let (waiting, verdict, field) = (None, Some(self.verdict), self.field.as_ref());
        PoseStatus { pose, state, waiting, verdict, max_uncertainty, field, robot_m }
    }

    /// The `alignment` archive.
    pub fn archive(&self, storeys: &[u32], pose_status: &PoseStatus<'_>, sources: AlignmentSources) -> ArchiveBuffer {
        let candidates: Vec<PoseRecord> = self.poses.iter().map(|p| p.record(storeys)).collect();
        let head = AlignmentHead {
            site_hash: sources.site_hash,
            slam_map_hash: sources.slam_map_hash,
            searched_map_hash: sources.searched_map_hash,
            plan_time_s: sources.plan_time_s,
            pose: pose_status.published_pose().unwrap_or(PoseRecord::NONE),
            waiting: pose_status.waiting.unwrap_or(PoseRecord::NONE),
            wrong_probability: self.wrong_probability,
            scale: self.scale.map_or(1.0, |s| s.value),
            // Nothing is known of a scale that nothing holds.
            scale_deviation: self.scale.map_or(1.0, |s| s.deviation.min(1.0)),
            reason: Text::default(),
            decision: Text::default(),
            change: Text::default(),
            verdict: self.verdict.into(),
            state: pose_status.state.into(),
            is_waiting: u32::from(pose_status.waiting.is_some()),
            validity: pose_status.validity().into(),
            first_undecided: 0,
            reserved: 0,
        };
        let mut builder = AlignmentBuilder::new(head, &self.reason, candidates);
        builder.head.change = builder.texts.add(self.change.as_deref().unwrap_or_default());
        if let Some(decision) = &self.decision {
            add_decision(&mut builder, decision);
        }
        builder.local_poses =
            pose_status.field.zip(pose_status.pose).map(|(field, pose)| local_poses(field, &pose, pose_status));
        for Exclusion { label, n_poses, .. } in self.exclusions.iter().take(messages::Alignment::MAX_HINTS) {
            let label = builder.texts.add(label);
            builder.hints.push(HintRecord { label, n_excluded: *n_poses as u32, reserved: 0 });
        }
        builder.finish()
    }
}

/// The pose from place to place, and for which part of the map the published one holds.
fn local_poses(field: &PoseField, pose: &PoseRecord, pose_status: &PoseStatus<'_>) -> LocalPosesParts {
    let whole = pose.map_from_slam();
    let PoseExtent { outline_m, walls_share, area_share, largest_off_m, unknown_share } = field.extent_of(&whole);
    let anywhere = field.covariance_of(&whole);
    let MaxUncertainty { m, rad } = pose_status.max_uncertainty;
    let Blocks { slam_from_blocks, width, of_block } = &field.blocks;
    let (mut rings, mut corners) = (Vec::new(), Vec::new());
    for piece in &outline_m {
        for (k, ring) in piece.iter().enumerate() {
            let (first_corner, n_corners) = (corners.len() as u32, ring.len() as u32);
            rings.push(OutlineRingRecord { first_corner, n_corners, is_hole: u32::from(k > 0), reserved: 0 });
            corners.extend(ring.iter().copied());
        }
    }
    let part = |part: &LocalPose| LocalPoseRecord {
        map_from_slam: part.map_from_slam.x_y_yaw(),
        covariance: flat(&part.covariance),
        about_m: part.about_m,
        area_m2: part.area_m2,
        walls_m: part.walls_m,
        explained_m: part.explained_m,
        is_borne_out: u32::from(part.is_borne_out),
        reserved: 0,
    };
    let head = LocalPosesHead {
        slam_from_blocks: *slam_from_blocks,
        block_m: BLOCK_M,
        anywhere_m: anywhere.map_or(f64::MAX, |covariance| covariance.worst_m()),
        anywhere_rad: anywhere.map_or(f64::MAX, |covariance| covariance.deviations()[2]),
        walls_share,
        area_share,
        largest_off_m,
        unknown_share,
        // An archive holds numbers that are some.
        max_deviation: [m.min(f64::MAX), rad.min(f64::MAX)],
        robot_m: pose_status.robot_m.unwrap_or_default(),
        has_robot: u32::from(pose_status.robot_m.is_some()),
        n_columns: *width as u32,
    };
    LocalPosesParts { head, parts: field.parts.iter().map(part).collect(), blocks: of_block.clone(), rings, corners }
}

fn add_decision(builder: &mut AlignmentBuilder, decision: &Decision) {
    builder.head.decision = builder.texts.add(&decision.to_string());
    let pairs = |pairs: &[[usize; 2]]| -> Vec<PosePairRecord> {
        pairs.iter().map(|pair| PosePairRecord { candidates: pair.map(|k| k as u32) }).collect()
    };
    for NamedPlace { place, rooms } in &decision.places {
        let [first_placed, first_pair] = [builder.placed.len(), builder.pose_pairs.len()].map(|n| n as u32);
        for (in_map_m, room) in place.in_map_m.iter().zip(rooms) {
            let texts = room.as_ref().map(|room| [&room.global_id, &room.name, &room.long_name]);
            let [room_global_id, room_name, room_long_name] =
                texts.map_or([Text::default(); 3], |texts| texts.map(|text| builder.texts.add(text)));
            builder.placed.push(PlacedRecord { in_map_m: *in_map_m, room_global_id, room_name, room_long_name });
        }
        builder.pose_pairs.extend(pairs(&place.decided));
        builder.deciding_places.push(DecidingPlaceRecord {
            in_slam_m: place.in_slam_m,
            way_m: place.way_m,
            differing_m: place.differing_m,
            first_placed,
            n_placed: builder.placed.len() as u32 - first_placed,
            first_pair,
            n_pairs: place.decided.len() as u32,
        });
    }
    builder.head.first_undecided = builder.pose_pairs.len() as u32;
    builder.pose_pairs.extend(pairs(&decision.undecided));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_pose_that_the_newest_map_bears_out_is_effective() {
        use AlignmentVerdict::{Accepted, Ambiguous, Refused};
        let validity = |state, is_waiting: bool, verdict| {
            let waiting = is_waiting.then_some(PoseRecord::NONE);
            let max_uncertainty = MaxUncertainty::in_degrees(0.1, 1.0);
            let pose = Some(PoseRecord::NONE);
            PoseStatus { pose, state, waiting, verdict, max_uncertainty, field: None, robot_m: None }.validity()
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

    #[test]
    fn a_pose_that_is_known_too_little_is_uncertain() {
        let validity = |m: f64, deg: f64| {
            let [place, yaw] = [m * m, deg.to_radians() * deg.to_radians()];
            let covariance = [place, 0.0, 0.0, 0.0, 1e-6, 0.0, 0.0, 0.0, yaw];
            PoseStatus {
                pose: Some(PoseRecord { covariance, ..PoseRecord::NONE }),
                state: PoseState::Tracked,
                waiting: None,
                verdict: Some(AlignmentVerdict::Accepted),
                max_uncertainty: MaxUncertainty::in_degrees(0.1, 1.0),
                field: None,
                robot_m: None,
            }
            .validity()
        };
        assert_eq!(validity(0.09, 0.9), PoseValidity::Effective);
        assert_eq!(validity(0.11, 0.9), PoseValidity::Uncertain);
        assert_eq!(validity(0.09, 1.1), PoseValidity::Uncertain);
    }
}
