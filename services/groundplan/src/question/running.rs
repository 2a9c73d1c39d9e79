//! Answers of the running daemons: of the maps that they publish, or of another date of their schedule.

use super::args::QuestionArgs;
use super::outcome::{AnswerText, outcome_of};
use crate::date_argument;
use crate::failure::Failure;
use crate::progress_line::ProgressLine;
use crate::run::Outcome;
use crate::wait::{Expectation, join};
use answers::AnswerBasis;
use bus::Daemon;
use daemon::{Robot, SiteConfig, chain};
use messages::MissionPlan;
use site_answers::{
    Answer, Drawing, KeptRasterizer, Question, circumstances_of, map_use, options_of, situation_of, start_is_known,
};
use site_schedule::schedule_in_force;
use site_view::{SiteSet, SiteSetReader, SiteViews};
use std::time::Duration;

const POLL_INTERVAL: Duration = Duration::from_millis(50);

/// Asks the running daemons.
///
/// # Errors
/// No daemons, maps that the daemons do not make, with the reason; names that stand for nothing; a date whose schedule is not known.
pub(super) fn answer<Q: Question<Answer: AnswerText>>(
    arguments: &QuestionArgs,
    question: &Q,
) -> Result<Outcome, Failure> {
    let config = arguments.site.config()?;
    let given = arguments.waypoint_options()?;
    let (bus, mut waiter) = join(&config)?;
    let mut reader = SiteSetReader::of(&bus).map_err(Failure::work)?;
    let mut expectation = Expectation::of(&config, Daemon::WaypointGen);
    reader.take().map_err(Failure::work)?;
    while reader.set().is_none_or(|set| set.mission_plan.is_none()) {
        expectation.check()?;
        waiter.wait(POLL_INTERVAL).map_err(Failure::work)?;
        reader.take().map_err(Failure::work)?;
    }
    let no_maps = || Failure::work("there are no maps yet");
    let set = reader.set().ok_or_else(no_maps)?;
    let views = set.views().map_err(Failure::work)?;
    let mission_plan = views.mission_plan.as_ref().ok_or_else(no_maps)?;
    let found = question.find(&views.site).map_err(Failure::usage)?;
    let schedule = schedule_in_force(&config, &views.site, &views.state);
    let progress = ProgressLine::new(false);
    let SiteViews { site, index, grids, .. } = &views;
    let robot = Robot::of_index(index);
    let resolution_m = grids.first().map_or(config.robot.resolution_m, |grid| grid.spec().resolution_m());
    let start = check_start(question, given.is_some(), mission_plan);
    let options = given.unwrap_or_else(|| options_of(site, mission_plan));
    let only_now = match (&schedule, &start) {
        _ if arguments.only_now => Some("--only-now was given".to_owned()),
        (Err(why), _) => Some(format!("the schedule in force is not known: {}", chain(why))),
        (_, Err(why)) => Some(why.clone()),
        _ => None,
    };
    let drawing = Drawing {
        site,
        timeline: schedule.as_ref().ok().map(|schedule| &schedule.timeline),
        robot: &robot,
        resolution_m,
        options: &options,
        basis: AnswerBasis::RunningSiteAtDate,
        only_now: only_now.as_deref(),
        progress: &progress,
    };
    let answer = match arguments.date.as_deref() {
        Some(date) => {
            start.map_err(Failure::usage)?;
            let site_zone = match &schedule {
                Ok(schedule) => schedule.site_zone.as_ref(),
                Err(why) => {
                    return Err(Failure::work(format!(
                        "the schedule in force is not known, so that no other date is: {}",
                        chain(why)
                    )));
                }
            };
            let period = date_argument::period(date, None, site_zone)?;
            drawing.answer(question, &found, Some(period), &mut KeptRasterizer::default()).map_err(Failure::work)?
        }
        None => published(&drawing, question, &found, &set, &views, &config)?,
    };
    drop(progress);
    outcome_of(&answer, arguments.json)
}

/// The answer of the maps that are published.
fn published<Q: Question>(
    drawing: &Drawing<'_>,
    question: &Q,
    found: &Q::Found,
    set: &SiteSet<'_>,
    views: &SiteViews<'_>,
    config: &SiteConfig,
) -> Result<Q::Answer, Failure> {
    let circumstances = circumstances_of(set, views, map_use(set, config).map_err(Failure::work)?);
    let situation = situation_of(views, drawing.timeline, &circumstances);
    let situation = situation.ok_or_else(|| Failure::work("there are no maps yet"))?;
    let mut answer = question.answer(&situation, found);
    if answer.wants_later() {
        let after_s = views.state.head.plan_time().map(|at| at.civil_seconds());
        let after_s = after_s.ok_or("everything is built, because the site has no plan time");
        let kept = &mut KeptRasterizer::default();
        let changes = drawing.changes(question, found, (after_s, &answer), &circumstances, kept);
        answer.set_changes(changes.map_err(Failure::work)?);
    }
    Ok(answer)
}

/// Whether it is known where the robot starts, if that matters.
fn check_start(question: &impl Question, has_options: bool, mission_plan: &MissionPlan<'_>) -> Result<(), String> {
    if question.depends_on_start() && !has_options && !start_is_known(mission_plan) {
        return Err(
            "the robot has a start, which maps of other dates need: give the options of waypoints with --waypoints"
                .to_owned(),
        );
    }
    Ok(())
}
