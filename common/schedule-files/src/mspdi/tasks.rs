//! Tasks with their dates, fields and predecessors.

use super::fields::{Fields, WrittenField};
use super::values;
use crate::PlanFileError;
use crate::assemble::{References, WrittenLink, WrittenPlan};
use crate::iso;
use crate::plan::{Constraint, ConstraintKind, DependencyKind, FindingKind, PlanDate, PlanTask, PlanTaskKind};
use crate::resources::WrittenResources;
use crate::values::{number, seconds};
use crate::xml::Xml;

/// The tasks that those to come may be nested in.
#[derive(Debug, Default)]
pub(super) struct Outline {
    /// Outline level and uid, each level higher than the one before.
    line: Vec<(u32, String)>,
    /// Name of the task that is the project.
    pub(super) project_name: String,
}

/// A task as it is written.
#[derive(Debug, Default)]
struct WrittenTask {
    task: PlanTask,
    level: u32,
    is_null: bool,
    is_summary: bool,
    is_milestone: bool,
    is_manual: bool,
    /// `Type`.
    kind: String,
    ignores_resources: bool,
    calendar: String,
    format: String,
    /// `Duration`, `RemainingDuration` and `ManualDuration`.
    durations: [String; 3],
    /// `ManualStart` and `ManualFinish`.
    manual: [Option<PlanDate>; 2],
    resume: Option<PlanDate>,
    constraint: String,
    constraint_date: Option<PlanDate>,
    deadline: Option<PlanDate>,
    fields: Vec<WrittenField>,
    links: Vec<WrittenPredecessor>,
}

/// The element `PredecessorLink`.
#[derive(Debug, Default)]
struct WrittenPredecessor {
    uid: String,
    kind: String,
    lag: String,
    lag_format: String,
    is_elsewhere: bool,
}

/// The element `Tasks`.
pub(super) fn read(
    xml: &mut Xml<'_>,
    plan: &mut WrittenPlan,
    outline: &mut Outline,
    fields: &Fields,
    resources: &mut WrittenResources,
) -> Result<(), PlanFileError> {
    while let Some(element) = xml.child()? {
        if element == "Task" {
            let written = WrittenTask::read(xml, plan)?;
            if let Some(task) = add(written, plan, outline, fields)? {
                resources.let_decide(&task);
            }
        } else {
            xml.skip()?;
        }
    }
    Ok(())
}

impl WrittenTask {
    fn read(xml: &mut Xml<'_>, plan: &mut WrittenPlan) -> Result<Self, PlanFileError> {
        let mut written = Self { level: 1, ..Self::default() };
        while let Some(element) = xml.child()? {
            let task = &mut written.task;
            match element {
                "UID" => task.uid = xml.text()?.into_owned(),
                "ID" => task.code = xml.text()?.into_owned(),
                "Name" => task.name = xml.text()?.into_owned(),
                "WBS" => task.wbs = xml.text()?.into_owned(),
                "OutlineLevel" => {
                    written.level = read_value(xml, element, plan, |text| text.parse().ok())?.unwrap_or(1)
                }
                "IsNull" => written.is_null = is_true(xml)?,
                "Summary" => written.is_summary = is_true(xml)?,
                "Milestone" => written.is_milestone = is_true(xml)?,
                "Manual" => written.is_manual = is_true(xml)?,
                "Type" => written.kind = xml.text()?.into_owned(),
                "IgnoreResourceCalendar" => written.ignores_resources = is_true(xml)?,
                "Active" => task.is_inactive = !is_true(xml)?,
                "Start" => task.dates.current[0] = read_value(xml, element, plan, iso::date)?,
                "Finish" => task.dates.current[1] = read_value(xml, element, plan, iso::date)?,
                "ManualStart" => written.manual[0] = read_value(xml, element, plan, iso::date)?,
                "ManualFinish" => written.manual[1] = read_value(xml, element, plan, iso::date)?,
                "EarlyStart" => task.dates.early[0] = read_value(xml, element, plan, iso::date)?,
                "EarlyFinish" => task.dates.early[1] = read_value(xml, element, plan, iso::date)?,
                "LateStart" => task.dates.late[0] = read_value(xml, element, plan, iso::date)?,
                "LateFinish" => task.dates.late[1] = read_value(xml, element, plan, iso::date)?,
                "ActualStart" => task.dates.actual[0] = read_value(xml, element, plan, iso::date)?,
                "ActualFinish" => task.dates.actual[1] = read_value(xml, element, plan, iso::date)?,
                "Resume" => written.resume = read_value(xml, element, plan, iso::date)?,
                "Duration" => written.durations[0] = xml.text()?.into_owned(),
                "RemainingDuration" => written.durations[1] = xml.text()?.into_owned(),
                "ManualDuration" => written.durations[2] = xml.text()?.into_owned(),
                "DurationFormat" => written.format = xml.text()?.into_owned(),
                "PercentComplete" => task.complete = read_value(xml, element, plan, share)?,
                "PhysicalPercentComplete" => task.physical_complete = read_value(xml, element, plan, share)?,
                "TotalSlack" => task.total_float_s = read_value(xml, element, plan, tenths_of_minutes)?,
                "FreeSlack" => task.free_float_s = read_value(xml, element, plan, tenths_of_minutes)?,
                "CalendarUID" => written.calendar = xml.text()?.into_owned(),
                "ConstraintType" => written.constraint = xml.text()?.into_owned(),
                "ConstraintDate" => written.constraint_date = read_value(xml, element, plan, iso::date)?,
                "Deadline" => written.deadline = read_value(xml, element, plan, iso::date)?,
                "Baseline" => read_baseline(xml, plan, task)?,
                "ExtendedAttribute" | "OutlineCode" => written.fields.push(WrittenField::read(xml)?),
                "PredecessorLink" => written.links.push(WrittenPredecessor::read(xml)?),
                _ => xml.skip()?,
            }
        }
        Ok(written)
    }

