//! The `alignment` archive: pose of the SLAM map in the model's map, covariance and verdict.

use crate::alignment_records::*;
use crate::archive::{Archive, ArchiveBuffer, ArchiveError, ArchiveKind, SectionList, Text};
use crate::archive_writer::ArchiveWriter;
use crate::local_poses::{LocalPoseRecord, LocalPoses, LocalPosesHead, OutlineRingRecord};
use crate::payload;
use crate::tag::check_tags;
use crate::text_pool::TextPool;

pub(crate) mod section {
    pub(crate) const HEAD: u32 = 1;
    pub(crate) const STRINGS: u32 = 2;
    pub(crate) const CANDIDATES: u32 = 3;
    pub(crate) const DECIDING_PLACES: u32 = 4;
    pub(crate) const PLACED: u32 = 5;
    pub(crate) const POSE_PAIRS: u32 = 6;
    pub(crate) const HINTS: u32 = 7;
    pub(crate) const LOCAL_POSES_HEAD: u32 = 8;
    pub(crate) const LOCAL_POSES: u32 = 9;
    pub(crate) const BLOCKS: u32 = 10;
    pub(crate) const OUTLINE_RINGS: u32 = 11;
    pub(crate) const OUTLINE_CORNERS: u32 = 12;
}

/// An alignment, read in place.
#[derive(Debug, Clone, Copy)]
pub struct Alignment<'a> {
    archive: Archive<'a>,
    strings: &'a str,
    /// Head of the alignment.
    pub head: &'a AlignmentHead,
    /// Poses that fit the newest map, best first.
    pub candidates: &'a [PoseRecord],
    /// Places to drive to that decide between candidates that fit alike, the best first.
    pub deciding_places: &'a [DecidingPlaceRecord],
    placed: &'a [PlacedRecord],
    pose_pairs: &'a [PosePairRecord],
    /// What each place hint excluded.
    pub hints: &'a [HintRecord],
    /// The pose from place to place; `None` without a current pose of the newest map.
    pub local_poses: Option<LocalPoses<'a>>,
}

impl<'a> Alignment<'a> {
    /// Candidates that are listed.
    pub const MAX_CANDIDATES: usize = 64;
    /// Deciding places.
    pub const MAX_DECIDING_PLACES: usize = 16;
    /// Place hints.
    pub const MAX_HINTS: usize = 64;

    /// Validates and views an archive.
    ///
    /// # Errors
    /// Bytes that are no whole alignment, or numbers that are none.
    pub fn open(bytes: &'a [u8]) -> Result<Self, ArchiveError> {
        let alignment = Self::of(Archive::open(bytes, ArchiveKind::Alignment)?)?;
        let head = alignment.head;
        check_tags([head.verdict], "verdict")?;
        check_tags([head.state], "state of a pose")?;
        check_tags([head.validity], "validity of a pose")?;
        let numbers = [head.wrong_probability, head.scale, head.scale_deviation];
        let whole = [head.reason, head.decision, head.change].iter().all(|text| text.of(alignment.strings).is_some())
            && head.is_waiting <= 1
            && alignment.candidates.len() <= Self::MAX_CANDIDATES
            && numbers.iter().all(|n| n.is_finite())
            && [&head.pose, &head.waiting].into_iter().chain(alignment.candidates).all(PoseRecord::is_finite);
        if !whole {
            return Err(ArchiveError::Index { what: "a pose" });
        }
        if !alignment.local_poses.is_none_or(|local| local.is_whole()) {
            return Err(ArchiveError::Index { what: "a local pose" });
        }
        if alignment.is_decision_whole() {
            Ok(alignment)
        } else {
            Err(ArchiveError::Index { what: "a deciding place" })
        }
    }

    /// True if all that is said beside poses lies within its limits and sections.
    fn is_decision_whole(&self) -> bool {
        let n_candidates = self.candidates.len();
        let is_text = |text: Text| text.of(self.strings).is_some();
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
        self.deciding_places.len() <= Self::MAX_DECIDING_PLACES
            && self.hints.len() <= Self::MAX_HINTS
            && self.placed.len() <= Self::MAX_DECIDING_PLACES * Self::MAX_CANDIDATES
            && self.pose_pairs.len() <= (Self::MAX_DECIDING_PLACES + 1) * Self::MAX_CANDIDATES * Self::MAX_CANDIDATES
            && self.head.first_undecided as usize <= self.pose_pairs.len()
            && self.deciding_places.iter().all(is_place)
            && self.placed.iter().all(is_placed)
            && self.pose_pairs.iter().all(is_pair)
            && self.hints.iter().all(|hint| is_text(hint.label))
    }

