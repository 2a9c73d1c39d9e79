//! Records of a work schedule, in the `site` and `tasks` archives.
//!
//! Dates and durations of models are texts in ISO 8601, as `ifc::TaskTime` says; those of planners' files are typed, and their texts
//! are empty: see [`crate::ScheduleDateRecord`].

use crate::Text;
use crate::tag::Tag;
use bytemuck::{CheckedBitPattern, NoUninit, Pod, Zeroable};

/// A text of a work schedule: it lies in the archive of the schedule, which need not be that of the site.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Zeroable, Pod)]
#[repr(transparent)]
pub struct ScheduleText(pub Text);

impl From<Text> for ScheduleText {
    fn from(text: Text) -> Self {
        Self(text)
    }
}

/// A schedule file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Zeroable, Pod)]
#[repr(C)]
pub struct ScheduleSourceRecord {
    /// Base name.
    pub file: ScheduleText,
    /// Name and version of the program that wrote it, as the file says; empty if it does not.
    pub written_by: ScheduleText,
    /// sha256 of the file's bytes.
    pub sha256: [u8; 32],
}
const _: () = assert!(size_of::<ScheduleSourceRecord>() == 48);

/// An IfcWorkPlan or IfcWorkSchedule.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Zeroable, Pod)]
#[repr(C)]
pub struct WorkControlRecord {
    /// STEP id in its file.
    pub step_id: u64,
    /// GlobalId.
    pub global_id: ScheduleText,
    /// Name.
    pub name: ScheduleText,
    /// PredefinedType, e.g. `PLANNED`.
    pub predefined_type: ScheduleText,
    /// StartTime.
    pub start: ScheduleText,
    /// FinishTime.
    pub finish: ScheduleText,
    /// 1 for IfcWorkPlan, 0 for IfcWorkSchedule.
    pub is_plan: u32,
    /// Index of its file.
    pub source: u32,
}
const _: () = assert!(size_of::<WorkControlRecord>() == 56);

/// An IfcWorkCalendar.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Zeroable, Pod)]
#[repr(C)]
pub struct CalendarRecord {
    /// STEP id in its file.
    pub step_id: u64,
    /// GlobalId.
    pub global_id: ScheduleText,
    /// Name.
    pub name: ScheduleText,
    /// First of its work times: those of work, then the exceptions.
    pub first_work_time: u32,
    /// Number of work times in which work goes on.
    pub n_working: u32,
    /// Number of exceptions behind them.
    pub n_exceptions: u32,
    /// Index of its file.
    pub source: u32,
}
const _: () = assert!(size_of::<CalendarRecord>() == 40);

/// An IfcWorkTime with its pattern. Bit `n` of a mask stands for day, weekday (1 is Monday) or month `n`; 0 means all.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Zeroable, Pod)]
#[repr(C)]
pub struct WorkTimeRecord {
    /// First day it applies to, in days since 1970-01-01; `i32::MIN` without a limit.
    pub first_day: i32,
    /// Last day it applies to; `i32::MAX` without a limit.
    pub last_day: i32,
    /// On which days.
    pub kind: Tag<RecurrenceKind>,
    /// DayComponent.
    pub days_of_month: u32,
    /// WeekdayComponent.
    pub weekdays: u32,
    /// MonthComponent.
    pub months: u32,
    /// Position; 0 if absent.
    pub position: i32,
    /// Interval, at least 1.
    pub interval: u32,
    /// Occurrences; 0 if absent.
    pub occurrences: u32,
    /// First of its periods.
    pub first_period: u32,
    /// Number of its periods: `[from, to)` in seconds of the day; none: all day long.
    pub n_periods: u32,
    /// Zero.
    pub reserved: u32,
}
const _: () = assert!(size_of::<WorkTimeRecord>() == 48);

/// IfcRecurrenceTypeEnum, and nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, CheckedBitPattern, NoUninit)]
#[repr(u32)]
#[expect(missing_docs, reason = "the names are the schema's")]
pub enum RecurrenceKind {
    /// Without a pattern: every day, all day long.
    Always = 0,
    Daily = 1,
    Weekly = 2,
    MonthlyByDayOfMonth = 3,
    MonthlyByPosition = 4,
    ByDayCount = 5,
    ByWeekdayCount = 6,
    YearlyByDayOfMonth = 7,
    YearlyByPosition = 8,
}

