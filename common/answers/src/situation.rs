//! Archives of a site that belong together, at a plan time.

use crate::circumstances::Circumstances;
use export::ExportInput;
use messages::{ElementState, Grids, MapGrids, MissionPlan, ScheduleState, ScheduleStateHead, Site};
use schedule::Timeline;

/// What answers are made from.
#[derive(Clone, Copy)]
pub struct Situation<'a> {
    /// The site, with the tasks that its schedule follows.
    pub site: &'a Site<'a>,
    /// States at the plan time.
    pub schedule_state: &'a ScheduleState<'a>,
    /// Index of the grids, with robot and door passages.
    pub index: &'a Grids<'a>,
    /// The grids.
    pub grids: &'a dyn MapGrids,
    /// Mission plan of these grids.
    pub mission_plan: &'a MissionPlan<'a>,
    /// The schedule at all other times; `None` where its rules are not known.
    pub timeline: Option<&'a Timeline>,
    /// What the answer is made of.
    pub circumstances: &'a Circumstances,
}

impl Situation<'_> {
    /// The last instant of the plan time, civil seconds; `None` if everything is built.
    pub(crate) fn at_s(&self) -> Option<i64> {
        let known = |s: i64| (s != ScheduleStateHead::NO_TIME).then_some(s);
        let head = self.schedule_state.head;
        known(head.plan_until_s).map(|until_s| until_s - 1).or(known(head.plan_time_s))
    }

    /// The first later instant at which the schedule closes a room; `None` if it never does, or is not known.
    pub(crate) fn room_closes_s(&self, space: usize) -> Option<i64> {
        let (timeline, at_s) = (self.timeline?, self.at_s()?);
        let mut later = timeline.instants_s().iter().copied().filter(|instant_s| *instant_s > at_s);
        later.find(|instant_s| timeline.is_blocked(space, *instant_s))
    }

    /// The first later instant at which the schedule lets a room open; `None` if it never does, or is not known.
    pub(crate) fn room_opens_s(&self, space: usize) -> Option<i64> {
        let (timeline, at_s) = (self.timeline?, self.at_s()?);
        let mut later = timeline.instants_s().iter().copied().filter(|instant_s| *instant_s > at_s);
        later.find(|instant_s| !timeline.is_blocked(space, *instant_s))
    }

    /// The first later instant at which an element stands; `None` if it never does, or is not known.
    pub(crate) fn element_stands_s(&self, element: usize) -> Option<i64> {
        let at_s = self.at_s()?;
        let Some(timeline) = self.timeline else {
            let finish_s = self.schedule_state.schedule_of(element).finish_s;
            return Some(finish_s).filter(|finish_s| *finish_s > at_s);
        };
        let mut later = timeline.instants_s().iter().copied().filter(|instant_s| *instant_s > at_s);
        later.find(|instant_s| timeline.element(element, *instant_s) == ElementState::Built)
    }
}

impl<'a> Situation<'a> {
    /// What files for other programs are made from, for what they tell beside footprints, geometry and probabilities.
    pub fn export_input(&self) -> ExportInput<'a> {
        let Situation { site, schedule_state, index, grids, mission_plan, circumstances, .. } = *self;
        ExportInput {
            site,
            schedule_state,
            index,
            grids,
            mission_plan,
            footprints: &[],
            resolution_m: circumstances.resolution_m.unwrap_or_default(),
            with_geometry: false,
            exact_footprints: false,
            probability: None,
        }
    }
}

/// The task of a site with a GlobalId.
pub(crate) fn task_called(site: &Site<'_>, global_id: &str) -> Option<usize> {
    let schedule = &site.schedule;
    schedule.tasks.iter().position(|task| schedule.text(task.global_id) == global_id)
}
