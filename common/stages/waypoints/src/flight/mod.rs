//! Flight waypoints: places in the air over floor and ground that keep a distance in all directions from what stands, and the straight
//! ways between them.
//!
//! The distance is that from the triangles of the bodies: grids say where the floor of storeys is and how high, nothing else.

mod air;
mod choice;
mod edges;
mod links;
mod outdoor_ground;
mod places;

use crate::flight_options::FlightOptions;
use crate::input::MissionPlanInput;
use air::Air;
use choice::Regions;
use edges::{FlightGraph, joined};
use frames::{TENTHS_PER_M, metres};
use links::Links;
use messages::{FlightHead, FlightRecords, FlightSpaceRecord, FlightWaypointRecord, NONE, NoFlight};
use outdoor_ground::OutdoorGround;
use places::{AirNode, AirNodes, NoLattice, Tried, Wanted, air_nodes, floor_places, is_asked_for, lattice};
use std::collections::BTreeMap;
use std::f64::consts::SQRT_2;

/// Flight waypoints of one plan, at most.
pub(crate) const MAX_WAYPOINTS: usize = 100_000;

/// Flight waypoints, or why there are none at all.
#[derive(Debug, Clone)]
pub(crate) struct FlightPlan {
    pub(crate) records: FlightRecords,
    /// A sentence for people.
    pub(crate) refusal: Option<String>,
}

/// Plans the flight waypoints of a site at a schedule state.
pub(crate) fn flight_plan(input: &MissionPlanInput<'_>, options: &FlightOptions) -> FlightPlan {
    let wanted = Wanted::of(input);
    let outdoors = OutdoorGround::of(input);
    let lattice = match lattice(input, options, &wanted, &outdoors) {
        Ok(lattice) => lattice,
        Err(why) => return refused(input, options, &why.to_string()),
    };
    let air = Air::of(input);
    let places = floor_places(input, options.clearance_tenths, &wanted, &outdoors, lattice);
    drop(outdoors);
    let AirNodes { nodes, tried } = air_nodes(&places, options, &wanted, lattice, &air);
    let FlightOptions { clearance_tenths: clearance, spacing_tenths: spacing, .. } = *options;
    let (nodes, links) = outside_of_bodies(nodes, &air, clearance, spacing);
    // Two ways to a waypoint, and a link between them, are no longer than the spacing.
    let reach = (f64::from(spacing) / f64::from(lattice.step) - SQRT_2) / 2.0;
    let regions = Regions::of(&nodes, &links, reach);
    let graph = joined(&nodes, &links, &regions, &air, [clearance, spacing]);
    if graph.waypoints.len() > MAX_WAYPOINTS {
        let n = graph.waypoints.len();
        return refused(
            input,
            options,
            &format!("there would be {n} flight waypoints, and {MAX_WAYPOINTS} are the most"),
        );
    }
    let mut records = empty(options);
    records.head.step_m = metres(lattice.step);
    add_waypoints(&mut records, input, &nodes, &graph, &air);
    number_parts(&mut records);
    records.spaces = outcomes(&records, input, &tried);
    FlightPlan { records, refusal: None }
}

impl std::fmt::Display for NoLattice {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::TooManyPlaces(n) => write!(
                f,
                "{n} places would be tried, and {} are the most: a larger spacing_m, fewer heights_m, or spaces have fewer",
                places::MAX_PLACES
            ),
            Self::CellsTooLarge(cell) => {
                write!(f, "cells of the maps are {} m wide: spacing_m must be four times that", metres(*cell))
            }
        }
    }
}

/// Nodes that lie within no body, and their links. A link meets no surface: what is linked lies within the same bodies.
fn outside_of_bodies(nodes: Vec<AirNode>, air: &Air, clearance: i32, spacing: i32) -> (Vec<AirNode>, Links) {
    let links = Links::of(&nodes, air, clearance, spacing);
    let parts = links.parts();
    let is_first = |k: &usize| parts[*k] as usize == *k;
    let within: Vec<bool> =
        (0..nodes.len()).map(|k| is_first(&k) && air.body_around(nodes[k].position).is_some()).collect();
    let is_kept: Vec<bool> = parts.iter().map(|&first| !within[first as usize]).collect();
    if is_kept.iter().all(|kept| *kept) {
        return (nodes, links);
    }
    let kept = nodes.iter().zip(&is_kept).filter(|(_, kept)| **kept).map(|(node, _)| *node).collect();
    (kept, links.of_kept(&is_kept))
}

