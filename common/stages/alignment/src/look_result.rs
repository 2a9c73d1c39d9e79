//! Makes the evidence for the next look at a growing SLAM map, and tells what this look changed.

use crate::alignment::{AlignedPose, Alignment};
use crate::held_out::{HeldOut, PoseHistory};
use crate::looks::{Looks, is_same, placed_raster, storey_of};
use crate::prepared_map::PreparedMap;
use frames::Slam;
use messages::{
    AlignmentEvidence, AlignmentEvidenceBuilder, AlignmentEvidenceHead, AlignmentVerdict, ArchiveBuffer, ContentHash,
    NONE, PoseHistoryRecord,
};

impl Alignment {
    /// The `alignment-evidence` archive after this look at a SLAM map; `None` if nothing is new since the looks before, whose
    /// archive goes on as it is. `storeys` are those of the references.
    pub fn evidence(
        &self,
        slam: &PreparedMap<Slam>,
        slam_map_hash: ContentHash,
        references_hash: ContentHash,
        storeys: &[u32],
        earlier: Option<&Looks<'_>>,
    ) -> Option<ArchiveBuffer> {
        let is_accepted = self.verdict == AlignmentVerdict::Accepted && !self.poses.is_empty();
        let was_accepted = earlier.and_then(|looks| looks.evidence.accepted());
        let is_first_accepted = is_accepted && was_accepted.is_none();
        if self.poses.is_empty() || earlier.is_some_and(|looks| !looks.has_grown && !is_first_accepted) {
            return None;
        }
        let n_poses = self.poses.len().min(AlignmentEvidence::MAX_POSES - 1);
        let mut poses: Vec<PoseHistoryRecord> =
            self.poses[..n_poses].iter().map(|pose| history_record(pose, storeys)).collect();
        let accepted = was_accepted.map(|was| {
            let is_it = |pose: &AlignedPose| is_same(was, storey_of(storeys, pose.reference), &pose.map_from_slam);
            self.poses[..n_poses].iter().position(is_it).unwrap_or_else(|| {
                poses.push(*was);
                poses.len() - 1
            })
        });
        let accepted = if is_accepted { Some(0) } else { accepted };
        let earlier = earlier.map(|looks| &looks.evidence);
        let map = placed_raster(slam);
        let head = AlignmentEvidenceHead {
            references_hash,
            slam_map_hash,
            before_hash: earlier.map_or(ContentHash::NONE, AlignmentEvidence::content_hash),
            n_looks: earlier.map_or(0, |earlier| earlier.head.n_looks) + 1,
            accepted: accepted.map_or(NONE, |index| index as u32),
            ..map.evidence_head(earlier)
        };
        let mut builder = AlignmentEvidenceBuilder::new(head, poses);
        map.mark(earlier, &mut builder);
        Some(builder.finish())
    }
}

impl Looks<'_> {
    /// What became of the pose that an earlier look has accepted, for people; `None` if none was, or if it still is.
    pub(crate) fn change(&self, alignment: &Alignment, storeys: &[u32]) -> Option<String> {
        let earlier = self.evidence.accepted()?;
        let best = alignment.poses.first().filter(|_| alignment.verdict == AlignmentVerdict::Accepted);
        let is_it = |pose: &AlignedPose| is_same(earlier, storey_of(storeys, pose.reference), &pose.map_from_slam);
        let [x_m, y_m, yaw_rad] = earlier.map_from_slam;
        let storey =
            if earlier.map_storey == NONE { String::new() } else { format!("storey {}, ", earlier.map_storey) };
        let place = format!("{storey}x {x_m:.2} m, y {y_m:.2} m, yaw {:.2} degrees", yaw_rad.to_degrees());
        match best {
            Some(pose) if is_it(pose) => None,
            Some(_) => Some(format!("an earlier look at this map accepted another pose: {place}")),
            None => Some(format!("the pose that an earlier look at this map accepted is withdrawn: {place}")),
        }
    }
}

fn history_record(pose: &AlignedPose, storeys: &[u32]) -> PoseHistoryRecord {
    let PoseHistory { of_this_building, held_out: HeldOut { seen_m, recalled_m, through_m } } = pose.history;
    PoseHistoryRecord {
        map_from_slam: pose.map_from_slam.x_y_yaw(),
        about_m: pose.about_m,
        of_this_building,
        seen_m,
        recalled_m,
        through_m,
        map_storey: storey_of(storeys, pose.reference),
        reserved: 0,
    }
}