/// An IfcTask with its time.
#[derive(Debug, Clone, Copy, PartialEq, Zeroable, Pod)]
#[repr(C)]
pub struct TaskRecord {
    /// GlobalId.
    pub global_id: ScheduleText,
    /// Name.
    pub name: ScheduleText,
    /// Identification.
    pub identification: ScheduleText,
    /// PredefinedType in capitals, ObjectType where that says USERDEFINED.
    pub predefined_type: ScheduleText,
    /// ScheduleDuration.
    pub schedule_duration: ScheduleText,
    /// ScheduleStart.
    pub schedule_start: ScheduleText,
    /// ScheduleFinish.
    pub schedule_finish: ScheduleText,
    /// EarlyStart.
    pub early_start: ScheduleText,
    /// EarlyFinish.
    pub early_finish: ScheduleText,
    /// LateStart.
    pub late_start: ScheduleText,
    /// LateFinish.
    pub late_finish: ScheduleText,
    /// ActualStart.
    pub actual_start: ScheduleText,
    /// ActualFinish.
    pub actual_finish: ScheduleText,
    /// Completion from 0 to 1; -1 if absent.
    pub completion: f64,
    /// STEP id in its file.
    pub step_id: u64,
    /// Task it is nested in, or `NONE`; no task is its own ancestor.
    pub parent: u32,
    /// Work schedule that controls it directly, or `NONE`.
    pub control: u32,
    /// Calendar that it is assigned to directly, or `NONE`.
    pub calendar: u32,
    /// How ScheduleDuration is counted.
    pub duration_kind: Tag<DurationKind>,
    /// Bits of [`task_flags`].
    pub flags: u32,
    /// Index of its file.
    pub source: u32,
}
const _: () = assert!(size_of::<TaskRecord>() == 144);

/// Bits of [`TaskRecord::flags`].
pub mod task_flags {
    /// IsMilestone.
    pub const MILESTONE: u32 = 1;
    /// The file has a time for it.
    pub const HAS_TIME: u32 = 2;
    /// It spans others and has no others nested in it: level of effort, hammock, WBS summary.
    pub const SPAN: u32 = 4;
    /// It is scheduled by hand: what it depends on does not move it.
    pub const MANUAL: u32 = 16;
    /// It is a span of all tasks that are nested in the same task, and in these: WBS summary of Primavera P6.
    pub const WBS_SUMMARY: u32 = 8;
}

/// How a duration is counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, CheckedBitPattern, NoUninit)]
#[repr(u32)]
pub enum DurationKind {
    /// The file does not say.
    NotDefined = 0,
    /// In working time.
    WorkTime = 1,
    /// On the clock.
    ElapsedTime = 2,
}

/// An IfcRelSequence.
#[derive(Debug, Clone, Copy, PartialEq, Zeroable, Pod)]
#[repr(C)]
pub struct SequenceRecord {
    /// GlobalId.
    pub global_id: ScheduleText,
    /// Lag as a duration; empty if there is none, or one in seconds, or a ratio.
    pub lag: ScheduleText,
    /// Lag of a planner's file in seconds; 0 if there is none, or a text, or a ratio.
    pub lag_s: i64,
    /// Lag as a part of the predecessor's duration; 0 if it is none.
    pub lag_ratio: f64,
    /// STEP id in its file.
    pub step_id: u64,
    /// Task.
    pub predecessor: u32,
    /// Task.
    pub successor: u32,
    /// Which ends of the two tasks it joins.
    pub kind: Tag<SequenceKind>,
    /// How the lag is counted.
    pub lag_kind: Tag<DurationKind>,
    /// Index of its file.
    pub source: u32,
    /// Calendar in whose working time the lag is counted, or `NONE`: that of the successor.
    pub lag_calendar: u32,
    /// Bits of [`sequence_flags`].
    pub flags: u32,
    /// Zero.
    pub reserved: u32,
}
const _: () = assert!(size_of::<SequenceRecord>() == 72);

/// Bits of [`SequenceRecord::flags`].
pub mod sequence_flags {
    /// What it asks for is worked out as in Primavera P6: the instant that it asks of a finish stands, and a start with a start is in the
    /// working time in which its lag would be counted.
    pub const PRIMAVERA: u32 = 1;
}

/// How two tasks depend on each other: which end of the predecessor bounds which end of the successor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, CheckedBitPattern, NoUninit)]
#[repr(u32)]
#[expect(missing_docs, reason = "the names are the schema's")]
pub enum SequenceKind {
    StartStart = 1,
    StartFinish = 2,
    FinishStart = 3,
    FinishFinish = 4,
}

/// A task works on something.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Zeroable, Pod)]
#[repr(C)]
pub struct TaskLinkRecord {
    /// The task.
    pub task: u32,
    /// What it works on.
    pub kind: Tag<LinkKind>,
    /// Element, space or storey.
    pub target: u32,
    /// Bits of [`link_flags`].
    pub flags: u32,
}
const _: () = assert!(size_of::<TaskLinkRecord>() == 16);

/// What a task works on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, CheckedBitPattern, NoUninit)]
#[repr(u32)]
pub enum LinkKind {
    /// An element.
    Element = 1,
    /// A space.
    Space = 2,
    /// All of a storey.
    Storey = 3,
}

