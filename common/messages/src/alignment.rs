//! The `alignment` archive: pose of the SLAM map in the model's map, covariance and verdict.

use crate::archive::{Archive, ArchiveBuffer, ArchiveError, ArchiveKind, NONE, SectionList, Text};
use crate::archive_writer::ArchiveWriter;
use crate::payload;
use crate::tag::{Tag, check_tags};
use bytemuck::{CheckedBitPattern, NoUninit, Pod, Zeroable};
use frames::{Map, PoseCovariance, Rigid2, Slam};

mod section {
    pub(super) const HEAD: u32 = 1;
    pub(super) const STRINGS: u32 = 2;
    pub(super) const CANDIDATES: u32 = 3;
}

/// Verdict on an alignment.
#[derive(Debug, Clone, Copy, PartialEq, Eq, CheckedBitPattern, NoUninit)]
#[repr(u32)]
pub enum AlignmentVerdict {
    /// One pose, wrong with a probability below 0.1 %.
    Accepted = 0,
    /// Several poses that fit almost alike.
    Ambiguous = 1,
    /// No pose fits well enough.
    Refused = 2,
}

impl AlignmentVerdict {
    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Accepted => "accepted",
            Self::Ambiguous => "ambiguous",
            Self::Refused => "refused",
        }
    }
}

/// How the current pose was obtained.
#[derive(Debug, Clone, Copy, PartialEq, Eq, CheckedBitPattern, NoUninit)]
#[repr(u32)]
pub enum PoseState {
    /// No pose was accepted yet.
    None = 0,
    /// A search of all poses accepted it, of the newest map.
    Found = 1,
    /// The last pose was refined with the newest map.
    Tracked = 2,
    /// The newest map does not confirm it: the last pose is kept.
    Held = 3,
}

impl PoseState {
    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Found => "found",
            Self::Tracked => "tracked",
            Self::Held => "held",
        }
    }
}

/// What the pose of an alignment is worth for the newest SLAM map in the current frame. Only an effective pose may be used
/// to move a robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq, CheckedBitPattern, NoUninit)]
#[repr(u32)]
pub enum PoseValidity {
    /// The newest map bears the pose out.
    Effective = 0,
    /// Another pose waits for an operator, who says which of both is right.
    WaitsForConfirm = 1,
    /// The newest map does not bear the pose out, or waits for a search.
    Held = 2,
    /// The newest map was searched, and no pose was accepted.
    Refused = 3,
    /// The newest map bears the pose out, but it is known less well than the site asks for.
    Uncertain = 4,
}

impl PoseValidity {
    /// Its name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Effective => "effective",
            Self::WaitsForConfirm => "waits_for_confirm",
            Self::Held => "held",
            Self::Refused => "refused",
            Self::Uncertain => "uncertain",
        }
    }
}

/// Evidence for a pose. Shares are from 0 to 1.
#[derive(Debug, Clone, Copy, Default, PartialEq, Zeroable, Pod)]
#[repr(C)]
pub struct PoseEvidence {
    /// By which poses are compared: between two poses of one map the difference is the natural logarithm of their odds.
    pub log_odds: f64,
    /// Agreement of walls, from 0 to 1: of precision and recall.
    pub score: f64,
    /// Share of the SLAM map's walls that the model has.
    pub precision: f64,
    /// Share of the visible walls of the model that the SLAM map has.
    pub recall: f64,
    /// Share of the SLAM map's free cells that are free in the model.
    pub free: f64,
    /// Length of the faces of the model's walls that the robot would have had in sight, in metres.
    pub seen_m: f64,
    /// Share of them that it saw through.
    pub seen_through: f64,
    /// Share of the SLAM map's occupied cells that lie in walls of the model.
    pub in_walls: f64,
    /// Share of them that lie where the model knows nothing.
    pub outside: f64,
    /// Share of the SLAM map's free cells that lie in walls of the model.
    pub free_in_walls: f64,
    /// Length of the SLAM map's walls that lie on faces of the model, of each face at most half a metre, in metres.
    pub distinct_m: f64,
}