    /// It takes as long as the work of its resources, if it has any.
    fn goes_by_resources(&self) -> bool {
        const FIXED_DURATION: &str = "1";
        let is_elapsed = self.task.duration.is_some_and(|duration| duration.is_elapsed);
        self.task.kind == PlanTaskKind::Task
            && self.kind != FIXED_DURATION
            && !self.ignores_resources
            && !self.is_manual
            && !is_elapsed
    }
}

/// Adds a task with its fields and predecessors; its identity if it goes by its resources.
fn add(
    mut written: WrittenTask,
    plan: &mut WrittenPlan,
    outline: &mut Outline,
    fields: &Fields,
) -> Result<Option<String>, PlanFileError> {
    if written.is_null {
        return Ok(None);
    }
    if written.task.uid == "0" && written.level == 0 {
        outline.project_name = written.task.name;
        return Ok(None);
    }
    let next = plan.next_task();
    finish(&mut written, plan);
    let goes_by_resources = written.goes_by_resources();
    let WrittenTask { task, level, links, fields: written_fields, .. } = written;
    let uid = task.uid.clone();
    while outline.line.pop_if(|(above, _)| *above >= level).is_some() {}
    let parent = outline.line.last().map(|(_, uid)| uid.clone());
    let calendar = Some(written.calendar).filter(|uid| !["", "-1", "0"].contains(&uid.as_str()));
    plan.push(task, References { parent, calendar, project: None })?;
    if plan.next_task() == next {
        return Ok(None);
    }
    for field in &written_fields {
        match fields.resolve(field) {
            (name, Some(value)) => plan.add_field(next, name, &value)?,
            (name, None) => {
                let message = format!("the value of its field {name:?} is in no lookup table");
                plan.find(Some(next), FindingKind::MissingReference, message);
            }
        }
    }
    for link in links {
        add_link(link, &uid, next, plan)?;
    }
    outline.line.push((level, uid.clone()));
    Ok(Some(uid).filter(|_| goes_by_resources))
}

/// Sets what depends on several elements.
fn finish(written: &mut WrittenTask, plan: &mut WrittenPlan) {
    let next = plan.next_task();
    let mut unreadable = |what: &str, text: &str| {
        let message = format!("its {what} {text:?} cannot be read");
        plan.find(Some(next), FindingKind::UnreadableValue, message);
    };
    let mut length = |what: &str, text: &str| {
        let length = values::length(text, &written.format);
        if length.is_none() && !text.is_empty() {
            unreadable(what, text);
        }
        length
    };
    let [duration, remaining, manual] = &written.durations;
    let manual = if written.is_manual { length("ManualDuration", manual) } else { None };
    let task = &mut written.task;
    task.duration = manual.or_else(|| length("Duration", duration));
    task.remaining = length("RemainingDuration", remaining);
    if written.is_manual {
        let [start, finish] = task.dates.current;
        task.dates.current = [written.manual[0].or(start), written.manual[1].or(finish)];
        task.is_manual = true;
    }
    if let (Some(resume), None) = (written.resume, task.dates.actual[1]) {
        task.dates.remaining = [Some(resume), task.dates.current[1]];
    }
    let has_length = task.duration.is_some_and(|duration| duration.seconds > 0);
    task.kind = match (written.is_summary, written.is_milestone && !has_length) {
        (true, _) => PlanTaskKind::Summary,
        (false, true) => PlanTaskKind::Milestone,
        (false, false) => PlanTaskKind::Task,
    };
    let deadline = written.deadline.map(|date| Constraint { kind: ConstraintKind::Deadline, date: Some(date) });
    task.constraints.extend(deadline);
    match (constraint_kind(&written.constraint), written.constraint_date) {
        (Ok(None), _) => {}
        (Ok(Some(ConstraintKind::AsLateAsPossible)), _) => {
            task.constraints.push(Constraint { kind: ConstraintKind::AsLateAsPossible, date: None });
        }
        (Ok(Some(kind)), Some(date)) => task.constraints.push(Constraint { kind, date: Some(date) }),
        (Ok(Some(_)), None) => unreadable("constraint without a date, of ConstraintType", &written.constraint),
        (Err(()), _) => unreadable("ConstraintType", &written.constraint),
    }
    if task.is_manual && task.dates.current == [None, None] && !written.is_summary {
        let message = "it is scheduled by hand and has no dates; they are computed".to_owned();
        plan.find(Some(next), FindingKind::NotUnderstood, message);
    }
}

