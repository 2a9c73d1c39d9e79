//! The `phase` archive: states of elements and spaces at a plan time.

use crate::archive::{Archive, ArchiveBuffer, ArchiveError, ArchiveKind, SectionList, Text};
use crate::site_builder::TextPool;
use bytemuck::{Pod, Zeroable};
use frames::PlanTime;

mod section {
    pub(super) const HEAD: u32 = 1;
    pub(super) const STRINGS: u32 = 2;
    pub(super) const PLANNED: u32 = 3;
    pub(super) const EFFECTIVE: u32 = 4;
    pub(super) const SPACES: u32 = 5;
}

/// Facts of the phase: one record. Times are seconds of the civil calendar since 1970-01-01T00:00.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Zeroable, Pod)]
#[repr(C)]
pub struct PhaseHead {
    /// Content hash of the site it belongs to.
    pub site_hash: u64,
    /// The plan time; [`PhaseHead::NO_TIME`] if everything stands regardless of dates.
    pub plan_time_s: i64,
    /// Last change before it, or [`PhaseHead::NO_TIME`].
    pub valid_from_s: i64,
    /// Next change after it, or [`PhaseHead::NO_TIME`].
    pub valid_until_s: i64,
}
const _: () = assert!(size_of::<PhaseHead>() == 32);

impl PhaseHead {
    /// No such time.
    pub const NO_TIME: i64 = i64::MIN;

    /// The plan time; `None` if everything stands regardless of dates.
    pub fn plan_time(&self) -> Option<PlanTime> {
        (self.plan_time_s != Self::NO_TIME).then(|| PlanTime::from_civil_seconds(self.plan_time_s)).flatten()
    }
}

/// State of an element.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum ElementState {
    /// Not there yet.
    NotStarted = 0,
    /// Being built.
    InProgress = 1,
    /// There.
    Built = 2,
    /// Being removed.
    BeingRemoved = 3,
    /// Gone.
    Removed = 4,
}

impl ElementState {
    /// True if the element is in the way: finished, or being worked on.
    pub fn is_obstacle(self) -> bool {
        matches!(self, Self::InProgress | Self::Built | Self::BeingRemoved)
    }

    fn from_id(id: u8) -> Option<Self> {
        [Self::NotStarted, Self::InProgress, Self::Built, Self::BeingRemoved, Self::Removed]
            .get(usize::from(id))
            .copied()
    }
}

/// State of a space.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum SpaceState {
    /// A robot may enter.
    Open = 0,
    /// A robot must not enter.
    Blocked = 1,
}

/// State of a space and why.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Zeroable, Pod)]
#[repr(C)]
pub struct SpaceStateRecord {
    /// [`SpaceState`] as a number.
    pub state: u32,
    /// Zero.
    pub reserved: u32,
    /// Reasons, separated by a line feed; empty if open.
    pub why: Text,
}
const _: () = assert!(size_of::<SpaceStateRecord>() == 16);

/// States at a plan time, read in place.
#[derive(Debug, Clone, Copy)]
pub struct Phase<'a> {
    archive: Archive<'a>,
    strings: &'a str,
    /// Facts of the phase.
    pub head: &'a PhaseHead,
    planned: &'a [u8],
    effective: &'a [u8],
    /// One record per space of the site.
    pub spaces: &'a [SpaceStateRecord],
}

impl<'a> Phase<'a> {
    /// Validates and views an archive.
    ///
    /// # Errors
    /// Bytes that are no whole phase archive, or states that do not exist.
    pub fn open(bytes: &'a [u8]) -> Result<Self, ArchiveError> {
        let archive = Archive::open(bytes, ArchiveKind::Phase)?;
        let phase = Self {
            archive,
            strings: archive.strings(section::STRINGS)?,
            head: archive.record(section::HEAD)?,
            planned: archive.section(section::PLANNED)?,
            effective: archive.section(section::EFFECTIVE)?,
            spaces: archive.section(section::SPACES)?,
        };
        let states = phase.planned.iter().chain(phase.effective);
        let texts = phase.spaces.iter().map(|s| s.why);
        let known =
            phase.planned.len() == phase.effective.len() && states.copied().all(|s| ElementState::from_id(s).is_some());
        let whole = |t: Text| {
            phase.strings.get(t.offset as usize..(t.offset as usize).saturating_add(t.length as usize)).is_some()
        };
        if known && texts.into_iter().all(whole) && phase.spaces.iter().all(|s| s.state <= 1) {
            Ok(phase)
        } else {
            Err(ArchiveError::Index { what: "a state" })
        }
    }

