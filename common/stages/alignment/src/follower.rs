//! Pose tracking: decides which pose is published while maps arrive; it never jumps without an operator.

use crate::thresholds::{N_WINS, SAME_M, SAME_RAD};
use frames::wrapped;
use messages::{ContentHash, PoseRecord, PoseState};

/// Maximum change of the published pose without confirmation by an operator.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MaxJump {
    /// At the middle of the SLAM map, in metres.
    pub m: f64,
    /// Of yaw.
    pub rad: f64,
}

/// Tracking state: published pose, pending pose, and rival pose.
#[derive(Debug, Clone)]
pub struct Follower {
    max_jump: MaxJump,
    pose: Option<PoseRecord>,
    state: PoseState,
    /// A pose that waits, and the map that it is of.
    waiting: Option<(PoseRecord, ContentHash)>,
    /// A pose elsewhere, and how many searches in a row it has won.
    rival: Option<(PoseRecord, u32)>,
}

impl Follower {
    /// From the last published pose, which the next map must support.
    pub fn new(max_jump: MaxJump, last: Option<PoseRecord>) -> Self {
        let state = if last.is_some() { PoseState::Held } else { PoseState::None };
        Self { max_jump, pose: last, state, waiting: None, rival: None }
    }

    /// The published pose.
    pub fn pose(&self) -> Option<&PoseRecord> {
        self.pose.as_ref()
    }

    /// State of the published pose.
    pub fn state(&self) -> PoseState {
        self.state
    }

    /// True if the newest map bears the published pose out.
    pub fn is_borne_out(&self) -> bool {
        matches!(self.state, PoseState::Found | PoseState::Tracked)
    }

    /// The pending pose.
    pub fn waiting(&self) -> Option<&PoseRecord> {
        self.waiting.as_ref().map(|(pose, _)| pose)
    }

    /// Sets the maximum change without confirmation.
    pub fn set_max_jump(&mut self, max_jump: MaxJump) {
        self.max_jump = max_jump;
    }

    /// Forgets everything, because the map frame changed.
    pub fn forget(&mut self) {
        *self = Self::new(self.max_jump, None);
    }

    /// Takes the result of tracking the newest map, which has this content hash; `None` if it does not support the pose.
    pub fn tracked(&mut self, found: Option<PoseRecord>, map_hash: ContentHash) {
        match found {
            Some(found) => self.place(found, map_hash, PoseState::Tracked),
            None => self.hold(),
        }
    }

    /// Nothing says whether the newest map supports the pose.
    pub fn hold(&mut self) {
        if self.pose.is_some() {
            self.state = PoseState::Held;
        }
    }

    /// Takes the result of a global search with the map that has this content hash; `None` if no pose is accepted. A
    /// requested search (`is_asked`) makes its pose pending at once. If a newer map has come meanwhile, it is tracked next.
    pub fn searched(&mut self, found: Option<PoseRecord>, map_hash: ContentHash, is_asked: bool) {
        let Some(found) = found else {
            self.rival = None;
            return;
        };
        let Some(pose) = &self.pose else {
            self.place(found, map_hash, PoseState::Found);
            return;
        };
        if is_within(pose, &found, SAME_M, SAME_RAD) {
            self.rival = None;
            self.place(found, map_hash, PoseState::Found);
            return;
        }
        let n_before = self.rival.filter(|(rival, _)| is_within(rival, &found, SAME_M, SAME_RAD)).map_or(0, |r| r.1);
        self.rival = Some((found, n_before + 1));
        if is_asked || n_before + 1 >= N_WINS {
            self.waiting = Some((found, map_hash));
        }
    }

    /// Publishes the pending pose, confirmed by an operator. True if it was found in the newest map, which has this content
    /// hash; if not, it is held until that map is tracked.
    pub fn confirm(&mut self, map_hash: ContentHash) -> bool {
        let Some((waiting, of_map)) = self.waiting.take() else { return false };
        let is_of_newest_map = of_map == map_hash;
        let state = if is_of_newest_map { PoseState::Found } else { PoseState::Held };
        (self.pose, self.state, self.rival) = (Some(waiting), state, None);
        is_of_newest_map
    }

    /// Takes a confirmation back: the pose before it is held until the newest map is tracked, and the confirmed one is pending
    /// again, found in no map that is known.
    pub fn undo_confirm(&mut self, before: PoseRecord) {
        self.waiting = self.pose.map(|pose| (pose, ContentHash::NONE));
        (self.pose, self.state, self.rival) = (Some(before), PoseState::Held, None);
    }

    /// Takes a pose at the published place if it is near enough.
    fn place(&mut self, found: PoseRecord, map_hash: ContentHash, state: PoseState) {
        let is_jump = self.pose.is_some_and(|pose| !is_within(&pose, &found, self.max_jump.m, self.max_jump.rad));
        if is_jump {
            (self.waiting, self.state) = (Some((found, map_hash)), PoseState::Held);
            return;
        }
        // A pending pose near this place is settled; one elsewhere stays pending.
        self.waiting = self.waiting.filter(|(waiting, _)| !is_within(waiting, &found, SAME_M, SAME_RAD));
        (self.pose, self.state) = (Some(found), state);
    }
}

