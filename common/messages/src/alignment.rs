//! The `alignment` archive: pose of the SLAM map in the model's map, covariance and verdict.

use crate::alignment_records::*;
use crate::archive::{ArchiveError, Text};
use crate::declaration::declare_archive;
use crate::local_poses::{LocalPoses, LocalPosesParts};
use crate::tag::check_tags;

declare_archive! {
    /// An alignment, read in place.
    view Alignment;
    /// An `alignment` archive to be; the texts of its head are those of its pool.
    owned AlignmentBuilder;
    sections {
        /// Head of the alignment.
        pub head: one(1, AlignmentHead),
        /// Poses that fit the newest map, best first.
        pub candidates: at_most(3, PoseRecord, Alignment::MAX_CANDIDATES),
        /// Places to drive to that decide between candidates that fit alike, the best first.
        pub deciding_places: at_most(4, DecidingPlaceRecord, Alignment::MAX_DECIDING_PLACES),
        /// Where they lie by each candidate.
        placed: at_most(5, PlacedRecord, Alignment::MAX_DECIDING_PLACES * Alignment::MAX_CANDIDATES),
        /// Pairs of candidates: those that are told apart at deciding places, then those that nothing tells apart.
        pose_pairs: at_most(6, PosePairRecord, Alignment::MAX_POSE_PAIRS),
        /// What each place hint excluded.
        pub hints: at_most(7, HintRecord, Alignment::MAX_HINTS),
        /// All texts.
        texts: texts(2),
        /// The pose from place to place; `None` without a current pose of the newest map.
        pub local_poses: optional_group(8, LocalPoses, LocalPosesParts),
    }
}

impl<'a> Alignment<'a> {
    /// Candidates that are listed.
    pub const MAX_CANDIDATES: usize = 64;
    /// Deciding places.
    pub const MAX_DECIDING_PLACES: usize = 16;
    /// Place hints.
    pub const MAX_HINTS: usize = 64;
    /// Pairs of candidates.
    const MAX_POSE_PAIRS: usize = (Self::MAX_DECIDING_PLACES + 1) * Self::MAX_CANDIDATES * Self::MAX_CANDIDATES;

    fn check(&self) -> Result<(), ArchiveError> {
        let head = self.head;
        check_tags([head.verdict], "verdict")?;
        check_tags([head.state], "state of a pose")?;
        check_tags([head.validity], "validity of a pose")?;
        let numbers = [head.wrong_probability, head.scale, head.scale_deviation];
        let whole = [head.reason, head.decision, head.change].into_iter().all(|text| self.texts.has(text))
            && head.is_waiting <= 1
            && numbers.iter().all(|n| n.is_finite())
            && [&head.pose, &head.waiting].into_iter().chain(self.candidates).all(PoseRecord::is_finite);
        let check = |ok: bool, what| if ok { Ok(()) } else { Err(ArchiveError::Index { what }) };
        check(whole, "a pose")?;
        check(self.local_poses.is_none_or(|local| local.is_whole()), "a local pose")?;
        check(self.is_decision_whole(), "a deciding place")
    }

    /// True if all that is said beside poses lies within its limits and sections.
    fn is_decision_whole(&self) -> bool {
        let n_candidates = self.candidates.len();
        let is_text = |text: Text| self.texts.has(text);
        let is_placed = |p: &PlacedRecord| {
            p.in_map_m.iter().all(|n| n.is_finite())
                && [p.room_global_id, p.room_name, p.room_long_name].into_iter().all(is_text)
        };
        let is_place = |place: &DecidingPlaceRecord| {
            place.in_slam_m.iter().chain([&place.way_m, &place.differing_m]).all(|n| n.is_finite())
                && place.n_placed as usize <= n_candidates
                && part(self.placed, place.first_placed, place.n_placed).is_some()
                && part(self.pose_pairs, place.first_pair, place.n_pairs).is_some()
        };
        let is_pair = |pair: &PosePairRecord| pair.candidates.iter().all(|k| (*k as usize) < n_candidates);
        self.head.first_undecided as usize <= self.pose_pairs.len()
            && self.deciding_places.iter().all(is_place)
            && self.placed.iter().all(is_placed)
            && self.pose_pairs.iter().all(is_pair)
            && self.hints.iter().all(|hint| is_text(hint.label))
    }

    /// What the current pose is worth for the newest map.
    pub fn validity(&self) -> PoseValidity {
        self.head.validity.get()
    }

    /// True if the newest map was searched; false while it waits for that, and the verdict is of an earlier map.
    pub fn is_searched(&self) -> bool {
        self.head.searched_map_hash == self.head.slam_map_hash
    }

