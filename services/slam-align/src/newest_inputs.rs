//! Identities of the newest samples: known also while the worker has them, and after their generation of the bus.

use messages::{ContentHash, InputHashes};
use site_view::SiteSamples;

/// What a job works on.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct JobInputs {
    pub(crate) hashes: InputHashes,
    pub(crate) plan_time_s: i64,
    pub(crate) frame_epoch: u64,
}

impl JobInputs {
    /// `None` unless site, schedule state and index of grids belong together.
    pub(crate) fn of(samples: &SiteSamples) -> Option<Self> {
        let state = samples.state()?;
        let robot = samples.index_of(state.site)?.bytes().header().inputs.robot;
        let (site, schedule_state) = (state.site.content_hash(), state.state.content_hash());
        Some(Self {
            hashes: InputHashes { site, schedule_state, robot, ..InputHashes::default() },
            plan_time_s: state.state.view().head.plan_time_s,
            frame_epoch: state.site.bytes().header().frame_epoch,
        })
    }
}

/// The newest site.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct NewestSite {
    pub(crate) hash: ContentHash,
    pub(crate) frame_epoch: u64,
    pub(crate) n_storeys: usize,
}

/// The newest samples by their hashes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct NewestInputs {
    pub(crate) site: Option<NewestSite>,
    /// Hash of the site of the schedule state, and of itself.
    pub(crate) schedule_state: Option<[ContentHash; 2]>,
    /// Hash of the site of the index, and of the robot.
    pub(crate) index: Option<[ContentHash; 2]>,
}

impl NewestInputs {
    /// Why nothing can be searched or compared yet; `None` if the newest samples belong together.
    pub(crate) fn why_incomplete(&self) -> Option<&'static str> {
        let Some(site) = self.site else {
            return Some("there are no maps of the site yet: see groundplan status");
        };
        let is_of_site = |hashes: Option<[ContentHash; 2]>| hashes.is_some_and(|[of_site, _]| of_site == site.hash);
        if !is_of_site(self.schedule_state) {
            return Some("the site has no schedule state yet: try again in a moment, or see groundplan status");
        }
        let is_complete = is_of_site(self.index);
        (!is_complete).then_some("the newest site has no maps yet: try again in a moment, or see groundplan status")
    }

    /// True if what was made from these inputs is worth taking: site, robot and map frame are still the same. The schedule
    /// state may be an earlier one; while the plan time moves, a search would never end otherwise.
    pub(crate) fn are_still(&self, inputs: &JobInputs) -> bool {
        self.site.is_some_and(|site| (site.hash, site.frame_epoch) == (inputs.hashes.site, inputs.frame_epoch))
            && self.index.is_none_or(|[site, robot]| site != inputs.hashes.site || robot == inputs.hashes.robot)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn inputs(site: u64, robot: u64, frame_epoch: u64) -> JobInputs {
        let [site, robot, schedule_state] = [site, robot, 5].map(ContentHash::from_bits);
        let hashes = InputHashes { site, robot, schedule_state, ..InputHashes::default() };
        JobInputs { hashes, frame_epoch, ..JobInputs::default() }
    }

    fn hashes(numbers: [u64; 2]) -> Option<[ContentHash; 2]> {
        Some(numbers.map(ContentHash::from_bits))
    }

    #[test]
    fn a_result_is_taken_only_if_site_robot_and_frame_are_still_the_newest() {
        let site = NewestSite { hash: ContentHash::from_bits(1), frame_epoch: 1, n_storeys: 1 };
        let newest = NewestInputs { site: Some(site), schedule_state: hashes([1, 6]), index: hashes([1, 2]) };
        assert!(newest.why_incomplete().is_none());
        assert!(newest.are_still(&inputs(1, 2, 1)), "of an earlier schedule state");
        assert!(!newest.are_still(&inputs(9, 2, 1)), "of another site");
        assert!(!newest.are_still(&inputs(1, 3, 1)), "for another robot");
        assert!(!newest.are_still(&inputs(1, 2, 2)), "in another frame");
    }

    #[test]
    fn what_is_missing_is_told() {
        let site = NewestSite { hash: ContentHash::from_bits(1), frame_epoch: 1, n_storeys: 1 };
        let mut newest = NewestInputs::default();
        assert!(newest.why_incomplete().unwrap().contains("no maps of the site"));
        newest.site = Some(site);
        newest.schedule_state = hashes([7, 5]);
        assert!(newest.why_incomplete().unwrap().contains("no schedule state"));
        newest.schedule_state = hashes([1, 5]);
        newest.index = hashes([7, 2]);
        assert!(newest.why_incomplete().unwrap().contains("no maps yet"));
    }
}
