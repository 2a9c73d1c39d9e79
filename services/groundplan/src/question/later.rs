//! The search for the next change of an answer: maps of every later change of the schedule are drawn until it does.

use super::asked::Question;
use crate::failure::Failure;
use crate::maps::{MapInputs, with_maps};
use crate::progress_line::ProgressLine;
use answers::{Circumstances, Later, Situation, date_text};
use daemon::Robot;
use messages::{ScheduleState, Site};
use raster::Rasterizer;
use schedule::{Period, Timeline};
use std::collections::BTreeSet;
use waypoints::MissionPlanOptions;

/// What later maps are drawn with.
pub(super) struct LaterMaps<'a> {
    pub(super) site: &'a Site<'a>,
    pub(super) timeline: &'a Timeline,
    pub(super) robot: &'a Robot,
    pub(super) options: &'a MissionPlanOptions,
    pub(super) circumstances: &'a Circumstances,
    pub(super) progress: &'a ProgressLine,
}

impl LaterMaps<'_> {
    /// The first later change after an instant at which the verdict is the opposite, or is known if it is not now.
    ///
    /// # Errors
    /// Archives that cannot be.
    pub(super) fn first_change<Q: Question>(
        &self,
        rasterizer: &mut Rasterizer,
        question: &Q,
        found: &Q::Found,
        (after_s, verdict): (i64, Option<bool>),
    ) -> Result<Later, Failure> {
        let instants_s = self.timeline.instants_s();
        let later = &instants_s[instants_s.partition_point(|instant_s| *instant_s <= after_s)..];
        let wanted = verdict != Some(true);
        for (k, &at_s) in later.iter().enumerate() {
            self.progress.step("looking ahead", k, later.len());
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
    ) -> Result<Option<bool>, Failure> {
        let Self { site, timeline, robot, options, circumstances, progress } = *self;
        let schedule_state = timeline.schedule_state(Period::instant(at_s)).finish();
        let schedule_state = ScheduleState::open(schedule_state.bytes()).map_err(Failure::work)?;
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
