//! Observations of a model's tasks and elements, from rows of progress and deviations: what is confirmed, and why the rest is not
//! written.

use super::compared::ComparedStorey;
use super::gathered::{Gathered, Row};
use crate::failure::Failure;
use as_built::{
    AdditionalElement, ElementFinding, ElementObservation, NotWritten, Observations, Provenance, TaskObservation,
};
use diagnostics::nearest_names_hint;
use frames::PlanTime;
use messages::{ScheduleDateKind, Site, plan_time};
use schedule::{Overrides, ReportedDates, Rules, TaskOperation, find_task, planned};
use std::collections::{BTreeMap, BTreeSet};

/// A site, and the file of it that is written.
pub(super) struct SiteOfModel<'a> {
    pub(super) site: &'a Site<'a>,
    /// Index of the file.
    pub(super) source: u32,
    pub(super) rules: &'a Rules,
}

/// What a row is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Target {
    Task(usize),
    Element(usize),
}

/// The observations of a model. `confirm` has what is confirmed of the deviations.
///
/// # Errors
/// Rows that cannot be used, a confirmation of what is not there.
pub(super) fn observations(
    of: &SiteOfModel<'_>,
    gathered: &Gathered,
    confirm: &[String],
) -> Result<Observations, Failure> {
    let mut all = Collected {
        of,
        elements: of.site.elements.iter().enumerate().map(|(k, e)| (of.site.text(e.global_id), k)).collect(),
        observations: Observations { sources: gathered.sources.clone(), ..Observations::default() },
        reported: BTreeSet::new(),
    };
    all.rows(gathered)?;
    if let Some((storey, source)) = &gathered.deviations {
        all.deviations(storey, *source, confirm)?;
    } else if let Some(first) = confirm.first() {
        return Err(Failure::usage(format!("--confirm {first}: there are no deviations")));
    }
    Ok(all.observations)
}

struct Collected<'c, 'a> {
    of: &'c SiteOfModel<'a>,
    /// By GlobalId.
    elements: BTreeMap<&'a str, usize>,
    observations: Observations,
    /// Elements of which rows tell.
    reported: BTreeSet<usize>,
}

impl Collected<'_, '_> {
    fn refuse(&mut self, (source, row): (usize, String), id: Option<&str>, reason: &str) {
        let (id, reason) = (id.map(str::to_owned), reason.to_owned());
        self.observations.not_written.push(NotWritten { source, row, id, reason });
    }

    fn rows(&mut self, gathered: &Gathered) -> Result<(), Failure> {
        let (site, rules) = (self.of.site, self.of.rules);
        let actuals = gathered.rows.iter().map(|row| row.actual.clone()).collect();
        let overrides =
            Overrides { actuals, is_of_earlier_revision: gathered.is_of_running_site, ..Overrides::default() };
        let dates = ReportedDates::of(site, rules, &overrides).map_err(Failure::usage)?;
        let mut rows: BTreeMap<Target, &Row> = BTreeMap::new();
        for row in &gathered.rows {
            let id = row.actual.id.as_str();
            let element = self.elements.get(id).map(|k| Target::Element(*k));
            let Some(target) = element.or_else(|| find_task(site, id).ok().map(Target::Task)) else {
                self.refuse(place(row), Some(id), "the model has neither an element nor a task of that name");
                continue;
            };
            if let Some(earlier) = rows.insert(target, row) {
                self.refuse(place(earlier), Some(&earlier.actual.id), "a later row or a report of it ranks before");
            }
        }
        let builders = Builders::of(site, rules)?;
        for (&target, row) in &rows {
            match target {
                Target::Task(task) => self.task(task, dates.tasks.get(&task).copied().unwrap_or_default(), row),
                Target::Element(element) => {
                    let dates = dates.elements.get(&element).copied().unwrap_or_default();
                    let needs_task = !builders.built.contains(&(element as u32));
                    self.element(element, dates, needs_task, row);
                }
            }
        }
        self.tasks_of_elements(&builders, &dates, &rows);
        Ok(())
    }

    fn task(&mut self, task: usize, [start, finish]: [Option<i64>; 2], row: &Row) {
        let record = &self.of.site.schedule.tasks[task];
        let global_id = self.of.site.schedule.text(record.global_id).to_owned();
        if record.source != self.of.source {
            return self.refuse(place(row), Some(&global_id), "its task is of another file of the site");
        }
        let [start, finish] = [start, finish].map(|at_s| at_s.and_then(plan_time));
        let provenance = provenance(row, finish.or(start));
        let completion = None;
        self.observations.tasks.push(TaskObservation { global_id, start, finish, completion, provenance });
    }

