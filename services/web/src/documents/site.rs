//! `site.json`: storeys, elements and spaces with all that does not change with the date, and the dates.

use super::Published;
use crate::tiles::{Extent, TileGrid};
use answers::findings::{Findings, ReportDocument, WaypointsDocument};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

/// Version of the layout of all documents of the page.
const VERSION: u32 = 1;

/// Keys of an element that change with the date, or are of no use in a plan.
const LEFT_OUT: [&str; 4] = ["vertices", "faces", "edges", "state"];

/// The document.
#[derive(Debug, Serialize)]
pub(crate) struct SiteDocument<'a> {
    version: u32,
    #[serde(flatten)]
    head: &'a SiteHead,
    tiles: TileGrid,
    dates: &'a [DateStop],
    elements: Value,
    spaces: Value,
    /// Names of the tasks of elements.
    tasks: Map<String, Value>,
    /// Index of the storey on which the robot starts, or that with the entrance; null where neither is known.
    entrance: Option<u32>,
    findings: Findings,
}

/// What a manifest says of the site.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(crate) struct SiteHead {
    /// Name for people: those of the files.
    #[serde(skip_deserializing)]
    pub(crate) title: String,
    /// True if the dates move by themselves.
    #[serde(skip_deserializing)]
    pub(crate) live: bool,
    /// True if viewers may change the plan time and confirm.
    #[serde(skip_deserializing)]
    pub(crate) control: bool,
    /// The files of the models.
    pub(crate) sources: Value,
    /// The files of the schedule.
    #[serde(default)]
    pub(crate) schedule_sources: Value,
    /// True if there is a schedule that the maps do not follow.
    pub(crate) schedule_ignored: bool,
    /// Metres per cell.
    pub(crate) resolution_m: f64,
    /// The robot that the maps are for.
    pub(crate) robot: Value,
    /// How frames lie to each other.
    pub(crate) frames: Value,
    /// The storeys that have maps.
    pub(crate) storeys: Vec<Storey>,
}

/// A storey with maps.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Storey {
    pub(crate) index: u32,
    pub(crate) name: Option<String>,
    pub(crate) floor_z_m: f64,
    pub(crate) floor: String,
    pub(crate) origin_m: [f64; 2],
    pub(crate) size_cells: [u32; 2],
}

impl Storey {
    /// Where its cells lie.
    pub(crate) fn extent(&self) -> Extent {
        Extent { origin_m: self.origin_m, size_cells: self.size_cells }
    }
}

/// A date that can be shown.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct DateStop {
    /// Names its document; `None` where only the daemons can show it.
    pub(crate) key: Option<String>,
    /// Plan time; `None` where everything is built.
    pub(crate) at: Option<String>,
    /// The next change.
    pub(crate) until: Option<String>,
}

impl SiteHead {
    /// Of `manifest.json`, of a site that does not move.
    ///
    /// # Errors
    /// A document of another layout.
    pub(crate) fn of_manifest(manifest: &Value) -> Result<Self, serde_json::Error> {
        let head = Self::deserialize(manifest)?;
        let names = head.sources.as_array().into_iter().flatten().filter_map(|source| source["file"].as_str());
        let names: Vec<&str> = names.map(|name| name.rsplit_once('.').map_or(name, |(stem, _)| stem)).collect();
        Ok(Self { title: names.join(", "), ..head })
    }

    /// The tiles of its storeys.
    pub(crate) fn tiles(&self) -> TileGrid {
        let extents: Vec<Extent> = self.storeys.iter().map(Storey::extent).collect();
        TileGrid::around(&extents, self.resolution_m)
    }
}

impl<'a> SiteDocument<'a> {
    /// Of a head, the dates, and what is published at any of them: that of the last one has all that is ever built.
    ///
    /// # Errors
    /// Documents of another layout.
    pub(crate) fn of(
        head: &'a SiteHead,
        dates: &'a [DateStop],
        published: Published,
    ) -> Result<Self, serde_json::Error> {
        let Published { mut semantic, waypoints, report, .. } = published;
        let mut take = |key: &str| semantic.get_mut(key).map_or_else(|| Value::Object(Map::new()), Value::take);
        let (mut elements, mut spaces) = (take("elements"), take("spaces"));
        let mut tasks = Map::new();
        for element in elements.as_object_mut().into_iter().flat_map(Map::values_mut) {
            let schedule = &mut element["schedule"];
            if let (Some(task), Some(name)) = (schedule["task"].as_str(), schedule["task_name"].as_str()) {
                tasks.insert(task.to_owned(), json!({"name": name}));
            }
            remove(schedule, &["state", "task_name"]);
            remove(element, &LEFT_OUT);
            remove(&mut element["attributes"], &["passage"]);
        }
        for space in spaces.as_object_mut().into_iter().flat_map(Map::values_mut) {
            remove(space, &["state", "why"]);
        }
        let entrance = entrance_of(&head.storeys, &waypoints);
        // Where there is no date nothing was found.
        let report: Option<ReportDocument> = serde_json::from_value(report)?;
        let waypoints: Option<WaypointsDocument> = serde_json::from_value(waypoints)?;
        let findings = Findings::of(report.unwrap_or_default(), waypoints.unwrap_or_default());
        Ok(Self { version: VERSION, head, tiles: head.tiles(), dates, elements, spaces, tasks, entrance, findings })
    }
}

