//! The newest samples of a site, each validated once, and the set of those that belong together.
//!
//! Samples of different topics come in any order, and there is no bus inside. A set is there only while the newest
//! samples match; [`crate::ConsistentSet`] holds the last one that did, and says how long a robot may use it.

use bus::{CheckedSample, GridSlot, RawSample, TopicName, topics};
use messages::{
    ArchiveError, Checked, Grid, GridSlotRecord, Grids, InputHashes, MissionPlan, OtherSite, ScheduleState, Site,
};

/// A sample of a topic that has a part in the set.
#[derive(Debug)]
pub enum SiteSample {
    /// The site.
    Site(CheckedSample<topics::Site>),
    /// The tasks of schedule files.
    Tasks(CheckedSample<topics::Tasks>),
    /// The schedule state.
    ScheduleState(CheckedSample<topics::ScheduleState>),
    /// The grid in a slot.
    Grid(GridSlot, CheckedSample<topics::Grid>),
    /// The index of the grids.
    Index(CheckedSample<topics::Grids>),
    /// The mission plan.
    MissionPlan(CheckedSample<topics::MissionPlan>),
}

impl SiteSample {
    /// Validates a sample; `None` for a topic that has no part in the set.
    ///
    /// # Errors
    /// Bytes that are no whole archive of the topic.
    pub fn check(sample: RawSample) -> Result<Option<Self>, ArchiveError> {
        // The name is that of the topic, so that every sample is one of it.
        Ok(match sample.topic() {
            TopicName::Site => sample.of(topics::Site).map(|s| s.check().map(Self::Site)).transpose()?,
            TopicName::Tasks => sample.of(topics::Tasks).map(|s| s.check().map(Self::Tasks)).transpose()?,
            TopicName::ScheduleState => {
                sample.of(topics::ScheduleState).map(|s| s.check().map(Self::ScheduleState)).transpose()?
            }
            TopicName::Grid(slot) => {
                let sample = sample.of(topics::Grid(slot));
                sample.map(|s| s.check().map(|grid| Self::Grid(slot, grid))).transpose()?
            }
            TopicName::Grids => sample.of(topics::Grids).map(|s| s.check().map(Self::Index)).transpose()?,
            TopicName::MissionPlan => {
                sample.of(topics::MissionPlan).map(|s| s.check().map(Self::MissionPlan)).transpose()?
            }
            TopicName::Candidate | TopicName::SlamMap | TopicName::Alignment | TopicName::Deviations => None,
        })
    }
}

/// The newest sample of each topic that has a part in the set. An older one is released as soon as the next is
/// inserted.
#[derive(Debug, Default)]
pub struct SiteSamples {
    site: Option<CheckedSample<topics::Site>>,
    tasks: Option<CheckedSample<topics::Tasks>>,
    state: Option<CheckedSample<topics::ScheduleState>>,
    /// By slot.
    grids: Vec<Option<CheckedSample<topics::Grid>>>,
    index: Option<CheckedSample<topics::Grids>>,
    mission_plan: Option<CheckedSample<topics::MissionPlan>>,
}

/// Site and schedule state that belong together.
#[derive(Debug, Clone, Copy)]
pub struct SiteState<'a> {
    /// The site.
    pub site: &'a CheckedSample<topics::Site>,
    /// The states of its elements and spaces.
    pub state: &'a CheckedSample<topics::ScheduleState>,
}

/// Site, schedule state, grids with their index, and mission plan that belong together.
#[derive(Debug, Clone)]
pub struct SiteSet<'a> {
    /// The site.
    pub site: &'a CheckedSample<topics::Site>,
    /// The tasks of schedule files that the state follows, where the topic is followed and they have come.
    pub tasks: Option<&'a CheckedSample<topics::Tasks>>,
    /// The states of its elements and spaces.
    pub state: &'a CheckedSample<topics::ScheduleState>,
    /// The index of the grids.
    pub index: &'a CheckedSample<topics::Grids>,
    /// The grids that the index names, in its order.
    pub grids: Vec<&'a CheckedSample<topics::Grid>>,
    /// The mission plan, if it is made from these grids.
    pub mission_plan: Option<&'a CheckedSample<topics::MissionPlan>>,
}

/// Views of a set: every index of one archive into another is within bounds.
#[derive(Debug, Clone)]
pub struct SiteViews<'a> {
    /// The site, with the tasks of schedule files if they are in the set.
    pub site: Site<'a>,
    /// The schedule state.
    pub state: ScheduleState<'a>,
    /// The index of the grids.
    pub index: Grids<'a>,
    /// The grids that the index names, in its order.
    pub grids: Vec<Grid<'a>>,
    /// The mission plan, if it is made from these grids.
    pub mission_plan: Option<MissionPlan<'a>>,
}

impl SiteSamples {
    /// Inserts a sample.
    pub fn insert(&mut self, sample: SiteSample) {
        match sample {
            SiteSample::Site(sample) => self.site = Some(sample),
            SiteSample::Tasks(sample) => self.tasks = Some(sample),
            SiteSample::ScheduleState(sample) => self.state = Some(sample),
            SiteSample::Grid(slot, sample) => {
                if self.grids.len() <= slot.index() {
                    self.grids.resize_with(slot.index() + 1, || None);
                }
                self.grids[slot.index()] = Some(sample);
            }
            SiteSample::Index(sample) => self.index = Some(sample),
            SiteSample::MissionPlan(sample) => self.mission_plan = Some(sample),
        }
    }

