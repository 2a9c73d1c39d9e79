//! Evidence over looks at a growing map: what is new counts once, and what was accepted does not change in silence.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

#[path = "../../../occupancy/tests/support/mod.rs"]
mod support;

use alignment::{Alignment, HeldOut, Looks, PreparedMap, align_maps_within, references_hash};
use frames::{Map, Rigid2, Slam};
use messages::{AlignmentEvidence, AlignmentVerdict, ArchiveBuffer, ContentHash, NONE};
use occupancy::{Cell, OccupancyMap};
use support::{PLACES, Walls, flat, model, scanned, scanned_bent};

fn truth() -> Rigid2<Map, Slam> {
    Rigid2::new([3.0, -7.0], 0.4)
}

/// The alignment of a map, and the evidence after it, if it adds to that before.
fn look(walls: &Walls, map: &OccupancyMap, before: Option<&ArchiveBuffer>) -> (Alignment, Option<ArchiveBuffer>) {
    let (references, slam) = ([PreparedMap::of_model(&model(walls))], PreparedMap::of_slam(map));
    let hash = references_hash(&references, &[NONE]);
    let before = before.map(|archive| AlignmentEvidence::open(archive.bytes()).unwrap());
    let looks = before.and_then(|evidence| Looks::of(evidence, hash, &slam));
    let found = align_maps_within(&references, &[NONE], &slam, None, &[], looks.as_ref());
    let map_hash = map.content_hash().unwrap();
    let after = found.evidence(&slam, map_hash, hash, &[NONE], looks.as_ref());
    (found, after)
}

fn seen_from(n_places: usize) -> OccupancyMap {
    scanned(&flat(), &PLACES[..n_places], truth(), 0.05, 0.0)
}

fn n_known(evidence: &AlignmentEvidence<'_>) -> usize {
    (0..evidence.head.width as usize * evidence.head.height as usize).filter(|k| evidence.is_known(*k)).count()
}

fn known_in(map: &OccupancyMap) -> usize {
    map.cells.iter().filter(|cell| **cell != Cell::Unknown).count()
}

#[test]
fn a_growing_map_adds_what_is_new_and_the_same_map_again_adds_nothing() {
    let maps = [1, 2, PLACES.len()].map(seen_from);
    let (first, evidence) = look(&flat(), &maps[0], None);
    assert!(first.poses.iter().all(|pose| pose.new.is_none()) && first.change.is_none());
    let mut evidence = evidence.unwrap();
    let mut before_hash = ContentHash::NONE;
    for (k, map) in maps.iter().enumerate() {
        let view = AlignmentEvidence::open(evidence.bytes()).unwrap();
        assert_eq!((view.head.n_looks as usize, view.head.before_hash), (k + 1, before_hash));
        assert_eq!((view.head.slam_map_hash, n_known(&view)), (map.content_hash().unwrap(), known_in(map)));
        let (again, nothing) = look(&flat(), map, Some(&evidence));
        assert!(nothing.is_none(), "nothing is new");
        assert_eq!(again.poses[0].new, Some(HeldOut::default()));
        before_hash = view.content_hash();
        let Some(next) = maps.get(k + 1) else { break };
        let (found, after) = look(&flat(), next, Some(&evidence));
        let new = found.poses[0].new.unwrap();
        assert!(new.seen_m > 1.0 && new.recalled_m > 0.7 * new.seen_m && new.through_m < 0.1 * new.seen_m, "{new:?}");
        // The same from the same.
        let (_, same) = look(&flat(), next, Some(&evidence));
        assert_eq!(after.as_ref().unwrap().bytes(), same.unwrap().bytes());
        evidence = after.unwrap();
    }
}