    fn element(&mut self, element: usize, dates: Option<[Option<i64>; 2]>, needs_task: bool, row: &Row) {
        let record = &self.of.site.elements[element];
        let global_id = self.of.site.text(record.global_id).to_owned();
        self.reported.insert(element);
        if record.source != self.of.source {
            return self.refuse(place(row), Some(&global_id), "it is an element of another file of the site");
        }
        let (what, at) = match dates {
            None => (ElementFinding::Absent, None),
            Some(dates) => {
                let [start, finish] = dates.map(|at_s| at_s.and_then(plan_time));
                (ElementFinding::Progress { start, finish, needs_task }, finish.or(start))
            }
        };
        let provenance = provenance(row, at);
        self.observations.elements.push(ElementObservation { global_id, what, provenance });
    }

    /// Tasks get the progress of their elements: all dates where all of them are built, else the share that is.
    fn tasks_of_elements(&mut self, builders: &Builders, dates: &ReportedDates, rows: &BTreeMap<Target, &Row>) {
        let site = self.of.site;
        for (&task, elements) in &builders.by_task {
            let record = &site.schedule.tasks[task];
            let has_finish = site.schedule.date(ScheduleDateKind::ActualFinish, task).is_some();
            if record.source != self.of.source || has_finish || rows.contains_key(&Target::Task(task)) {
                continue;
            }
            let built = |k: &&u32| {
                let element = **k as usize;
                let row = rows.get(&Target::Element(element))?;
                let [start, finish] = dates.elements.get(&element).copied().flatten()?;
                Some((finish?, start, *row))
            };
            let done: Vec<_> = elements.iter().filter_map(|k| built(&k)).collect();
            let Some((last_s, _, row)) = done.iter().max_by_key(|(finish, ..)| *finish) else { continue };
            let is_done = done.len() == elements.len();
            let completion = done.len() as f64 / elements.len() as f64;
            if !is_done && record.completion >= completion {
                continue;
            }
            let start = done.iter().filter_map(|(_, start, _)| *start).min().filter(|_| is_done);
            self.observations.tasks.push(TaskObservation {
                global_id: site.schedule.text(record.global_id).to_owned(),
                start: start.and_then(plan_time),
                finish: plan_time(*last_s).filter(|_| is_done),
                completion: Some(completion),
                provenance: provenance(row, plan_time(*last_s)),
            });
        }
    }

    fn deviations(&mut self, storey: &ComparedStorey, source: usize, confirm: &[String]) -> Result<(), Failure> {
        let can_be = |id: &str| {
            storey.elements.get(id).is_some_and(|e| ["absent", "displaced"].contains(&e.observation.as_str()))
        };
        let number = |id: &str| id.parse::<usize>().ok().filter(|n| (1..=storey.obstacles.len()).contains(n));
        for id in confirm {
            if !can_be(id) && number(id).is_none() {
                let ids = storey.elements.keys().map(String::as_str).filter(|id| can_be(id));
                let hint = nearest_names_hint(id, ids);
                return Err(Failure::usage(format!(
                    "--confirm {id}: the deviations have no absent or displaced element of this GlobalId, and {} obstacles{hint}",
                    storey.obstacles.len()
                )));
            }
        }
        let at = storey.plan_time.as_deref().map(|text| PlanTime::parse(text, self.of.rules.site_zone.as_ref()));
        let at = at.transpose().map_err(Failure::usage)?.map(|written| written.at);
        let observer = format!("robot, map {}", storey.slam_map_hash);
        let seen = |row: &str, is_confirmed: bool| Provenance {
            source,
            row: row.to_owned(),
            observer: if is_confirmed { format!("{observer}; confirmed with --confirm") } else { observer.clone() },
            at,
        };
        let builders = Builders::of(self.of.site, self.of.rules)?;
        for (id, element) in &storey.elements {
            let is_confirmed = confirm.contains(id);
            let known = self.elements.get(id.as_str()).copied();
            let is_reported = known.is_some_and(|k| self.reported.contains(&k));
            for part in element.absent_parts.iter().filter(|part| part.verdict == "late") {
                let stretch = format!("from {:.2} to {:.2} m of its axis it is absent", part.from_m, part.to_m);
                self.refuse(
                    (source, id.clone()),
                    Some(id),
                    &format!("{stretch}: an element is there or not, not in part"),
                );
            }
            let what = match (element.observation.as_str(), element.verdict.as_str()) {
                ("observed", "early") if !is_reported => match at {
                    None => {
                        self.refuse(
                            (source, id.clone()),
                            Some(id),
                            "the comparison has no date: when it was built is not known",
                        );
                        continue;
                    }
                    Some(at) => {
                        let needs_task = known.is_some_and(|k| !builders.built.contains(&(k as u32)));
                        ElementFinding::Progress { start: None, finish: Some(at), needs_task }
                    }
                },
                ("absent", _) if is_confirmed && !is_reported => ElementFinding::Absent,
                ("absent", "late") if !is_reported => {
                    self.refuse((source, id.clone()), Some(id), "it is absent, which nobody confirmed");
                    continue;
                }
                ("absent" | "displaced", _) if is_confirmed && is_reported => {
                    self.refuse((source, id.clone()), Some(id), "a report of the element ranks before it");
                    continue;
                }
                ("displaced", _) if is_confirmed => match self.displacement(element.displacement_m) {
                    Ok(by_m) => ElementFinding::Displaced { by_m, deviation_m: element.deviation_m },
                    Err(why) => {
                        self.refuse((source, id.clone()), Some(id), why);
                        continue;
                    }
                },
                ("displaced", _) => {
                    self.refuse((source, id.clone()), Some(id), "it is displaced, which nobody confirmed");
                    continue;
                }
                _ => continue,
            };
            let (global_id, provenance) = (id.clone(), seen(id, is_confirmed));
            self.observations.elements.push(ElementObservation { global_id, what, provenance });
        }
        for (k, obstacle) in storey.obstacles.iter().enumerate() {
            let (number, row) = ((k + 1).to_string(), format!("obstacle {}", k + 1));
            if !confirm.contains(&number) {
                let reason =
                    format!("{:.2} m2 that are no element of the model, which nobody confirmed", obstacle.area_m2);
                self.refuse((source, row), None, &reason);
                continue;
            }
            let provenance = seen(&row, true);
            match self.additional(storey, &obstacle.polygon_m, provenance) {
                Ok(element) => self.observations.additional.push(element),
                Err(why) => self.refuse((source, row), None, why),
            }
        }
        Ok(())
    }

