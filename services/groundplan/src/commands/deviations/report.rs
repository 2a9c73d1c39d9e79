//! Deviations as files, JSON and text.

use super::args::Args;
use super::planner_files::planner_files;
use crate::args::report_set_aside;
use crate::date_argument;
use crate::failure::Failure;
use crate::input_document::read_document;
use bcf::{BcfVersion, Container};
use export::{
    DeviationExport, DeviationsDocument, ExportFile, deviation_files_after, deviation_files_in, progress_mspdi,
    with_manifest,
};
use frames::PlanTime;
use messages::{DeviationVerdict, Deviations, Observation, ScheduleState, ScheduleStateHead, Site};
use serde_json::json;
use std::fmt::Write;
use std::path::PathBuf;

/// Writes the files that are asked for, with goals if there are any, and the progress of tasks with these identities in their
/// schedule files, `plans`; what is to be printed.
///
/// # Errors
/// A folder that cannot be written.
pub(super) fn write(
    arguments: &Args,
    site: &Site<'_>,
    schedule_state: &ScheduleState<'_>,
    found: &Deviations<'_>,
    goals: Option<ExportFile>,
    (uids, plans): (&[&str], &[PathBuf]),
) -> Result<String, Failure> {
    // Topics have a creation date; a comparison without a date has only that of the machine.
    let now = || PlanTime::from_civil_seconds(jiff::Timestamp::now().as_second());
    let created = messages::plan_time(schedule_state.head.plan_time_s).or_else(now);
    let created = created.ok_or_else(|| Failure::work("the machine's clock tells no date"))?;
    let input = DeviationExport { site, schedule_state, deviations: found, created };
    if let Some(folder) = &arguments.out {
        let folder = arguments.overwrite.folder_at(folder)?;
        let files = files(arguments, &input)?.into_iter().chain(progress_mspdi(&input, uids));
        let files = files.chain(planner_files(&input, uids, plans)?).chain(goals).collect();
        let manifest = json!({
            "plan_time": date_argument::optional_text(found.head.plan_time_s),
            "slam_map_hash": found.head.slam_map_hash.to_string(),
        });
        report_set_aside(folder.replace(&with_manifest(manifest, files)).map_err(Failure::work)?);
    }
    if arguments.json {
        return Ok(serde_json::to_string_pretty(&DeviationsDocument::of(&input)).map_err(Failure::work)? + "\n");
    }
    Ok(text(site, found))
}

/// The files, with the topics of an earlier comparison if they are given.
fn files(arguments: &Args, input: &DeviationExport<'_>) -> Result<Vec<ExportFile>, Failure> {
    let Some(path) = &arguments.bcf else {
        return Ok(deviation_files_in(input, BcfVersion::of(&arguments.bcf_version).unwrap_or_default()));
    };
    let unusable = |e: &dyn std::fmt::Display| Failure::usage(format!("--bcf {}: {e}", path.display()));
    let earlier = Container::read(&read_document(path).map_err(|e| unusable(&e))?).map_err(|e| unusable(&e))?;
    deviation_files_after(input, earlier).map_err(|e| unusable(&e))
}

/// For people: counts, everything that is not as planned, what stands beside it.
fn text(site: &Site<'_>, found: &Deviations<'_>) -> String {
    let head = found.head;
    let storey = site.text(site.map_storeys[head.map_storey as usize].name);
    let date = match head.plan_time_s {
        ScheduleStateHead::NO_TIME => "everything built".to_owned(),
        at_s => date_argument::text(at_s),
    };
    let mut out = format!("storey {} {storey} at {date}\n", head.map_storey);
    let count = |observation: Observation| {
        let n = found.elements.iter().filter(|e| e.observation == observation).count();
        format!("{n} {}", observation.name())
    };
    // Writing to a string does not fail.
    let _ = writeln!(out, "elements: {}", Observation::ALL.map(count).join(", "));
    for record in found.elements {
        let (verdict, observation) = (record.verdict.get(), record.observation.get());
        if verdict.deviation().is_none() {
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
            verdict.name(),
            site.text(element.name),
            observation.name()
        );
    }
    for part in found.absent_parts.iter().filter(|p| p.verdict == DeviationVerdict::Late) {
        let element = &site.elements[part.element as usize];
        let [[x0, y0], [x1, y1]] = part.ends_m;
        let _ = writeln!(
            out,
            "  {:<9} {}  {} {:?}: absent from {:.2} to {:.2} m of its axis, {x0:.2}, {y0:.2} to {x1:.2}, {y1:.2}",
            DeviationVerdict::Late.name(),
            site.text(element.global_id),
            site.text(element.ifc_type),
            site.text(element.name),
            part.from_m,
            part.to_m,
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