/// A pose of the robot's map in the model's.
#[derive(Debug, Clone, Copy, PartialEq, Zeroable, Pod)]
#[repr(C)]
pub struct PoseRecord {
    /// `map_from_slam`: x, y in metres, yaw in radians.
    pub map_from_slam: [f64; 3],
    /// Covariance of the position of [`PoseRecord::about_m`] (x, y) and of yaw, row-major.
    pub covariance: [f64; 9],
    /// The middle of the mapped area, in the frame of the SLAM map.
    pub about_m: [f64; 2],
    /// Evidence for it.
    pub evidence: PoseEvidence,
    /// Map storey; [`NONE`] for a map without a site.
    pub map_storey: u32,
    /// Zero.
    pub reserved: u32,
}
const _: () = assert!(size_of::<PoseRecord>() == 208);

/// Head of an alignment: one record.
#[derive(Debug, Clone, Copy, PartialEq, Zeroable, Pod)]
#[repr(C)]
pub struct AlignmentHead {
    /// Content hash of the site; 0 for maps without one.
    pub site_hash: u64,
    /// Content hash of the newest SLAM map, for which the pose is valid or not.
    pub slam_map_hash: u64,
    /// Content hash of the SLAM map that verdict, reason and candidates are of; another one than the newest while that waits
    /// for its search, 0 if none was searched.
    pub searched_map_hash: u64,
    /// The plan time of the reference, or [`crate::ScheduleStateHead::NO_TIME`].
    pub plan_time_s: i64,
    /// The current pose; zeros unless [`AlignmentHead::state`] says that there is one.
    pub pose: PoseRecord,
    /// A pose that waits for an operator to confirm it; zeros unless [`AlignmentHead::is_waiting`].
    pub waiting: PoseRecord,
    /// Probability that the best pose of the map that was searched last is wrong; 1 before a search.
    pub wrong_probability: f64,
    /// Scale of the SLAM map against the model; 1 if its lengths are right.
    pub scale: f64,
    /// Standard deviation of the scale.
    pub scale_deviation: f64,
    /// Why the newest verdict is not `accepted`; empty if it is.
    pub reason: Text,
    /// Verdict on the map that was searched last.
    pub verdict: Tag<AlignmentVerdict>,
    /// How the current pose was obtained.
    pub state: Tag<PoseState>,
    /// 1 if there is a pending pose.
    pub is_waiting: u32,
    /// What the current pose is worth.
    pub validity: Tag<PoseValidity>,
}
const _: () = assert!(size_of::<AlignmentHead>() == 496);

/// An alignment, read in place.
#[derive(Debug, Clone, Copy)]
pub struct Alignment<'a> {
    archive: Archive<'a>,
    strings: &'a str,
    /// Head of the alignment.
    pub head: &'a AlignmentHead,
    /// Poses that fit the newest map, best first.
    pub candidates: &'a [PoseRecord],
}

impl<'a> Alignment<'a> {
    /// Candidates that are listed.
    pub const MAX_CANDIDATES: usize = 64;

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
        let whole = head.reason.of(alignment.strings).is_some()
            && head.is_waiting <= 1
            && alignment.candidates.len() <= Self::MAX_CANDIDATES
            && numbers.iter().all(|n| n.is_finite())
            && [&head.pose, &head.waiting].into_iter().chain(alignment.candidates).all(PoseRecord::is_finite);
        if whole { Ok(alignment) } else { Err(ArchiveError::Index { what: "a pose" }) }
    }

    /// The sections of an archive, without validation of their records.
    pub(crate) fn of(archive: Archive<'a>) -> Result<Self, ArchiveError> {
        Ok(Self {
            archive,
            strings: archive.strings(section::STRINGS)?,
            head: archive.record(section::HEAD)?,
            candidates: archive.section(section::CANDIDATES)?,
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

    /// The pending pose, which an operator must confirm.
    pub fn waiting(&self) -> Option<&'a PoseRecord> {
        (self.head.is_waiting == 1).then_some(&self.head.waiting)
    }

    /// Why the map that was searched last is not accepted; empty if it is.
    pub fn reason(&self) -> &'a str {
        self.head.reason.of(self.strings).expect("it was checked when the archive was opened")
    }
}

