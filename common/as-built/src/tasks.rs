//! Progress of tasks: actual dates and completion in IfcTaskTime, or in IfcScheduleTimeControl of IFC2X3, and tasks for elements
//! that none builds.

use crate::editor::Editor;
use crate::global_id::global_id_of;
use crate::owner_history::OwnerHistory;
use crate::step_file::{Instance, Schema, StepFile};
use crate::step_text::{date_text, list, real, reference, text};
use frames::PlanTime;

/// Progress, as it is written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Progress {
    pub(crate) start: Option<PlanTime>,
    pub(crate) finish: Option<PlanTime>,
    pub(crate) completion: Option<f64>,
    /// As of when.
    pub(crate) at: Option<PlanTime>,
}

impl Progress {
    /// IFC has no completion of zero: it is the same as none.
    fn completion(&self) -> Option<String> {
        let done = if self.finish.is_some() { Some(1.0) } else { self.completion };
        done.filter(|done| *done > 0.0).map(real)
    }

    fn status(&self) -> Option<&'static str> {
        match self {
            Self { finish: Some(_), .. } => Some("Completed"),
            Self { start: Some(_), .. } => Some("Started"),
            _ => self.completion.is_some_and(|done| done > 0.0).then_some("Started"),
        }
    }
}

/// Place of TaskTime in IfcTask of IFC4.
const TASK_TIME: usize = 11;

/// Place of Status in IfcTask: IFC2X3 has no LongDescription before it.
fn status_place(schema: Schema) -> usize {
    if schema == Schema::Ifc2x3 { 6 } else { 7 }
}

/// Attributes of the time of a task, by their places.
struct TimeAttributes {
    entity: &'static str,
    n: usize,
    actual_start: usize,
    actual_finish: usize,
    status_time: usize,
    completion: usize,
}

const TASK_TIME_ATTRIBUTES: TimeAttributes = TimeAttributes {
    entity: "IFCTASKTIME",
    n: 20,
    status_time: 14,
    actual_start: 16,
    actual_finish: 17,
    completion: 19,
};
const TIME_CONTROL_ATTRIBUTES: TimeAttributes = TimeAttributes {
    entity: "IFCSCHEDULETIMECONTROL",
    n: 23,
    actual_start: 5,
    actual_finish: 9,
    status_time: 19,
    completion: 22,
};

/// True for the entities that are tasks.
pub(crate) fn is_task(instance: &Instance<'_>) -> bool {
    ["IFCTASK", "IFCMOVE", "IFCORDERACTION"].iter().any(|entity| instance.is(entity))
}

/// Gives a task of the file its progress.
///
/// # Errors
/// Why it cannot be written; then nothing is.
pub(crate) fn write_task(
    editor: &mut Editor<'_, '_>,
    owner: &mut OwnerHistory,
    task: &Instance<'_>,
    progress: &Progress,
) -> Result<(), String> {
    let before = editor.n_changes();
    match editor.file.schema {
        Schema::Ifc2x3 => in_time_control(editor, owner, task, progress)?,
        Schema::Ifc4 | Schema::Ifc4x3 => in_task_time(editor, task, progress)?,
    }
    if let Some(status) = progress.status() {
        editor.set(task, status_place(editor.file.schema), text(status));
    }
    if editor.n_changes() > before {
        owner.mark_changed(editor, task);
    }
    Ok(())
}

fn in_task_time(editor: &mut Editor<'_, '_>, task: &Instance<'_>, progress: &Progress) -> Result<(), String> {
    let file = editor.file;
    if task.arguments.len() <= TASK_TIME {
        return Err(format!("the task #{} has fewer attributes than an IfcTask", task.id));
    }
    let attributes = &TASK_TIME_ATTRIBUTES;
    let Some(id) = file.reference(task, TASK_TIME) else {
        let none = vec!["$".to_owned(); attributes.n];
        let time = added_time(editor, attributes.entity, none, attributes, progress);
        editor.set(task, TASK_TIME, reference(time));
        return Ok(());
    };
    let time = file.instance(id).filter(|time| time.arguments.len() >= attributes.n);
    let time = time.ok_or_else(|| format!("the time #{id} of the task is missing or has too few attributes"))?;
    check_finish(file, &time, attributes, progress)?;
    let sharers = file.all("IFCTASK").iter().filter(|task| file.reference(task, TASK_TIME) == Some(id)).count();
    if sharers > 1 {
        let kept = (0..time.arguments.len()).map(|k| editor.argument(&time, k)).collect();
        let copy = added_time(editor, time.entity, kept, attributes, progress);
        editor.set(task, TASK_TIME, reference(copy));
    } else {
        for (k, value) in values(editor, attributes, progress, Some(&time)) {
            editor.set(&time, k, value);
        }
    }
    Ok(())
}

