//! The result of a check, as a document for programs.

use answers::{Circumstances, ElementRef};
use schemars::JsonSchema;
use serde::Serialize;

/// Whether a model is fit for a robot, and what is to be mended.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ModelCheck {
    /// What was checked, for which robot.
    pub circumstances: Circumstances,
    /// True if no issue changes maps.
    pub fit: bool,
    /// What the model holds and how much of it the robot gets to.
    pub model: ModelFigures,
    /// Faults of the model, the worst first.
    pub issues: Vec<Issue>,
    /// What keeps this robot out and is no fault of the model.
    pub building: Vec<Issue>,
    /// What was looked for.
    pub checked: Vec<&'static str>,
    /// What was not looked for, or could not be, and why.
    pub not_checked: Vec<NotChecked>,
}

/// Figures of a model.
#[derive(Debug, Clone, Default, PartialEq, Serialize, JsonSchema)]
pub struct ModelFigures {
    /// Map storeys, the ground outdoors not counted.
    pub storeys: usize,
    /// Elements with a body or without.
    pub elements: usize,
    /// Doors.
    pub doors: usize,
    /// Doors that this robot cannot pass, whatever the reason.
    pub closed_doors: usize,
    /// Rooms: spaces indoors that are no gross areas and no shafts.
    pub rooms: usize,
    /// Rooms to which no way leads this robot.
    pub unreachable_rooms: usize,
    /// Floor indoors on which the middle of the robot can be.
    pub standing_m2: f64,
    /// That of it to which it gets.
    pub reached_m2: f64,
}

/// Elements with one cause.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Issue {
    /// Stable code for programs.
    pub code: &'static str,
    /// `maps` if maps are wrong for it, `data` if not; `building` if the model is not at fault.
    pub kind: &'static str,
    /// One line for people: what it is, and its effect.
    pub title: String,
    /// Why it matters to a robot.
    pub cause: &'static str,
    /// What the author of the model does about it.
    pub advice: &'static str,
    /// What it does on the maps.
    pub effect: Effect,
    /// How many elements there are, listed or not.
    pub n: usize,
    /// The first of them, at most 500.
    pub elements: Vec<IssueElement>,
}

/// What an issue does on the maps.
#[derive(Debug, Clone, Default, PartialEq, Serialize, JsonSchema)]
pub struct Effect {
    /// For people; empty if maps are as they would be without it.
    pub text: String,
    /// Floor, or area of elements, that is wrong on the maps: out of reach, missing, assumed, or in two rooms; null where no
    /// area is.
    pub area_m2: Option<f64>,
    /// Doors that are closed on the maps, or in the wrong place, for it.
    pub doors: Vec<ElementRef>,
    /// Rooms that are wrong on the maps for it.
    pub rooms: Vec<AffectedRoom>,
}

/// A room that is wrong on the maps.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct AffectedRoom {
    /// GlobalId.
    pub global_id: String,
    /// Name and long name; null if it has neither.
    pub name: Option<String>,
    /// Area of its floor polygon.
    pub area_m2: f64,
    /// True if no way leads there for this issue, and one would lead there without it.
    pub unreachable: bool,
}

/// An element, room or storey of an issue.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct IssueElement {
    /// GlobalId; empty for what has none.
    pub global_id: String,
    /// Entity, e.g. `IfcDoor`.
    #[serde(rename = "type")]
    pub ifc_type: String,
    /// Name; null if it has none.
    pub name: Option<String>,
    /// Storey of the file that contains it, or on which it stands; null if there is none.
    pub storey: Option<String>,
    /// What is wrong with it; empty where the title says all.
    pub text: String,
    /// Where it is; null if it is nowhere.
    pub place: Option<Place>,
}

/// A place on a map.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Place {
    /// Index of the map storey; null if it is on none.
    pub storey: Option<u32>,
    /// Lower left and upper right corner in `map`.
    pub bounds_m: [[f64; 2]; 2],
    /// Height in `map`.
    pub z_m: f64,
}

/// Something that was not checked.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct NotChecked {
    /// What.
    pub what: &'static str,
    /// Why not.
    pub why: &'static str,
}

impl Place {
    /// Its middle.
    pub fn middle_m(&self) -> [f64; 2] {
        let [min, max] = self.bounds_m;
        [0, 1].map(|k| (min[k] + max[k]) / 2.0)
    }
}
