//! Answers of the running daemons: of the maps that they publish, or of another date of their schedule.

use super::args::QuestionArgs;
use super::asked::{Answer, Question, outcome_of};
use super::later::LaterMaps;
use super::models::Drawing;
use crate::date_argument;
use crate::failure::Failure;
use crate::progress_line::ProgressLine;
use crate::run::Outcome;
use crate::wait::{Expectation, join};
use answers::{AnswerBasis, Circumstances, Epochs, Later, MapUse, Situation};
use bus::{Daemon, Stamp};
use daemon::{Robot, SiteConfig, StatusBoard, chain};
use jiff::Timestamp;
use messages::{EdgeKind, MissionPlan, Site, StoreyEntry};
use raster::Rasterizer;
use site_schedule::schedule_in_force;
use site_view::{Freshness, MapsInUse, SiteSet, SiteSetReader, SiteViews};
use std::time::Duration;
use waypoints::MissionPlanOptions;

const POLL_INTERVAL: Duration = Duration::from_millis(50);

/// Asks the running daemons.
///
/// # Errors
/// No daemons, maps that the daemons do not make, with the reason; names that stand for nothing; a date whose schedule is not known.
pub(super) fn answer<Q: Question>(arguments: &QuestionArgs, question: &Q) -> Result<Outcome, Failure> {
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
    let start = start_is_known(question, given.is_some(), mission_plan);
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
        only_now,
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
            drawing.answer(question, &found, Some(period))?
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
    let SiteViews { site, state, index, grids, mission_plan } = views;
    let mission_plan = mission_plan.as_ref().ok_or_else(|| Failure::work("there are no maps yet"))?;
    let head = state.head;
    let epoch = |header: &messages::SampleHeader| header.epoch;
    let epochs = Epochs {
        site: epoch(set.site.bytes().header()),
        schedule_state: epoch(set.state.bytes().header()),
        grids: epoch(set.index.bytes().header()),
        mission_plan: set.mission_plan.map_or(0, |sample| epoch(sample.bytes().header())),
    };
    let resolution_m = Some(drawing.resolution_m);
    let circumstances = Circumstances::of_running(site, state, index, resolution_m, (epochs, map_use(set, config)?));
    let situation = Situation {
        site,
        schedule_state: state,
        index,
        grids,
        mission_plan,
        timeline: drawing.timeline,
        circumstances: &circumstances,
    };
    let mut answer = question.answer(&situation, found);
    if answer.wants_later() {
        let changes = match (drawing.timeline, head.plan_time(), &drawing.only_now) {
            (_, _, Some(why)) => Later::not_searched(why.clone()),
            (None, ..) => Later::not_searched("the schedule is not known"),
            (_, None, _) => Later::not_searched("everything is built, because the site has no plan time"),
            (Some(timeline), Some(at), None) => {
                let profile = &drawing.robot.profile;
                let mut rasterizer = Rasterizer::new(site, profile, drawing.resolution_m).map_err(Failure::work)?;
                let Drawing { robot, options, progress, .. } = *drawing;
                let later = LaterMaps { site, timeline, robot, options, circumstances: &circumstances, progress };
                later.first_change(&mut rasterizer, question, found, (at.civil_seconds(), answer.verdict()))?
            }
        };
        answer.set_changes(changes);
    }
    Ok(answer)
}

/// Whether the maps of a set may be used now: the rule of all readers of maps, with what the daemons last said of themselves.
fn map_use(set: &SiteSet<'_>, config: &SiteConfig) -> Result<MapUse, Failure> {
    let board = StatusBoard::of_site(config).map_err(Failure::work)?;
    let now = Stamp::now();
    let index = set.index.view();
    let mut freshness = Freshness::default();
    freshness.joined(Stamp(0));
    daemon::hear_daemons(&board, &mut freshness);
    freshness.on_schedule_state(now, set.state.content_hash(), set.state.view().head);
    freshness.on_index(now, index.head, index.slots.to_vec());
    freshness.on_maps(MapsInUse {
        epoch: set.index.bytes().header().epoch,
        site_hash: set.site.content_hash(),
        grids: index.slots.to_vec(),
    });
    Ok(MapUse::of(freshness.state(now, Timestamp::now().as_millisecond()).why_not()))
}

/// The options of a mission plan that say what it says: the lifts that the robot takes, and how it drives.
fn options_of(site: &Site<'_>, mission_plan: &MissionPlan<'_>) -> MissionPlanOptions {
    let lifts = mission_plan.edges.iter().filter(|edge| edge.kind == EdgeKind::Lift && edge.usable == 1);
    let lifts = lifts.map(|edge| site.text(site.elements[edge.of as usize].global_id).to_owned()).collect();
    MissionPlanOptions { lifts, drive: mission_plan.head.drive, ..MissionPlanOptions::default() }
}

/// Whether it is known where the robot starts, if that matters.
fn start_is_known(question: &impl Question, has_options: bool, mission_plan: &MissionPlan<'_>) -> Result<(), String> {
    let has_start = mission_plan.storeys.iter().any(|storey| storey.entry == StoreyEntry::Start);
    if question.depends_on_start() && has_start && !has_options {
        return Err(
            "the robot has a start, which maps of other dates need: give the options of waypoints with --waypoints"
                .to_owned(),
        );
    }
    Ok(())
}