    /// Verdict on the map that was searched last, see [`Alignment::is_searched`].
    pub fn verdict(&self) -> AlignmentVerdict {
        self.head.verdict.get()
    }

    /// How the current pose was obtained.
    pub fn state(&self) -> PoseState {
        self.head.state.get()
    }

    /// The current pose: the only one to be used, and only where [`Alignment::usable`] gives it.
    pub fn pose(&self) -> Option<&'a PoseRecord> {
        (self.state() != PoseState::None).then_some(&self.head.pose)
    }

    /// The pose of the SLAM map around a place in it, and what that is worth for a robot there: the rule for everybody who knows where
    /// the robot is. `None` without a current pose.
    pub fn pose_at(&self, in_slam_m: [f64; 2]) -> Option<(PoseRecord, PoseValidity)> {
        let (whole, validity) = (self.pose()?, self.validity());
        let Some(local_poses) = self.local_poses else { return Some((*whole, validity)) };
        let local = local_poses.at(in_slam_m, whole);
        let validity = match validity {
            PoseValidity::Effective | PoseValidity::Uncertain => {
                let is_known = local.is_some_and(|pose| !local_poses.is_uncertain(&pose));
                if is_known { PoseValidity::Effective } else { PoseValidity::Uncertain }
            }
            other => other,
        };
        Some((local.unwrap_or(*whole), validity))
    }

    /// The pending pose, which an operator must confirm.
    pub fn waiting(&self) -> Option<&'a PoseRecord> {
        (self.head.is_waiting == 1).then_some(&self.head.waiting)
    }

    /// Why the map that was searched last is not accepted, and what is wrong with it, which may also be said of one that is; else empty.
    pub fn reason(&self) -> &'a str {
        self.text(self.head.reason)
    }

    /// What would decide between candidates that fit alike, for people; `None` where nothing has to be decided.
    pub fn decision(&self) -> Option<&'a str> {
        Some(self.text(self.head.decision)).filter(|text| !text.is_empty())
    }

    /// What became of the pose that an earlier look at the same map accepted; `None` if it still is, or if none was.
    pub fn change(&self) -> Option<&'a str> {
        Some(self.text(self.head.change)).filter(|text| !text.is_empty())
    }

    /// Where a deciding place lies by each of the best candidates.
    pub fn placed(&self, place: &DecidingPlaceRecord) -> &'a [PlacedRecord] {
        part(self.placed, place.first_placed, place.n_placed).expect(CHECKED)
    }

    /// The pairs of candidates that are told apart at a deciding place.
    pub fn decided(&self, place: &DecidingPlaceRecord) -> &'a [PosePairRecord] {
        part(self.pose_pairs, place.first_pair, place.n_pairs).expect(CHECKED)
    }

    /// The pairs of candidates that nothing in the model tells apart that the robot can reach.
    pub fn undecided(&self) -> &'a [PosePairRecord] {
        self.pose_pairs.get(self.head.first_undecided as usize..).expect(CHECKED)
    }

    /// A text of the archive.
    pub fn text(&self, text: Text) -> &'a str {
        self.texts.get(text)
    }
}

const CHECKED: &str = "it was checked when the archive was opened";

fn part<T>(all: &[T], first: u32, n: u32) -> Option<&[T]> {
    all.get(first as usize..)?.get(..n as usize)
}

