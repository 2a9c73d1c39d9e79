//! `flight.json`: places in the air to fly to, which of them are joined, and why spaces have none.

use crate::input::ExportInput;
use crate::text::rounded;
use crate::waypoints::space_id;
use frames::metres;
use messages::{Flight, FlightHead, FlightSpaceRecord, FlightWaypointRecord, NoFlight, element_flags};
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// Flight waypoints, where options ask for them. Lengths in metres.
#[derive(Debug, Serialize, JsonSchema)]
pub struct FlightDocument {
    /// Version of this layout: 1.
    version: u32,
    /// `map`.
    frame: &'static str,
    /// Counts changes of the map frame.
    frame_epoch: u32,
    /// Plan time; null if all elements stand regardless of dates.
    plan_time: Option<String>,
    /// Least distance of all waypoints and edges from the bodies of what stands, and from rooms that are closed.
    clearance_m: f64,
    /// Largest distance in plan of waypoints that are joined.
    spacing_m: f64,
    /// Distance in plan of the places that were tried; null if none were.
    step_m: Option<f64>,
    /// Heights above the ground, ascending.
    heights_m: Vec<f64>,
    /// Farther than this no distance is measured.
    measured_m: f64,
    /// Number of connected parts.
    parts: u32,
    /// The waypoints: by storey, height, and place from south to north and west to east.
    waypoints: Vec<FlightWaypoint>,
    /// Ids of waypoints between which the straight way keeps the clearance, in both directions.
    edges: Vec<[u32; 2]>,
    /// Waypoints outside of spaces, storey by storey.
    outside_of_spaces: Vec<FlightOutside>,
    /// What became of each space, by GlobalId.
    spaces: BTreeMap<String, FlightSpace>,
    /// Elements that stand and whose body could not be made, by GlobalId: no distance is kept from them.
    without_body: BTreeSet<String>,
}

/// A place to fly to.
#[derive(Debug, Serialize, JsonSchema)]
struct FlightWaypoint {
    /// Its number, from 0.
    id: u32,
    /// Index of the map storey over whose floor it lies.
    storey: u32,
    /// GlobalId of the space over whose floor it lies; null outside of spaces.
    space: Option<String>,
    /// In `map`.
    x_m: f64,
    /// In `map`.
    y_m: f64,
    /// In `map`.
    z_m: f64,
    /// Above the highest ground of the storey within the clearance around it in plan.
    height_above_ground_m: f64,
    /// Distance to the nearest face of what stands, at most `measured_m`.
    clearance_m: f64,
    /// GlobalId of the nearest element, or of the site or road that is terrain; null if none is as near as `measured_m`.
    nearest: Option<String>,
    /// Number of its connected part, from 0, the largest first.
    part: u32,
}

/// Waypoints of a storey outside of spaces.
#[derive(Debug, Serialize, JsonSchema)]
struct FlightOutside {
    /// Index of the map storey.
    storey: u32,
    /// Number of waypoints, one for each height.
    waypoints: Vec<u32>,
}

/// What became of a space.
#[derive(Debug, Serialize, JsonSchema)]
struct FlightSpace {
    /// Index of the map storey; null if it is on none.
    storey: Option<u32>,
    /// One for each height.
    heights: Vec<FlightHeight>,
}

/// What became of a space at a height.
#[derive(Debug, Serialize, JsonSchema)]
struct FlightHeight {
    /// Height above the ground.
    height_m: f64,
    /// Number of waypoints.
    waypoints: u32,
    /// Why there is none; null if there is one.
    reason: Option<String>,
    /// The same as a code for programs: `not_asked`, `blocked`, `no_floor`, `too_narrow`, `within_body`, `other_floor`,
    /// `too_large`.
    why: Option<&'static str>,
    /// The largest distance that a place was found to have, where none keeps the clearance; else null.
    largest_clearance_m: Option<f64>,
}

