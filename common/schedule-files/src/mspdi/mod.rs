//! MS Project XML (MSPDI) of MS Project 2003 to 2021 and of the programs that write it as well.
//!
//! - Dates have no zone, lengths are `PT8H0M0S`. `DurationFormat` says only how a length is shown, and whether it is elapsed: the even
//!   codes 4 to 12 are, and 20, each with 32 added where the length is an estimate.
//! - `LinkLag` and slacks are tenths of minutes whatever `LagFormat` says; with the formats 19 and 20 (51 and 52) a lag is a percentage
//!   of the predecessor's duration instead, elapsed with 20.
//! - The task of UID 0 on outline level 0 is the project itself and no task. Rows that are empty in the planner's table have `IsNull`.
//! - Nesting is `OutlineLevel` alone, in the order of the file.
//! - A task with a length that is marked as a milestone is a task: MS Project shows it so, and works on it all the same.
//! - A task that is scheduled by hand (`Manual`, since 2010) has its dates in `ManualStart` and `ManualFinish`; the others are a guess of
//!   MS Project where those are missing. Neither dependencies nor constraints move it. A task with `Active` 0 (since 2010) is switched
//!   off.
//! - Of the eleven baselines that of number 0 is "the" baseline. Deadlines move nothing.
//! - A task of another `Type` than 1 (fixed duration) without `IgnoreResourceCalendar` takes as long as the work of its resources, `Work`
//!   by `Units`, in the working time that their calendars share with its own, if it has one.
//! - Calendars of resources stand among the others. `BaseCalendarUID` and `CalendarUID` are -1, or 0 since 2013, where there is none.
//! - A working time that ends at 00:00 ends with its day. A working day without working times has the usual ones.
//! - Exceptions are week days of type 0 until 2003, and elements of their own since 2007, which writes both: the same days twice. Since
//!   2007 they recur, and calendars have working weeks. Here all of them are days: those of exceptions that do not recur rank before
//!   those that do, and these before working weeks.
//! - A custom field is known by its `FieldID`; its name is its alias, if the planner gave it one. Since 2007 values of lookup tables are
//!   `ValueGUID`, until then `ValueID`. An outline code is a path of such values.
//! - Links to tasks of other files (`CrossProject`) are found and left out.

mod calendars;
mod fields;
mod recurrence;
mod resources;
mod tasks;
mod values;

use crate::PlanFileError;
use crate::assemble::WrittenPlan;
use crate::iso;
use crate::plan::{FindingKind, PlanDate, PlanFile};
use crate::resources::{OwnCalendar, WrittenResources};
use crate::xml::Xml;
use fields::Fields;
use tasks::Outline;

/// Elements other than the root, which is `Project`.
///
/// # Errors
/// XML that is not well-formed, and more of something than a schedule has.
pub(crate) fn read(xml: &mut Xml<'_>) -> Result<PlanFile, PlanFileError> {
    let mut file = PlanFile { honours_constraints: true, ..PlanFile::default() };
    let mut plan = WrittenPlan::default();
    let mut fields = Fields::default();
    let mut calendars = Vec::new();
    let mut outline = Outline::default();
    let mut work = WrittenResources::default();
    let (mut title, mut save_version, mut build, mut default_calendar) = Default::default();
    while let Some(element) = xml.child()? {
        match element {
            "Title" => title = xml.text()?,
            "Name" => file.name = xml.text()?.into_owned(),
            "SaveVersion" => save_version = xml.text()?,
            "BuildNumber" => build = xml.text()?,
            "CalendarUID" => default_calendar = xml.text()?,
            "StartDate" => file.start = project_date(xml, "start", &mut plan)?,
            "StatusDate" => file.data_date = project_date(xml, "status date", &mut plan)?,
            "HonorConstraints" => file.honours_constraints = !["0", "false"].contains(&&*xml.text()?),
            "OutlineCodes" => fields.read_outline_codes(xml)?,
            "ExtendedAttributes" => fields.read_extended_attributes(xml)?,
            "Calendars" => calendars = calendars::read(xml, &mut plan.findings)?,
            "Tasks" => tasks::read(xml, &mut plan, &mut outline, &fields, &mut work)?,
            "Resources" => resources::read(xml, &mut work)?,
            "Assignments" => resources::read_assignments(xml, &mut work)?,
            _ => xml.skip()?,
        }
    }
    for calendar in &mut calendars {
        calendar.is_default = !default_calendar.is_empty() && calendar.uid == default_calendar;
    }
    if !title.is_empty() {
        file.name = title.into_owned();
    } else if file.name.is_empty() {
        file.name = outline.project_name;
    }
    file.written_by = format!("MS Project XML, save version {save_version} {build}").trim_end().to_owned();
    file.calendars = crate::calendars::resolve(&calendars, &mut plan.findings)?;
    plan.into_file(&mut file);
    work.add_to(&mut file, OwnCalendar::Combined);
    Ok(file)
}

fn project_date(xml: &mut Xml<'_>, what: &str, plan: &mut WrittenPlan) -> Result<Option<PlanDate>, PlanFileError> {
    let text = xml.text()?;
    let date = iso::date(&text);
    if date.is_none() && !text.is_empty() {
        plan.find(None, FindingKind::UnreadableValue, format!("the {what} {text:?} of the project cannot be read"));
    }
    Ok(date)
}

#[cfg(test)]
mod tests;