#[test]
fn a_robot_that_begins_another_map_begins_anew() {
    let (_, evidence) = look(&flat(), &seen_from(2), None);
    let elsewhere = scanned(&flat(), &PLACES[2..], Rigid2::new([30.0, 9.0], -1.0), 0.05, 0.0);
    let (found, after) = look(&flat(), &elsewhere, evidence.as_ref());
    assert!(found.poses.iter().all(|pose| pose.new.is_none()));
    let after = after.unwrap();
    let head = *AlignmentEvidence::open(after.bytes()).unwrap().head;
    assert_eq!((head.n_looks, head.before_hash), (1, ContentHash::NONE));
    // So does a robot in another building.
    let mut other = flat();
    other.push([8.0, 6.5, 9.0, 6.7]);
    let (found, _) = look(&other, &seen_from(PLACES.len()), evidence.as_ref());
    assert!(found.poses.iter().all(|pose| pose.new.is_none()));
}

#[test]
fn a_map_that_a_loop_closure_bends_goes_on_and_what_moved_is_not_new() {
    let straight = seen_from(PLACES.len());
    let (_, evidence) = look(&flat(), &straight, None);
    let bent = scanned_bent(&flat(), &PLACES, truth(), 0.05, 0.0, &|[x, y]| [x, y + 0.01 * x]);
    let (found, after) = look(&flat(), &bent, evidence.as_ref());
    let new = found.poses[0].new.unwrap();
    assert!(new.seen_m < 0.5 && after.is_none(), "{new:?}");
}

#[test]
fn a_pose_that_an_earlier_look_accepted_is_not_withdrawn_or_replaced_in_silence() {
    let whole = seen_from(PLACES.len());
    let (found, evidence) = look(&flat(), &whole, None);
    assert_eq!(found.verdict, AlignmentVerdict::Accepted, "{}", found.reason);
    let evidence = evidence.unwrap();
    let accepted = AlignmentEvidence::open(evidence.bytes()).unwrap().accepted().unwrap().map_from_slam;
    assert_eq!(accepted, found.poses[0].map_from_slam.x_y_yaw());
    let (again, _) = look(&flat(), &whole, Some(&evidence));
    assert!(again.change.is_none() && again.verdict == AlignmentVerdict::Accepted);
    // Walls that were there are gone.
    let free = |cell: &Cell| if *cell == Cell::Occupied { Cell::Free } else { *cell };
    let without_walls = OccupancyMap { cells: whole.cells.iter().map(free).collect(), ..whole.clone() };
    let (refused, after) = look(&flat(), &without_walls, Some(&evidence));
    assert!(refused.verdict == AlignmentVerdict::Refused && after.is_none());
    let change = refused.change.unwrap();
    assert!(change.starts_with("the pose that an earlier look at this map accepted is withdrawn: x 3.0"), "{change}");
    // The robot believes that it is elsewhere.
    let moved = OccupancyMap { origin: [whole.origin[0] + 1.0, whole.origin[1], 0.0], ..whole };
    let (moved, _) = look(&flat(), &moved, Some(&evidence));
    assert_eq!(moved.verdict, AlignmentVerdict::Accepted, "{}", moved.reason);
    assert!(moved.change.unwrap().starts_with("an earlier look at this map accepted another pose: x 3.0"));
}

#[test]
fn new_places_speak_against_a_pose_in_which_the_robot_sees_through_walls() {
    let (_, evidence) = look(&flat(), &seen_from(2), None);
    // What the robot had not seen yet is not as planned.
    let built: Walls =
        flat().into_iter().enumerate().filter(|(k, _)| ![6, 7, 8, 9].contains(k)).map(|(_, w)| w).collect();
    let planned = look(&flat(), &seen_from(PLACES.len()), evidence.as_ref()).0;
    let map = scanned(&built, &PLACES, truth(), 0.05, 0.0);
    let (found, _) = look(&flat(), &map, evidence.as_ref());
    let [as_planned, as_built] = [planned.poses[0].new, found.poses[0].new].map(Option::unwrap);
    assert!(as_built.through_m > as_planned.through_m + 0.5, "{as_built:?}, {as_planned:?}");
}