    /// The sections of an archive, without validation of their records.
    pub(crate) fn of(archive: Archive<'a>) -> Result<Self, ArchiveError> {
        let heads: &[LocalPosesHead] = archive.optional_section(section::LOCAL_POSES_HEAD)?;
        let local_poses = heads.first().map(|head| -> Result<LocalPoses<'a>, ArchiveError> {
            Ok(LocalPoses {
                head,
                parts: archive.section(section::LOCAL_POSES)?,
                blocks: archive.section(section::BLOCKS)?,
                rings: archive.section(section::OUTLINE_RINGS)?,
                corners: archive.section(section::OUTLINE_CORNERS)?,
            })
        });
        Ok(Self {
            archive,
            strings: archive.strings(section::STRINGS)?,
            head: archive.record(section::HEAD)?,
            candidates: archive.section(section::CANDIDATES)?,
            deciding_places: archive.section(section::DECIDING_PLACES)?,
            placed: archive.section(section::PLACED)?,
            pose_pairs: archive.section(section::POSE_PAIRS)?,
            hints: archive.section(section::HINTS)?,
            local_poses: local_poses.transpose()?,
        })
    }

    /// Hash of the content.
    pub fn content_hash(&self) -> u64 {
        self.archive.content_hash()
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

    /// The current pose: the only one to be used, and only while [`Alignment::validity`] is effective.
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
        text.of(self.strings).expect(CHECKED)
    }
}

const CHECKED: &str = "it was checked when the archive was opened";

fn part<T>(all: &[T], first: u32, n: u32) -> Option<&[T]> {
    all.get(first as usize..)?.get(..n as usize)
}

/// An `alignment` archive to be.
#[derive(Debug)]
pub struct AlignmentBuilder<'a> {
    /// Head of the alignment; its texts are those of the pool.
    pub head: AlignmentHead,
    /// Poses that fit, best first; those beyond [`Alignment::MAX_CANDIDATES`] are left out.
    pub candidates: &'a [PoseRecord],
    /// Places to drive to that decide between candidates.
    pub deciding_places: Vec<DecidingPlaceRecord>,
    /// Where they lie by each candidate.
    pub placed: Vec<PlacedRecord>,
    /// Pairs of candidates: those that are told apart at deciding places, then those that nothing tells apart.
    pub pose_pairs: Vec<PosePairRecord>,
    /// What place hints excluded.
    pub hints: Vec<HintRecord>,
    /// The pose from place to place, if there is a current one of the newest map.
    pub local_poses: Option<LocalPosesParts>,
    /// All texts.
    pub texts: TextPool,
}

/// The pose of a SLAM map from place to place, to be written.
#[derive(Debug, Clone)]
pub struct LocalPosesParts {
    /// Of the map as a whole.
    pub head: LocalPosesHead,
    /// One for each part.
    pub parts: Vec<LocalPoseRecord>,
    /// The part of each block, row-major; [`crate::NONE`] without floor.
    pub blocks: Vec<u32>,
    /// Loops of the outline of the part for which the pose holds.
    pub rings: Vec<OutlineRingRecord>,
    /// Their corners.
    pub corners: Vec<[f64; 2]>,
}

impl<'a> AlignmentBuilder<'a> {
    /// Poses alone.
    pub fn new(head: AlignmentHead, reason: &str, candidates: &'a [PoseRecord]) -> Self {
        let mut texts = TextPool::default();
        let head = AlignmentHead { reason: texts.add(reason), ..head };
        let (deciding_places, placed, pose_pairs, hints) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        Self { head, candidates, deciding_places, placed, pose_pairs, hints, local_poses: None, texts }
    }

    /// Writes the archive into the heap.
    pub fn finish(&self) -> ArchiveBuffer {
        self.to_buffer()
    }

    fn sections(&self) -> SectionList<'_> {
        let mut list = SectionList::default();
        list.add(section::HEAD, std::slice::from_ref(&self.head));
        list.add(section::CANDIDATES, &self.candidates[..self.candidates.len().min(Alignment::MAX_CANDIDATES)]);
        list.add(section::DECIDING_PLACES, &self.deciding_places);
        list.add(section::PLACED, &self.placed);
        list.add(section::POSE_PAIRS, &self.pose_pairs);
        list.add(section::HINTS, &self.hints);
        list.add(section::STRINGS, self.texts.bytes());
        if let Some(LocalPosesParts { head, parts, blocks, rings, corners }) = &self.local_poses {
            list.add(section::LOCAL_POSES_HEAD, std::slice::from_ref(head));
            list.add(section::LOCAL_POSES, parts);
            list.add(section::BLOCKS, blocks);
            list.add(section::OUTLINE_RINGS, rings);
            list.add(section::OUTLINE_CORNERS, corners);
        }
        list
    }
}

impl ArchiveWriter for AlignmentBuilder<'_> {
    type Payload = payload::Alignment;

    fn length(&self) -> usize {
        self.sections().length()
    }

    fn write(&self, out: &mut [u8]) -> u64 {
        self.sections().write(out, ArchiveKind::Alignment)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tag::Tag;
    use bytemuck::Zeroable;

    fn head() -> AlignmentHead {
        AlignmentHead {
            site_hash: 1,
            slam_map_hash: 2,
            searched_map_hash: 1,
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
        let buffer = AlignmentBuilder::new(head(), "two fit", &[PoseRecord::NONE; 2]).finish();
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
            let buffer = AlignmentBuilder::new(wrong, "", &[]).finish();
            assert!(Alignment::open(buffer.bytes()).is_err());
        }
    }

    /// Two candidates, and a place in a room by each of them that tells them apart.
    fn undecided() -> AlignmentBuilder<'static> {
        let mut builder = AlignmentBuilder::new(head(), "two fit", &[PoseRecord::NONE; 2]);
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
        let refused = |change: fn(&mut AlignmentBuilder<'_>)| {
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
