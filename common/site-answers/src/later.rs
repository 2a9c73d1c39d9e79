//! The search for the next change of an answer: maps of every later change of the schedule are drawn until it does.

use crate::draw_error::DrawError;
use crate::maps::{MapInputs, with_maps};
use crate::progress::DrawingProgress;
use crate::question::Question;
use answers::{Circumstances, Later, Situation, date_text};
use daemon::Robot;
use messages::{ScheduleState, Site};
use raster::Rasterizer;
use schedule::{Period, Timeline};
use std::collections::BTreeSet;
use waypoints::MissionPlanOptions;

/// What later maps are drawn with.
pub(crate) struct LaterMaps<'a> {
    pub(crate) site: &'a Site<'a>,
    pub(crate) timeline: &'a Timeline,
    pub(crate) robot: &'a Robot,
    pub(crate) options: &'a MissionPlanOptions,
    pub(crate) circumstances: &'a Circumstances,
    pub(crate) progress: &'a dyn DrawingProgress,
}

impl LaterMaps<'_> {
    /// The first later change after an instant at which the verdict is the opposite, or is known if it is not now.
    ///
    /// # Errors
    /// Archives that cannot be.
    pub(crate) fn first_change<Q: Question>(
        &self,
        rasterizer: &mut Rasterizer,
        question: &Q,
        found: &Q::Found,
        (after_s, verdict): (i64, Option<bool>),
    ) -> Result<Later, DrawError> {
        let instants_s = self.timeline.instants_s();
        let later = &instants_s[instants_s.partition_point(|instant_s| *instant_s <= after_s)..];
        let wanted = verdict != Some(true);
        for (k, &at_s) in later.iter().enumerate() {
            if !self.progress.step("looking ahead", k, later.len()) {
                let why =
                    format!("it stays so until {}, and the time for maps of later changes is over", date_text(at_s));
                return Ok(Later { at: None, n_changes: k, why_not_searched: Some(why) });
            }
            if self.verdict_at(rasterizer, question, found, at_s)? == Some(wanted) {
                return Ok(Later { at: Some(date_text(at_s)), n_changes: k + 1, why_not_searched: None });
            }
        }
        Ok(Later { at: None, n_changes: later.len(), why_not_searched: None })
    }

    fn verdict_at<Q: Question>(
        &self,
        rasterizer: &mut Rasterizer,
        question: &Q,
        found: &Q::Found,
        at_s: i64,
    ) -> Result<Option<bool>, DrawError> {
        let Self { site, timeline, robot, options, circumstances, progress } = *self;
        let schedule_state = timeline.schedule_state(Period::instant(at_s)).finish();
        let schedule_state = ScheduleState::open(schedule_state.bytes())?;
        // No waypoint is asked for: whether rooms are reached is looked at all the same.
        let options = MissionPlanOptions { kinds: BTreeSet::new(), flight: None, ..options.clone() };
        let inputs = MapInputs { site, schedule_state: &schedule_state, robot, options: &options, progress };
        with_maps(&inputs, rasterizer, |maps| {
            let situation = Situation {
                site,
                schedule_state: &schedule_state,
                index: maps.index,
                grids: maps.grids,
                mission_plan: maps.mission_plan,
                timeline: Some(timeline),
                circumstances,
            };
            Ok(question.verdict(&situation, found))
        })
    }
}
