//! The way from a place to another over storeys, or what is missing.

use crate::circumstances::Circumstances;
use crate::find::FoundPlace;
use crate::later::Later;
use crate::missing::{Missing, missing_of};
use crate::named::{ElementRef, RoomRef, StoreyRef};
use crate::situation::Situation;
use export::rounded;
use messages::{DoorPassageRecord, DoorUse, DriveModel, JOULES_PER_WH, NONE};
use schemars::JsonSchema;
use serde::Serialize;
use waypoints::{Driven, FloorLeg, PortalLeg, WayEnd, WayFinder, WayLeg};

/// The way from a place to another for this robot. It exists only if the robot can stand on every cell of it.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct WayAnswer {
    /// What the answer is made of.
    pub circumstances: Circumstances,
    /// Where it begins.
    pub from: PlaceAnswer,
    /// Where it ends.
    pub to: PlaceAnswer,
    /// True if there is a way.
    pub exists: bool,
    /// Length of all legs, as walked, up stairs and slopes. Null if there is no way.
    pub length_m: Option<f64>,
    /// By what the way was chosen: `length`, `time` or `energy`. Only beside `duration_s`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub chosen_by: Option<&'static str>,
    /// Time of all legs, where the options of the waypoints tell what climbing takes, or the way leads over slopes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub duration_s: Option<f64>,
    /// Energy of all legs in watt-hours, if the options of the waypoints tell the mass of the robot.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub energy_wh: Option<f64>,
    /// Sum of all rises on it, in metres: with the mass of the robot the work to lift it. Null if there is no way.
    pub climb_m: Option<f64>,
    /// Sum of all falls on it, in metres. Null if there is no way.
    pub descent_m: Option<f64>,
    /// Its legs in their order; none if there is no way.
    pub legs: Vec<WayLegAnswer>,
    /// What would have to change, from the beginning on, on the way that has the fewest obstacles; empty if there is a way, and where
    /// no closed door or room, and no stair, ramp or lift before which this robot can stand, leads to the end.
    pub missing: Vec<Missing>,
    /// When there is a way; null if there is one.
    pub changes: Option<Later>,
}

/// An end of a way.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct PlaceAnswer {
    /// The words of the question.
    pub asked: String,
    /// The room that they name; null for a point.
    pub room: Option<RoomRef>,
    /// The map storey; null if the room is on none.
    pub storey: Option<StoreyRef>,
    /// Where the way begins or ends, in `map`; without a way the centroid of the room, or the point.
    pub at_m: Option<[f64; 3]>,
}

/// A leg of a way.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct WayLegAnswer {
    /// `floor`, `stair`, `ramp`, `lift`, `step`, or `ground` where it goes on on the map of the ground outdoors, or comes from there.
    pub kind: &'static str,
    /// Index of the map storey on which it begins.
    pub storey: u32,
    /// Index of the map storey on which it ends.
    pub to_storey: u32,
    /// Length, as walked.
    pub length_m: f64,
    /// Sum of its rises, in metres.
    pub climb_m: f64,
    /// Sum of its falls, in metres.
    pub descent_m: f64,
    /// Slope of the steepest ground on it; 0 for what is no ramp and no ground with a slope.
    pub slope_rad: f64,
    /// Time, where the options of the waypoints tell what climbing takes, or the leg leads over slopes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub duration_s: Option<f64>,
    /// Energy in watt-hours, if the options of the waypoints tell the mass of the robot.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub energy_wh: Option<f64>,
    /// The stair, ramp or lift, or the floor above a step; null for a leg over floor, and where only the map is another one.
    pub element: Option<ElementRef>,
    /// Doorways in their order.
    pub doors: Vec<DoorOnWay>,
    /// Rooms in the order in which they are entered.
    pub rooms: Vec<RoomRef>,
    /// Corners of its line, in `map`.
    pub points_m: Vec<[f64; 3]>,
}

/// A doorway on a way.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct DoorOnWay {
    /// The door.
    #[serde(flatten)]
    pub element: ElementRef,
    /// True if it hangs; false where there is only its opening.
    pub is_hung: bool,
    /// Width between what remains when it is open, in metres.
    pub clear_width_m: f64,
}

/// The way for the robot of a situation, the shortest or least costly as its mission plan has it; when there is one is for the caller to
/// find out ([`way_exists`] at later times).
pub fn way(situation: &Situation<'_>, from: &FoundPlace, to: &FoundPlace) -> WayAnswer {
    let finder = finder(situation);
    let found = finder.way(from.end, to.end);
    let drive = finder.drive();
    let (legs, length_m, missing) = match &found {
        Ok(way) => {
            let legs = way.legs.iter().map(|leg| leg_answer(situation, drive, leg)).collect();
            (legs, Some(rounded(way.length_m)), Vec::new())
        }
        Err(no_way) => (Vec::new(), None, missing_of(situation, [from, to], no_way)),
    };
    let is_sloped = |legs: &[WayLegAnswer]| legs.iter().any(|leg| leg.slope_rad > 0.0);
    let costs = found.as_ref().ok().and_then(|way| Costs::of(drive, is_sloped(&legs), way.driven));
    let ends = |legs: &[WayLegAnswer]| -> Option<[[f64; 3]; 2]> {
        Some([*legs.first()?.points_m.first()?, *legs.last()?.points_m.last()?])
    };
    let [begin_m, end_m] = ends(&legs).map_or([None; 2], |ends| ends.map(Some));
    WayAnswer {
        circumstances: situation.circumstances.clone(),
        from: PlaceAnswer::of(situation, from, begin_m),
        to: PlaceAnswer::of(situation, to, end_m),
        exists: found.is_ok(),
        length_m,
        chosen_by: costs.map(|_| drive.cost.get().name()),
        duration_s: costs.map(|costs| costs.duration_s),
        energy_wh: costs.and_then(|costs| costs.energy_wh),
        climb_m: found.is_ok().then(|| sum(&legs, |leg| leg.climb_m)),
        descent_m: found.is_ok().then(|| sum(&legs, |leg| leg.descent_m)),
        legs,
        missing,
        changes: None,
    }
}

