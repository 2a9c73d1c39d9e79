//! Answers of maps that are drawn for them, and the change of an answer at later dates.

use crate::draw_error::DrawError;
use crate::kept_rasterizer::KeptRasterizer;
use crate::later::LaterMaps;
use crate::maps::{MapInputs, Maps, with_maps};
use crate::progress::DrawingProgress;
use crate::question::{Answer, Question};
use answers::{AnswerBasis, Circumstances, Later, Situation};
use daemon::Robot;
use messages::{ScheduleState, ScheduleStateBuilder, Site};
use schedule::{Period, Timeline};
use site_view::SiteViews;
use waypoints::MissionPlanOptions;

/// What answers are drawn from.
#[derive(Clone, Copy)]
pub struct Drawing<'a> {
    /// The site, with the tasks of its schedule.
    pub site: &'a Site<'a>,
    /// Its schedule, where that is known.
    pub timeline: Option<&'a Timeline>,
    /// For which robot.
    pub robot: &'a Robot,
    /// Metres per cell.
    pub resolution_m: f64,
    /// What is planned.
    pub options: &'a MissionPlanOptions,
    /// Of what answers are.
    pub basis: AnswerBasis,
    /// Why it is not looked for when an answer changes; `None` if it is.
    pub only_now: Option<&'a str>,
    /// Takes what is done.
    pub progress: &'a dyn DrawingProgress,
}

impl Drawing<'_> {
    /// The answer over a period, or with everything built.
    ///
    /// # Errors
    /// Maps that cannot be drawn.
    pub fn answer<Q: Question>(
        &self,
        question: &Q,
        found: &Q::Found,
        period: Option<Period>,
        kept: &mut KeptRasterizer,
    ) -> Result<Q::Answer, DrawError> {
        let Self { site, timeline, robot, progress, .. } = *self;
        let schedule_state = match (timeline, period) {
            (Some(timeline), Some(period)) => timeline.schedule_state(period).finish(),
            (Some(timeline), None) => timeline.everything_built().finish(),
            (None, _) => {
                let (elements, spaces) = (site.elements.len(), site.spaces.len());
                ScheduleStateBuilder::everything_built(site.content_hash(), elements, spaces).finish()
            }
        };
        let schedule_state = ScheduleState::open(schedule_state.bytes())?;
        progress.stage("slicing");
        let rasterizer = kept.of(site, &robot.profile, self.resolution_m)?;
        let circumstances = self.circumstances(&schedule_state);
        let options = question.options(site, found, self.options.clone());
        let inputs = MapInputs { site, schedule_state: &schedule_state, robot, options: &options, progress };
        let mut answer: Q::Answer = with_maps(&inputs, rasterizer, |maps| {
            let situation = self.situation(&schedule_state, maps, &circumstances);
            Ok::<_, DrawError>(question.answer(&situation, found))
        })?;
        if answer.wants_later() {
            let after_s = period.map(|period| period.until_s.map_or(period.from_s, |until_s| until_s - 1));
            let why_no_date = "everything is built, because no date is given";
            let changes = self.changes(question, found, (after_s.ok_or(why_no_date), &answer), &circumstances, kept)?;
            answer.set_changes(changes);
        }
        Ok(answer)
    }

    /// When an answer after an instant changes, or why nobody looks.
    ///
    /// # Errors
    /// Maps that cannot be drawn.
    pub fn changes<Q: Question>(
        &self,
        question: &Q,
        found: &Q::Found,
        (after_s, answer): (Result<i64, &str>, &Q::Answer),
        circumstances: &Circumstances,
        kept: &mut KeptRasterizer,
    ) -> Result<Later, DrawError> {
        let Self { site, robot, options, progress, .. } = *self;
        match (self.timeline, after_s, self.only_now) {
            (_, Err(why), _) | (_, _, Some(why)) => Ok(Later::not_searched(why)),
            (None, ..) => Ok(Later::not_searched("the schedule is not known")),
            (Some(timeline), Ok(after_s), None) => {
                let rasterizer = kept.of(site, &robot.profile, self.resolution_m)?;
                let later = LaterMaps { site, timeline, robot, options, circumstances, progress };
                later.first_change(rasterizer, question, found, (after_s, answer.verdict()))
            }
        }
    }

    /// The circumstances of maps that are drawn of a schedule state.
    pub fn circumstances(&self, schedule_state: &ScheduleState<'_>) -> Circumstances {
        let robot = (self.robot.name.as_str(), &self.robot.profile);
        Circumstances::of_maps(self.basis, self.site, schedule_state, robot, Some(self.resolution_m))
    }

    fn situation<'s>(
        &'s self,
        schedule_state: &'s ScheduleState<'s>,
        maps: &'s Maps<'s>,
        circumstances: &'s Circumstances,
    ) -> Situation<'s> {
        Situation {
            site: self.site,
            schedule_state,
            index: maps.index,
            grids: maps.grids,
            mission_plan: maps.mission_plan,
            timeline: self.timeline,
            circumstances,
        }
    }
}

/// The situation of the maps that a running site publishes; `None` while there is no mission plan of them.
pub fn situation_of<'s>(
    views: &'s SiteViews<'s>,
    timeline: Option<&'s Timeline>,
    circumstances: &'s Circumstances,
) -> Option<Situation<'s>> {
    let SiteViews { site, state, index, grids, mission_plan } = views;
    let mission_plan = mission_plan.as_ref()?;
    Some(Situation { site, schedule_state: state, index, grids, mission_plan, timeline, circumstances })
}
