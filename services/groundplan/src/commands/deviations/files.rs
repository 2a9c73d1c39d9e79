//! Comparing models with a map in files.

use super::args::Args;
use super::report::write;
use crate::alignment_report;
use crate::args::{ModelArgs, ScheduleInput, robot_of_profile, with_timeline};
use crate::date_argument;
use crate::failure::Failure;
use ::deviations::{DeviationInput, deviations};
use alignment::{AlignmentSources, PreparedMap, References, SitePlaces, align_maps_within};
use messages::{Alignment, AlignmentVerdict, Deviations, ScheduleState};
use occupancy::OccupancyMap;
use std::path::Path;

/// Compares the models with a map of the robot.
///
/// # Errors
/// Models or maps that cannot be read, a map whose pose is not accepted, a folder that cannot be written.
pub(super) fn compare(arguments: &Args, slam: &Path) -> Result<String, Failure> {
    let robot = robot_of_profile(arguments.robot.as_deref())?;
    let schedule = ScheduleInput::read(&arguments.schedule)?;
    let instant_s = |text| date_argument::instant_s(text, schedule.site_zone());
    let at_s = arguments.date.as_deref().map(instant_s).transpose()?;
    let map = OccupancyMap::read(slam).map_err(Failure::usage)?;
    let model = ModelArgs::new(arguments.models.clone(), arguments.allow_boxes);
    with_timeline(&model, &schedule, |site, timeline, progress| {
        let schedule_state = timeline.schedule_state_at(at_s).finish();
        let schedule_state = ScheduleState::open(schedule_state.bytes()).map_err(Failure::work)?;
        progress.stage("aligning");
        let mut references = References::new(site, &robot.profile).map_err(Failure::work)?;
        let mut maps: Vec<_> = references.at(site, &schedule_state).map_err(Failure::work)?.enumerate().collect();
        maps.retain(|(storey, _)| arguments.place.storey.is_none_or(|only| only as usize == *storey));
        let storeys: Vec<u32> = maps.iter().map(|(storey, _)| *storey as u32).collect();
        let maps: Vec<_> = maps.into_iter().map(|(_, map)| map).collect();
        let slam_map = PreparedMap::of_slam(&map);
        let (places, known) = (SitePlaces::of(site), arguments.place.known_places()?);
        let hints = places.hints(known.points_in_rooms(), known.elevation_m, known.portal.as_deref());
        let (hint, hints) = (arguments.place.hint(), hints.map_err(Failure::usage)?);
        let mut found = align_maps_within(&maps, &storeys, &slam_map, hint.as_ref(), &hints);
        found.decide(&maps, &slam_map, &storeys, &places.rooms);
        let plan_time_s = schedule_state.head.plan_time_s;
        let sources = AlignmentSources { site_hash: 0, slam_map_hash: 0, searched_map_hash: 0, plan_time_s };
        let archive = found.archive(&storeys, &found.pose_status(&storeys), sources);
        let Some(pose) = found.poses.first().filter(|_| found.verdict == AlignmentVerdict::Accepted) else {
            let alignment = Alignment::open(archive.bytes()).map_err(Failure::work)?;
            return Err(Failure::work(format!(
                "where the map lies is {}",
                alignment_report::text(&alignment).trim_end()
            )));
        };
        progress.stage("comparing");
        let slam_map_hash = map.content_hash().map_err(Failure::work)?;
        let found = deviations(&DeviationInput {
            site,
            schedule_state: &schedule_state,
            robot: &robot.profile,
            map_storey: storeys[pose.reference] as usize,
            slam: &map,
            slam_map_hash,
            map_from_slam: pose.map_from_slam,
            about_m: pose.about_m,
            covariance: pose.covariance,
        });
        let found = Deviations::open(found.bytes()).map_err(Failure::work)?;
        write(arguments, site, &schedule_state, &found)
    })
}
