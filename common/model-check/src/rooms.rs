//! Rooms: without floor, without a door, out of reach, on no map, in each other, and floor in no room.

use crate::causes::IssueCode;
use crate::evidence::{Found, Group, Subject};
use crate::regions::Regions;
use answers::{RoomRef, Situation};
use export::NotMapped;
use frames::metres;
use geometry::{Bounds, MultiPolygon, intersection};
use messages::{FloorKind, NONE, NoWaypoint, Site, SpaceAccess, space_flags};
use std::collections::BTreeSet;

/// Rooms that share less are not said to overlap.
const MIN_SHARED_M2: f64 = 0.25;
/// Share of the smaller room below which they are not said to overlap: walls are drawn along their middle by some programs.
const MIN_SHARED_PART: f64 = 0.03;
/// Words by which people name what is open to the storey below; parts of names, lower case.
const VOIDS: [&str; 12] = [
    "void", "atrium", "shaft", "luftraum", "schacht", "leerraum", "vide ", "gaine", "puits", "hueco", "schaht",
    "shacht",
];

/// True if a space is a room indoors: no gross area, nothing outdoors, no shaft.
pub(crate) fn is_room(site: &Site<'_>, space: usize) -> bool {
    let record = &site.spaces[space];
    ![space_flags::METADATA_ONLY, space_flags::EXTERNAL, space_flags::SHAFT].into_iter().any(|flag| record.has(flag))
}

/// Rooms to which no way leads.
pub(crate) fn unreachable(situation: &Situation<'_>, storeys: &[Regions]) -> BTreeSet<u32> {
    let site = situation.site;
    let plan = situation.mission_plan;
    let is_out = |space: &u32| {
        let has_reached = storeys.iter().any(|storey| storey.has_reached(*space));
        let space = *space as usize;
        let why = plan.spaces[space].why.get();
        // Of rooms in each other that is told; a void has no floor.
        let is_no_place = why == NoWaypoint::Shared || (why == NoWaypoint::NoFloor && is_void(site, space));
        let is_mapped = is_room(site, space) && site.spaces[space].map_storey != NONE;
        is_mapped && plan.spaces[space].access == SpaceAccess::NoWay && !has_reached && !is_no_place
    };
    (0..site.spaces.len() as u32).filter(is_out).collect()
}

/// True if people mean a void by the name of a space, or the room below reaches up through it.
pub(crate) fn is_void(site: &Site<'_>, space: usize) -> bool {
    let record = &site.spaces[space];
    let names = [record.name, record.long_name].map(|name| site.text(name).to_lowercase() + " ");
    let is_named = VOIDS.iter().any(|word| names.iter().any(|name| name.contains(word)));
    is_named
        || opens_to_below(site, record.floor_z_tenths, record.centroid_m.map(|c| c * f64::from(frames::TENTHS_PER_M)))
}

/// True if a room of a lower floor reaches up through a height at a place.
pub(crate) fn opens_to_below(site: &Site<'_>, floor_z: i32, place: [f64; 2]) -> bool {
    site.spaces.iter().any(|below| {
        let top = below.floor_z_tenths.saturating_add(below.height_tenths);
        let is_below = below.n_rings > 0 && below.floor_z_tenths < floor_z - 10_000 && top > floor_z + 3_000;
        is_below && !below.has(space_flags::METADATA_ONLY) && site.floor_polygon(below).contains(place)
    })
}

/// What is found of rooms as the files have them.
pub(crate) fn rooms(situation: &Situation<'_>) -> Vec<Found> {
    let site = situation.site;
    let mut all = without_floor(situation);
    for space in export::assumed_rooms(site) {
        let mut found = Found::of(IssueCode::FloorAssumed, Subject::Space(space as usize), "");
        found.area_m2 = site.spaces[space as usize].area_m2;
        found.rooms.push(space);
        all.push(found);
    }
    all.extend(assumed_storeys(situation));
    all.extend(overlapping(site));
    all
}

