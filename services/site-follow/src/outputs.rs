//! The topics of a site as its drawing daemons have them, published from archives of its server.

use crate::file_folder::FileFolder;
use bus::{Bus, GridSlot, topics};
use daemon::facts::{RasterizeFacts, WaypointFacts};
use daemon::{Decide, Epochs, Failure, LatchedOutput, NewSample, OutputEnd, Outputs, Published};
use frames::metres;
use messages::{Checked, ContentHash, plan_time};
use replica::RobotFiles;
use std::sync::Arc;

/// What is published.
pub enum FollowSample {
    /// The site.
    Site(NewSample<topics::Site>),
    /// The tasks of schedule files; `None` where there are none any more.
    Tasks(Option<NewSample<topics::Tasks>>),
    /// The schedule state.
    State(NewSample<topics::ScheduleState>),
    /// A grid.
    Grid(GridSlot, NewSample<topics::Grid>),
    /// The index of so many grids.
    Index(NewSample<topics::Grids>, usize),
    /// The mission plan.
    MissionPlan(NewSample<topics::MissionPlan>),
    /// Before all others: exported files that are not these are not shown any more.
    Files(Arc<FileFolder>, Option<RobotFiles>),
}

/// The ends of the topics.
pub struct FollowOutputs {
    site: LatchedOutput<topics::Site>,
    tasks: LatchedOutput<topics::Tasks>,
    state: LatchedOutput<topics::ScheduleState>,
    grids: Vec<LatchedOutput<topics::Grid>>,
    index: LatchedOutput<topics::Grids>,
    mission_plan: LatchedOutput<topics::MissionPlan>,
    bus: Option<Bus>,
    /// What goes once the decision that is underway is settled.
    leaving: Leaving,
}

/// Topics that nothing is published on any more.
#[derive(Debug, Default)]
struct Leaving {
    tasks: bool,
    /// Grids from this slot on.
    grids_from: Option<usize>,
}

impl Default for FollowOutputs {
    fn default() -> Self {
        Self {
            site: LatchedOutput::new(topics::Site),
            tasks: LatchedOutput::new(topics::Tasks),
            state: LatchedOutput::new(topics::ScheduleState),
            grids: Vec::new(),
            index: LatchedOutput::new(topics::Grids),
            mission_plan: LatchedOutput::new(topics::MissionPlan),
            bus: None,
            leaving: Leaving::default(),
        }
    }
}

impl FollowOutputs {
    /// The schedule state that is published.
    pub(crate) fn state(&self) -> Published {
        self.state.published()
    }

    /// What is told of the maps.
    pub(crate) fn maps(&self) -> RasterizeFacts {
        let Some(index) = self.index.last().map(Checked::view) else { return RasterizeFacts::default() };
        let cell_tenths = index.slots.first().map_or(0, |slot| slot.cell_tenths);
        RasterizeFacts {
            grids: self.index.published(),
            plan_time_s: plan_time(index.head.plan_time_s).map(|at| at.civil_seconds()),
            site_hash: index.head.site_hash,
            site_epoch: self.site.epoch(),
            state_epoch: self.state.epoch(),
            state_hash: index.head.schedule_state_hash,
            storeys: index.slots.len(),
            robot: index.robot_name.to_owned(),
            resolution_m: metres(cell_tenths),
            settings: Vec::new(),
        }
    }

    /// What is told of the mission plan.
    pub(crate) fn mission_plan(&self) -> WaypointFacts {
        let Some(plan) = self.mission_plan.last().map(Checked::view) else { return WaypointFacts::default() };
        WaypointFacts {
            mission_plan: self.mission_plan.published(),
            grids_hash: self.mission_plan.inputs().grids,
            waypoints: plan.waypoints.len(),
            scans: plan.storeys.iter().map(|storey| storey.n_scans).sum(),
            settings: Vec::new(),
        }
    }

    /// Content hash of the site that is published.
    pub(crate) fn site(&self) -> ContentHash {
        self.site.published().content_hash
    }

    /// The output of a slot, which is opened if it is the first sample there.
    fn grid(&mut self, slot: GridSlot, epochs: &mut Epochs) -> Result<&mut LatchedOutput<topics::Grid>, Failure> {
        while self.grids.len() <= slot.index() {
            let next = GridSlot::new(self.grids.len()).ok_or("there are more storeys than slots")?;
            let mut output = LatchedOutput::new(topics::Grid(next));
            if let Some(bus) = &self.bus {
                output.attach(bus, epochs)?;
            }
            self.grids.push(output);
        }
        Ok(&mut self.grids[slot.index()])
    }
}

impl<D: Decide> Outputs<D> for FollowOutputs {
    type Publication = FollowSample;

    fn ends(&mut self) -> Vec<&mut dyn OutputEnd> {
        let before: [&mut dyn OutputEnd; 3] = [&mut self.site, &mut self.tasks, &mut self.state];
        let grids = self.grids.iter_mut().map(|grid| grid as &mut dyn OutputEnd);
        let after: [&mut dyn OutputEnd; 2] = [&mut self.index, &mut self.mission_plan];
        before.into_iter().chain(grids).chain(after).collect()
    }

    fn attach(&mut self, bus: &Bus, epochs: &mut Epochs) -> Result<(), Failure> {
        self.bus = Some(bus.clone());
        Outputs::<D>::ends(self).into_iter().try_for_each(|end| end.attach(bus, epochs))
    }

    fn publish(&mut self, sample: FollowSample, _: &D, epochs: &mut Epochs) -> Result<(), Failure> {
        match sample {
            FollowSample::Site(site) => self.site.publish(epochs, site),
            FollowSample::Tasks(Some(tasks)) => self.tasks.publish(epochs, tasks),
            FollowSample::Tasks(None) => {
                self.leaving.tasks = true;
                Ok(())
            }
            FollowSample::State(state) => self.state.publish(epochs, state),
            FollowSample::Grid(slot, grid) => self.grid(slot, epochs)?.publish(epochs, grid),
            FollowSample::Index(index, n_grids) => {
                self.leaving.grids_from = Some(n_grids);
                self.index.publish(epochs, index)
            }
            FollowSample::MissionPlan(plan) => self.mission_plan.publish(epochs, plan),
            FollowSample::Files(folder, files) => {
                folder.withdraw_unless(files.as_ref());
                Ok(())
            }
        }
    }

    fn settle(&mut self) {
        for end in Outputs::<D>::ends(self) {
            end.settle();
        }
        // What no index names any more goes after the index that says so, and when there is no way back.
        let Leaving { tasks, grids_from } = std::mem::take(&mut self.leaving);
        if tasks {
            self.tasks.withdraw();
        }
        if let Some(n_grids) = grids_from {
            self.grids.truncate(n_grids);
        }
    }

    fn go_back(&mut self, _: &D, epochs: &mut Epochs) {
        self.leaving = Leaving::default();
        for end in Outputs::<D>::ends(self) {
            end.go_back(epochs);
        }
    }

    fn published(&self) -> Published {
        self.index.published()
    }
}