impl PoseRecord {
    /// No pose.
    pub const NONE: Self = Self {
        map_from_slam: [0.0; 3],
        covariance: [0.0; 9],
        about_m: [0.0; 2],
        evidence: PoseEvidence {
            log_odds: 0.0,
            score: 0.0,
            precision: 0.0,
            recall: 0.0,
            free: 0.0,
            seen_m: 0.0,
            seen_through: 0.0,
            in_walls: 0.0,
            outside: 0.0,
            free_in_walls: 0.0,
            distinct_m: 0.0,
        },
        map_storey: NONE,
        reserved: 0,
    };

    /// The motion from the robot's map to the model's.
    pub fn map_from_slam(&self) -> Rigid2<Map, Slam> {
        Rigid2::of_x_y_yaw(self.map_from_slam)
    }

    /// The covariance of where [`PoseRecord::about_m`] comes to lie and of yaw.
    pub fn pose_covariance(&self) -> PoseCovariance {
        PoseCovariance::from_rows([0, 1, 2].map(|r| [0, 1, 2].map(|c| self.covariance[3 * r + c])))
    }

    fn is_finite(&self) -> bool {
        let evidence: [f64; 11] = bytemuck::cast(self.evidence);
        let numbers = self.map_from_slam.iter().chain(&self.covariance).chain(&self.about_m).chain(&evidence);
        numbers.into_iter().all(|n| n.is_finite())
    }
}

/// An `alignment` archive to be.
#[derive(Debug)]
pub struct AlignmentBuilder<'a> {
    /// Head of the alignment; its reason is filled in.
    pub head: AlignmentHead,
    /// Why the newest map is not accepted.
    pub reason: &'a str,
    /// Poses that fit, best first; those beyond [`Alignment::MAX_CANDIDATES`] are left out.
    pub candidates: &'a [PoseRecord],
}

impl AlignmentBuilder<'_> {
    /// Writes the archive into the heap.
    pub fn finish(&self) -> ArchiveBuffer {
        self.to_buffer()
    }

    /// The head with its reason, which is all text that there is.
    fn head(&self) -> AlignmentHead {
        AlignmentHead { reason: Text { offset: 0, length: self.reason.len() as u32 }, ..self.head }
    }

    fn sections<'a>(&'a self, head: &'a AlignmentHead) -> SectionList<'a> {
        let mut list = SectionList::default();
        list.add(section::HEAD, std::slice::from_ref(head));
        list.add(section::CANDIDATES, &self.candidates[..self.candidates.len().min(Alignment::MAX_CANDIDATES)]);
        list.add(section::STRINGS, self.reason.as_bytes());
        list
    }
}

impl ArchiveWriter for AlignmentBuilder<'_> {
    type Payload = payload::Alignment;

    fn length(&self) -> usize {
        self.sections(&self.head()).length()
    }

    fn write(&self, out: &mut [u8]) -> u64 {
        self.sections(&self.head()).write(out, ArchiveKind::Alignment)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
            verdict: AlignmentVerdict::Ambiguous.into(),
            state: PoseState::Held.into(),
            is_waiting: 0,
            validity: PoseValidity::Held.into(),
        }
    }

    #[test]
    fn poses_and_reasons_come_back() {
        let buffer = AlignmentBuilder { head: head(), reason: "two fit", candidates: &[PoseRecord::NONE; 2] }.finish();
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
            let buffer = AlignmentBuilder { head: wrong, reason: "", candidates: &[] }.finish();
            assert!(Alignment::open(buffer.bytes()).is_err());
        }
    }
}