/// Rooms on no map, and rooms with a map and no floor.
fn without_floor(situation: &Situation<'_>) -> Vec<Found> {
    let site = situation.site;
    let of_room = |room: export::RoomNotMapped| {
        let space = room.space as usize;
        let code = match room.reason {
            NotMapped::Shaft => return None,
            NotMapped::NoFloor | NotMapped::NoLevel if is_void(site, space) => return None,
            NotMapped::NoFloor => IssueCode::RoomWithoutFloor,
            NotMapped::NoLevel => IssueCode::RoomNotMapped,
        };
        let mut found = Found::of(code, Subject::Space(space), room.reason.text());
        found.area_m2 = site.spaces[space].area_m2;
        found.rooms.push(room.space);
        Some(found)
    };
    export::spaces_not_mapped(&situation.export_input()).into_iter().filter_map(of_room).collect()
}

/// Storeys whose floor is what walls enclose, or that have none.
fn assumed_storeys(situation: &Situation<'_>) -> Vec<Found> {
    let of_grid = |grid: &messages::Grid<'_>| {
        let cell_m2 = metres(grid.head.cell_tenths) * metres(grid.head.cell_tenths);
        let subject = Subject::MapStorey(grid.head.map_storey);
        match grid.head.floor.get() {
            FloorKind::AssumedFromEnclosure => {
                let mut found = Found::of(IssueCode::StoreyFloorAssumed, subject, "");
                found.area_m2 = grid.floor.iter().filter(|floor| **floor != 0).count() as f64 * cell_m2;
                Some(found)
            }
            FloorKind::Missing => Some(Found::of(IssueCode::StoreyWithoutFloor, subject, "")),
            FloorKind::Built | FloorKind::AssumedFromSpaces | FloorKind::Ground => None,
        }
    };
    situation.grids.each(of_grid).flatten().collect()
}

/// Rooms of a storey that share floor.
fn overlapping(site: &Site<'_>) -> Vec<Found> {
    let is_mapped = |k: &usize| is_room(site, *k) && site.spaces[*k].n_rings > 0 && !is_void(site, *k);
    let polygon = |k: usize| {
        let polygon = site.floor_polygon(&site.spaces[k]);
        polygon.bounds().map(|bounds| (k, polygon, bounds))
    };
    let mut rooms: Vec<(usize, MultiPolygon, Bounds)> =
        (0..site.spaces.len()).filter(is_mapped).filter_map(polygon).collect();
    rooms.sort_by_key(|(k, _, bounds)| (bounds.min[0], *k));
    let mut all: Vec<Found> = Vec::new();
    for (at, (a, polygon_a, bounds_a)) in rooms.iter().enumerate() {
        let near = rooms[at + 1..].iter().take_while(|(_, _, bounds)| bounds.min[0] < bounds_a.max[0]);
        for (b, polygon_b, _) in near.filter(|(_, _, bounds)| bounds.meets(bounds_a)) {
            all.extend(shared(site, (*a, polygon_a), (*b, polygon_b)));
        }
    }
    // A room in two others is told once, with that which it shares most with.
    let space = |found: &Found| found.rooms.first().copied();
    all.sort_by(|a, b| space(a).cmp(&space(b)).then(b.area_m2.total_cmp(&a.area_m2)));
    all.dedup_by_key(|found| space(found));
    all
}

