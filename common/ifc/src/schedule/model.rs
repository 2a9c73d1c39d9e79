//! Schedule types; dates and durations stay texts, because their interpretation is configuration.

use diagnostics::Named;

/// The schedule of a file. Tasks are in the order of their starts, Identifications and GlobalIds, calendars and sequences in
/// that of their GlobalIds.
#[derive(Debug, Default, PartialEq)]
pub struct Schedule {
    /// IfcWorkPlan, then IfcWorkSchedule.
    pub controls: Vec<WorkControl>,
    /// IfcWorkCalendar.
    pub calendars: Vec<WorkCalendar>,
    /// IfcTask.
    pub tasks: Vec<Task>,
    /// IfcRelSequence between two tasks that exist.
    pub sequences: Vec<Sequence>,
    /// Which tasks work on what; a pair that is linked in both directions is here twice.
    pub links: Vec<TaskLink>,
}

/// An IfcWorkPlan or IfcWorkSchedule.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct WorkControl {
    /// Identity.
    pub id: Named,
    /// True for IfcWorkPlan.
    pub is_plan: bool,
    /// PredefinedType (WorkControlType in IFC2X3), e.g. `PLANNED`; empty if absent.
    pub predefined_type: String,
    /// StartTime, as [`TaskTime::schedule_start`].
    pub start: String,
    /// FinishTime.
    pub finish: String,
}

/// An IfcTask.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Task {
    /// Identity.
    pub id: Named,
    /// Identification (TaskId in IFC2X3); empty if absent.
    pub identification: String,
    /// PredefinedType in capitals, else that of its type; ObjectType in capitals where that says USERDEFINED, and in IFC2X3
    /// (`MOVE` for an IfcMove without one); empty if absent.
    /// `USERDEFINED` where no ObjectType says more.
    pub predefined_type: String,
    /// IsMilestone.
    pub is_milestone: bool,
    /// Index of the task it is nested in.
    pub parent: Option<usize>,
    /// Index of the work schedule that controls it directly.
    pub control: Option<usize>,
    /// Index of the calendar that it is assigned to directly.
    pub calendar: Option<usize>,
    /// TaskTime, or IfcScheduleTimeControl of its IfcRelAssignsTasks.
    pub time: Option<TaskTime>,
}

/// Kind of time in which a duration or lag is counted.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum DurationType {
    /// In the working time of a calendar.
    WorkTime,
    /// On the clock.
    ElapsedTime,
    /// The file does not say.
    #[default]
    NotDefined,
}

/// An IfcTaskTime or IfcScheduleTimeControl. Dates are ISO 8601 texts as the file has them, those of IFC2X3 are written as such:
/// `2024-03-04` for an IfcCalendarDate, `2024-03-04T08:00:00` with `+01:00` where a zone is given for an IfcDateAndTime.
/// Durations are ISO 8601 texts, those of IFC2X3 `PT28800S`. Empty if absent.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TaskTime {
    /// DurationType; ElapsedTime for IFC2X3.
    pub duration_type: DurationType,
    /// ScheduleDuration.
    pub schedule_duration: String,
    /// ScheduleStart.
    pub schedule_start: String,
    /// ScheduleFinish.
    pub schedule_finish: String,
    /// EarlyStart.
    pub early_start: String,
    /// EarlyFinish.
    pub early_finish: String,
    /// LateStart.
    pub late_start: String,
    /// LateFinish.
    pub late_finish: String,
    /// ActualStart.
    pub actual_start: String,
    /// ActualFinish.
    pub actual_finish: String,
    /// Completion, from 0 to 1.
    pub completion: Option<f64>,
}

/// IfcRelSequence.
#[derive(Debug, Clone, PartialEq)]
pub struct Sequence {
    /// Identity.
    pub id: Named,
    /// Index of RelatingProcess.
    pub predecessor: usize,
    /// Index of RelatedProcess.
    pub successor: usize,
    /// SequenceType.
    pub kind: SequenceType,
    /// TimeLag.
    pub lag: Option<Lag>,
}

/// Kind of dependency of two tasks.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum SequenceType {
    /// Starts when the predecessor starts.
    StartStart,
    /// Finishes when the predecessor starts.
    StartFinish,
    /// Starts when the predecessor finishes; also where the file does not say.
    #[default]
    FinishStart,
    /// Finishes when the predecessor finishes.
    FinishFinish,
}

/// IfcLagTime, or the TimeLag of IFC2X3.
#[derive(Debug, Clone, PartialEq)]
pub struct Lag {
    /// How much.
    pub value: LagValue,
    /// DurationType; ElapsedTime for IFC2X3.
    pub duration_type: DurationType,
}

/// Lag of a successor.
#[derive(Debug, Clone, PartialEq)]
pub enum LagValue {
    /// An ISO 8601 duration as the file has it; that of IFC2X3 is written as `PT28800S` or `-PT28800S`.
    Duration(String),
    /// A part of the predecessor's duration.
    Ratio(f64),
}

/// A task works on something.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TaskLink {
    /// Index of the task.
    pub task: usize,
    /// On what.
    pub target: LinkTarget,
    /// True for IfcRelAssignsToProcess (the product goes in), false for IfcRelAssignsToProduct (it comes out).
    pub is_input: bool,
    /// True if the file links a building or site that holds the target.
    pub from_above: bool,
}

/// Target of a task, by its index in [`crate::Model`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum LinkTarget {
    /// An element.
    Element(usize),
    /// A space.
    Space(usize),
    /// Everything on a storey.
    Storey(usize),
}

/// An IfcWorkCalendar.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct WorkCalendar {
    /// Identity.
    pub id: Named,
    /// WorkingTimes: when work goes on.
    pub working: Vec<WorkTime>,
    /// ExceptionTimes: when it does not.
    pub exceptions: Vec<WorkTime>,
}

/// An IfcWorkTime.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct WorkTime {
    /// First day it applies to, as `[year, month, day]`; `None` without a limit.
    pub first_day: Option<[i32; 3]>,
    /// Last day it applies to.
    pub last_day: Option<[i32; 3]>,
    /// RecurrencePattern; without one every day counts, all day long.
    pub recurrence: Option<Recurrence>,
}

/// An IfcRecurrencePattern.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Recurrence {
    /// RecurrenceType.
    pub kind: RecurrenceType,
    /// DayComponent: days of the month, from 1.
    pub days_of_month: Vec<u32>,
    /// WeekdayComponent: 1 is Monday.
    pub weekdays: Vec<u32>,
    /// MonthComponent: 1 is January.
    pub months: Vec<u32>,
    /// Position: the n-th of its kind in the month, negative from the end.
    pub position: Option<i32>,
    /// Interval: every n-th; 1 if absent.
    pub interval: u32,
    /// Occurrences: how often at all.
    pub occurrences: Option<u32>,
    /// TimePeriods as seconds of the day; empty: all day long. An end that is not after its start lies on the next day.
    pub periods_s: Vec<[u32; 2]>,
}

/// IfcRecurrenceTypeEnum.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[expect(missing_docs, reason = "the names are the schema's")]
pub enum RecurrenceType {
    #[default]
    Daily,
    Weekly,
    MonthlyByDayOfMonth,
    MonthlyByPosition,
    ByDayCount,
    ByWeekdayCount,
    YearlyByDayOfMonth,
    YearlyByPosition,
}