fn sum(legs: &[WayLegAnswer], of: impl Fn(&WayLegAnswer) -> f64) -> f64 {
    rounded(legs.iter().map(of).sum())
}

/// True if there is a way.
pub fn way_exists(situation: &Situation<'_>, from: WayEnd, to: WayEnd) -> bool {
    finder(situation).way(from, to).is_ok()
}

fn finder<'a>(situation: &Situation<'a>) -> WayFinder<'a> {
    let Situation { site, schedule_state, index, grids, mission_plan, .. } = *situation;
    WayFinder::new(site, schedule_state, index, grids, mission_plan)
}

impl PlaceAnswer {
    fn of(situation: &Situation<'_>, place: &FoundPlace, at_m: Option<[f64; 3]>) -> Self {
        let site = situation.site;
        let (room, map_storey, [x_m, y_m]) = match place.end {
            WayEnd::Space(space) => {
                let record = &site.spaces[space];
                (Some(RoomRef::of(site, space)), record.map_storey, record.centroid_m)
            }
            WayEnd::Point { map_storey, at } => (None, map_storey, at.coordinates_m()),
        };
        let storey = StoreyRef::of(site, map_storey);
        let unmoved_m = storey.as_ref().map(|storey| [rounded(x_m), rounded(y_m), storey.floor_z_m]);
        Self { asked: place.asked.clone(), room, storey, at_m: at_m.or(unmoved_m) }
    }

    /// For people.
    pub(crate) fn label(&self) -> String {
        let storey = self.storey.as_ref().map_or(String::new(), |storey| format!(" on {}", storey.name));
        match &self.room {
            Some(room) => format!("{}{storey}", room.label()),
            None => format!("{}{storey}", self.asked),
        }
    }
}

/// What is told of time and energy.
#[derive(Clone, Copy)]
struct Costs {
    duration_s: f64,
    energy_wh: Option<f64>,
}

impl Costs {
    /// Of a way or leg, if it leads over slopes or they were asked for.
    fn of(drive: &DriveModel, is_sloped: bool, driven: Driven) -> Option<Self> {
        let energy_wh = drive.has_energy().then(|| rounded(driven.energy_j / JOULES_PER_WH));
        (is_sloped || drive.is_asked_for()).then(|| Self { duration_s: rounded(driven.duration_s), energy_wh })
    }
}

fn leg_answer(situation: &Situation<'_>, drive: &DriveModel, leg: &WayLeg) -> WayLegAnswer {
    let (answer, driven) = match leg {
        WayLeg::Floor(leg) => (floor_answer(situation, leg), leg.driven),
        WayLeg::Portal(leg) => (portal_answer(situation, leg), leg.driven),
    };
    let costs = Costs::of(drive, answer.slope_rad > 0.0, driven);
    let duration_s = costs.map(|costs| costs.duration_s);
    WayLegAnswer { duration_s, energy_wh: costs.and_then(|costs| costs.energy_wh), ..answer }
}

fn floor_answer(situation: &Situation<'_>, leg: &FloorLeg) -> WayLegAnswer {
    let site = situation.site;
    let door = |passage: &DoorPassageRecord| DoorOnWay {
        element: ElementRef::of(site, site.doors[passage.door as usize].element as usize),
        is_hung: passage.passage.get().for_robot() != DoorUse::NotHung,
        clear_width_m: rounded(passage.clear_width_m),
    };
    WayLegAnswer {
        kind: "floor",
        storey: leg.map_storey,
        to_storey: leg.map_storey,
        length_m: rounded(leg.length_m),
        climb_m: rounded(leg.climb_m),
        descent_m: rounded(leg.descent_m),
        slope_rad: rounded(leg.slope_rad),
        duration_s: None,
        energy_wh: None,
        element: None,
        doors: leg.doors.iter().map(door).collect(),
        rooms: leg.spaces.iter().map(|space| RoomRef::of(site, *space)).collect(),
        points_m: leg.line.iter().zip(&leg.z_m).map(|(p, z_m)| [p.x_m(), p.y_m(), *z_m].map(rounded)).collect(),
    }
}

fn portal_answer(situation: &Situation<'_>, leg: &PortalLeg) -> WayLegAnswer {
    let plan = situation.mission_plan;
    let edge = &plan.edges[leg.edge];
    let mut storeys = edge.nodes.map(|node| plan.nodes[node as usize].map_storey);
    let mut points_m: Vec<[f64; 3]> = plan.points_of(edge).iter().map(|p| p.map(rounded)).collect();
    if !leg.is_forward {
        storeys.reverse();
        points_m.reverse();
    }
    let rises = || points_m.windows(2).map(|pair| pair[1][2] - pair[0][2]);
    WayLegAnswer {
        kind: edge.kind.get().name(),
        storey: storeys[0],
        to_storey: storeys[1],
        length_m: rounded(leg.length_m),
        climb_m: rounded(rises().map(|rise_m| rise_m.max(0.0)).sum()),
        descent_m: rounded(rises().map(|rise_m| (-rise_m).max(0.0)).sum()),
        slope_rad: rounded(edge.slope_rad),
        duration_s: None,
        energy_wh: None,
        element: (edge.of != NONE).then(|| ElementRef::of(situation.site, edge.of as usize)),
        doors: Vec::new(),
        rooms: Vec::new(),
        points_m,
    }
}