/// Bits of [`TaskLinkRecord::flags`].
pub mod link_flags {
    /// The product goes into the task (IfcRelAssignsToProcess); otherwise it comes out of it.
    pub const INPUT: u32 = 1;
    /// The file links a building or site that holds the target.
    pub const FROM_ABOVE: u32 = 2;
    /// The link itself says what the task does, whatever the task's type is: it builds the target ..
    pub const BUILDS: u32 = 4;
    /// .. removes it ..
    pub const REMOVES: u32 = 8;
    /// .. works in its spaces and leaves it as it is ..
    pub const WORKS_IN: u32 = 16;
    /// .. or uses it: it stands from the start of the task until its finish.
    pub const USES: u32 = 32;
}

/// How long a task may take: three-point durations, ascending.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Zeroable, Pod)]
#[repr(C)]
pub struct TaskUncertaintyRecord {
    /// Shortest duration, in seconds; at least 0.
    pub duration_optimistic_s: i64,
    /// Most likely duration.
    pub duration_likely_s: i64,
    /// Longest duration.
    pub duration_pessimistic_s: i64,
    /// The task; no task has two of these records.
    pub task: u32,
    /// 1 if the durations are on the clock, 0 if they are working time of the task's calendar.
    pub is_elapsed: u32,
}
const _: () = assert!(size_of::<TaskUncertaintyRecord>() == 32);

impl TaskUncertaintyRecord {
    /// Longest duration that is accepted: ten thousand years.
    pub const MAX_DURATION_S: i64 = 10_000 * 366 * 86_400;

    /// True if the durations ascend from 0 to [`Self::MAX_DURATION_S`].
    pub fn is_ascending(&self) -> bool {
        let Self { duration_optimistic_s, duration_likely_s, duration_pessimistic_s, .. } = *self;
        0 <= duration_optimistic_s
            && duration_optimistic_s <= duration_likely_s
            && duration_likely_s <= duration_pessimistic_s
            && duration_pessimistic_s <= Self::MAX_DURATION_S
    }
}

/// Work of resources on a task by one calendar; the task ends with the last of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Zeroable, Pod)]
#[repr(C)]
pub struct TaskAssignmentRecord {
    /// How long it takes in working time of the calendar, in seconds; more than 0.
    pub duration_s: i64,
    /// The task; its own calendar and duration say nothing of it.
    pub task: u32,
    /// The calendar.
    pub calendar: u32,
}
const _: () = assert!(size_of::<TaskAssignmentRecord>() == 16);

/// A date that binds a task.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Zeroable, Pod)]
#[repr(C)]
pub struct TaskConstraintRecord {
    /// The date in civil seconds since 1970, on the clock of its offset; 0 for [`TaskConstraintKind::AsLateAsPossible`].
    pub at_s: i64,
    /// Its offset to UTC in seconds, or [`Self::NO_OFFSET`]: it is of the site's clock.
    pub offset_s: i32,
    /// The task; it may have several.
    pub task: u32,
    /// What is bound.
    pub kind: Tag<TaskConstraintKind>,
    /// Bits of [`constraint_flags`].
    pub flags: u32,
}
const _: () = assert!(size_of::<TaskConstraintRecord>() == 24);

impl TaskConstraintRecord {
    /// A date without an offset.
    pub const NO_OFFSET: i32 = i32::MIN;

    /// True if the date is within ten thousand years of 1970.
    pub fn is_in_calendar(&self) -> bool {
        self.at_s.unsigned_abs() <= TaskUncertaintyRecord::MAX_DURATION_S.unsigned_abs()
    }
}

/// Bits of [`TaskConstraintRecord::flags`].
pub mod constraint_flags {
    /// The date has no time of day: a start is its midnight, a finish its end.
    pub const DAY: u32 = 1;
    /// The date goes before dependencies, as in MS Project unless told otherwise.
    pub const FIRM: u32 = 2;
}

/// How a date binds a task.
#[derive(Debug, Clone, Copy, PartialEq, Eq, CheckedBitPattern, NoUninit)]
#[repr(u32)]
#[expect(missing_docs, reason = "the names are those of the products")]
pub enum TaskConstraintKind {
    AsLateAsPossible = 1,
    StartOn = 2,
    FinishOn = 3,
    StartNotEarlierThan = 4,
    StartNotLaterThan = 5,
    FinishNotEarlierThan = 6,
    FinishNotLaterThan = 7,
    /// It goes before dependencies, always.
    MandatoryStart = 8,
    /// It goes before dependencies, always.
    MandatoryFinish = 9,
    /// It moves nothing: a finish after it is told.
    Deadline = 10,
    /// It finishes then, however long that takes, if it has begun by then and no predecessor decides its finish.
    ExpectedFinish = 11,
}
