//! Answers of model files at a date.

use super::args::QuestionArgs;
use super::asked::{Answer, Question, outcome_of};
use super::later::LaterMaps;
use super::output_folder;
use crate::args::ScheduleInput;
use crate::date_argument;
use crate::failure::Failure;
use crate::maps::{MapInputs, with_maps};
use crate::progress_line::ProgressLine;
use crate::run::Outcome;
use answers::{AnswerBasis, Circumstances, Later, Situation};
use daemon::Robot;
use messages::{ScheduleState, ScheduleStateBuilder, Site};
use raster::Rasterizer;
use schedule::{Period, Timeline};
use waypoints::MissionPlanOptions;

/// What an answer is drawn from.
pub(super) struct Drawing<'a> {
    pub(super) site: &'a Site<'a>,
    pub(super) timeline: Option<&'a Timeline>,
    pub(super) robot: &'a Robot,
    pub(super) resolution_m: f64,
    pub(super) options: &'a MissionPlanOptions,
    pub(super) basis: AnswerBasis,
    /// Why it is not looked for when the answer changes.
    pub(super) only_now: Option<String>,
    pub(super) progress: &'a ProgressLine,
}

/// Reads the models and answers.
///
/// # Errors
/// Bad arguments, models that cannot be read, dates that can be read in two ways, maps that cannot be drawn.
pub(super) fn answer<Q: Question>(arguments: &QuestionArgs, question: &Q) -> Result<Outcome, Failure> {
    output_folder::refuse(&arguments.models, &question.command(), arguments.date.as_deref())?;
    let robot = arguments.robot.robot()?;
    let options = arguments.waypoint_options()?.unwrap_or_default();
    let schedule = ScheduleInput::read(&arguments.schedule)?;
    let date = arguments.date.as_deref();
    if date.is_none() && arguments.schedule.changes_dates() {
        return Err(Failure::usage("--delay and --actuals change dates: say which with --date"));
    }
    let period = date.map(|date| date_argument::period(date, None, schedule.site_zone())).transpose()?;
    let progress = ProgressLine::new(false);
    let model = arguments.model();
    let pool = model.pool()?;
    pool.install(|| {
        let site = model.site(&pool, None, 1, &progress)?;
        let site = Site::open(site.bytes()).map_err(Failure::work)?;
        let tasks = schedule.linked_tasks(&site)?;
        let site = tasks.site(&site)?;
        waypoints::check_names(&site, &options).map_err(Failure::usage)?;
        let found = question.find(&site).map_err(Failure::usage)?;
        let timeline = schedule.timeline(&site);
        // Without a date, dates that cannot be used do not matter.
        let timeline = if period.is_some() { Some(timeline?) } else { timeline.ok() };
        let drawing = Drawing {
            site: &site,
            timeline: timeline.as_ref(),
            robot: &robot,
            resolution_m: arguments.robot.resolution,
            options: &options,
            basis: AnswerBasis::Models,
            only_now: arguments.only_now.then(|| "--only-now was given".to_owned()),
            progress: &progress,
        };
        let answer = drawing.answer(question, &found, period)?;
        drop(progress);
        outcome_of(&answer, arguments.json)
    })
}

impl Drawing<'_> {
    /// The answer over a period, or with everything built.
    ///
    /// # Errors
    /// Maps that cannot be drawn.
    pub(super) fn answer<Q: Question>(
        &self,
        question: &Q,
        found: &Q::Found,
        period: Option<Period>,
    ) -> Result<Q::Answer, Failure> {
        let Self { site, timeline, robot, progress, .. } = *self;
        let schedule_state = match (timeline, period) {
            (Some(timeline), Some(period)) => timeline.schedule_state(period).finish(),
            (Some(timeline), None) => timeline.everything_built().finish(),
            (None, _) => {
                let (elements, spaces) = (site.elements.len(), site.spaces.len());
                ScheduleStateBuilder::everything_built(site.content_hash(), elements, spaces).finish()
            }
        };
        let schedule_state = ScheduleState::open(schedule_state.bytes()).map_err(Failure::work)?;
        progress.stage("slicing");
        let mut rasterizer = Rasterizer::new(site, &robot.profile, self.resolution_m).map_err(Failure::work)?;
        let circumstances = Circumstances::of_maps(
            self.basis,
            site,
            &schedule_state,
            (&robot.name, &robot.profile),
            Some(self.resolution_m),
        );
        let options = question.options(site, found, self.options.clone());
        let inputs = MapInputs { site, schedule_state: &schedule_state, robot, options: &options, progress };
        let mut answer = with_maps(&inputs, &mut rasterizer, |maps| {
            let situation = Situation {
                site,
                schedule_state: &schedule_state,
                index: maps.index,
                grids: maps.grids,
                mission_plan: maps.mission_plan,
                timeline,
                circumstances: &circumstances,
            };
            Ok(question.answer(&situation, found))
        })?;
        if answer.wants_later() {
            let changes = match (timeline, period, &self.only_now) {
                (_, None, _) => Later::not_searched("everything is built, because no date is given"),
                (_, _, Some(why)) => Later::not_searched(why.clone()),
                (None, ..) => Later::not_searched("the schedule is not known"),
                (Some(timeline), Some(period), None) => {
                    let later = LaterMaps {
                        site,
                        timeline,
                        robot,
                        options: self.options,
                        circumstances: &circumstances,
                        progress,
                    };
                    let after_s = period.until_s.map_or(period.from_s, |until_s| until_s - 1);
                    later.first_change(&mut rasterizer, question, found, (after_s, answer.verdict()))?
                }
            };
            answer.set_changes(changes);
        }
        Ok(answer)
    }
}
