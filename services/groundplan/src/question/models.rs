//! Answers of model files at a date.

use super::args::QuestionArgs;
use super::outcome::{AnswerText, outcome_of};
use super::output_folder;
use crate::args::ScheduleInput;
use crate::date_argument;
use crate::failure::Failure;
use crate::progress_line::ProgressLine;
use crate::run::Outcome;
use answers::AnswerBasis;
use messages::Site;
use site_answers::{Drawing, KeptRasterizer, Question};

/// Reads the models and answers.
///
/// # Errors
/// Bad arguments, models that cannot be read, dates that can be read in two ways, maps that cannot be drawn.
pub(super) fn answer<Q: Question<Answer: AnswerText>>(
    arguments: &QuestionArgs,
    question: &Q,
    command: &[&str],
) -> Result<Outcome, Failure> {
    output_folder::refuse(&arguments.models, command, arguments.date.as_deref())?;
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
            only_now: arguments.only_now.then_some("--only-now was given"),
            progress: &progress,
        };
        let answer = drawing.answer(question, &found, period, &mut KeptRasterizer::default()).map_err(Failure::work)?;
        drop(progress);
        outcome_of(&answer, arguments.json)
    })
}
