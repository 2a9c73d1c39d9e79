//! Progress of the tasks of schedule files, as a robot's map and reports show it, for the planner.
//!
//! A task that builds has done its work on an element that stands, also beside its place, or is reported as finished; one that
//! removes, on an element that is absent. Other tasks leave nothing to see. Parts without a task of their own count for that of
//! their whole.

use super::input::DeviationExport;
use crate::csv::quoted;
use crate::provenance::schedule_file;
use messages::{DateSource, LinkKind, NONE, Observation, ScheduleDate, ScheduleDateKind, link_flags, plan_time};
use std::collections::BTreeMap;
use std::fmt::Write;

/// Progress of a task.
#[derive(Debug, Clone, PartialEq)]
pub struct TaskProgress {
    /// Index of the task.
    pub task: usize,
    /// Elements with a body that it builds or removes; 0 for tasks that leave nothing to see.
    pub elements: usize,
    /// Of these: on which it has done its work.
    pub done: usize,
    /// Of these: of which nothing is known.
    pub unseen: usize,
    /// When it began, at the latest, as `YYYY-MM-DDTHH:MM:SS`.
    pub actual_start: Option<ProgressDate>,
    /// When it was done; none unless all of its elements are.
    pub actual_finish: Option<ProgressDate>,
}

/// A date with its source.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct ProgressDate {
    /// `YYYY-MM-DDTHH:MM:SS`.
    pub at: String,
    /// `plan`: its file has it; `reported`: an element's progress was reported; `seen`: the plan time of the comparison, as a bound.
    pub from: &'static str,
}

impl TaskProgress {
    /// Share that is done in whole per cent, rounded down; `None` for tasks that leave nothing to see.
    pub fn percent(&self) -> Option<usize> {
        (self.elements > 0).then(|| self.done * 100 / self.elements)
    }

    /// Progress of all tasks of schedule files, by task; empty where the schedule is that of the models.
    pub fn all(input: &DeviationExport<'_>) -> Vec<Self> {
        let schedule = &input.site.schedule;
        if schedule.sources.is_empty() {
            return Vec::new();
        }
        let none = |task| Self { task, elements: 0, done: 0, unseen: 0, actual_start: None, actual_finish: None };
        let mut all: Vec<Self> = (0..schedule.tasks.len()).map(none).collect();
        let mut last_finish: Vec<Option<ProgressDate>> = vec![None; all.len()];
        let observed: BTreeMap<u32, Observation> =
            input.deviations.elements.iter().map(|record| (record.element, record.observation.get())).collect();
        let by_element = links_by_element(input);
        for element in (0..input.site.elements.len()).filter(|k| input.site.elements[*k].n_parts > 0) {
            for (task, removes) in links_of(input, &by_element, element) {
                let work = ElementWork::of(input, element, observed.get(&(element as u32)).copied(), removes);
                let progress = &mut all[task];
                progress.elements += 1;
                progress.done += usize::from(work.is_done);
                progress.unseen += usize::from(work.is_unseen);
                progress.actual_start = earliest(progress.actual_start.take(), work.begun);
                last_finish[task] = last_finish[task].take().max(work.done);
            }
        }
        for (progress, finish) in all.iter_mut().zip(last_finish) {
            let written = |kind| {
                let at = written(schedule.date(kind, progress.task)?)?;
                Some(ProgressDate { at, from: "plan" })
            };
            let is_done = progress.elements > 0 && progress.done == progress.elements;
            let actual_finish = written(ScheduleDateKind::ActualFinish).or(finish.filter(|_| is_done));
            progress.actual_start = written(ScheduleDateKind::ActualStart).or(progress.actual_start.take());
            progress.actual_finish = actual_finish;
        }
        all
    }
}

/// What is known of a task's work on an element.
struct ElementWork {
    is_done: bool,
    is_unseen: bool,
    begun: Option<ProgressDate>,
    done: Option<ProgressDate>,
}

impl ElementWork {
    fn of(input: &DeviationExport<'_>, element: usize, observed: Option<Observation>, removes: bool) -> Self {
        let seen_s = input.deviations.head.plan_time_s;
        let seen = plan_time(seen_s).map(|at| ProgressDate { at: at.to_string(), from: "seen" });
        let record = input.schedule_state.schedule_of(element);
        let reported = |at_s: i64| {
            let is_past = record.source == DateSource::Reported && !removes && at_s <= seen_s;
            plan_time(at_s).filter(|_| is_past).map(|at| ProgressDate { at: at.to_string(), from: "reported" })
        };
        let (begun, finished) = (reported(record.start_s), reported(record.finish_s));
        let is_seen_done = match observed {
            Some(Observation::Observed | Observation::Displaced) => !removes,
            Some(Observation::Absent) => removes,
            Some(Observation::Unseen) | None => false,
        };
        let is_done = is_seen_done || finished.is_some();
        Self {
            is_done,
            is_unseen: !is_done && matches!(observed, Some(Observation::Unseen) | None),
            begun: begun.or_else(|| finished.clone()).or_else(|| seen.clone().filter(|_| is_seen_done)),
            done: finished.or(seen.filter(|_| is_seen_done)),
        }
    }
}