/// IFC2X3: the time of a task hangs on its assignment to a schedule.
fn in_time_control(
    editor: &mut Editor<'_, '_>,
    owner: &mut OwnerHistory,
    task: &Instance<'_>,
    progress: &Progress,
) -> Result<(), String> {
    let file = editor.file;
    let attributes = &TIME_CONTROL_ATTRIBUTES;
    let relations = file.all("IFCRELASSIGNSTASKS");
    let of_task = |relation: &&Instance<'_>| file.references(relation, 4).contains(&task.id);
    let with_time = relations.iter().filter(of_task).find(|relation| file.reference(relation, 7).is_some());
    if let Some(id) = with_time.and_then(|relation| file.reference(relation, 7)) {
        let time = file.instance(id).filter(|time| time.arguments.len() >= attributes.n);
        let time = time.ok_or_else(|| format!("the time #{id} of the task is missing or has too few attributes"))?;
        check_finish(file, &time, attributes, progress)?;
        let relation = relations.iter().filter(of_task).find(|r| file.reference(r, 7) == Some(id));
        let sharers: usize = relations
            .iter()
            .filter(|relation| file.reference(relation, 7) == Some(id))
            .map(|relation| file.references(relation, 4).len())
            .sum();
        if sharers > 1 {
            // What has a GlobalId is not copied: the time is that of several tasks.
            let relation = relation.map_or(id, |relation| relation.id);
            return Err(format!("its time #{id} (by #{relation}) is that of {sharers} tasks"));
        }
        let before = editor.n_changes();
        for (k, value) in values(editor, attributes, progress, Some(&time)) {
            editor.set(&time, k, value);
        }
        if editor.n_changes() > before {
            owner.mark_changed(editor, &time);
        }
        return Ok(());
    }
    let global_id = file.global_id(task).unwrap_or_default();
    let time = added_time_control(editor, owner, global_id, progress);
    match relations.iter().find(|relation| of_task(relation) && relation.arguments.len() > 7) {
        Some(relation) if file.references(relation, 4).len() == 1 => {
            editor.set(relation, 7, reference(time));
            owner.mark_changed(editor, relation);
        }
        _ => assign_with_time(editor, owner, (task.id, global_id), time, progress),
    }
    Ok(())
}

/// Refuses progress of a task at work where the model has its finish: which of both is right is not known.
fn check_finish(
    file: &StepFile<'_>,
    time: &Instance<'_>,
    attributes: &TimeAttributes,
    progress: &Progress,
) -> Result<(), String> {
    let is_finished = !matches!(file.argument(time, attributes.actual_finish), b"$" | b"");
    if is_finished && progress.finish.is_none() && progress.completion.is_none_or(|done| done < 1.0) {
        return Err("the model has its actual finish, and the report none".to_owned());
    }
    Ok(())
}

/// What is set of a time, by place; a date that it has already is left alone.
fn values(
    editor: &mut Editor<'_, '_>,
    attributes: &TimeAttributes,
    progress: &Progress,
    current: Option<&Instance<'_>>,
) -> Vec<(usize, String)> {
    let dates = [
        (attributes.actual_start, progress.start),
        (attributes.actual_finish, progress.finish),
        (attributes.status_time, progress.at),
    ];
    let mut values = Vec::new();
    for (k, at) in dates.into_iter().filter_map(|(k, at)| Some((k, at?))) {
        if !current.is_some_and(|current| has_date(editor.file, current, k, at)) {
            values.push((k, date(editor, at)));
        }
    }
    values.extend(progress.completion().map(|done| (attributes.completion, done)));
    values
}

/// True if a time of IFC2X3 has this date already.
fn has_date(file: &StepFile<'_>, time: &Instance<'_>, k: usize, at: PlanTime) -> bool {
    let found = file.referred(time, k).filter(|date| date.is("IFCDATEANDTIME"));
    let parts = found.and_then(|date| Some((file.referred(&date, 0)?, file.referred(&date, 1)?)));
    parts.is_some_and(|(day, clock)| {
        let civil = at.0;
        let numbers =
            [0, 1, 2].map(|k| file.number(&day, k)).into_iter().chain([0, 1, 2].map(|k| file.number(&clock, k)));
        let [days, months, years] = [i16::from(civil.day()), i16::from(civil.month()), civil.year()];
        let [hours, minutes, seconds] = [civil.hour(), civil.minute(), civil.second()].map(i16::from);
        numbers.eq([days, months, years, hours, minutes, seconds].map(|number| Some(f64::from(number))))
    })
}

fn added_time(
    editor: &mut Editor<'_, '_>,
    entity: &str,
    mut arguments: Vec<String>,
    attributes: &TimeAttributes,
    progress: &Progress,
) -> u64 {
    for (k, value) in values(editor, attributes, progress, None) {
        arguments[k] = value;
    }
    editor.add(entity, &arguments)
}

fn added_time_control(editor: &mut Editor<'_, '_>, owner: &mut OwnerHistory, task: &str, progress: &Progress) -> u64 {
    let attributes = &TIME_CONTROL_ATTRIBUTES;
    let mut arguments = vec!["$".to_owned(); attributes.n];
    arguments[0] = format!("'{}'", global_id_of(&["time", task]));
    arguments[1] = owner.of_added(editor);
    added_time(editor, attributes.entity, arguments, attributes, progress)
}

