//! Comparing models with a map in files.

use super::args::{Args, KnownPose};
use super::goals::carried;
use super::report::write;
use crate::alignment_report;
use crate::args::{ModelArgs, ScheduleInput, robot_of_profile, with_timeline};
use crate::date_argument;
use crate::failure::Failure;
use ::deviations::{DeviationInput, LocalTransform, deviations};
use alignment::{AlignmentSources, MaxUncertainty, PlaceHint, PreparedMap, References, SitePlaces, align_maps_within};
use frames::{PoseCovariance, Rigid2, Slam};
use messages::{
    Alignment, AlignmentVerdict, ContentHash, Deviations, PoseRecord, RobotProfile, ScheduleState, Site, SlamFrame,
    flat,
};
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
        let pose = match arguments.known_pose() {
            Some(known) => known_pose(&known, arguments.place.storey, site, &map)?,
            None => {
                progress.stage("aligning");
                aligned(arguments, site, &schedule_state, &robot.profile, &map)?
            }
        };
        progress.stage("comparing");
        let slam_map_hash = map.content_hash().map_err(Failure::work)?;
        let input = DeviationInput {
            site,
            schedule_state: &schedule_state,
            robot: &robot.profile,
            map_storey: pose.map_storey,
            slam: &map,
            slam_map_hash,
            slam_frame: &pose.slam_frame,
            about_m: pose.about_m,
            covariance: pose.covariance,
        };
        let goals = arguments.goals.as_deref();
        let goals = goals.map(|path| carried(path, pose.map_storey, &LocalTransform::of(&input))).transpose()?;
        let found = deviations(&input);
        let found = Deviations::open(found.bytes()).map_err(Failure::work)?;
        write(arguments, site, &schedule_state, &found, goals, (&schedule.task_uids(), arguments.schedule.files()))
    })
}

/// Where the map lies.
struct MapPose {
    map_storey: usize,
    slam_frame: SlamFrame,
    about_m: [f64; 2],
    covariance: PoseCovariance,
}

/// The pose that the caller knows.
fn known_pose(known: &KnownPose, storey: Option<u32>, site: &Site<'_>, map: &OccupancyMap) -> Result<MapPose, Failure> {
    let map_storey = storey.map_or(0, |storey| storey as usize);
    if map_storey >= site.map_storeys.len() {
        return Err(Failure::usage(format!(
            "--storey {map_storey}: the site has {} map storeys",
            site.map_storeys.len()
        )));
    }
    let [place, yaw] = [known.place_m, known.yaw_rad].map(|deviation| deviation * deviation);
    let covariance = PoseCovariance::from_rows([[place, 0.0, 0.0], [0.0, place, 0.0], [0.0, 0.0, yaw]]);
    let pose = PoseRecord {
        map_from_slam: known.x_y_yaw,
        covariance: flat(&covariance),
        about_m: middle_m(map),
        map_storey: map_storey as u32,
        ..PoseRecord::NONE
    };
    Ok(MapPose { map_storey, slam_frame: SlamFrame::rigid(&pose), about_m: pose.about_m, covariance })
}

/// The middle of a map in its frame.
fn middle_m(map: &OccupancyMap) -> [f64; 2] {
    let half = [map.width, map.cells.len() / map.width.max(1)].map(|n| n as f64 * map.resolution_m / 2.0);
    Rigid2::<Slam, Slam>::of_x_y_yaw(map.origin).apply(half)
}

/// The pose that alignment finds.
fn aligned(
    arguments: &Args,
    site: &Site<'_>,
    schedule_state: &ScheduleState<'_>,
    robot: &RobotProfile,
    map: &OccupancyMap,
) -> Result<MapPose, Failure> {
    let mut references = References::new(site, robot).map_err(Failure::work)?;
    let maps: Vec<_> = references.at(site, schedule_state).map_err(Failure::work)?.collect();
    let storeys: Vec<u32> = (0..maps.len() as u32).collect();
    let slam_map = PreparedMap::of_slam(map);
    let (places, known) = (SitePlaces::of(site), arguments.place.known_places()?);
    let hints = places.hints(known.points_in_rooms(), known.elevation_m, known.portal.as_deref());
    let (hint, mut hints) = (arguments.place.hint(), hints.map_err(Failure::usage)?);
    if let Some(storey) = arguments.place.storey {
        if !storeys.contains(&storey) {
            return Err(Failure::usage(format!("the model has no storey {storey} with which maps are aligned")));
        }
        hints.push(PlaceHint::on_storey(storey));
    }
    let mut found = align_maps_within(&maps, &storeys, &slam_map, hint.as_ref(), &hints, None);
    found.decide(&maps, &slam_map, &storeys, &places.rooms);
    let plan_time_s = schedule_state.head.plan_time_s;
    let none = ContentHash::NONE;
    let sources = AlignmentSources { site_hash: none, slam_map_hash: none, searched_map_hash: none, plan_time_s };
    let archive = found.archive(
        &storeys,
        &found.pose_status(&storeys, MaxUncertainty::in_degrees(f64::INFINITY, f64::INFINITY), None),
        sources,
    );
    let alignment = Alignment::open(archive.bytes()).map_err(Failure::work)?;
    let best = found.poses.first().filter(|_| found.verdict == AlignmentVerdict::Accepted);
    let Some((pose, slam_frame)) = best.zip(alignment.slam_frame()) else {
        let text = alignment_report::text(&alignment, None);
        return Err(Failure::work(format!("where the map lies is {}", text.trim_end())));
    };
    Ok(MapPose {
        map_storey: storeys[pose.reference] as usize,
        slam_frame,
        about_m: pose.about_m,
        covariance: pose.covariance,
    })
}
