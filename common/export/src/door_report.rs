//! Door passages for reports: one entry per door on its storey, with reasons in words.

use crate::input::ExportInput;
use crate::semantic::clear_width_word;
use crate::text::{rounded, text_or_null};
use frames::TENTHS_PER_M;
use messages::{DoorPassage, DoorPassageRecord, NONE, RobotProfile, Site};
use schemars::JsonSchema;
use serde::Serialize;

/// A door that is worth a line of the report.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct DoorReport {
    global_id: String,
    name: Option<String>,
    /// Index of the map storey on which it stands.
    storey: u32,
    /// `passable`, `absent` where it leaves a hole, or the code of the first reason why it is closed.
    passage: &'static str,
    /// Every reason why it is closed.
    reasons: Vec<Reason>,
    /// Width between what remains when it is open, together with the leaves beside it that this robot can have open.
    clear_width_m: f64,
    /// `lining_and_panel` or `assumed`.
    clear_width_from: &'static str,
    /// Narrowest line of cells through it that are not occupied.
    width_in_map_m: f64,
    /// On how many of its two sides there is floor.
    sides_with_floor: u32,
}

/// Why a door is closed to the robot.
#[derive(Debug, Serialize, JsonSchema)]
struct Reason {
    /// `in_progress`, `no_floor`, `operation`, `too_narrow`, `no_opening`, `threshold`,
    /// `wall_uncut`, `obstructed` or `resolution`.
    code: &'static str,
    /// The same for people.
    text: String,
    /// Width that the robot needs.
    #[serde(skip_serializing_if = "Option::is_none")]
    needed_m: Option<f64>,
    /// Width that it finds.
    #[serde(skip_serializing_if = "Option::is_none")]
    found_m: Option<f64>,
    /// A finer resolution of the map at which the door is open.
    #[serde(skip_serializing_if = "Option::is_none")]
    needed_resolution_m: Option<f64>,
    /// GlobalId of the element that stands in the way.
    #[serde(skip_serializing_if = "Option::is_none")]
    element: Option<String>,
}

/// What a robot finds at each door, once per door: on the storey on which the door stands, else on the lowest whose slab it
/// meets. By door.
pub fn each_door(site: &Site<'_>, doors: &[DoorPassageRecord]) -> Vec<DoorPassageRecord> {
    let mut found: Vec<DoorPassageRecord> = doors.to_vec();
    let own =
        |d: &DoorPassageRecord| site.doors.get(d.door as usize).is_some_and(|door| door.map_storey == d.map_storey);
    found.sort_by_key(|d| (d.door, !own(d), d.map_storey));
    found.dedup_by_key(|d| d.door);
    found
}

/// A reason why a door is closed, in words.
pub fn reason_text(site: &Site<'_>, robot: &RobotProfile, door: &DoorPassageRecord, reason: DoorPassage) -> String {
    let (needed_m, found_m) = widths_m(robot, door, reason).unwrap_or_default();
    match reason {
        DoorPassage::NoFloor => "no floor on this storey at the door".to_owned(),
        DoorPassage::NoOpening => "its wall has no opening".to_owned(),
        DoorPassage::Threshold => format!("a threshold of {:.2} m stands in it", threshold_m(site, door)),
        DoorPassage::WallUncut if touches_from_outside(site, door) => {
            "its opening touches the wall from outside".to_owned()
        }
        DoorPassage::WallUncut => "its wall is not cut by its opening".to_owned(),
        DoorPassage::CannotOpen if is_trapdoor(site, door) => "it is a trapdoor".to_owned(),
        DoorPassage::CannotOpen if site.moving_leaves(&site.doors[door.door as usize]).is_none() => {
            "all its leaves are fixed".to_owned()
        }
        DoorPassage::CannotOpen => match site.text(site.doors[door.door as usize].operation) {
            "" => "this robot does not open doors of its kind".to_owned(),
            operation => format!("this robot does not open {operation}"),
        },
        DoorPassage::TooNarrow => format!("clear width {found_m:.2} m, this robot needs {needed_m:.2} m"),
        DoorPassage::Obstructed => {
            let obstacle = site.elements.get(door.obstacle as usize).filter(|_| door.obstacle != NONE);
            let name =
                obstacle.map_or(String::new(), |e| format!("{} {} ", site.text(e.ifc_type), site.text(e.global_id)));
            format!("{name}stands in the way and leaves {found_m:.2} m, this robot needs {needed_m:.2} m")
        }
        DoorPassage::ClosedByResolution if door.needed_resolution_m == 0.0 => {
            format!("the map's cells leave {:.2} m of it", door.width_in_map_m)
        }
        DoorPassage::ClosedByResolution => format!(
            "the map's cells leave {:.2} m of it; at a resolution of {} m it is open",
            door.width_in_map_m,
            rounded(door.needed_resolution_m)
        ),
        DoorPassage::InProgress => "it is being worked on".to_owned(),
        DoorPassage::Absent | DoorPassage::Passable => "it does not stand".to_owned(),
    }
}

