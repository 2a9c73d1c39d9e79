//! What differs between a site as planned and a robot's map: of files, or from the running daemon.

use crate::align::told;
use crate::args::{ModelArgs, ScheduleInput, report_set_aside, robot_of_profile, with_timeline};
use crate::cli::DeviationsArgs;
use crate::failure::Failure;
use crate::live;
use crate::plan_date;
use ::deviations::{DeviationInput, deviations as compare};
use alignment::{MadeFrom, PreparedMap, References, align_maps};
use export::{DeviationExport, DeviationsDocument, deviation_files, with_manifest};
use frames::PlanTime;
use messages::{Alignment, Deviations, Judgement, Observation, Phase, PhaseHead, Site, Verdict};
use occupancy::OccupancyMap;
use serde_json::json;
use std::fmt::Write;
use std::path::Path;

/// Compares, or takes what the daemon compared, and writes files of it.
///
/// # Errors
/// Models or maps that cannot be read, a map whose pose is not accepted, a folder that cannot be written; no daemon.
pub fn deviations(arguments: &DeviationsArgs) -> Result<String, Failure> {
    match &arguments.slam {
        None if arguments.models.is_empty() => live::deviations(arguments),
        None => Err(Failure::usage("--slam is needed with models; without both the running daemon tells")),
        Some(slam) => of_files(arguments, slam),
    }
}

fn of_files(arguments: &DeviationsArgs, slam: &Path) -> Result<String, Failure> {
    let robot = robot_of_profile(arguments.robot.as_deref())?;
    let schedule = ScheduleInput::read(&arguments.schedule)?;
    let instant_s = |text| plan_date::instant_s(text, schedule.site_zone());
    let at_s = arguments.date.as_deref().map(instant_s).transpose()?;
    let map = OccupancyMap::read(slam).map_err(Failure::usage)?;
    let model = ModelArgs::new(arguments.models.clone(), arguments.allow_boxes);
    with_timeline(&model, &schedule, |site, timeline, progress| {
        let phase = timeline.phase_at(at_s).finish();
        let phase = Phase::open(phase.bytes()).map_err(Failure::work)?;
        progress.stage("aligning");
        let mut references = References::new(site, &robot.profile).map_err(Failure::work)?;
        let mut maps: Vec<_> = references.at(site, &phase).map_err(Failure::work)?.enumerate().collect();
        maps.retain(|(storey, _)| arguments.place.storey.is_none_or(|only| only as usize == *storey));
        let storeys: Vec<u32> = maps.iter().map(|(storey, _)| *storey as u32).collect();
        let maps: Vec<_> = maps.into_iter().map(|(_, map)| map).collect();
        let found = align_maps(&maps, &PreparedMap::of_slam(&map), arguments.place.hint().as_ref());
        let made_from = MadeFrom { site_hash: 0, slam_map_hash: 0, plan_time_s: phase.head.plan_time_s };
        let archive = found.archive(&storeys, &found.counting(&storeys), made_from);
        let Some(pose) = found.poses.first().filter(|_| found.verdict == Verdict::Accepted) else {
            let alignment = Alignment::open(archive.bytes()).map_err(Failure::work)?;
            return Err(Failure::work(format!("where the map lies is {}", told::text(&alignment).trim_end())));
        };
        progress.stage("comparing");
        let slam_map_hash = map.content_hash().map_err(Failure::work)?;
        let found = compare(&DeviationInput {
            site,
            phase: &phase,
            robot: &robot.profile,
            map_storey: storeys[pose.reference] as usize,
            slam: &map,
            slam_map_hash,
            pose: pose.map_from_slam,
            about_m: pose.about_m,
            covariance: pose.covariance,
        });
        let found = Deviations::open(found.bytes()).map_err(Failure::work)?;
        write(arguments, site, &phase, &found)
    })
}

/// Writes the files that are asked for; what is to be printed.
///
/// # Errors
/// A folder that cannot be written.
pub(crate) fn write(
    arguments: &DeviationsArgs,
    site: &Site<'_>,
    phase: &Phase<'_>,
    found: &Deviations<'_>,
) -> Result<String, Failure> {
    // Topics want to know when they were made; a comparison without a date has only that of the machine.
    let now = || PlanTime::from_civil_seconds(jiff::Timestamp::now().as_second());
    let created = messages::plan_time(phase.head.plan_time_s).or_else(now);
    let created = created.ok_or_else(|| Failure::work("the machine's clock tells no date"))?;
    let input = DeviationExport { site, phase, deviations: found, created };
    if let Some(folder) = &arguments.out {
        let folder = arguments.overwrite.folder_at(folder)?;
        let manifest = json!({
            "plan_time": plan_date::optional_text(found.head.plan_time_s),
            "slam_map_hash": format!("{:016x}", found.head.slam_map_hash),
        });
        report_set_aside(folder.replace(&with_manifest(manifest, deviation_files(&input))).map_err(Failure::work)?);
    }
    if arguments.json {
        return Ok(serde_json::to_string_pretty(&DeviationsDocument::of(&input)).map_err(Failure::work)? + "\n");
    }
    Ok(text(site, found))
}

/// For people: counts, everything that is not as planned, what stands beside it.
fn text(site: &Site<'_>, found: &Deviations<'_>) -> String {
    let head = found.head;
    let storey = site.text(site.map_storeys[head.map_storey as usize].name);
    let date = match head.plan_time_s {
        PhaseHead::NO_TIME => "everything built".to_owned(),
        at_s => plan_date::text(at_s),
    };
    let mut out = format!("storey {} {storey} at {date}\n", head.map_storey);
    let count = |observation: Observation| {
        let n = found.elements.iter().filter(|e| e.observation == observation as u32).count();
        format!("{n} {}", observation.name())
    };
    // Writing to a string does not fail.
    let _ = writeln!(out, "elements: {}", Observation::ALL.map(count).join(", "));
    for record in found.elements {
        let (Some(judgement), Some(observation)) =
            (Judgement::from_id(record.judgement), Observation::from_id(record.observation))
        else {
            continue;
        };
        if matches!(judgement, Judgement::OnPlan | Judgement::Unknown) {
            continue;
        }
        let element = &site.elements[record.element as usize];
        let (id, kind) = (site.text(element.global_id), site.text(element.ifc_type));
        let by = match observation {
            Observation::Displaced => format!(" by {:.2} m", record.offset_m.abs()),
            _ => String::new(),
        };
        let _ = writeln!(
            out,
            "  {:<9} {id}  {kind} {:?}: {}{by}",
            judgement.name(),
            site.text(element.name),
            observation.name()
        );
    }
    for obstacle in found.obstacles {
        let [x, y] = obstacle.centroid_m;
        let _ = writeln!(
            out,
            "  not in the model: {:.2} m2, {:.1} m long, at {x:.2}, {y:.2}",
            obstacle.area_m2, obstacle.length_m
        );
    }
    out
}
