//! Sites with a schedule and no geometry.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]
#![allow(dead_code, reason = "every test file uses a part of this")]

use bytemuck::Zeroable;
use frames::PlanTime;
use messages::*;
use schedule::{EvaluateError, Overrides, Period, Probabilities, Rules, Timeline, evaluate, probabilities};

/// Civil seconds of a date.
pub(crate) fn at(text: &str) -> i64 {
    text.parse::<PlanTime>().unwrap().civil_seconds()
}

/// A date of civil seconds.
pub(crate) fn text(seconds: i64) -> String {
    plan_time(seconds).unwrap().to_string()
}

/// A site with a schedule, before it is written.
pub(crate) struct ScheduledSite {
    pub(crate) builder: SiteBuilder,
}

impl ScheduledSite {
    /// A file without anything.
    pub(crate) fn new() -> Self {
        let mut builder = SiteBuilder::default();
        let file = builder.texts.add("site.ifc");
        builder.sources.push(SourceRecord { file, ..SourceRecord::zeroed() });
        Self { builder }
    }

    /// A file with a work schedule that starts on Monday, 4 March 2024 at 08:00.
    pub(crate) fn starting() -> Self {
        let mut site = Self::new();
        let (global_id, start) = (site.text("schedule"), site.text("2024-03-04T08:00:00"));
        site.builder.schedule.work_controls.push(WorkControlRecord { global_id, start, ..WorkControlRecord::zeroed() });
        site
    }

    pub(crate) fn text(&mut self, text: &str) -> ScheduleText {
        self.builder.texts.add(text).into()
    }

    /// A task named and identified by `name`, in the work schedule if there is one.
    pub(crate) fn task(&mut self, name: &str) -> usize {
        let name = self.text(name);
        let control = if self.builder.schedule.work_controls.is_empty() { NONE } else { 0 };
        self.builder.schedule.tasks.push(TaskRecord {
            global_id: name,
            name,
            parent: NONE,
            control,
            calendar: NONE,
            completion: -1.0,
            ..TaskRecord::zeroed()
        });
        self.builder.schedule.tasks.len() - 1
    }

    /// A task with scheduled dates.
    pub(crate) fn dated(&mut self, name: &str, start: &str, finish: &str) -> usize {
        let (task, start, finish) = (self.task(name), self.text(start), self.text(finish));
        (self.builder.schedule.tasks[task].schedule_start, self.builder.schedule.tasks[task].schedule_finish) =
            (start, finish);
        task
    }

    /// A task that only lasts, in working time.
    pub(crate) fn lasting(&mut self, name: &str, duration: &str) -> usize {
        let (task, duration) = (self.task(name), self.text(duration));
        self.builder.schedule.tasks[task].schedule_duration = duration;
        self.builder.schedule.tasks[task].duration_kind = DurationKind::WorkTime.into();
        task
    }

    pub(crate) fn kind(&mut self, task: usize, kind: &str) {
        self.builder.schedule.tasks[task].predefined_type = self.text(kind);
    }

    pub(crate) fn nest(&mut self, whole: usize, parts: &[usize]) {
        parts.iter().for_each(|part| self.builder.schedule.tasks[*part].parent = whole as u32);
    }

    pub(crate) fn sequence(&mut self, predecessor: usize, successor: usize, kind: SequenceKind, lag: &str) -> usize {
        let lag = self.text(lag);
        self.builder.schedule.sequences.push(SequenceRecord {
            lag,
            predecessor: predecessor as u32,
            successor: successor as u32,
            kind: kind.into(),
            lag_kind: DurationKind::WorkTime.into(),
            lag_calendar: NONE,
            ..SequenceRecord::zeroed()
        });
        self.builder.schedule.sequences.len() - 1
    }

    /// Monday to Friday, 8 to 12 and 13 to 17, for these tasks.
    pub(crate) fn office_hours(&mut self, tasks: &[usize]) -> usize {
        let b = &mut self.builder;
        let first_period = b.schedule.periods_s.len() as u32;
        b.schedule.periods_s.extend([[8 * 3600, 12 * 3600], [13 * 3600, 17 * 3600]]);
        b.schedule.work_times.push(WorkTimeRecord {
            first_day: i32::MIN,
            last_day: i32::MAX,
            kind: RecurrenceKind::Weekly.into(),
            weekdays: 0b11_1110,
            interval: 1,
            first_period,
            n_periods: 2,
            ..WorkTimeRecord::zeroed()
        });
        let global_id = b.texts.add("calendar").into();
        let first_work_time = b.schedule.work_times.len() as u32 - 1;
        b.schedule.calendars.push(CalendarRecord {
            global_id,
            first_work_time,
            n_working: 1,
            ..CalendarRecord::zeroed()
        });
        let calendar = b.schedule.calendars.len() as u32 - 1;
        tasks.iter().for_each(|task| b.schedule.tasks[*task].calendar = calendar);
        calendar as usize
    }

    /// An element of this entity.
    pub(crate) fn element(&mut self, entity: &str) -> usize {
        let k = self.builder.elements.len();
        let global_id = self.builder.texts.add(&format!("element-{k}"));
        let supertypes = self.builder.texts.add_list([entity, "IfcElement"]);
        self.builder.elements.push(ElementRecord {
            global_id,
            supertypes,
            whole: NONE,
            storey: NONE,
            space: NONE,
            door: NONE,
            stair: NONE,
            ..ElementRecord::zeroed()
        });
        k
    }

