//! Looks for what would decide an ambiguous alignment.

use crate::alignment::{AlignedPose, Alignment};
use crate::decision::{DecidingPlace, Decision, NamedPlace};
use crate::distinction::{MAX_COMPARED_POSES, distinction};
use crate::prepared_map::PreparedMap;
use crate::rooms::{Room, room_at};
use frames::{Map, Slam};
use messages::{AlignmentVerdict, NONE};

impl Alignment {
    /// Looks for what would decide between poses that fit alike, and tells it with the reason. `storeys` are those of the
    /// references, as for [`AlignedPose::record`]; `rooms` are those of all of them.
    ///
    /// Nothing changes if the alignment is not ambiguous, or has one pose only.
    pub fn decide(
        &mut self,
        references: &[impl AsRef<PreparedMap<Map>>],
        slam: &PreparedMap<Slam>,
        storeys: &[u32],
        rooms: &[Room],
    ) {
        let poses = self.alike();
        if self.verdict != AlignmentVerdict::Ambiguous || poses.len() < 2 {
            return;
        }
        let found = distinction(references, slam, poses);
        let storey_of = |pose: &AlignedPose| storeys.get(pose.reference).copied().unwrap_or(NONE);
        let rooms_of = |place: &DecidingPlace| -> Vec<Option<Room>> {
            let placed = poses.iter().zip(&place.in_map_m);
            placed.map(|(pose, at)| room_at(rooms, storey_of(pose), *at).cloned()).collect()
        };
        let named = |place: DecidingPlace| NamedPlace { rooms: rooms_of(&place), place };
        let decision = Decision { places: found.places.into_iter().map(named).collect(), undecided: found.undecided };
        self.reason = format!("{}; {decision}", self.reason);
        self.decision = Some(decision);
    }

    /// The best poses that fit almost alike, as far as they are compared.
    fn alike(&self) -> &[AlignedPose] {
        &self.poses[..(1 + self.n_rivals).min(self.poses.len()).min(MAX_COMPARED_POSES)]
    }
}
