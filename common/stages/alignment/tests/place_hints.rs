//! Hints of places: they exclude the poses that contradict them, and a wrong one accepts nothing.

#[path = "../../../occupancy/tests/support/mod.rs"]
mod support;

use alignment::{Alignment, Area, PlaceHint, PreparedMap, Room, SitePlaces, align_maps_within};
use frames::{Map, Rigid2, Slam, wrapped};
use messages::AlignmentVerdict;
use support::{model, scanned, twin};

/// The robot began in the left half, where its map has x and y 0.
const START_M: [f64; 2] = [1.0, 1.0];

fn truth() -> Rigid2<Map, Slam> {
    Rigid2::new(START_M, 0.4)
}

/// Two storeys that are alike, with a room in each half of each.
fn places() -> SitePlaces {
    let room = |name: &str, map_storey, [x0, x1]: [f64; 2]| Room {
        name: name.to_owned(),
        map_storey,
        rings_m: vec![vec![[x0, 0.2], [x1, 0.2], [x1, 5.8], [x0, 5.8]]],
        ..Room::default()
    };
    let halves = [[0.2, 5.0], [5.0, 9.8]];
    let rooms = [("0.1", 0, halves[0]), ("0.2", 0, halves[1]), ("1.1", 1, halves[0]), ("1.2", 1, halves[1])];
    SitePlaces {
        rooms: rooms.map(|(name, storey, half)| room(name, storey, half)).into(),
        floors: vec![(0, 0.0), (1, 3.2)],
        portals: Vec::new(),
    }
}

fn align(place_hints: &[PlaceHint]) -> Alignment {
    let slam = scanned(&twin(), &[START_M, [9.0, 5.0], [5.0, 2.0], [5.0, 4.6]], truth(), 0.05, 0.0);
    let references = [model(&twin()), model(&twin())].map(|map| PreparedMap::of_model(&map));
    align_maps_within(&references, &[0, 1], &PreparedMap::of_slam(&slam), None, place_hints, None)
}

/// Accepted in the true pose on this storey.
fn is_true(found: &Alignment, storey: usize) -> bool {
    let pose = found.poses[0];
    let at = pose.map_from_slam.apply([0.0; 2]);
    found.verdict == AlignmentVerdict::Accepted
        && pose.reference == storey
        && (at[0] - START_M[0]).hypot(at[1] - START_M[1]) < 0.05
        && wrapped(pose.map_from_slam.yaw_rad() - truth().yaw_rad()).abs() < 0.01
}

#[test]
fn rooms_and_elevation_exclude_the_twins() {
    let site = places();
    let without = align(&[]);
    assert_eq!((without.verdict, without.exclusions.len()), (AlignmentVerdict::Ambiguous, 0));
    let start = site.in_room([0.0; 2], "1.1").unwrap();
    let found = align(std::slice::from_ref(&start));
    assert!(is_true(&found, 1), "{found:?}");
    let exclusion = &found.exclusions[0];
    assert_eq!((exclusion.label.as_str(), exclusion.n_poses), ("start in room 1.1", 3));
    let by_floor = align(&[site.at_elevation(0.3).unwrap()]);
    assert_eq!(by_floor.verdict, AlignmentVerdict::Ambiguous, "the half turn is left");
    assert_eq!(by_floor.exclusions[0].n_poses, 2);
    // Where the robot saw the number of a door, in the frame of its map.
    let door = truth().apply_inverse([8.0, 3.0]);
    let found = align(&[site.at_elevation(0.3).unwrap(), site.in_room(door, "0.2").unwrap()]);
    assert!(is_true(&found, 0), "{found:?}");
}

#[test]
fn a_point_just_outside_of_its_room_is_in_it_and_one_far_off_is_not() {
    let rooms = |y1: f64| {
        let ring = vec![[0.2, 0.2], [5.0, 0.2], [5.0, y1], [0.2, y1]];
        let room = Room { name: "half".to_owned(), rings_m: vec![ring], ..Room::default() };
        PlaceHint { label: "half".to_owned(), areas: vec![Area::Room { in_slam_m: [0.0; 2], room }] }
    };
    assert!(is_true(&align(&[rooms(0.6)]), 0), "0.4 m outside");
    assert_eq!(align(&[rooms(0.3)]).verdict, AlignmentVerdict::Refused, "0.7 m outside");
}

#[test]
fn what_the_robot_saw_beside_a_portal_decides_which_end_it_came_out_of() {
    let beside = |bounds_m| PlaceHint {
        label: "portal".to_owned(),
        areas: vec![Area::Beside { map_storeys: vec![1], bounds_m }],
    };
    let in_building = align(&[beside([[0.0, 0.0], [2.0, 2.0]])]);
    assert!(in_building.poses.iter().all(|pose| pose.reference == 1), "{in_building:?}");
    assert_eq!((in_building.verdict, in_building.exclusions[0].n_poses), (AlignmentVerdict::Ambiguous, 2));
    let outside = align(&[beside([[40.0, 40.0], [42.0, 42.0]])]);
    assert_eq!(outside.verdict, AlignmentVerdict::Refused);
}

#[test]
fn a_hint_that_excludes_the_true_pose_accepts_no_other() {
    let room =
        Room { name: "far".to_owned(), rings_m: vec![vec![[40.0, 0.0], [45.0, 0.0], [45.0, 5.0]]], ..Room::default() };
    let far =
        PlaceHint { label: "start in room far".to_owned(), areas: vec![Area::Room { in_slam_m: [0.0; 2], room }] };
    let found = align(&[far, places().at_elevation(0.0).unwrap()]);
    assert_eq!(found.verdict, AlignmentVerdict::Refused);
    assert!(found.reason.contains("where it cannot lie by the hints (start in room far"), "{}", found.reason);
    assert_eq!([&found.exclusions[0], &found.exclusions[1]].map(|e| e.n_poses > 0), [true, true]);
}
