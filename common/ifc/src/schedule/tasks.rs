//! Tasks: attributes, nesting, assignment to schedules and calendars.

use rustc_hash::FxHashMap;

use super::context::{Context, tell};
use super::model::{Task, TaskTime, WorkControl};
use super::times;
use crate::kernel::{File, Record};
use crate::products::named;
use crate::relations::Relations;
use diagnostics::{DiagnosticCode, Report, Severity};

/// A task by its own attributes and those of its type.
pub(super) fn task(context: &Context<'_, '_>, relations: &Relations, record: &Record<'_>, report: &mut Report) -> Task {
    let file = context.file;
    let id = named(file, record);
    let text = |name: &str| file.attribute(record, name).text().map(|t| t.trim().to_owned()).unwrap_or_default();
    let time = file.attribute(record, "TaskTime").reference().and_then(|time| {
        let once = file.short_record_of(time, "IFCTASKTIME");
        let found = once.or_else(|| {
            let recurring = file.short_record_of(time, "IFCTASKTIMERECURRING")?;
            let message = "its time recurs; only the first time counts".to_owned();
            tell(report, Severity::Warning, DiagnosticCode::TaskTimeRecurring, &id, message);
            Some(recurring)
        });
        if found.is_none() {
            let message = format!("its time #{} is missing or no IfcTaskTime", file.written_id(time));
            tell(report, Severity::Error, DiagnosticCode::TaskTimeMissing, &id, message);
        }
        found.map(|t| times::task_time(file, &t, &id, report))
    });
    let identification = [text("Identification"), text("TaskId")].into_iter().find(|t| !t.is_empty());
    Task {
        identification: identification.unwrap_or_default(),
        predefined_type: predefined_type(context, relations, record),
        is_milestone: file.attribute(record, "IsMilestone").boolean().unwrap_or(false),
        time,
        id,
        ..Task::default()
    }
}

/// Start and Identification: people read tasks in this order, and those without either in that of GlobalIds.
pub(super) fn place_in_plan(file: &File<'_>, record: &Record<'_>) -> (String, String) {
    let text = |record: &Record<'_>, name: &str| {
        file.attribute(record, name).text().map(|t| t.trim().to_owned()).unwrap_or_default()
    };
    let time = file.attribute(record, "TaskTime").reference().and_then(|time| file.record(time));
    let start = time.map(|time| text(&time, "ScheduleStart")).unwrap_or_default();
    (start, text(record, "Identification"))
}

/// Of the task, else of its IfcTaskType; the text where that is user-defined, or where the schema has no types.
fn predefined_type(context: &Context<'_, '_>, relations: &Relations, record: &Record<'_>) -> String {
    let file = context.file;
    let text = |record: &Record<'_>, name: &str| {
        file.attribute(record, name).text().map(|t| t.trim().to_ascii_uppercase()).unwrap_or_default()
    };
    if file.schema.attribute("IFCTASK", "PredefinedType").is_none() {
        let said = text(record, "ObjectType");
        return if said.is_empty() && record.is("IFCMOVE") { "MOVE".to_owned() } else { said };
    }
    let defined = |record: &Record<'_>, name: &str| {
        let kind = file.attribute(record, "PredefinedType").enumeration()?.to_ascii_uppercase();
        let said = text(record, name);
        Some(if kind == "USERDEFINED" && !said.is_empty() { said } else { kind })
    };
    let own = defined(record, "ObjectType");
    if own.as_deref().is_some_and(|kind| kind != "NOTDEFINED") {
        return own.unwrap_or_default();
    }
    let of_type = relations.type_of.get(&record.id).and_then(|&id| file.short_record_of(id, "IFCTASKTYPE"));
    of_type.and_then(|record| defined(&record, "ProcessType")).or(own).unwrap_or_default()
}

/// IfcRelNests and, as some files do, IfcRelAggregates between tasks; no task becomes its own ancestor.
pub(super) fn nest(context: &Context<'_, '_>, tasks: &mut [Task], report: &mut Report) {
    let file = context.file;
    // Broken records were reported when the relations were read.
    let known = &mut Report::default();
    let relations = ["IfcRelNests", "IfcRelAggregates"].into_iter().flat_map(|name| file.records(name, known));
    let pairs: Vec<(usize, usize)> = relations
        .flat_map(|relation| {
            let whole = relation.at(4).reference().and_then(|id| context.task_idx.get(&id).copied());
            let parts = relation.at(5).references().into_iter().filter_map(|id| context.task_idx.get(&id).copied());
            parts.filter_map(move |part| Some((part, whole?))).collect::<Vec<_>>()
        })
        .collect();
    for (part, whole) in pairs {
        match tasks[part].parent {
            None => tasks[part].parent = Some(whole),
            Some(first) if first != whole => {
                let names = [first, whole].map(|k| &tasks[k].id.name);
                let message = format!("it is nested in {:?} and in {:?}; the first counts", names[0], names[1]);
                tell(report, Severity::Warning, DiagnosticCode::TaskNestedTwice, &tasks[part].id.clone(), message);
            }
            Some(_) => {}
        }
    }
    break_circles(tasks, report);
}