impl AlignmentBuilder {
    /// Poses alone; candidates, best first, beyond [`Alignment::MAX_CANDIDATES`] are left out.
    pub fn new(head: AlignmentHead, reason: &str, mut candidates: Vec<PoseRecord>) -> Self {
        candidates.truncate(Alignment::MAX_CANDIDATES);
        let mut builder = Self { candidates, ..Self::default() };
        builder.head = AlignmentHead { reason: builder.texts.add(reason), ..head };
        builder
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::content_hash::ContentHash;
    use crate::tag::Tag;
    use bytemuck::Zeroable;

    fn head() -> AlignmentHead {
        AlignmentHead {
            site_hash: ContentHash::from_bits(1),
            slam_map_hash: ContentHash::from_bits(2),
            searched_map_hash: ContentHash::from_bits(1),
            plan_time_s: 3,
            pose: PoseRecord { map_from_slam: [1.0, 2.0, 0.5], ..PoseRecord::NONE },
            waiting: PoseRecord::NONE,
            wrong_probability: 0.01,
            scale: 1.0,
            scale_deviation: 0.001,
            reason: Text::default(),
            decision: Text::default(),
            change: Text::default(),
            verdict: AlignmentVerdict::Ambiguous.into(),
            state: PoseState::Held.into(),
            is_waiting: 0,
            validity: PoseValidity::Held.into(),
            first_undecided: 0,
            reserved: 0,
        }
    }

    #[test]
    fn poses_and_reasons_come_back() {
        let buffer = AlignmentBuilder::new(head(), "two fit", vec![PoseRecord::NONE; 2]).finish();
        let view = Alignment::open(buffer.bytes()).unwrap();
        assert_eq!(
            (view.verdict(), view.state(), view.reason()),
            (AlignmentVerdict::Ambiguous, PoseState::Held, "two fit")
        );
        assert_eq!(view.pose().unwrap().map_from_slam, [1.0, 2.0, 0.5]);
        assert!(view.waiting().is_none() && view.candidates.len() == 2);
        assert!(view.validity() == PoseValidity::Held && !view.is_searched());
    }

    #[test]
    fn numbers_that_are_none_are_refused() {
        for wrong in [
            AlignmentHead { scale: f64::NAN, ..head() },
            AlignmentHead { verdict: Tag::numbered(3), ..head() },
            AlignmentHead { state: Tag::numbered(4), ..head() },
            AlignmentHead { validity: Tag::numbered(5), ..head() },
            AlignmentHead { pose: PoseRecord { about_m: [f64::INFINITY; 2], ..PoseRecord::NONE }, ..head() },
        ] {
            let buffer = AlignmentBuilder::new(wrong, "", vec![]).finish();
            assert!(Alignment::open(buffer.bytes()).is_err());
        }
    }

    /// Two candidates, and a place in a room by each of them that tells them apart.
    fn undecided() -> AlignmentBuilder {
        let mut builder = AlignmentBuilder::new(head(), "two fit", vec![PoseRecord::NONE; 2]);
        builder.head.decision = builder.texts.add("drive through U.04");
        let [global_id, name] = ["0123456789012345678901", "U.04"].map(|text| builder.texts.add(text));
        let room =
            PlacedRecord { in_map_m: [1.0, 2.0], room_global_id: global_id, room_name: name, room_long_name: name };
        builder.placed = vec![room, PlacedRecord { room_global_id: Text::default(), ..room }];
        builder.pose_pairs = vec![PosePairRecord { candidates: [0, 1] }; 2];
        builder.head.first_undecided = 1;
        let place = DecidingPlaceRecord { in_slam_m: [3.0, 4.0], n_placed: 2, n_pairs: 1, ..Zeroable::zeroed() };
        builder.deciding_places = vec![place];
        let label = builder.texts.add("start room U.04");
        builder.hints = vec![HintRecord { label, n_excluded: 3, reserved: 0 }];
        builder
    }

    #[test]
    fn what_decides_and_what_hints_excluded_come_back() {
        let buffer = undecided().finish();
        let view = Alignment::open(buffer.bytes()).unwrap();
        assert_eq!((view.reason(), view.decision()), ("two fit", Some("drive through U.04")));
        let place = &view.deciding_places[0];
        let rooms: Vec<&str> = view.placed(place).iter().map(|placed| view.text(placed.room_global_id)).collect();
        assert_eq!(rooms, ["0123456789012345678901", ""]);
        assert_eq!((view.decided(place).len(), view.undecided().len()), (1, 1));
        assert_eq!(
            view.hints.iter().map(|hint| (view.text(hint.label), hint.n_excluded)).next(),
            Some(("start room U.04", 3))
        );
        let refused = |change: fn(&mut AlignmentBuilder)| {
            let mut builder = undecided();
            change(&mut builder);
            Alignment::open(builder.finish().bytes()).is_err()
        };
        assert!(refused(|b| b.deciding_places[0].n_placed = 3));
        assert!(refused(|b| b.deciding_places[0].first_pair = 2));
        assert!(refused(|b| b.deciding_places[0].way_m = f64::NAN));
        assert!(refused(|b| b.deciding_places = vec![b.deciding_places[0]; Alignment::MAX_DECIDING_PLACES + 1]));
        assert!(refused(|b| b.pose_pairs[1].candidates[1] = 2));
        assert!(refused(|b| b.head.first_undecided = 3));
        assert!(refused(|b| b.placed[0].room_name.length = 1000));
        assert!(refused(|b| b.hints[0].label.offset = 1000));
        assert!(refused(|b| b.head.decision.length = 1000));
        assert!(refused(|b| b.head.change.length = 1000));
    }
}