    /// Gives up the grids from this slot on: there are no more storeys.
    pub fn truncate_grids(&mut self, n_storeys: usize) {
        self.grids.truncate(n_storeys);
    }

    /// Takes earlier samples for topics without a newer one.
    pub fn take_back(&mut self, earlier: Self) {
        self.site = self.site.take().or(earlier.site);
        self.tasks = self.tasks.take().or(earlier.tasks);
        self.state = self.state.take().or(earlier.state);
        self.index = self.index.take().or(earlier.index);
        self.mission_plan = self.mission_plan.take().or(earlier.mission_plan);
        if self.grids.len() < earlier.grids.len() {
            self.grids.resize_with(earlier.grids.len(), || None);
        }
        for (grid, earlier) in self.grids.iter_mut().zip(earlier.grids) {
            *grid = grid.take().or(earlier);
        }
    }

    /// The newest site.
    pub fn site(&self) -> Option<&CheckedSample<topics::Site>> {
        self.site.as_ref()
    }

    /// The newest grid of a slot, also if the index does not name it.
    pub fn grid(&self, slot: GridSlot) -> Option<&CheckedSample<topics::Grid>> {
        self.grids.get(slot.index())?.as_ref()
    }

    /// The newest index of grids.
    pub fn index(&self) -> Option<&CheckedSample<topics::Grids>> {
        self.index.as_ref()
    }

    /// The newest mission plan, of any grids.
    pub fn mission_plan(&self) -> Option<&CheckedSample<topics::MissionPlan>> {
        self.mission_plan.as_ref()
    }

    /// The newest mission plan, if it is made from the grids that the newest index names.
    pub fn mission_plan_of_index(&self) -> Option<&CheckedSample<topics::MissionPlan>> {
        let index = self.index.as_ref()?;
        self.mission_plan
            .as_ref()
            .filter(|mission_plan| mission_plan.bytes().header().inputs.grids == index.content_hash())
    }

    /// The newest site and the newest schedule state, if they belong together; if not, the one that is missing is on its
    /// way.
    pub fn state(&self) -> Option<SiteState<'_>> {
        let (site, state) = (self.site.as_ref()?, self.state.as_ref()?);
        (state.view().head.site_hash == site.content_hash()).then_some(SiteState { site, state })
    }

    /// The newest index of grids, if it is of this site, with any schedule state: it names the robot.
    pub fn index_of(&self, site: &CheckedSample<topics::Site>) -> Option<&CheckedSample<topics::Grids>> {
        self.index.as_ref().filter(|index| index.view().head.site_hash == site.content_hash())
    }

    /// The newest samples, if they belong together: the index names site, state and every grid; if not, those that are
    /// missing are on their way.
    pub fn set(&self) -> Option<SiteSet<'_>> {
        let (site, state, index) = (self.site.as_ref()?, self.state.as_ref()?, self.index.as_ref()?);
        let named = index.view();
        let is_of_state =
            named.head.site_hash == site.content_hash() && named.head.schedule_state_hash == state.content_hash();
        let named_grid = |(place, slot): (usize, &GridSlotRecord)| {
            self.grids.get(place)?.as_ref().filter(|grid| grid.content_hash() == slot.content_hash)
        };
        let grids = named.slots.iter().enumerate().map(named_grid).collect::<Option<Vec<_>>>()?;
        let tasks = self.tasks.as_ref().filter(|tasks| tasks.content_hash() == state.view().head.tasks_hash);
        is_of_state.then_some(SiteSet { site, tasks, state, index, grids, mission_plan: self.mission_plan_of_index() })
    }
}

impl<'a> SiteState<'a> {
    /// True if a sample with these inputs was made from this site and state.
    pub fn made(&self, inputs: &InputHashes) -> bool {
        inputs.site == self.site.content_hash() && inputs.schedule_state == self.state.content_hash()
    }

    /// Views of both.
    ///
    /// # Errors
    /// A state with other elements or spaces than the site has.
    pub fn views(&self) -> Result<(Site<'a>, ScheduleState<'a>), OtherSite> {
        let (site, state) = (self.site.view(), self.state.view());
        state.check_site(&site)?;
        Ok((site, state))
    }
}

impl<'a> SiteSet<'a> {
    /// True if the tasks that the schedule state follows are in the set, or are those of the site itself.
    pub fn has_tasks(&self) -> bool {
        self.tasks.is_some() || self.state.view().head.tasks_hash.is_none()
    }

    /// Views of all archives.
    ///
    /// # Errors
    /// An archive that names what the site does not have.
    pub fn views(&self) -> Result<SiteViews<'a>, OtherSite> {
        let (site, state, index) = (self.site.view(), self.state.view(), self.index.view());
        let site = self.tasks.map_or(Ok(site), |tasks| site.with_tasks(&tasks.view()))?;
        state.check_site(&site)?;
        index.check_site(&site)?;
        let grids: Vec<Grid<'a>> = self.grids.iter().map(|grid| grid.view()).collect();
        grids.iter().try_for_each(|grid| grid.check_site(&site))?;
        let mission_plan = self.mission_plan.map(Checked::view);
        mission_plan.iter().try_for_each(|mission_plan| mission_plan.check_site(&site))?;
        Ok(SiteViews { site, state, index, grids, mission_plan })
    }
}