/// True if two poses of a storey move the middle of the newer SLAM map to about the same place, and turn as far.
fn is_within(pose: &PoseRecord, newer: &PoseRecord, far_m: f64, far_rad: f64) -> bool {
    let [a, b] = [pose, newer].map(|p| p.map_from_slam().apply(newer.about_m));
    let turn_rad = wrapped(pose.map_from_slam[2] - newer.map_from_slam[2]).abs();
    pose.map_storey == newer.map_storey && libm::hypot(a[0] - b[0], a[1] - b[1]) <= far_m && turn_rad <= far_rad
}

#[cfg(test)]
mod tests {
    use super::*;

    const MAP: ContentHash = ContentHash::from_bits(1);
    const OTHER_MAP: ContentHash = ContentHash::from_bits(2);
    const MAX_JUMP: MaxJump = MaxJump { m: 0.1, rad: 0.0175 };

    fn at(x_m: f64) -> PoseRecord {
        PoseRecord { map_from_slam: [x_m, 0.0, 0.0], map_storey: 0, ..PoseRecord::NONE }
    }

    fn at_zero() -> Follower {
        let mut follower = Follower::new(MAX_JUMP, None);
        follower.searched(Some(at(0.0)), MAP, false);
        assert_eq!((follower.pose(), follower.state()), (Some(&at(0.0)), PoseState::Found));
        follower
    }

    #[test]
    fn small_steps_are_followed_and_a_large_one_waits() {
        let mut follower = at_zero();
        follower.tracked(Some(at(0.08)), MAP);
        follower.tracked(Some(at(0.16)), MAP);
        assert_eq!((follower.pose(), follower.state()), (Some(&at(0.16)), PoseState::Tracked));
        follower.tracked(Some(at(0.30)), MAP);
        assert_eq!((follower.pose(), follower.state()), (Some(&at(0.16)), PoseState::Held));
        assert_eq!(follower.waiting(), Some(&at(0.30)));
        assert!(follower.confirm(MAP));
        assert_eq!((follower.pose(), follower.state(), follower.waiting()), (Some(&at(0.30)), PoseState::Found, None));
        assert!(!follower.confirm(MAP), "nothing waits");
    }

    #[test]
    fn a_pose_of_an_earlier_map_is_held_when_it_is_confirmed_until_the_newest_bears_it_out() {
        let mut follower = at_zero();
        follower.searched(Some(at(7.0)), MAP, true);
        follower.tracked(None, OTHER_MAP);
        assert!(!follower.confirm(OTHER_MAP));
        assert_eq!((follower.pose(), follower.state()), (Some(&at(7.0)), PoseState::Held));
        follower.tracked(Some(at(7.01)), OTHER_MAP);
        assert_eq!((follower.pose(), follower.state()), (Some(&at(7.01)), PoseState::Tracked));
    }

    #[test]
    fn a_confirmation_that_is_taken_back_gives_the_pose_before_it_and_waits_again() {
        let mut follower = at_zero();
        follower.searched(Some(at(7.0)), MAP, true);
        follower.confirm(MAP);
        follower.undo_confirm(at(0.0));
        assert_eq!((follower.pose(), follower.state()), (Some(&at(0.0)), PoseState::Held));
        assert_eq!(follower.waiting(), Some(&at(7.0)));
    }

    #[test]
    fn a_step_that_goes_back_no_longer_waits() {
        let mut follower = at_zero();
        follower.tracked(Some(at(0.2)), MAP);
        follower.tracked(Some(at(0.05)), MAP);
        assert_eq!((follower.pose(), follower.waiting()), (Some(&at(0.05)), None));
    }

    #[test]
    fn another_place_must_win_several_searches_in_a_row_and_then_waits() {
        let mut follower = at_zero();
        for _ in 1..N_WINS {
            follower.searched(Some(at(7.0)), MAP, false);
            assert_eq!(follower.waiting(), None);
        }
        follower.searched(None, MAP, false);
        follower.searched(Some(at(7.0)), MAP, false);
        assert_eq!(follower.waiting(), None, "not in a row");
        (1..N_WINS).for_each(|_| follower.searched(Some(at(7.0)), MAP, false));
        assert_eq!((follower.waiting(), follower.pose()), (Some(&at(7.0)), Some(&at(0.0))));
        follower.tracked(Some(at(0.01)), MAP);
        assert_eq!(follower.waiting(), Some(&at(7.0)), "what was followed does not settle it");
    }

    #[test]
    fn a_requested_search_waits_at_once() {
        let mut follower = at_zero();
        follower.searched(Some(PoseRecord { map_storey: 1, ..at(0.0) }), MAP, true);
        assert_eq!(follower.waiting().map(|w| w.map_storey), Some(1));
        assert_eq!(follower.pose().map(|p| p.map_storey), Some(0));
    }

    #[test]
    fn a_map_that_does_not_bear_the_pose_out_holds_it() {
        let mut follower = at_zero();
        follower.tracked(None, MAP);
        follower.searched(None, MAP, false);
        assert_eq!((follower.pose(), follower.state()), (Some(&at(0.0)), PoseState::Held));
        let mut nothing = Follower::new(MAX_JUMP, None);
        nothing.tracked(None, MAP);
        assert_eq!((nothing.pose(), nothing.state()), (None, PoseState::None));
    }

    #[test]
    fn what_counted_before_a_restart_counts_when_the_next_map_bears_it_out() {
        let mut follower = Follower::new(MAX_JUMP, Some(at(1.0)));
        assert_eq!((follower.pose(), follower.state()), (Some(&at(1.0)), PoseState::Held));
        follower.tracked(Some(at(1.02)), MAP);
        assert_eq!((follower.pose(), follower.state()), (Some(&at(1.02)), PoseState::Tracked));
    }
}
