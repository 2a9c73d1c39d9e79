//! Writes tasks of schedule files and their links as a work schedule.
//!
//! Each lag names the calendar in which the file counts it.

use crate::calendar_records::add_calendars;
use crate::file_findings::{add_findings, first_names, named};
use crate::link_rules::LinkRules;
use crate::links::{LinkOrigin, Links, Target};
use crate::schedule_file::ScheduleFile;
use crate::task_dates::{civil_date, date_records};
use crate::task_values::{all_tasks, is_work, task_ids, three_point_record};
use bytemuck::Zeroable;
use diagnostics::counted;
use messages::*;
use schedule_files::{
    Constraint, ConstraintKind, Dependency, DependencyKind, LagCalendar, PlanDate, PlanFile, PlanLag, PlanTask,
    PlanTaskKind,
};

/// The `tasks` archive of schedule files that were linked with a site by [`crate::link`].
pub fn tasks_of(site: &Site<'_>, plans: &[ScheduleFile], rules: &LinkRules, links: &Links) -> TasksBuilder {
    let mut builder = TasksBuilder::default();
    builder.head = TasksHead {
        site_hash: site.content_hash(),
        n_elements: site.elements.len() as u32,
        n_spaces: site.spaces.len() as u32,
        n_storeys: site.storeys.len() as u32,
        ..builder.head
    };
    let ids = task_ids(plans);
    let mut first_task = 0;
    for (source, plan) in (0..).zip(plans) {
        add_file(&mut builder, plan, source, first_task, &ids);
        first_task += plan.plan.tasks.len() as u32;
    }
    builder.schedule.dates.sort_by_key(|date| (date.kind.get(), date.owner));
    add_links(&mut builder, rules, links);
    let mut report = Report::default();
    report_links(&mut report, site, plans, rules, links, &ids);
    for diagnostic in report.finish() {
        builder.diagnostics.push(DiagnosticRecord::of(&diagnostic, &mut builder.texts));
    }
    builder
}

fn add_file(builder: &mut TasksBuilder, plan: &ScheduleFile, source: u32, first_task: u32, ids: &[String]) {
    let (file, sha256) = (builder.texts.add(&plan.file).into(), plan.sha256);
    let plan = &plan.plan;
    let written_by = builder.texts.add(&plan.written_by).into();
    builder.sources.push(ScheduleSourceRecord { file, written_by, sha256 });
    let first_control = builder.schedule.work_controls.len() as u32;
    let of_file = [(&plan.name, plan.start)];
    let of_projects: Vec<_> = plan.projects.iter().map(|project| (&project.name, project.start)).collect();
    for (name, start) in if of_projects.is_empty() { &of_file[..] } else { &of_projects } {
        let control = builder.schedule.work_controls.len() as u32;
        let record = |date| ScheduleDateRecord::new(civil_date(date), ScheduleDateKind::WorkStart, control);
        builder.schedule.dates.extend(start.map(record));
        builder.schedule.work_controls.push(WorkControlRecord {
            global_id: file,
            name: builder.texts.add(name).into(),
            predefined_type: ScheduleText::default(),
            start: ScheduleText::default(),
            finish: ScheduleText::default(),
            is_plan: 0,
            step_id: 0,
            source,
        });
    }
    let first_calendar = add_calendars(builder, &plan.calendars, source);
    let usual = plan.calendars.iter().position(|calendar| calendar.is_default);
    for (k, task) in plan.tasks.iter().enumerate() {
        let calendar = task.calendar.or(usual).map_or(NONE, |calendar| first_calendar + calendar as u32);
        let parent = task.parent.map_or(NONE, |parent| first_task + parent as u32);
        let at = first_task as usize + k;
        let (dates, duration) = date_records(task, at as u32);
        let has_time = duration.is_some() || !dates.is_empty();
        let record = TaskRecord {
            global_id: builder.texts.add(&ids[at]).into(),
            parent,
            control: if parent == NONE { first_control + task.project.unwrap_or(0) as u32 } else { NONE },
            calendar,
            source,
            ..task_record(builder, task, has_time)
        };
        builder.schedule.tasks.push(record);
        builder.schedule.dates.extend(dates);
        builder.schedule.durations.extend(duration);
        let three_point = three_point_record(task, at as u32).filter(TaskUncertaintyRecord::is_ascending);
        builder.schedule.uncertainties.extend(three_point);
        let firm = if plan.honours_constraints { constraint_flags::FIRM } else { 0 };
        let constraints = constraints_of(plan, task).into_iter();
        let record = |(kind, date)| constraint_record(kind, date, at as u32, firm);
        builder.schedule.constraints.extend(constraints.map(record));
        let work = task.assignments.iter().filter(|_| !task.is_inactive);
        builder.schedule.assignments.extend(work.map(|work| TaskAssignmentRecord {
            duration_s: work.length_s,
            task: at as u32,
            calendar: first_calendar + work.calendar as u32,
        }));
    }
    for dependency in &plan.dependencies {
        let record = SequenceRecord {
            predecessor: first_task + dependency.predecessor as u32,
            successor: first_task + dependency.successor as u32,
            source,
            ..sequence_record(plan, dependency, first_calendar)
        };
        builder.schedule.sequences.push(record);
    }
    add_findings(builder, plan, source, &ids[first_task as usize..]);
}