/// A date: a text, or entities of IFC2X3.
fn date(editor: &mut Editor<'_, '_>, at: PlanTime) -> String {
    if editor.file.schema != Schema::Ifc2x3 {
        return date_text(at);
    }
    let civil = at.0;
    let day = [civil.day().to_string(), civil.month().to_string(), civil.year().to_string()];
    let day = editor.add("IFCCALENDARDATE", &day);
    let time = [civil.hour().to_string(), civil.minute().to_string(), real(f64::from(civil.second()))];
    let time: Vec<String> = time.into_iter().chain(["$".to_owned(), "$".to_owned()]).collect();
    let time = editor.add("IFCLOCALTIME", &time);
    reference(editor.add("IFCDATEANDTIME", &[reference(day), reference(time)]))
}

/// An element for which there is no task.
pub(crate) struct Built<'o> {
    pub(crate) element: u64,
    pub(crate) global_id: &'o str,
    /// Its Name, as the file writes it.
    pub(crate) name: String,
}

/// Adds a task that builds an element, with its progress; that of an earlier run is brought up to date.
///
/// # Errors
/// Why it cannot be written.
pub(crate) fn add_task(
    editor: &mut Editor<'_, '_>,
    owner: &mut OwnerHistory,
    built: &Built<'_>,
    progress: &Progress,
) -> Result<(), String> {
    let id = global_id_of(&["task", built.global_id]);
    if let Some(task) = editor.file.root(&id).and_then(|task| editor.file.instance(task)) {
        return write_task(editor, owner, &task, progress);
    }
    let none = || "$".to_owned();
    let history = owner.of_added(editor);
    let name = if built.name == "$" { text("As built") } else { built.name.clone() };
    let identification = text(&format!("as-built {}", built.global_id));
    let status = progress.status().map_or_else(none, text);
    let old_schema = editor.file.schema == Schema::Ifc2x3;
    let kind = if old_schema { text("CONSTRUCTION") } else { none() };
    let mut task = vec![history.clone(), name, none(), kind, identification];
    task.extend(if old_schema { vec![status, none()] } else { vec![none(), status, none()] });
    task.extend([".F.".to_owned(), none()]);
    if !old_schema {
        let attributes = &TASK_TIME_ATTRIBUTES;
        let time = added_time(editor, attributes.entity, vec![none(); attributes.n], attributes, progress);
        task.extend([reference(time), ".CONSTRUCTION.".to_owned()]);
    }
    let task = editor.add_root("IFCTASK", &id, &task);
    if old_schema {
        let time = added_time_control(editor, owner, &id, progress);
        assign_with_time(editor, owner, (task, &id), time, progress);
    } else {
        let schedule = work_schedule(editor, owner, progress);
        let relation = [history.clone(), none(), none(), list(&[task]), none(), reference(schedule)];
        editor.add_root("IFCRELASSIGNSTOCONTROL", &global_id_of(&["control", &id]), &relation);
    }
    let relation = [history, none(), none(), list(&[task]), none(), reference(built.element)];
    editor.add_root("IFCRELASSIGNSTOPRODUCT", &global_id_of(&["product", &id]), &relation);
    Ok(())
}

/// IFC2X3: assigns a task to the schedule of what is built, with its time.
fn assign_with_time(
    editor: &mut Editor<'_, '_>,
    owner: &mut OwnerHistory,
    (task, global_id): (u64, &str),
    time: u64,
    progress: &Progress,
) {
    let schedule = work_schedule(editor, owner, progress);
    let history = owner.of_added(editor);
    let none = || "$".to_owned();
    let relation = [history, none(), none(), list(&[task]), none(), reference(schedule), reference(time)];
    editor.add_root("IFCRELASSIGNSTASKS", &global_id_of(&["assignment", global_id]), &relation);
}

/// The schedule of added tasks: one for a file.
fn work_schedule(editor: &mut Editor<'_, '_>, owner: &mut OwnerHistory, progress: &Progress) -> u64 {
    let id = global_id_of(&["schedule"]);
    if let Some(schedule) = editor.root(&id) {
        return schedule;
    }
    let history = owner.of_added(editor);
    let begun = [progress.start, progress.finish, progress.at].into_iter().flatten().next();
    let begun = date(editor, begun.unwrap_or(PlanTime::LAST));
    let (none, name) = (|| "$".to_owned(), text("As built"));
    let head = [history, name, none(), none(), text("as-built"), begun.clone()];
    let behind = [none(), none(), none(), none(), begun, none(), ".ACTUAL.".to_owned()];
    let mut schedule: Vec<String> = head.into_iter().chain(behind).collect();
    if editor.file.schema == Schema::Ifc2x3 {
        schedule.push(none());
    }
    editor.add_root("IFCWORKSCHEDULE", &id, &schedule)
}
