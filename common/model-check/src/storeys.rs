//! Storeys: apart from the others, at another height than their floors, and without a map.

use crate::causes::IssueCode;
use crate::evidence::{Found, Subject};
use crate::rooms::is_room;
use answers::Situation;
use frames::metres;
use geometry::DisjointSets;
use messages::{EdgeKind, NONE, Site};
use std::collections::{BTreeMap, BTreeSet};

/// Storey and floor that differ by more disagree: floors, screeds and structural levels differ by less.
const MAX_OFF: i32 = 5_000;

/// What is found of the storeys.
pub(crate) fn storeys(situation: &Situation<'_>) -> Vec<Found> {
    let site = situation.site;
    let mut all = apart(situation);
    all.extend(at_other_heights(site));
    all.extend(not_mapped(site));
    all
}

/// Storeys with rooms to which nothing leads from the storey of most rooms.
fn apart(situation: &Situation<'_>) -> Vec<Found> {
    let Situation { site, mission_plan, .. } = *situation;
    let mut rooms: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for space in (0..site.spaces.len()).filter(|space| is_room(site, *space) && site.spaces[*space].n_rings > 0) {
        let map_storey = site.spaces[space].map_storey;
        if map_storey != NONE {
            rooms.entry(map_storey).or_default().push(space as u32);
        }
    }
    let mut sets = DisjointSets::new(site.map_storeys.len());
    for edge in mission_plan.edges.iter().filter(|edge| !matches!(edge.kind.get(), EdgeKind::Floor | EdgeKind::Door)) {
        let [a, b] = edge.nodes.map(|node| mission_plan.nodes[node as usize].map_storey);
        sets.join(a, b);
    }
    let mut n_rooms: BTreeMap<u32, usize> = BTreeMap::new();
    for (storey, of_storey) in &rooms {
        *n_rooms.entry(sets.first(*storey)).or_insert(0) += of_storey.len();
    }
    let Some(main) = n_rooms.iter().max_by_key(|(first, n)| (**n, std::cmp::Reverse(**first))).map(|(first, _)| *first)
    else {
        return Vec::new();
    };
    // A roof with a room over it, and no door, is no storey that people go to.
    let has_door = |storey: u32| site.doors.iter().any(|door| door.map_storey == storey);
    let is_apart: Vec<u32> =
        rooms.keys().copied().filter(|storey| sets.first(*storey) != main && has_door(*storey)).collect();
    let found = |storey: u32| {
        let mut found = Found::of(IssueCode::StoreysApart, Subject::MapStorey(storey), why_apart(site, storey));
        found.rooms.clone_from(&rooms[&storey]);
        found
    };
    is_apart.into_iter().map(found).collect()
}

/// What of stairs there is at a storey that nothing leads to.
fn why_apart(site: &Site<'_>, storey: u32) -> String {
    let z = site.map_storeys[storey as usize].floor_z_tenths;
    let is_near = |e: &&messages::ElementRecord| {
        e.has(messages::element_flags::VERTICAL)
            && e.whole == NONE
            && e.n_parts > 0
            && e.min_tenths[2] < z + 20_000
            && z - 20_000 < e.max_tenths[2]
    };
    let near: Vec<String> = site
        .elements
        .iter()
        .filter(is_near)
        .take(3)
        .map(|e| {
            let [low, high] = [e.min_tenths[2], e.max_tenths[2]].map(metres);
            format!("{} {} goes from {low:.2} m to {high:.2} m", site.text(e.ifc_type), site.text(e.global_id))
        })
        .collect();
    let floor = format!("its floor lies at {:.2} m", metres(z));
    if near.is_empty() {
        format!("{floor}; no stair, ramp or lift is near that height")
    } else {
        format!("{floor}; {}", near.join(", "))
    }
}

/// Storeys whose placement and floor disagree.
fn at_other_heights(site: &Site<'_>) -> Vec<Found> {
    let off = |k: usize| {
        let storey = &site.storeys[k];
        let map_storey = site.map_storeys.get(storey.map_storey as usize)?;
        // A storey that gave its name to the map, and has floor of its own.
        let is_own =
            storey.has_placement == 1 && storey.why.length == 0 && map_storey.floor.get() == messages::FloorKind::Built;
        let by = map_storey.floor_z_tenths - storey.placement_z_tenths;
        (is_own && by.abs() > MAX_OFF).then(|| {
            let [storey_m, floor_m] = [storey.placement_z_tenths, map_storey.floor_z_tenths].map(metres);
            let text = format!("it is placed at {storey_m:.2} m, and its floor lies at {floor_m:.2} m");
            Found::of(IssueCode::StoreyElevation, Subject::Storey(k), text)
        })
    };
    (0..site.storeys.len()).filter_map(off).collect()
}

/// Storeys without a map that contain rooms or doors.
fn not_mapped(site: &Site<'_>) -> Vec<Found> {
    let found = |k: usize| {
        let storey = &site.storeys[k];
        if storey.map_storey != NONE {
            return None;
        }
        let of_storey = |space: &usize| site.spaces[*space].storey == k as u32 && is_room(site, *space);
        let rooms: Vec<u32> = (0..site.spaces.len()).filter(of_storey).map(|space| space as u32).collect();
        let contains = |door: &messages::DoorRecord| site.elements[door.element as usize].storey == k as u32;
        let doors: BTreeSet<u32> = (0..).zip(site.doors).filter(|(_, door)| contains(door)).map(|(d, _)| d).collect();
        // Rooms of it that lie on another storey's map are not lost.
        let lost: Vec<u32> =
            rooms.into_iter().filter(|space| site.spaces[*space as usize].map_storey == NONE).collect();
        let lost_doors: Vec<u32> =
            doors.into_iter().filter(|door| site.doors[*door as usize].map_storey == NONE).collect();
        if lost.is_empty() && lost_doors.is_empty() {
            return None;
        }
        let mut found = Found::of(IssueCode::StoreyNotMapped, Subject::Storey(k), site.text(storey.why));
        found.area_m2 = lost.iter().map(|space| site.spaces[*space as usize].area_m2).sum();
        (found.rooms, found.doors) = (lost, lost_doors);
        Some(found)
    };
    (0..site.storeys.len()).filter_map(found).collect()
}