/// A task without its dates, which are records of their own.
fn task_record(builder: &mut TasksBuilder, task: &PlanTask, has_time: bool) -> TaskRecord {
    let mut flags = if task.kind == PlanTaskKind::Milestone { task_flags::MILESTONE } else { 0 };
    flags |= match task.kind {
        PlanTaskKind::Span => task_flags::SPAN,
        PlanTaskKind::WbsSummary => task_flags::SPAN | task_flags::WBS_SUMMARY,
        _ => 0,
    };
    flags |= if has_time { task_flags::HAS_TIME } else { 0 };
    flags |= if task.is_manual && !task.is_inactive { task_flags::MANUAL } else { 0 };
    let is_elapsed = task.duration.is_some_and(|d| d.is_elapsed);
    TaskRecord {
        name: builder.texts.add(&task.name).into(),
        identification: builder.texts.add(if task.code.is_empty() { &task.uid } else { &task.code }).into(),
        completion: task.complete.or(task.physical_complete).unwrap_or(-1.0),
        parent: NONE,
        control: NONE,
        calendar: NONE,
        duration_kind: if is_elapsed { DurationKind::ElapsedTime } else { DurationKind::WorkTime }.into(),
        flags,
        ..TaskRecord::zeroed()
    }
}

/// What binds a task, and the dates; a task that is scheduled by hand has deadlines alone, as in MS Project.
fn constraints_of(plan: &PlanFile, task: &PlanTask) -> Vec<(TaskConstraintKind, Option<PlanDate>)> {
    if task.is_inactive {
        return Vec::new();
    }
    let counts = |c: &&Constraint| !task.is_manual || c.kind == ConstraintKind::Deadline;
    let written = task.constraints.iter().filter(counts).map(|c| (constraint_kind(c.kind), c.date));
    let expected = plan.expected_finish_of(task).map(|date| (TaskConstraintKind::ExpectedFinish, Some(date)));
    written.chain(expected).collect()
}

fn constraint_kind(kind: ConstraintKind) -> TaskConstraintKind {
    match kind {
        ConstraintKind::AsLateAsPossible => TaskConstraintKind::AsLateAsPossible,
        ConstraintKind::MustStartOn => TaskConstraintKind::StartOn,
        ConstraintKind::MustFinishOn => TaskConstraintKind::FinishOn,
        ConstraintKind::StartNotEarlierThan => TaskConstraintKind::StartNotEarlierThan,
        ConstraintKind::StartNotLaterThan => TaskConstraintKind::StartNotLaterThan,
        ConstraintKind::FinishNotEarlierThan => TaskConstraintKind::FinishNotEarlierThan,
        ConstraintKind::FinishNotLaterThan => TaskConstraintKind::FinishNotLaterThan,
        ConstraintKind::MandatoryStart => TaskConstraintKind::MandatoryStart,
        ConstraintKind::MandatoryFinish => TaskConstraintKind::MandatoryFinish,
        ConstraintKind::Deadline => TaskConstraintKind::Deadline,
    }
}

/// What binds a task, with a flag that says whether its date goes before dependencies.
fn constraint_record(kind: TaskConstraintKind, date: Option<PlanDate>, task: u32, firm: u32) -> TaskConstraintRecord {
    let date = date.map(civil_date);
    TaskConstraintRecord {
        at_s: date.map_or(0, |date| date.at_s),
        offset_s: date.and_then(|date| date.offset_s).unwrap_or(TaskConstraintRecord::NO_OFFSET),
        task,
        kind: kind.into(),
        flags: firm | if date.is_some_and(|date| date.is_day) { constraint_flags::DAY } else { 0 },
    }
}

