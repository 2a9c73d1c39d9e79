//! Elements, rooms, storeys and tasks as answers name them.

use messages::{NONE, Site, plan_time};
use schemars::JsonSchema;
use serde::Serialize;

/// A plan time for people and JSON.
pub fn date_text(seconds: i64) -> String {
    plan_time(seconds).map(|at| at.to_string()).unwrap_or_default()
}

/// The same; `None` for [`messages::ScheduleStateHead::NO_TIME`].
pub fn optional_date_text(seconds: i64) -> Option<String> {
    plan_time(seconds).map(|at| at.to_string())
}

/// An element.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct ElementRef {
    /// GlobalId.
    pub global_id: String,
    /// Name; null if it has none.
    pub name: Option<String>,
    /// Entity, e.g. `IfcDoor`.
    #[serde(rename = "type")]
    pub ifc_type: String,
}

/// A room.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct RoomRef {
    /// GlobalId.
    pub global_id: String,
    /// Name and long name, as outputs write them; null if it has neither.
    pub name: Option<String>,
}

/// A map storey.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct StoreyRef {
    /// Index of the map storey.
    pub index: u32,
    /// Name.
    pub name: String,
    /// Height of its floor in `map`.
    pub floor_z_m: f64,
}

/// A task of the schedule.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct TaskRef {
    /// GlobalId.
    pub global_id: String,
    /// Identification; null if it has none.
    pub identification: Option<String>,
    /// Name; null if it has none.
    pub name: Option<String>,
}

fn some_text(text: &str) -> Option<String> {
    (!text.is_empty()).then(|| text.to_owned())
}

impl ElementRef {
    /// An element of a site.
    pub fn of(site: &Site<'_>, element: usize) -> Self {
        let record = &site.elements[element];
        Self {
            global_id: site.text(record.global_id).to_owned(),
            name: some_text(site.text(record.name)),
            ifc_type: site.text(record.ifc_type).to_owned(),
        }
    }

    /// Name and GlobalId for people.
    pub fn label(&self) -> String {
        label(self.name.as_deref(), &self.global_id)
    }
}

impl RoomRef {
    /// A space of a site.
    pub fn of(site: &Site<'_>, space: usize) -> Self {
        let global_id = site.text(site.spaces[space].global_id).to_owned();
        Self { global_id, name: export::space_name(site, space as u32) }
    }

    /// Its name, else its GlobalId.
    pub fn label(&self) -> &str {
        self.name.as_deref().unwrap_or(&self.global_id)
    }
}

impl StoreyRef {
    /// A map storey of a site; `None` for `NONE`.
    pub fn of(site: &Site<'_>, map_storey: u32) -> Option<Self> {
        let record = site.map_storeys.get(map_storey as usize).filter(|_| map_storey != NONE)?;
        let floor_z_m = export::rounded(frames::metres(record.floor_z_tenths));
        Some(Self { index: map_storey, name: site.text(record.name).to_owned(), floor_z_m })
    }
}

impl TaskRef {
    /// A task of a site.
    pub fn of(site: &Site<'_>, task: usize) -> Self {
        let record = &site.schedule.tasks[task];
        Self {
            global_id: site.schedule.text(record.global_id).to_owned(),
            identification: some_text(site.schedule.text(record.identification)),
            name: some_text(site.schedule.text(record.name)),
        }
    }

    /// Identification and name, else its GlobalId.
    pub fn label(&self) -> String {
        let words: Vec<&str> = [&self.identification, &self.name].into_iter().filter_map(Option::as_deref).collect();
        if words.is_empty() { self.global_id.clone() } else { words.join(" ") }
    }
}

/// A name with its GlobalId in brackets, or that alone.
pub(crate) fn label(name: Option<&str>, global_id: &str) -> String {
    name.map_or_else(|| global_id.to_owned(), |name| format!("{name} ({global_id})"))
}