/// Height of a door's opening above the floor of its map storey, in metres.
fn threshold_m(site: &Site<'_>, door: &DoorPassageRecord) -> f64 {
    let opening = site.openings.get(site.doors[door.door as usize].opening as usize);
    let floor = site.map_storeys.get(door.map_storey as usize);
    opening.zip(floor).map_or(0.0, |(o, f)| f64::from(o.bottom_z_tenths - f.floor_z_tenths) / f64::from(TENTHS_PER_M))
}

/// True if no part of the opening of a door lies in its wall.
fn touches_from_outside(site: &Site<'_>, door: &DoorPassageRecord) -> bool {
    let opening = site.openings.get(site.doors[door.door as usize].opening as usize);
    opening.is_some_and(|o| o.plan.half[0] > 0.0 && !o.is_in_wall())
}

fn is_trapdoor(site: &Site<'_>, door: &DoorPassageRecord) -> bool {
    let element = site.doors[door.door as usize].element as usize;
    site.text(site.elements[element].predefined_type) == "TRAPDOOR"
}

/// Width that the robot needs and width that it finds, where a width is the reason.
fn widths_m(robot: &RobotProfile, door: &DoorPassageRecord, reason: DoorPassage) -> Option<(f64, f64)> {
    match reason {
        DoorPassage::TooNarrow => Some((robot.needed_width_m(), door.clear_width_m)),
        DoorPassage::Obstructed => Some((2.0 * robot.radius_m, door.width_between_obstacles_m)),
        DoorPassage::ClosedByResolution => Some((2.0 * robot.radius_m, door.width_in_map_m)),
        _ => None,
    }
}

impl Reason {
    fn of(input: &ExportInput<'_>, door: &DoorPassageRecord, reason: DoorPassage) -> Self {
        let (site, robot) = (input.site, &input.index.head.robot);
        let widths_m = widths_m(robot, door, reason);
        let is_in_the_way = matches!(
            reason,
            DoorPassage::NoOpening | DoorPassage::WallUncut | DoorPassage::Threshold | DoorPassage::Obstructed
        );
        let obstacle = site.elements.get(door.obstacle as usize).filter(|_| is_in_the_way);
        let is_resolution = reason == DoorPassage::ClosedByResolution && door.needed_resolution_m > 0.0;
        Self {
            code: reason.name(),
            text: reason_text(site, robot, door, reason),
            needed_m: widths_m.map(|w| rounded(w.0)),
            found_m: widths_m.map(|w| rounded(w.1)),
            needed_resolution_m: is_resolution.then(|| rounded(door.needed_resolution_m)),
            element: obstacle.map(|e| site.text(e.global_id).to_owned()),
        }
    }
}

/// The doors that are closed, lead to no floor, or whose clear width is assumed.
pub(crate) fn door_reports(input: &ExportInput<'_>) -> Vec<DoorReport> {
    let site = input.site;
    let worth_a_line = |d: &DoorPassageRecord| {
        let assumed = clear_width_word(&site.doors[d.door as usize]) == "assumed";
        d.passage != DoorPassage::Passable || d.sides_with_floor < 2 || assumed
    };
    let report = |d: DoorPassageRecord| {
        let door = &site.doors[d.door as usize];
        let element = &site.elements[door.element as usize];
        DoorReport {
            global_id: site.text(element.global_id).to_owned(),
            name: text_or_null(site.text(element.name)),
            storey: d.map_storey,
            passage: d.passage.get().name(),
            reasons: d.closed_by().map(|reason| Reason::of(input, &d, reason)).collect(),
            clear_width_m: rounded(d.clear_width_m),
            clear_width_from: clear_width_word(door),
            width_in_map_m: rounded(d.width_in_map_m),
            sides_with_floor: d.sides_with_floor,
        }
    };
    each_door(site, input.index.doors).into_iter().filter(worth_a_line).map(report).collect()
}