impl FlightDocument {
    /// Of the inputs of an export; `None` if no flight waypoints were asked for.
    pub fn of(input: &ExportInput<'_>) -> Option<Self> {
        let (site, flight) = (input.site, input.mission_plan.flight.as_ref()?);
        let id = |space: usize| site.text(site.spaces[space].global_id).to_owned();
        let head = flight.head;
        let is_lost = |(k, element): &(usize, &messages::ElementRecord)| {
            input.schedule_state.effective(*k).is_obstacle() && element.has(element_flags::FAILED)
        };
        let lost = site.elements.iter().enumerate().filter(is_lost);
        Some(Self {
            version: 1,
            frame: "map",
            frame_epoch: site.head.frame_epoch,
            plan_time: input.schedule_state.head.plan_time().map(|time| time.to_string()),
            clearance_m: head.clearance_m,
            spacing_m: head.spacing_m,
            step_m: Some(head.step_m).filter(|step_m| *step_m > 0.0),
            heights_m: flight.heights_m.to_vec(),
            measured_m: FlightHead::MEASURED_M,
            parts: head.n_parts,
            waypoints: (0..).zip(flight.waypoints).map(|(id, record)| waypoint(input, id, record)).collect(),
            edges: flight.edges.to_vec(),
            outside_of_spaces: outside_of_spaces(flight),
            spaces: (0..site.spaces.len()).map(|k| (id(k), space(input, flight, k))).collect(),
            without_body: lost.map(|(_, element)| site.text(element.global_id).to_owned()).collect(),
        })
    }
}

fn waypoint(input: &ExportInput<'_>, id: u32, record: &FlightWaypointRecord) -> FlightWaypoint {
    let site = input.site;
    let [x_m, y_m, z_m] = record.position_in_map_tenths.map(|c| rounded(metres(c)));
    let element = site.elements.get(record.element as usize).map(|element| element.global_id);
    let nearest = element.or_else(|| site.terrains.get(record.terrain as usize).map(|terrain| terrain.global_id));
    FlightWaypoint {
        id,
        storey: record.map_storey,
        space: space_id(input, record.space),
        x_m,
        y_m,
        z_m,
        height_above_ground_m: rounded(z_m - metres(record.ground_z_tenths)),
        clearance_m: rounded(record.clearance_m),
        nearest: nearest.map(|id| site.text(id).to_owned()),
        part: record.part,
    }
}

fn outside_of_spaces(flight: &Flight<'_>) -> Vec<FlightOutside> {
    let mut by_storey: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for waypoint in flight.waypoints.iter().filter(|waypoint| waypoint.space == messages::NONE) {
        let counts = by_storey.entry(waypoint.map_storey).or_insert_with(|| vec![0; flight.heights_m.len()]);
        counts[waypoint.height as usize] += 1;
    }
    by_storey.into_iter().map(|(storey, waypoints)| FlightOutside { storey, waypoints }).collect()
}

fn space(input: &ExportInput<'_>, flight: &Flight<'_>, space: usize) -> FlightSpace {
    let map_storey = input.site.spaces[space].map_storey;
    let records = flight.of_space(space).iter().zip(flight.heights_m);
    FlightSpace {
        storey: (map_storey != messages::NONE).then_some(map_storey),
        heights: records.map(|(record, height_m)| height(input, flight, space, record, *height_m)).collect(),
    }
}

fn height(
    input: &ExportInput<'_>,
    flight: &Flight<'_>,
    space: usize,
    record: &FlightSpaceRecord,
    height_m: f64,
) -> FlightHeight {
    let (why, clearance_m) = (record.why.get(), flight.head.clearance_m);
    let largest_m = rounded(record.largest_clearance_m);
    let reason = match why {
        NoFlight::Has => None,
        NoFlight::NotAsked => Some("it was not asked for".to_owned()),
        NoFlight::Blocked => {
            let why = input.schedule_state.why(space).collect::<Vec<_>>().join(", ");
            Some(format!("it is blocked: {why}"))
        }
        NoFlight::NoFloor => Some("no place that was tried lies over floor of it".to_owned()),
        NoFlight::TooNarrow => {
            Some(format!("no place that was tried keeps {clearance_m} m: {largest_m} m are the most"))
        }
        NoFlight::WithinBody => Some(format!("all places that keep {clearance_m} m lie within a body")),
        NoFlight::OtherFloor => Some("another floor lies between its own and that height".to_owned()),
        NoFlight::TooLarge => Some(
            "no flight waypoints are planned: the site has too many places, or cells too large for the spacing"
                .to_owned(),
        ),
    };
    FlightHeight {
        height_m,
        waypoints: record.n_waypoints,
        reason,
        why: (why != NoFlight::Has).then(|| why.name()),
        largest_clearance_m: (why == NoFlight::TooNarrow).then_some(largest_m),
    }
}