/// Records without waypoints.
fn empty(options: &FlightOptions) -> FlightRecords {
    let head = FlightHead {
        clearance_m: metres(options.clearance_tenths),
        spacing_m: metres(options.spacing_tenths),
        step_m: 0.0,
        n_parts: 0,
        reserved: 0,
    };
    let heights_m = options.heights_tenths.iter().map(|height| metres(*height)).collect();
    FlightRecords { head, heights_m, ..FlightRecords::default() }
}

fn refused(input: &MissionPlanInput<'_>, options: &FlightOptions, why: &str) -> FlightPlan {
    let mut records = empty(options);
    let nothing = FlightSpaceRecord { largest_clearance_m: 0.0, n_waypoints: 0, why: NoFlight::TooLarge.into() };
    records.spaces = vec![nothing; input.site.spaces.len() * records.heights_m.len()];
    FlightPlan { records, refusal: Some(format!("no flight waypoints are planned: {why}")) }
}

fn add_waypoints(
    records: &mut FlightRecords,
    input: &MissionPlanInput<'_>,
    nodes: &[AirNode],
    graph: &FlightGraph,
    air: &Air,
) {
    let farthest = FlightHead::MEASURED_M * f64::from(TENTHS_PER_M);
    let ids: BTreeMap<u32, u32> = graph.waypoints.iter().copied().zip(0..).collect();
    for &node in &graph.waypoints {
        let AirNode { layer: [grid, height], position, ground, space, .. } = nodes[node as usize];
        let nearest = air.nearest(position, farthest);
        let [element, terrain] = nearest.map_or([NONE; 2], |(owner, _)| owner.numbers());
        records.waypoints.push(FlightWaypointRecord {
            clearance_m: nearest.map_or(farthest, |(_, distance)| distance) / f64::from(TENTHS_PER_M),
            position_in_map_tenths: position,
            ground_z_tenths: ground,
            map_storey: input.grids.head(grid as usize).map_storey,
            height,
            space: space.checked_sub(1).unwrap_or(NONE),
            part: 0,
            element,
            terrain,
        });
    }
    records.edges = graph.edges.iter().map(|edge| edge.map(|node| ids[&node])).collect();
}

/// Numbers connected parts from that with the most waypoints.
fn number_parts(records: &mut FlightRecords) {
    let mut sets = geometry::DisjointSets::new(records.waypoints.len());
    records.edges.iter().for_each(|&[a, b]| sets.join(a, b));
    let firsts: Vec<u32> = (0..records.waypoints.len() as u32).map(|k| sets.first(k)).collect();
    let mut sizes: BTreeMap<u32, usize> = BTreeMap::new();
    firsts.iter().for_each(|first| *sizes.entry(*first).or_default() += 1);
    let mut order: Vec<(u32, usize)> = sizes.into_iter().collect();
    order.sort_by_key(|&(first, size)| (std::cmp::Reverse(size), first));
    let numbers: BTreeMap<u32, u32> = order.iter().map(|(first, _)| *first).zip(0..).collect();
    records.head.n_parts = numbers.len() as u32;
    for (waypoint, first) in records.waypoints.iter_mut().zip(&firsts) {
        waypoint.part = numbers[first];
    }
}

/// What became of each space at each height; what was tried is by space plus 1 and height.
fn outcomes(records: &FlightRecords, input: &MissionPlanInput<'_>, tried: &[Tried]) -> Vec<FlightSpaceRecord> {
    let n_heights = records.heights_m.len();
    let mut counts = vec![0; tried.len() - n_heights];
    for waypoint in records.waypoints.iter().filter(|waypoint| waypoint.space != NONE) {
        counts[waypoint.space as usize * n_heights + waypoint.height as usize] += 1;
    }
    let why = |space: usize, n: u32, tried: &Tried| match tried {
        _ if n > 0 => NoFlight::Has,
        _ if !is_asked_for(input.options, input.site, space) => NoFlight::NotAsked,
        _ if input.schedule_state.is_blocked(space) => NoFlight::Blocked,
        Tried { n_places: 0, .. } => NoFlight::NoFloor,
        Tried { n_clear: 0, n_over_other_floor: 0, .. } => NoFlight::TooNarrow,
        Tried { n_clear: 0, .. } => NoFlight::OtherFloor,
        _ => NoFlight::WithinBody,
    };
    let outcome = |(k, (n_waypoints, tried)): (usize, (u32, &Tried))| {
        let why = why(k / n_heights, n_waypoints, tried);
        let largest = if why == NoFlight::TooNarrow { tried.largest } else { 0.0 };
        let largest_clearance_m = largest / f64::from(TENTHS_PER_M);
        FlightSpaceRecord { largest_clearance_m, n_waypoints, why: why.into() }
    };
    counts.into_iter().zip(&tried[n_heights..]).enumerate().map(outcome).collect()
}