    /// A vector in `map` as one in the world of the file.
    fn displacement(&self, by_m: Option<[f64; 2]>) -> Result<[f64; 2], &'static str> {
        let [x, y] = by_m.ok_or("how far it is displaced is not known")?;
        let world_from_map = self.world_from_map()?;
        let ([x0, y0, _], [x1, y1, _]) = (world_from_map([0.0; 3]), world_from_map([x, y, 0.0]));
        Ok([x1 - x0, y1 - y0])
    }

    fn additional(
        &self,
        storey: &ComparedStorey,
        polygon_m: &[Vec<[f64; 2]>],
        provenance: Provenance,
    ) -> Result<AdditionalElement, &'static str> {
        let world_from_map = self.world_from_map()?;
        let site = self.of.site;
        let record = site.map_storeys.get(storey.storey as usize).ok_or("the site has no such storey")?;
        let floor_z_m = frames::metres(record.floor_z_tenths);
        let point = |[x, y]: &[f64; 2]| {
            let [x, y, _] = world_from_map([*x, *y, floor_z_m]);
            [x, y]
        };
        Ok(AdditionalElement {
            rings_m: polygon_m.iter().map(|ring| ring.iter().map(point).collect()).collect(),
            bottom_z_m: world_from_map([0.0, 0.0, floor_z_m])[2],
            top_z_m: world_from_map([0.0, 0.0, storey.lidar_z_m])[2],
            storey: site.text(record.global_id).to_owned(),
            provenance,
        })
    }

    /// The motion from the map to the world of the file; of several files, where each lies in the world of the first is not kept.
    fn world_from_map(&self) -> Result<impl Fn([f64; 3]) -> [f64; 3] + use<>, &'static str> {
        if self.of.site.sources.len() > 1 {
            return Err("the site has several files, and where this one lies among them is not known");
        }
        let world_from_map = self.of.site.map_from_world().inverse();
        Ok(move |point| world_from_map.apply(point))
    }
}

fn place(row: &Row) -> (usize, String) {
    (row.source, format!("line {}", row.actual.line()))
}

fn provenance(row: &Row, at: Option<PlanTime>) -> Provenance {
    let Row { actual, source, observer, at: confirmed_at } = row;
    Provenance {
        source: *source,
        row: format!("line {}", actual.line()),
        observer: observer.clone(),
        at: confirmed_at.or(at),
    }
}

/// Which tasks of the models build which elements, by the plan.
struct Builders {
    /// Elements with a body by the tasks that build them.
    by_task: BTreeMap<usize, Vec<u32>>,
    /// All elements that a task builds.
    built: BTreeSet<u32>,
}

impl Builders {
    fn of(site: &Site<'_>, rules: &Rules) -> Result<Self, Failure> {
        let timeline = planned(site, rules, &[]).map_err(Failure::usage)?;
        let (mut by_task, mut built) = (BTreeMap::new(), BTreeSet::new());
        for (task, targets) in timeline.task_targets(site).iter().enumerate() {
            let builds = targets.elements.iter().filter(|(_, operation)| **operation == TaskOperation::Constructs);
            let elements: Vec<u32> = builds.map(|(element, _)| *element).collect();
            built.extend(&elements);
            let with_body: Vec<u32> = elements.into_iter().filter(|k| site.elements[*k as usize].n_parts > 0).collect();
            if !with_body.is_empty() {
                by_task.insert(task, with_body);
            }
        }
        Ok(Self { by_task, built })
    }
}