    /// Hash of the content.
    pub fn content_hash(&self) -> u64 {
        self.archive.content_hash()
    }

    /// State of an element of the site, as planned or as observed, whichever counts.
    pub fn effective(&self, element: usize) -> ElementState {
        ElementState::from_id(self.effective[element]).unwrap_or(ElementState::Built)
    }

    /// State of an element of the site by the plan alone.
    pub fn planned(&self, element: usize) -> ElementState {
        ElementState::from_id(self.planned[element]).unwrap_or(ElementState::Built)
    }

    /// Number of elements.
    pub fn n_elements(&self) -> usize {
        self.effective.len()
    }

    /// True if a robot must not enter the space.
    pub fn is_blocked(&self, space: usize) -> bool {
        self.spaces[space].state == SpaceState::Blocked as u32
    }

    /// Why a space is blocked; empty if it is open.
    pub fn why(&self, space: usize) -> impl Iterator<Item = &'a str> {
        let why = self.spaces[space].why;
        self.strings[why.offset as usize..][..why.length as usize].split('\n').filter(|w| !w.is_empty())
    }
}

/// Records of a `phase` archive to be.
#[derive(Debug)]
pub struct PhaseBuilder {
    /// Texts.
    pub texts: TextPool,
    /// Facts of the phase.
    pub head: PhaseHead,
    planned: Vec<u8>,
    effective: Vec<u8>,
    spaces: Vec<SpaceStateRecord>,
}

impl PhaseBuilder {
    /// The phase in which every element stands and every space is open.
    pub fn everything_built(site_hash: u64, n_elements: usize, n_spaces: usize) -> Self {
        let none = PhaseHead::NO_TIME;
        Self {
            texts: TextPool::default(),
            head: PhaseHead { site_hash, plan_time_s: none, valid_from_s: none, valid_until_s: none },
            planned: vec![ElementState::Built as u8; n_elements],
            effective: vec![ElementState::Built as u8; n_elements],
            spaces: vec![Zeroable::zeroed(); n_spaces],
        }
    }

    /// Sets what is planned for an element and what counts.
    pub fn set_element(&mut self, element: usize, planned: ElementState, effective: ElementState) {
        self.planned[element] = planned as u8;
        self.effective[element] = effective as u8;
    }

    /// Blocks a space for these reasons.
    pub fn block_space(&mut self, space: usize, why: &[&str]) {
        let why = self.texts.add(&why.join("\n"));
        self.spaces[space] = SpaceStateRecord { state: SpaceState::Blocked as u32, reserved: 0, why };
    }

    /// Writes the archive into the heap.
    pub fn finish(&self) -> ArchiveBuffer {
        let mut list = SectionList::default();
        list.add(section::HEAD, std::slice::from_ref(&self.head));
        list.add(section::PLANNED, &self.planned);
        list.add(section::EFFECTIVE, &self.effective);
        list.add(section::SPACES, &self.spaces);
        list.add(section::STRINGS, self.texts.bytes());
        let mut buffer = ArchiveBuffer::zeroed(list.len());
        list.write(buffer.bytes_mut(), ArchiveKind::Phase);
        buffer
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn states_and_reasons_come_back() {
        let mut builder = PhaseBuilder::everything_built(7, 2, 2);
        builder.set_element(1, ElementState::Built, ElementState::InProgress);
        builder.block_space(0, &["task:abc", "private"]);
        let buffer = builder.finish();
        let phase = Phase::open(buffer.bytes()).unwrap();
        assert_eq!((phase.planned(1), phase.effective(1)), (ElementState::Built, ElementState::InProgress));
        assert_eq!(phase.why(0).collect::<Vec<_>>(), ["task:abc", "private"]);
        assert!(phase.is_blocked(0) && !phase.is_blocked(1) && phase.why(1).next().is_none());
        assert_eq!(phase.head.plan_time(), None);
    }
}
