//! Resources with their calendars, and their work on tasks.

use crate::PlanFileError;
use crate::iso::duration_s;
use crate::resources::{WrittenAssignment, WrittenResources};
use crate::values::{number, seconds};
use crate::xml::Xml;

/// Type of resources that work; others are material and costs.
const WORK: &str = "1";

/// The element `Resources`.
pub(super) fn read(xml: &mut Xml<'_>, resources: &mut WrittenResources) -> Result<(), PlanFileError> {
    while let Some(element) = xml.child()? {
        if element == "Resource" {
            let [uid, kind, calendar] = cells(xml, ["UID", "Type", "CalendarUID"])?;
            if kind.is_empty() || kind == WORK {
                resources.add(&uid, &calendar);
            }
        } else {
            xml.skip()?;
        }
    }
    Ok(())
}

/// The element `Assignments`.
pub(super) fn read_assignments(xml: &mut Xml<'_>, resources: &mut WrittenResources) -> Result<(), PlanFileError> {
    while let Some(element) = xml.child()? {
        if element == "Assignment" {
            let [task, resource, units, work] = cells(xml, ["TaskUID", "ResourceUID", "Units", "Work"])?;
            let units = number(&units).unwrap_or(1.0);
            let length_s = duration_s(&work).and_then(|work_s| seconds(work_s as f64 / units, 1.0));
            if resources.decide(&task) && units > 0.0 {
                resources.assign(WrittenAssignment { task, resource, length_s })?;
            }
        } else {
            xml.skip()?;
        }
    }
    Ok(())
}

/// The texts of the children of an element with these names.
fn cells<const N: usize>(xml: &mut Xml<'_>, names: [&str; N]) -> Result<[String; N], PlanFileError> {
    let mut cells = [const { String::new() }; N];
    while let Some(element) = xml.child()? {
        match names.iter().position(|name| *name == element) {
            Some(k) => cells[k] = xml.text()?.into_owned(),
            None => xml.skip()?,
        }
    }
    Ok(cells)
}