fn sequence_record(plan: &PlanFile, dependency: &Dependency, first_calendar: u32) -> SequenceRecord {
    let kind = match dependency.kind {
        DependencyKind::FinishStart => SequenceKind::FinishStart,
        DependencyKind::StartStart => SequenceKind::StartStart,
        DependencyKind::FinishFinish => SequenceKind::FinishFinish,
        DependencyKind::StartFinish => SequenceKind::StartFinish,
    };
    let (lag_s, lag_ratio, is_elapsed) = match dependency.lag {
        None => (0, 0.0, false),
        Some(PlanLag::Length(length)) => (length.seconds, 0.0, length.is_elapsed),
        Some(PlanLag::Ratio { ratio, is_elapsed }) => (0, ratio, is_elapsed),
    };
    let calendar = lag_calendar(plan, dependency);
    // Without a calendar there is no working time.
    let is_elapsed = is_elapsed || calendar.is_none();
    SequenceRecord {
        global_id: ScheduleText::default(),
        lag: ScheduleText::default(),
        lag_s,
        lag_ratio,
        predecessor: 0,
        successor: 0,
        kind: kind.into(),
        lag_kind: if is_elapsed { DurationKind::ElapsedTime } else { DurationKind::WorkTime }.into(),
        step_id: 0,
        source: 0,
        lag_calendar: calendar.filter(|_| !is_elapsed).map_or(NONE, |calendar| first_calendar + calendar as u32),
        flags: if plan.is_primavera { sequence_flags::PRIMAVERA } else { 0 },
        reserved: 0,
    }
}

/// Index of the calendar of the file in which a lag is counted.
fn lag_calendar(plan: &PlanFile, dependency: &Dependency) -> Option<usize> {
    let usual = || plan.calendars.iter().position(|calendar| calendar.is_default);
    let of_task = |task: usize| plan.tasks[task].calendar;
    let own = match plan.lag_calendar_of(dependency) {
        LagCalendar::Successor => of_task(dependency.successor),
        LagCalendar::Predecessor => of_task(dependency.predecessor),
        LagCalendar::Project => plan.project_calendar_of(&plan.tasks[dependency.successor]),
    };
    own.or_else(usual)
}

fn add_links(builder: &mut TasksBuilder, rules: &LinkRules, links: &Links) {
    for link in &links.links {
        let (kind, target) = match link.target {
            Target::Element(k) => (LinkKind::Element, k),
            Target::Space(k) => (LinkKind::Space, k),
        };
        builder.schedule.task_links.push(TaskLinkRecord {
            task: link.task as u32,
            kind: kind.into(),
            target,
            flags: link.effect.flag(),
        });
        let origin = match link.origin {
            LinkOrigin::Table(line) => builder.texts.add(&format!("table of links, line {line}")),
            LinkOrigin::Rule(rule) => builder.texts.add(&rules.rules[rule].name),
        };
        builder.link_rules.push(origin.into());
    }
}

/// Reports what was linked with nothing, and why.
fn report_links(
    report: &mut Report,
    site: &Site<'_>,
    plans: &[ScheduleFile],
    rules: &LinkRules,
    links: &Links,
    ids: &[String],
) {
    let tasks = all_tasks(plans);
    let mut add = |severity, code, task: Option<usize>, message: String| {
        let entity = task.map(|k| named(&ids[k], &tasks[k].task.name));
        let source = task.map(|k| tasks[k].file as u32);
        report.push(Diagnostic { severity, code, entity, source, message });
    };
    if links.links.is_empty() {
        let message = format!(
            "none of {} is linked to an element or space: the schedule changes no map; see [[link]] of the schedule rules",
            counted(tasks.len(), "task")
        );
        add(Severity::Error, DiagnosticCode::TasksWithoutLinks, None, message);
    }
    let mut linked = vec![false; tasks.len()];
    links.links.iter().for_each(|link| linked[link.task] = true);
    let is_work = is_work(&tasks, plans);
    let unlinked: Vec<usize> = (0..tasks.len()).filter(|k| is_work[*k] && !linked[*k]).collect();
    if !unlinked.is_empty() && !links.links.is_empty() {
        let (n, names) = (counted(unlinked.len(), "task"), first_names(&unlinked, ids));
        let message = format!("{n} without an element or space: {names}; they change no map");
        add(Severity::Warning, DiagnosticCode::TasksWithoutLinks, None, message);
    }
    for &(task, rule) in &links.untold_effects {
        let rule = &rules.rules[rule].name;
        let message = format!(
            "{rule}: no word of [link_words] tells what the task does with its elements; they stay as if it did not exist"
        );
        add(Severity::Warning, DiagnosticCode::LinkEffectUnknown, Some(task), message);
    }
    for (line, why) in &links.unmatched_rows {
        let message = format!("table of links, line {line}: {why}");
        add(Severity::Warning, DiagnosticCode::LinkRowUnmatched, None, message);
    }
    if !site.schedule.tasks.is_empty() {
        let n = counted(site.schedule.tasks.len(), "task");
        let message = format!("the models have a schedule of {n} too, which is not used: schedule files go before it");
        add(Severity::Warning, DiagnosticCode::ModelScheduleReplaced, None, message);
    }
}