/// Tasks that build or remove each element, and whether they remove it.
fn links_by_element(input: &DeviationExport<'_>) -> BTreeMap<u32, Vec<(usize, bool)>> {
    let mut by_element: BTreeMap<u32, Vec<(usize, bool)>> = BTreeMap::new();
    for link in input.site.schedule.task_links.iter().filter(|link| link.kind == LinkKind::Element) {
        let removes = link.flags & link_flags::REMOVES != 0;
        if removes || link.flags & link_flags::BUILDS != 0 {
            by_element.entry(link.target).or_default().push((link.task as usize, removes));
        }
    }
    by_element
}

/// Those of an element, or of what it is a part of.
fn links_of(
    input: &DeviationExport<'_>,
    by_element: &BTreeMap<u32, Vec<(usize, bool)>>,
    element: usize,
) -> Vec<(usize, bool)> {
    // Wholes that are parts of themselves end after a round.
    let whole = |k: &u32| Some(input.site.elements[*k as usize].whole).filter(|whole| *whole != NONE);
    let mut wholes = std::iter::successors(Some(element as u32), whole).take(64);
    wholes.find_map(|k| by_element.get(&k)).cloned().unwrap_or_default()
}

fn earliest(a: Option<ProgressDate>, b: Option<ProgressDate>) -> Option<ProgressDate> {
    [a, b].into_iter().flatten().min()
}

/// A date of a planner's file as a date and a time at the site; an offset is left out, because planners' tools have none.
fn written(date: ScheduleDate<'_>) -> Option<String> {
    match date {
        ScheduleDate::Civil(date) => plan_time(date.at_s).map(|at| at.to_string()),
        // Texts are those of models, whose tasks are no rows of these tables.
        ScheduleDate::Text(_) => None,
    }
}

/// `progress.csv`: one line for each task. Cells stay empty where nothing is known.
pub(super) fn table(input: &DeviationExport<'_>, all: &[TaskProgress]) -> String {
    let mut out = "task,name,file,complete_percent,elements,done,unseen,actual_start,actual_start_from,actual_finish,\
                   actual_finish_from,seen\n"
        .to_owned();
    let schedule = &input.site.schedule;
    let seen = plan_time(input.deviations.head.plan_time_s).map_or(String::new(), |at| at.to_string());
    for progress in all {
        let record = &schedule.tasks[progress.task];
        let [id, name] = [record.global_id, record.name].map(|text| quoted(schedule.text(text)));
        let file = quoted(schedule_file(input.site, record).unwrap_or_default());
        let percent = progress.percent().map_or(String::new(), |percent| percent.to_string());
        let [start, finish] = [&progress.actual_start, &progress.actual_finish]
            .map(|date| date.as_ref().map_or(",".to_owned(), |date| format!("{},{}", date.at, date.from)));
        let TaskProgress { elements, done, unseen, .. } = progress;
        // Writing to a string does not fail.
        let _ = writeln!(out, "{id},{name},{file},{percent},{elements},{done},{unseen},{start},{finish},{seen}");
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::CivilDate;

    #[test]
    fn dates_of_planners_become_dates_and_times_at_the_site() {
        let civil = |offset_s, is_day| ScheduleDate::Civil(CivilDate { at_s: 1_713_169_800, offset_s, is_day });
        assert_eq!(written(civil(None, false)).as_deref(), Some("2024-04-15T08:30:00"));
        assert_eq!(written(civil(Some(7200), false)).as_deref(), Some("2024-04-15T08:30:00"));
        assert_eq!(written(ScheduleDate::Text("2024-04-15")), None, "of a model");
    }

    #[test]
    fn only_all_elements_make_a_hundred_per_cent() {
        let of = |done, elements| {
            let (actual_start, actual_finish) = (None, None);
            TaskProgress { task: 0, elements, done, unseen: 0, actual_start, actual_finish }.percent()
        };
        assert_eq!([of(0, 0), of(0, 3), of(999, 1000), of(3, 3)], [None, Some(0), Some(99), Some(100)]);
    }
}
