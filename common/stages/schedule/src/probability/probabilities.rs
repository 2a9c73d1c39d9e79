//! Dates of all tasks in many runs, with the timeline that they vary.

use super::element_groups::ElementGroups;
use super::samples::Samples;
use super::uncertainty::Uncertainty;
use crate::timeline::Timeline;

/// Dates of all tasks in many runs, and what they make of elements and spaces.
pub struct Probabilities<'t> {
    pub(super) timeline: &'t Timeline,
    pub(super) uncertainty: Uncertainty,
    pub(super) samples: Samples,
    pub(super) groups: ElementGroups,
}

impl<'t> Probabilities<'t> {
    /// The runs of a timeline.
    pub(crate) fn of(timeline: &'t Timeline, uncertainty: Uncertainty, samples: Samples) -> Self {
        Self { timeline, uncertainty, samples, groups: ElementGroups::of(timeline) }
    }

    /// The rules that they were worked out by.
    pub fn uncertainty(&self) -> &Uncertainty {
        &self.uncertainty
    }
}
