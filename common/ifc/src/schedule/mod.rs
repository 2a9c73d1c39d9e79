//! Reads the schedule of a file: work schedules, tasks, times, sequences, calendars, product links.

mod calendars;
mod context;
mod links;
mod model;
mod sequences;
mod tasks;
mod times;

pub use model::{
    DurationType, Lag, LagValue, LinkTarget, Recurrence, RecurrenceType, Schedule, Sequence, SequenceType, Task,
    TaskLink, TaskTime, WorkCalendar, WorkControl, WorkTime,
};

use context::Context;
use rustc_hash::FxHashMap;

use crate::kernel::File;
use crate::products::{Products, named};
use crate::relations::Relations;
use crate::{Storey, units};
use diagnostics::Report;

/// Reads the schedule; nothing where there is none.
pub(crate) fn read(
    file: &File<'_>,
    relations: &Relations,
    products: &Products<'_, '_>,
    storeys: &[Storey],
    report: &mut Report,
) -> Schedule {
    let mut tasks = file.records("IfcTask", report);
    tasks.sort_by_cached_key(|task| tasks::place_in_plan(file, task));
    let task_idx = tasks.iter().enumerate().map(|(k, task)| (task.id, k)).collect();
    let task_ids = tasks.iter().map(|task| named(file, task)).collect();
    let context = Context { file, time_unit_s: units::seconds_per_time_unit(file), task_idx, task_ids };
    let (calendars, calendar_idx) = calendars::calendars(&context, report);
    let (controls, control_idx) = controls(&context, report);
    let mut read: Vec<Task> = tasks.iter().map(|task| tasks::task(&context, relations, task, report)).collect();
    tasks::nest(&context, &mut read, report);
    tasks::assign(&context, &mut read, &controls, [&control_idx, &calendar_idx], report);
    Schedule {
        sequences: sequences::sequences(&context, report),
        links: links::links(&context, relations, products, storeys, report),
        controls,
        calendars,
        tasks: read,
    }
}

/// IfcWorkPlan and IfcWorkSchedule, and where each is.
fn controls(context: &Context<'_, '_>, report: &mut Report) -> (Vec<WorkControl>, FxHashMap<u32, usize>) {
    let file = context.file;
    let mut controls = Vec::new();
    let mut control_idx = FxHashMap::default();
    let plans = file.records("IfcWorkPlan", report).into_iter().map(|record| (true, record));
    let schedules = file.records("IfcWorkSchedule", report).into_iter().map(|record| (false, record));
    let all: Vec<_> = plans.chain(schedules).collect();
    for (is_plan, record) in all {
        let kind =
            ["PredefinedType", "WorkControlType"].into_iter().find_map(|n| file.attribute(&record, n).enumeration());
        let id = named(file, &record);
        let mut date = |name: &str| times::date(file, file.attribute(&record, name), &id, report);
        let (start, finish) = (date("StartTime"), date("FinishTime"));
        control_idx.insert(record.id, controls.len());
        let predefined_type = kind.unwrap_or_default().to_ascii_uppercase();
        controls.push(WorkControl { id, is_plan, predefined_type, start, finish });
    }
    (controls, control_idx)
}
