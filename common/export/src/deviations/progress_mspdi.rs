//! `progress.xml`: progress of tasks as a project of MS Project (MSPDI), from which planners' tools take it over.
//!
//! # Source
//! Microsoft, Project XML Data Interchange schema, `mspdi_pj12.xsd`: order of the elements of `Project` and `Task`.

use super::input::DeviationExport;
use super::progress::TaskProgress;
use crate::text::xml_text;
use messages::plan_time;
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, Event};
use std::io::Result;

/// The document of tasks, each with its UID in the planner's file.
pub(super) fn document(input: &DeviationExport<'_>, tasks: &[(u32, &TaskProgress)]) -> Vec<u8> {
    written(input, tasks).expect("memory does not fail")
}

fn written(input: &DeviationExport<'_>, tasks: &[(u32, &TaskProgress)]) -> Result<Vec<u8>> {
    let mut xml = Writer::new(Vec::new());
    xml.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), Some("yes"))))?;
    let root = xml.create_element("Project").with_attribute(("xmlns", "http://schemas.microsoft.com/project"));
    root.write_inner_content(|xml| {
        xml_text(xml, "SaveVersion", "14")?;
        xml_text(xml, "Name", "progress")?;
        if let Some(seen) = plan_time(input.deviations.head.plan_time_s) {
            xml_text(xml, "StatusDate", &seen.to_string())?;
        }
        xml.create_element("Tasks").write_inner_content(|xml| {
            (1..).zip(tasks).try_for_each(|(id, (uid, progress))| task(xml, input, id, *uid, progress))
        })?;
        Ok(())
    })?;
    Ok(xml.into_inner())
}

fn task(
    xml: &mut Writer<Vec<u8>>,
    input: &DeviationExport<'_>,
    id: u32,
    uid: u32,
    progress: &TaskProgress,
) -> Result<()> {
    let schedule = &input.site.schedule;
    let record = &schedule.tasks[progress.task];
    xml.create_element("Task").write_inner_content(|xml| {
        xml_text(xml, "UID", &uid.to_string())?;
        xml_text(xml, "ID", &id.to_string())?;
        xml_text(xml, "Name", schedule.text(record.name))?;
        if let Some(percent) = progress.percent() {
            xml_text(xml, "PercentComplete", &percent.to_string())?;
        }
        for (name, date) in [("ActualStart", &progress.actual_start), ("ActualFinish", &progress.actual_finish)] {
            if let Some(date) = date {
                xml_text(xml, name, &date.at)?;
            }
        }
        Ok(())
    })?;
    Ok(())
}