/// Floors of entrances are that near to height 0: the outer door of a storey above leads to a balcony or a roof.
const ENTRANCE_HEIGHT_M: f64 = 1.5;

/// The storey of the robot's start, else the one at ground level that it enters through an outer door; of several the one
/// nearest to height 0.
fn entrance_of(storeys: &[Storey], waypoints: &Value) -> Option<u32> {
    let entry = |storey: &Storey| {
        let mut outcomes = waypoints["storeys"].as_array().into_iter().flatten();
        outcomes.find(|outcome| outcome["storey"] == storey.index).and_then(|outcome| outcome["entry"].as_str())
    };
    let start = storeys.iter().find(|storey| entry(storey) == Some("start"));
    let is_at_ground = |s: &&Storey| entry(s) == Some("outer_door") && s.floor_z_m.abs() <= ENTRANCE_HEIGHT_M;
    let at_ground = storeys.iter().filter(is_at_ground);
    let nearest = at_ground.min_by(|a, b| a.floor_z_m.abs().total_cmp(&b.floor_z_m.abs()));
    start.or(nearest).map(|storey| storey.index)
}

fn remove(of: &mut Value, keys: &[&str]) {
    if let Some(of) = of.as_object_mut() {
        keys.iter().for_each(|key| drop(of.remove(*key)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_changes_with_the_date_is_not_in_the_site() {
        let semantic = json!({
            "elements": {"a": {"type": "IfcDoor", "vertices": [1], "schedule": {"start": "x", "state": "built", "task": "3.1", "task_name": "Doors"},
                "attributes": {"passage": {"0": "passable"}, "clear_width_m": 0.9}}},
            "spaces": {"s": {"name": "G.01", "state": "open", "why": []}},
        });
        let entry = |storey: u32, entry: &str| json!({"storey": storey, "entry": entry});
        let waypoints = json!({"storeys": [entry(0, "placed"), entry(1, "portal"), entry(2, "outer_door")]});
        let published = Published { semantic, waypoints, site_graph: Value::Null, report: Value::Null };
        let document = serde_json::to_value(SiteDocument::of(&SiteHead::default(), &[], published).unwrap()).unwrap();
        let element =
            json!({"type": "IfcDoor", "schedule": {"start": "x", "task": "3.1"}, "attributes": {"clear_width_m": 0.9}});
        assert_eq!(document["elements"], json!({"a": element}));
        assert_eq!(document["tasks"], json!({"3.1": {"name": "Doors"}}));
        assert_eq!(document["spaces"], json!({"s": {"name": "G.01"}}));
        assert_eq!((&document["version"], &document["tiles"]["size"]), (&json!(1), &json!(512)));
    }

    #[test]
    fn the_entrance_is_at_ground_level_and_not_on_a_balcony() {
        let storey = |index, floor_z_m| Storey {
            index,
            name: None,
            floor_z_m,
            floor: "built".to_owned(),
            origin_m: [0.0; 2],
            size_cells: [1, 1],
        };
        let storeys = [storey(0, -3.0), storey(1, 0.2), storey(2, 3.2)];
        let entrance = |entries: [&str; 3]| {
            let outcomes: Vec<Value> =
                entries.iter().enumerate().map(|(k, entry)| json!({"storey": k, "entry": entry})).collect();
            entrance_of(&storeys, &json!({"storeys": outcomes}))
        };
        assert_eq!(entrance(["outer_door", "outer_door", "outer_door"]), Some(1));
        assert_eq!(entrance(["placed", "placed", "outer_door"]), None);
        assert_eq!(entrance(["start", "outer_door", "placed"]), Some(0));
    }
}