    /// A space of this name.
    pub(crate) fn space(&mut self, name: &str) -> usize {
        let name = self.builder.texts.add(name);
        self.builder.spaces.push(SpaceRecord {
            global_id: name,
            name,
            map_storey: NONE,
            storey: NONE,
            ..SpaceRecord::zeroed()
        });
        self.builder.spaces.len() - 1
    }

    pub(crate) fn storey(&mut self) -> usize {
        self.builder.storeys.push(StoreyRecord { map_storey: NONE, ..StoreyRecord::zeroed() });
        self.builder.storeys.len() - 1
    }

    pub(crate) fn bounds(&mut self, space: usize, element: usize) {
        self.builder.boundaries.push(BoundaryRecord { space: space as u32, element: element as u32 });
    }

    pub(crate) fn link(&mut self, task: usize, kind: LinkKind, target: usize, flags: u32) {
        let record = TaskLinkRecord { task: task as u32, kind: kind.into(), target: target as u32, flags };
        self.builder.schedule.task_links.push(record);
    }

    pub(crate) fn builds(&mut self, task: usize, element: usize) {
        self.link(task, LinkKind::Element, element, 0);
    }

    /// A text property of an element; all of one element in one go.
    pub(crate) fn properties(&mut self, element: usize, properties: &[(&str, &str, &str)]) {
        let first = self.add_properties(properties);
        let record = &mut self.builder.elements[element];
        (record.first_attribute, record.n_attributes) = (first, properties.len() as u32);
    }

    pub(crate) fn space_properties(&mut self, space: usize, properties: &[(&str, &str, &str)]) {
        let first = self.add_properties(properties);
        let record = &mut self.builder.spaces[space];
        (record.first_attribute, record.n_attributes) = (first, properties.len() as u32);
    }

    fn add_properties(&mut self, properties: &[(&str, &str, &str)]) -> u32 {
        let first = self.builder.attributes.len() as u32;
        for (set, name, value) in properties {
            let [set, name, text] = [set, name, value].map(|t| self.builder.texts.add(t));
            let kind = AttributeKind::Text.into();
            self.builder.attributes.push(AttributeRecord { set, name, text, kind, ..AttributeRecord::zeroed() });
        }
        first
    }

    pub(crate) fn evaluate(&self) -> Timeline {
        self.evaluate_with(&Rules::default(), &Overrides::default()).unwrap()
    }

    pub(crate) fn ruled(&self, rules: &str) -> Timeline {
        self.evaluate_with(&Rules::parse(rules).unwrap(), &Overrides::default()).unwrap()
    }

    pub(crate) fn evaluate_with(&self, rules: &Rules, overrides: &Overrides) -> Result<Timeline, EvaluateError> {
        let site = self.builder.finish();
        evaluate(&Site::open(site.bytes()).unwrap(), rules, overrides)
    }

    /// What is certain about the site by these rules.
    pub(crate) fn with_probabilities<T>(
        &self,
        rules: &str,
        overrides: &Overrides,
        look: impl FnOnce(&Timeline, &Probabilities<'_>) -> T,
    ) -> T {
        let site = self.builder.finish();
        let (site, rules) = (Site::open(site.bytes()).unwrap(), Rules::parse(rules).unwrap());
        let timeline = evaluate(&site, &rules, overrides).unwrap();
        look(&timeline, &probabilities(&site, &rules, overrides, &timeline).unwrap())
    }

    /// Three-point durations of a task in hours of its working time.
    pub(crate) fn three_point_h(&mut self, task: usize, [optimistic_h, likely_h, pessimistic_h]: [i64; 3]) {
        self.builder.schedule.uncertainties.push(TaskUncertaintyRecord {
            duration_optimistic_s: optimistic_h * 3600,
            duration_likely_s: likely_h * 3600,
            duration_pessimistic_s: pessimistic_h * 3600,
            task: task as u32,
            is_elapsed: 0,
        });
    }

    /// The schedule state of a timeline, opened.
    pub(crate) fn schedule_state<T>(
        timeline: &Timeline,
        period: Period,
        look: impl FnOnce(&ScheduleState<'_>) -> T,
    ) -> T {
        let schedule_state = timeline.schedule_state(period).finish();
        look(&ScheduleState::open(schedule_state.bytes()).unwrap())
    }
}

/// Start and finish of a task.
pub(crate) fn dates(timeline: &Timeline, task: usize) -> Option<(String, String)> {
    timeline.task(task).map(|d| (text(d.start_s), text(d.finish_s)))
}

/// The first diagnostic of a code.
pub(crate) fn diagnostic<'t>(timeline: &'t Timeline, code: &str) -> Option<&'t Diagnostic> {
    timeline.diagnostics().iter().find(|f| f.code.name() == code)
}

/// Names of the states of an element over time.
pub(crate) fn states(timeline: &Timeline, element: usize, instants: &[&str]) -> Vec<&'static str> {
    instants.iter().map(|t| timeline.element(element, at(t)).name()).collect()
}