fn add_link(
    link: WrittenPredecessor,
    successor: &str,
    task: usize,
    plan: &mut WrittenPlan,
) -> Result<(), PlanFileError> {
    if link.is_elsewhere {
        let message = format!("it depends on task {:?} of another file; that dependency is left out", link.uid);
        plan.find(Some(task), FindingKind::MissingReference, message);
        return Ok(());
    }
    let kind = match link.kind.as_str() {
        "0" => DependencyKind::FinishFinish,
        "1" | "" => DependencyKind::FinishStart,
        "2" => DependencyKind::StartFinish,
        "3" => DependencyKind::StartStart,
        other => {
            let message =
                format!("it depends on task {:?} in a way {other:?} that means nothing; it is left out", link.uid);
            plan.find(Some(task), FindingKind::NotUnderstood, message);
            return Ok(());
        }
    };
    let lag = values::lag(&link.lag, &link.lag_format).unwrap_or_else(|| {
        let message = format!("the lag {:?} of its dependency on task {:?} cannot be read", link.lag, link.uid);
        plan.find(Some(task), FindingKind::UnreadableValue, message);
        None
    });
    plan.link(WrittenLink { predecessor: link.uid, successor: successor.to_owned(), kind, lag })
}

impl WrittenPredecessor {
    fn read(xml: &mut Xml<'_>) -> Result<Self, PlanFileError> {
        let mut link = Self::default();
        while let Some(element) = xml.child()? {
            match element {
                "PredecessorUID" => link.uid = xml.text()?.into_owned(),
                "Type" => link.kind = xml.text()?.into_owned(),
                "LinkLag" => link.lag = xml.text()?.into_owned(),
                "LagFormat" => link.lag_format = xml.text()?.into_owned(),
                "CrossProject" => link.is_elsewhere = is_true(xml)?,
                _ => xml.skip()?,
            }
        }
        Ok(link)
    }
}

fn read_baseline(xml: &mut Xml<'_>, plan: &mut WrittenPlan, task: &mut PlanTask) -> Result<(), PlanFileError> {
    let mut dates = [None; 2];
    let mut is_first = false;
    while let Some(element) = xml.child()? {
        match element {
            "Number" => is_first = xml.text()? == "0",
            "Start" => dates[0] = read_value(xml, "baseline start", plan, iso::date)?,
            "Finish" => dates[1] = read_value(xml, "baseline finish", plan, iso::date)?,
            _ => xml.skip()?,
        }
    }
    if is_first {
        task.dates.baseline = dates;
    }
    Ok(())
}

/// A value of the task that comes next; one that cannot be read is found.
fn read_value<T>(
    xml: &mut Xml<'_>,
    what: &str,
    plan: &mut WrittenPlan,
    read: impl Fn(&str) -> Option<T>,
) -> Result<Option<T>, PlanFileError> {
    let text = xml.text()?;
    let value = read(&text);
    if value.is_none() && !text.is_empty() {
        let message = format!("its {what} {text:?} cannot be read");
        plan.find(Some(plan.next_task()), FindingKind::UnreadableValue, message);
    }
    Ok(value)
}

fn is_true(xml: &mut Xml<'_>) -> Result<bool, PlanFileError> {
    let text = xml.text()?;
    Ok(text == "1" || text == "true")
}

/// A share of 100.
fn share(text: &str) -> Option<f64> {
    Some((number(text)? / 100.0).clamp(0.0, 1.0))
}

fn tenths_of_minutes(text: &str) -> Option<i64> {
    seconds(number(text)?, 6.0)
}

/// How a date binds a task; none for as soon as possible.
fn constraint_kind(code: &str) -> Result<Option<ConstraintKind>, ()> {
    Ok(Some(match code {
        "" | "0" => return Ok(None),
        "1" => ConstraintKind::AsLateAsPossible,
        "2" => ConstraintKind::MustStartOn,
        "3" => ConstraintKind::MustFinishOn,
        "4" => ConstraintKind::StartNotEarlierThan,
        "5" => ConstraintKind::StartNotLaterThan,
        "6" => ConstraintKind::FinishNotEarlierThan,
        "7" => ConstraintKind::FinishNotLaterThan,
        _ => return Err(()),
    }))
}