fn shared(site: &Site<'_>, a: (usize, &MultiPolygon), b: (usize, &MultiPolygon)) -> Option<Found> {
    let ranges = [a.0, b.0].map(|k| {
        let record = &site.spaces[k];
        [record.floor_z_tenths, record.floor_z_tenths.saturating_add(record.height_tenths.max(1))]
    });
    let in_height = ranges[0][1].min(ranges[1][1]) - ranges[0][0].max(ranges[1][0]);
    // A room whose ceiling reaches a little into the storey above is not in its rooms.
    if in_height < 5_000 {
        return None;
    }
    let common = intersection(a.1, b.1);
    let area_m2 = common.area_m2();
    let (small, large) = if a.1.area_m2() <= b.1.area_m2() { (a, b) } else { (b, a) };
    let small_m2 = small.1.area_m2();
    if area_m2 < MIN_SHARED_M2 || area_m2 < MIN_SHARED_PART * small_m2 {
        return None;
    }
    let other = RoomRef::of(site, large.0);
    let text = format!("{area_m2:.1} of {small_m2:.1} m2 lie in {} ({})", other.label(), other.global_id);
    let mut found = Found::of(IssueCode::RoomsOverlap, Subject::Space(small.0), text);
    found.area_m2 = area_m2;
    found.rooms = vec![small.0 as u32, large.0 as u32];
    let bounds = common.bounds()?;
    let bounds_m = [bounds.min, bounds.max].map(|p| p.map(|c| export::rounded(metres(c))));
    found.place =
        crate::evidence::place_of_space(site, small.0).map(|place| crate::document::Place { bounds_m, ..place });
    Some(found)
}

/// Rooms that stay out of reach whatever the issues so far explain.
pub(crate) fn left_over(situation: &Situation<'_>, storeys: &[Regions], rooms: &BTreeSet<u32>) -> Vec<Found> {
    let site = situation.site;
    let found = |&space: &u32| {
        let has_door = site.doors.iter().any(|door| door.spaces.contains(&space));
        let reason = situation.mission_plan.access_reason(space as usize);
        let is_open = storeys.iter().any(|storey| storey.is_shared(space));
        let (code, text) = match situation.mission_plan.spaces[space as usize].why.get() {
            // What stands there is there, as far as the model knows.
            NoWaypoint::TooNarrow | NoWaypoint::Keepout | NoWaypoint::Blocked | NoWaypoint::Closing => {
                (IssueCode::RoomBehind, reason.to_owned())
            }
            _ if has_door || is_open || is_void(site, space as usize) => {
                (IssueCode::RoomUnreachable, reason.to_owned())
            }
            _ => (IssueCode::RoomWithoutDoor, String::new()),
        };
        let mut found = Found::of(code, Subject::Space(space as usize), text);
        found.area_m2 = site.spaces[space as usize].area_m2;
        found.rooms.push(space);
        found
    };
    rooms.iter().map(found).collect()
}

/// What each group keeps out of reach: alone, then together with others of its kind.
pub(crate) fn reach(groups: &mut [Group], storeys: &[Regions], unreachable: &BTreeSet<u32>) -> BTreeSet<u32> {
    use crate::causes::IssueKind;
    use crate::regions::gain;
    let mut explained = BTreeSet::new();
    // What an earlier kind opens is not told again of a later one.
    let mut before = crate::regions::Gain::default();
    let mut joins = Vec::new();
    for kinds in [&[IssueKind::Maps, IssueKind::Data][..], &[IssueKind::Building]] {
        let own = |group: &&mut Group| kinds.contains(&group.kind);
        let mut alone = crate::regions::Gain::default();
        for group in groups.iter_mut().filter(own) {
            let of_group = || joins.iter().chain(group.found.iter().flat_map(|found| &found.joins));
            let gained = gain(storeys, of_group()).without(&before);
            if gained.is_empty() {
                continue;
            }
            group.unreachable = gained.rooms(storeys, unreachable);
            group.unreachable_m2 = gained.area_m2(storeys);
            alone = alone.joined(&gained);
        }
        let added: Vec<_> =
            groups.iter_mut().filter(own).flat_map(|g| g.found.iter().flat_map(|f| f.joins.clone())).collect();
        joins.extend(added);
        let together = gain(storeys, joins.iter());
        let rest = together.without(&before).without(&alone);
        // Rooms behind two causes at once: told of that with the most doors.
        if let Some(group) = groups
            .iter_mut()
            .filter(own)
            .filter(|g| g.found.iter().any(|f| !f.joins.is_empty()))
            .max_by_key(|g| g.found.len())
            && !rest.is_empty()
        {
            group.unreachable.extend(rest.rooms(storeys, unreachable));
            group.unreachable_m2 += rest.area_m2(storeys);
        }
        explained.extend(together.rooms(storeys, unreachable));
        before = together;
    }
    explained
}
