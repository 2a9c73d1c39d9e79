//! `summary/KEY.json`: areas and tasks of a date, counted.

use super::date::{entries, space_state};
use super::{Published, TasksDocument};
use serde::Serialize;
use std::collections::BTreeMap;

/// The document.
#[derive(Debug, Serialize)]
pub(crate) struct SummaryDocument<'a> {
    /// By index of the storey.
    storeys: BTreeMap<u32, Areas>,
    sum: Areas,
    /// Status of every task with dates; empty without a plan time.
    tasks: BTreeMap<&'a str, &'static str>,
}

/// What is open, in square metres.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
struct Areas {
    /// Cells that are free on the planning map; null without one.
    free_m2: Option<f64>,
    /// Rooms by their state: `reached`, `no_way`, `blocked`, `open`. External ones, and those that only group others, are none.
    rooms: BTreeMap<String, Rooms>,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
struct Rooms {
    n: usize,
    area_m2: f64,
}

/// Free cells of the planning maps, by storey.
#[derive(Debug, Default)]
pub(crate) struct FreeCells {
    /// Metres per cell.
    pub(crate) resolution_m: f64,
    /// Number of free cells of a storey.
    pub(crate) n_free: BTreeMap<u32, usize>,
}

impl<'a> SummaryDocument<'a> {
    /// Of what is published at a date, `None` where everything is built.
    pub(crate) fn of(published: &Published, free: &FreeCells, tasks: &'a TasksDocument, at: Option<&str>) -> Self {
        let mut storeys: BTreeMap<u32, Areas> = BTreeMap::new();
        for (storey, n_free) in &free.n_free {
            let free_m2 = *n_free as f64 * free.resolution_m * free.resolution_m;
            storeys.entry(*storey).or_default().free_m2 = Some(rounded(free_m2));
        }
        for (id, space) in entries(&published.semantic, "spaces") {
            let Some(storey) = space["storey"].as_u64().and_then(|storey| u32::try_from(storey).ok()) else { continue };
            if space["external"] == true || space["metadata_only"] == true {
                continue;
            }
            let state = space_state(space, &published.waypoints["spaces"][id]).to_owned();
            let rooms = storeys.entry(storey).or_default().rooms.entry(state).or_default();
            rooms.n += 1;
            rooms.area_m2 += space["area_m2"].as_f64().unwrap_or_default();
        }
        let mut sum = Areas::default();
        for areas in storeys.values_mut() {
            if let Some(free_m2) = areas.free_m2 {
                sum.free_m2 = Some(rounded(sum.free_m2.unwrap_or_default() + free_m2));
            }
            for (state, rooms) in &mut areas.rooms {
                rooms.area_m2 = rounded(rooms.area_m2);
                let of_all = sum.rooms.entry(state.clone()).or_default();
                of_all.n += rooms.n;
                of_all.area_m2 = rounded(of_all.area_m2 + rooms.area_m2);
            }
        }
        Self { storeys, sum, tasks: at.map(|at| tasks.statuses(at)).unwrap_or_default() }
    }
}

/// To a hundredth of a square metre.
fn rounded(area_m2: f64) -> f64 {
    (area_m2 * 100.0).round() / 100.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::{Value, json};

    #[test]
    fn areas_are_those_of_rooms_by_state_and_of_free_cells() {
        let space = |area_m2: f64, storey: u32| json!({"state": "open", "storey": storey, "area_m2": area_m2});
        let external = json!({"state": "open", "storey": 0, "area_m2": 99.0, "external": true});
        let groups = json!({"state": "open", "storey": 0, "area_m2": 99.0, "metadata_only": true});
        let published = Published {
            semantic: json!({"spaces": {
                "a": space(10.004, 0), "b": space(5.5, 0), "c": space(7.0, 1), "d": external, "e": groups,
            }}),
            waypoints: json!({"spaces": {"a": {"access": "reached"}, "b": {"access": "no_way"}, "c": {"access": "reached"}}}),
            ..Published::default()
        };
        let free = FreeCells { resolution_m: 0.5, n_free: [(0, 100), (2, 8)].into() };
        let tasks = TasksDocument::of_elements(&Value::Null);
        let summary = serde_json::to_value(SummaryDocument::of(&published, &free, &tasks, None)).unwrap();
        assert_eq!(summary["storeys"]["0"]["free_m2"], 25.0);
        assert_eq!(summary["storeys"]["0"]["rooms"]["no_way"], json!({"n": 1, "area_m2": 5.5}));
        assert_eq!(
            (&summary["storeys"]["1"]["free_m2"], &summary["storeys"]["2"]["rooms"]),
            (&Value::Null, &json!({}))
        );
        assert_eq!(summary["sum"]["rooms"]["reached"], json!({"n": 2, "area_m2": 17.0}));
        assert_eq!((&summary["sum"]["free_m2"], &summary["tasks"]), (&json!(27.0), &json!({})));
    }
}