/// Drops the link that closes a circle; linear, because every chain is walked once.
fn break_circles(tasks: &mut [Task], report: &mut Report) {
    // 0: not seen, 1: on the chain that is walked, 2: known to end.
    let mut seen = vec![0u8; tasks.len()];
    for start in 0..tasks.len() {
        let mut chain = Vec::new();
        let mut at = Some(start);
        while let Some(task) = at.filter(|t| seen[*t] == 0) {
            seen[task] = 1;
            chain.push(task);
            at = tasks[task].parent;
        }
        if let Some(closing) = at.filter(|t| seen[*t] == 1)
            && let Some(&last) = chain.last()
        {
            tasks[last].parent = None;
            let circle =
                chain.iter().skip_while(|t| **t != closing).take(8).map(|t| format!("{:?}", tasks[*t].id.name));
            let names: Vec<String> = circle.collect();
            let message = format!("tasks are nested in a circle: {}; the last link is dropped", names.join(", "));
            tell(report, Severity::Error, DiagnosticCode::TaskNestingCircle, &tasks[last].id.clone(), message);
        }
        chain.into_iter().for_each(|task| seen[task] = 2);
    }
}

/// Schedules and calendars of tasks (IfcRelAssignsToControl, IfcRelAssignsTasks), and times of IFC2X3.
pub(super) fn assign(
    context: &Context<'_, '_>,
    tasks: &mut [Task],
    controls: &[WorkControl],
    [control_idx, calendar_idx]: [&FxHashMap<u32, usize>; 2],
    report: &mut Report,
) {
    let file = context.file;
    // IfcRelAssignsTasks is one of them in IFC2X3.
    for relation in file.records("IfcRelAssignsToControl", report) {
        let members = relation.at(4).references().into_iter().filter_map(|id| context.task_idx.get(&id).copied());
        let members: Vec<usize> = members.collect();
        let control = relation.at(6).reference();
        let of_control = |index: &FxHashMap<u32, usize>| control.and_then(|id| index.get(&id).copied());
        let (schedule, calendar) = (of_control(control_idx), of_control(calendar_idx));
        if let Some(control) = control.filter(|id| !members.is_empty() && file.record(*id).is_none()) {
            let message = format!("it is assigned to #{}, which does not exist", file.written_id(control));
            tell(report, Severity::Error, DiagnosticCode::TaskControlDangling, &tasks[members[0]].id.clone(), message);
        }
        let time = file.attribute(&relation, "TimeForTask").reference();
        let time = time.map(|id| (id, file.short_record_of(id, "IFCSCHEDULETIMECONTROL")));
        for task in members {
            let task = &mut tasks[task];
            // A schedule says more than the plan that holds it.
            if task.control.is_none_or(|k| controls[k].is_plan) {
                task.control = schedule.or(task.control);
            }
            if let (Some(first), Some(second)) = (task.calendar, calendar)
                && first != second
            {
                let message = "it is assigned to two calendars; the first counts".to_owned();
                tell(report, Severity::Warning, DiagnosticCode::TaskCalendarTwice, &task.id, message);
            }
            task.calendar = task.calendar.or(calendar);
            match &time {
                Some((_, Some(time))) if task.time.is_none() => {
                    let time: TaskTime = times::time_control(context, time, &task.id, report);
                    task.time = Some(time);
                }
                Some((id, None)) => {
                    let message = format!("its time #{} is missing or no IfcScheduleTimeControl", file.written_id(*id));
                    tell(report, Severity::Error, DiagnosticCode::TaskTimeMissing, &task.id, message);
                }
                _ => {}
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::DurationType;
    use crate::testing::{file, file_of, read};

    fn codes(diagnostics: &[diagnostics::Diagnostic]) -> Vec<&'static str> {
        diagnostics.iter().map(|d| d.code.name()).filter(|c| c.starts_with("ta") || c.starts_with("time")).collect()
    }

    #[test]
    fn tasks_have_type_time_schedule_and_calendar() {
        let (model, diagnostics) = read(&file(
            "#1=IFCTASK('root',$,'Root',$,$,$,$,$,$,.F.,$,$,$);
             #2=IFCTASK('t',$,'Walls',$,'roomClosed','1.1',$,$,$,.T.,$,#3,.USERDEFINED.);
             #3=IFCTASKTIME($,$,$,.WORKTIME.,'P3D','2024-03-04T08:00:00',$,$,$,$,$,$,$,$,$,$,$,$,$,0.5);
             #4=IFCRELNESTS('n',$,$,$,#1,(#2));#5=IFCWORKSCHEDULE('w',$,'S',$,$,$,$,$,$,$,$,'2024-03-04',$,.PLANNED.);
             #6=IFCWORKCALENDAR('c',$,'C',$,$,$,$,$,.FIRSTSHIFT.);#7=IFCRELASSIGNSTOCONTROL('a',$,$,$,(#1),$,#5);
             #8=IFCRELASSIGNSTOCONTROL('b',$,$,$,(#2),$,#6);",
        ))
        .unwrap();
        let (root, walls) = (&model.schedule.tasks[0], &model.schedule.tasks[1]);
        assert_eq!((root.parent, root.control, root.calendar), (None, Some(0), None));
        assert_eq!((walls.parent, walls.control, walls.calendar), (Some(0), None, Some(0)));
        assert_eq!((walls.predefined_type.as_str(), walls.identification.as_str()), ("ROOMCLOSED", "1.1"));
        let time = walls.time.as_ref().unwrap();
        assert_eq!((time.duration_type, time.schedule_duration.as_str()), (DurationType::WorkTime, "P3D"));
        assert_eq!((time.schedule_start.as_str(), time.completion), ("2024-03-04T08:00:00", Some(0.5)));
        assert_eq!(model.schedule.controls[0].start, "2024-03-04");
        assert!(walls.is_milestone && codes(&diagnostics).is_empty());
    }

    #[test]
    fn the_type_of_a_task_may_be_that_of_its_type() {
        let (model, _) = read(&file(
            "#1=IFCTASK('t',$,'T',$,$,$,$,$,$,.F.,$,$,.NOTDEFINED.);
             #2=IFCTASKTYPE('y',$,$,$,$,$,$,$,$,.DEMOLITION.,$);#3=IFCRELDEFINESBYTYPE('r',$,$,$,(#1),#2);",
        ))
        .unwrap();
        assert_eq!(model.schedule.tasks[0].predefined_type, "DEMOLITION");
        let (old, _) = read(&file_of("IFC2X3", "#1=IFCMOVE('m',$,'M',$,$,'1',$,$,.F.,$,#9,#9,$);")).unwrap();
        assert_eq!(old.schedule.tasks[0].predefined_type, "MOVE");
    }

    #[test]
    fn time_controls_of_ifc2x3_count_the_time_unit_of_the_project() {
        let control = |unit: &str| {
            read(&file_of(
                "IFC2X3",
                &format!(
                    "#1=IFCTASK('t',$,'T',$,'Removal','1',$,$,.F.,$);#4=IFCRELASSIGNSTASKS('r',$,$,$,(#1),$,$,#5);
                     #5=IFCSCHEDULETIMECONTROL('c',$,$,$,$,$,$,$,$,$,$,$,$,2.,$,$,$,$,$,$,$,$,$,$);
                     #100=IFCPROJECT('p',$,$,$,$,$,$,$,#104);#104=IFCUNITASSIGNMENT((#105));{unit}"
                ),
            ))
            .unwrap()
        };
        let (model, _) = control("#105=IFCSIUNIT(*,.TIMEUNIT.,$,.SECOND.);");
        let task = &model.schedule.tasks[0];
        assert_eq!((task.predefined_type.as_str(), task.identification.as_str()), ("REMOVAL", "1"));
        assert_eq!(task.time.as_ref().unwrap().duration_type, DurationType::ElapsedTime);
        let duration = |unit: &str| {
            let (model, diagnostics) = control(unit);
            (model.schedule.tasks[0].time.clone().unwrap().schedule_duration, codes(&diagnostics))
        };
        let hour = "#105=IFCCONVERSIONBASEDUNIT($,.TIMEUNIT.,'HOUR',#106);#106=IFCMEASUREWITHUNIT(IFCREAL(3600.),#107);
            #107=IFCSIUNIT(*,.TIMEUNIT.,$,.SECOND.);";
        assert_eq!(duration(hour), ("PT7200S".to_owned(), vec![]));
        assert_eq!(
            duration("#105=IFCSIUNIT(*,.LENGTHUNIT.,$,.METRE.);"),
            ("PT2S".to_owned(), vec![]),
            "seconds are usual"
        );
        let unknown = "#105=IFCCONVERSIONBASEDUNIT($,.TIMEUNIT.,'SHIFT',$);";
        assert_eq!(duration(unknown), (String::new(), vec!["time_unit_unknown"]));
    }

    #[test]
    fn a_task_that_is_nested_in_itself_keeps_no_circle() {
        let (model, diagnostics) = read(&file(
            "#1=IFCTASK('a',$,'A',$,$,$,$,$,$,.F.,$,$,$);#2=IFCTASK('b',$,'B',$,$,$,$,$,$,.F.,$,$,$);
             #3=IFCRELNESTS('n',$,$,$,#1,(#2));#4=IFCRELNESTS('m',$,$,$,#2,(#1));",
        ))
        .unwrap();
        assert_eq!(model.schedule.tasks.iter().filter(|t| t.parent.is_some()).count(), 1);
        assert_eq!(codes(&diagnostics), ["task_nesting_circle"]);
    }

    #[test]
    fn missing_times_and_controls_are_named() {
        let (_, diagnostics) =
            read(&file("#1=IFCTASK('a',$,'A',$,$,$,$,$,$,.F.,$,#9,$);#2=IFCRELASSIGNSTOCONTROL('b',$,$,$,(#1),$,#8);"))
                .unwrap();
        assert_eq!(codes(&diagnostics), ["task_time_missing", "task_control_dangling"]);
        let named = |d: &&diagnostics::Diagnostic| d.entity.as_ref().is_some_and(|e| e.global_id == "a");
        assert_eq!(diagnostics.iter().filter(named).count(), 2);
    }
}
