//! Spaces whose centroid is not standable or not reachable; each case is also drawn as an image.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

mod support;

use messages::{NoWaypoint, WaypointRecord};
use support::{House, Planned, brute_force, quick};
use waypoints::{MissionPlanOptions, Start};

/// Plans with fine cells, and draws the picture.
fn pictured(name: &str, drawing: &str, options: &MissionPlanOptions) -> Planned {
    let house = House { cell_tenths: 500, ..House::drawn(&[drawing]) };
    let planned = house.planned(options);
    let path = planned.write_picture(name, options);
    assert!(path.exists());
    planned
}

fn at(waypoint: &WaypointRecord) -> [f64; 2] {
    [waypoint.position_in_map_m[0], waypoint.position_in_map_m[1]]
}

/// The faces of the only storey that the scans see, of those that can be seen.
fn coverage(planned: &Planned) -> f64 {
    let mission_plan = planned.mission_plan();
    f64::from(mission_plan.storeys[0].n_seen) / f64::from(mission_plan.storeys[0].n_faces)
}

/// The centre lies in its space, and no cell of the space on which the robot can stand is nearer to the centroid.
fn assert_moved_to_the_nearest(planned: &Planned, space: char) {
    let grid = planned.archives.grid(0);
    let spec = grid.spec();
    let centre = planned.centre(space).unwrap();
    let centroid = centre.centroid_in_map_m;
    let far = |p: [f64; 2]| (p[0] - centroid[0]).hypot(p[1] - centroid[1]);
    assert!(planned.is_in(space, at(&centre)));
    assert!(brute_force::clearance_m(&grid, at(&centre)) >= 0.3 - brute_force::TOLERANCE_M);
    let standing = brute_force::standing(&grid, 0.3);
    let middles = (0..spec.n_cells()).filter(|&c| standing[c]).map(|c| spec.centre_of(spec.cell_of(c)));
    let inside = middles.map(|m| m.coordinates_m()).filter(|m| planned.is_in(space, *m));
    let nearest_m = inside.map(far).fold(f64::INFINITY, f64::min);
    assert!((far(at(&centre)) - nearest_m).abs() < 1e-9, "{} m, not {nearest_m} m", far(at(&centre)));
}

const L_SHAPED: &str = "
########
#aaaaaa#
#aaaaaa#
#aaaaaa#
#aaaaaa#
#aaaaaa#
#aaaaaa#
#aaaaaa#
#aaaaaa#
#aaaaaa#
#aaaaaa#
#aaaaaa#
#aaaaaa#
#aaaaaa#
#aaaaaa###################
#aaaaaaaaaaaaaaaaaaaaaaaa#
#aaaaaaaaaaaaaaaaaaaaaaaa#
#aaaaaaaaaaaaaaaaaaaaaaaa#
#aaaaaaaaaaaaaaaaaaaaaaaa#
#aaaaaaaaaaaaaaaaaaaaaaaa#
#aaaaaaaaaaaaaaaaaaaaaaaa#
##########################";

#[test]
fn an_l_shaped_room_has_its_centre_inside_and_is_covered_whole() {
    let planned = pictured("l-shaped", L_SHAPED, &quick());
    let centroid = planned.centre('a').unwrap().centroid_in_map_m;
    assert!(!planned.is_in('a', [centroid[0], centroid[1]]), "the centroid of this room is not in it");
    assert_moved_to_the_nearest(&planned, 'a');
    assert!(coverage(&planned) >= 0.99, "{}", coverage(&planned));
    // Nothing of either arm is left out of what could be seen.
    let storey = planned.mission_plan().storeys[0];
    assert!(f64::from(storey.n_faces) >= 0.98 * f64::from(storey.n_targets), "{storey:?}");
}

const BLOCKED_CENTROID: &str = "
######################
#aaaaaaaaaaaaaaaaaaaa#
#aaaaaaaaaaaaaaaaaaaa#
#aaaaaaaaaaaaaaaaaaaa#
#aaaaaaaaaaaaaaaaaaaa#
#aaaaaaaFFFFFFFaaaaaa#
#aaaaaaaFFFFFFFaaaaaa#
#aaaaaaaFFFFFFFaaaaaa#
#aaaaaaaFFFFFFFaaaaaa#
#aaaaaaaFFFFFFFaaaaaa#
#aaaaaaaaaaaaaaaaaaaa#
#aaaaaaaaaaaaaaaaaaaa#
#aaaaaaaaaaaaaaaaaaaa#
#aaaaaaaaaaaaaaaaaaaa#
#aaaaaaaaaaaaaaaaaaaa#
######################";

#[test]
fn a_centroid_under_furniture_is_moved_beside_it() {
    let planned = pictured("blocked-centroid", BLOCKED_CENTROID, &quick());
    let centroid = planned.centre('a').unwrap().centroid_in_map_m;
    assert_eq!(planned.planning(0, [centroid[0], centroid[1]]), 100);
    assert_moved_to_the_nearest(&planned, 'a');
    assert!(coverage(&planned) >= 0.99, "behind the furniture, too: {}", coverage(&planned));
    assert!(planned.scans().len() > 1, "furniture hides faces");
}

const CLOSED_DOOR: &str = "
###########################
#aaaaaaaaaaaaaaaa#bbbbbbbb#
#aaaaaaaaaaaaaaaa#bbbbbbbb#
#aaaaaaaaaaaaaaaa#bbbbbbbb#
#aaaaaaaaaaaaaaaa#bbbbbbbb#
#aaaaaaaaaaaaaaaaDbbbbbbbb#
#aaaaaaaaaaaaaaaaDbbbbbbbb#
#aaaaaaaaaaaaaaaaDbbbbbbbb#
#aaaaaaaaaaaaaaaa#bbbbbbbb#
#aaaaaaaaaaaaaaaa#bbbbbbbb#
#aaaaaaaaaaaaaaaa#bbbbbbbb#
#aaaaaaaaaaaaaaaa#bbbbbbbb#
###########################";

#[test]
fn a_room_behind_a_closed_door_is_refused_with_the_door_and_its_clear_width() {
    let planned = pictured("closed-door", CLOSED_DOOR, &quick());
    let (why, reason) = planned.why('b');
    assert_eq!((why, planned.space('b').door), (NoWaypoint::ClosedDoor, 0));
    assert_eq!(reason, "its door door-0 is closed to the robot: 0.50 m clear, the robot needs 0.70 m");
    assert_eq!(planned.why('a'), (NoWaypoint::Has, String::new()));
    assert!(planned.mission_plan().waypoints.iter().all(|w| planned.name_of(w) == Some('a')));
    assert!(planned.mission_plan().storeys[0].unreached_m2 > 0.5);
}

const TWO_COMPONENTS: &str = "
#############################
#aaaaaaaaaaaaaaaa##bbbbbbbbb#
#aaaaaaaaaaaaaaaa##bbbbbbbbb#
#aaaaaaaaaaaaaaaa##bbbbbbbbb#
#aaaaaaaaaaaaaaaa##bbbbbbbbb#
#aaaaaaaaaaaaaaaa##bbbbbbbbb#
#aaaaaaaaaaaaaaaa##bbbbbbbbb#
#aaaaaaaaaaaaaaaa##bbbbbbbbb#
#aaaaaaaaaaaaaaaa##bbbbbbbbb#
#aaaaaaaaaaaaaaaa##bbbbbbbbb#
#############################";

#[test]
fn of_two_parts_without_a_way_between_them_the_larger_one_is_planned() {
    let planned = pictured("two-components", TWO_COMPONENTS, &quick());
    assert!(planned.centre('a').is_some());
    assert_eq!(planned.why('b'), (NoWaypoint::Unreachable, "no way leads there from where the robot is".to_owned()));
    assert!(planned.mission_plan().waypoints.iter().all(|w| planned.name_of(w) == Some('a')));
}

#[test]
fn of_two_parts_without_a_way_between_them_the_one_with_the_robot_is_planned() {
    let start = Some(Start { storey: 0, x_m: 4.5, y_m: 1.0 });
    let planned = pictured("two-components-start", TWO_COMPONENTS, &MissionPlanOptions { start, ..quick() });
    assert!(planned.centre('b').is_some());
    assert_eq!(planned.why('a').0, NoWaypoint::Unreachable);
    assert!(planned.mission_plan().waypoints.iter().all(|w| planned.name_of(w) == Some('b')));
    // The tour begins where the robot is, and the way from there counts.
    let mission_plan = planned.mission_plan();
    let first = mission_plan.tour_of(&mission_plan.storeys[0])[0];
    assert!((first[0] - 4.5).hypot(first[1] - 1.0) < 0.05, "{first:?}");
    assert!(mission_plan.waypoints[0].leg_m > 0.0 || at(&mission_plan.waypoints[0]) == first);
}

const NO_SPACE: &str = "
########################
#......................#
#......................#
#......................#
#......................#
#..........#...........#
#..........#...........#
#..........#...........#
#..........#...........#
#..........#...........#
#..........#...........#
#..........#...........#
########################";

#[test]
fn a_storey_without_any_space_is_scanned_and_has_no_centres() {
    let planned = pictured("no-space", NO_SPACE, &quick());
    let mission_plan = planned.mission_plan();
    assert_eq!((mission_plan.spaces.len(), mission_plan.storeys[0].n_parts), (0, 1));
    assert_eq!(planned.scans().len(), mission_plan.waypoints.len());
    assert!(coverage(&planned) >= 0.99, "{}", coverage(&planned));
    assert!(
        mission_plan.waypoints.iter().all(|w| w.space == messages::NONE && w.centroid_in_map_m == w.position_in_map_m)
    );
}

const FURNITURE_FILLED: &str = "
##############################
#aaaaaaaaaaaa#bFFbFFbFFbFFbFb#
#aaaaaaaaaaaa#bFFbFFbFFbFFbFb#
#aaaaaaaaaaaa#bbbbbbbbbbbbbbb#
#aaaaaaaaaaaaDbFFbFFbFFbFFbFb#
#aaaaaaaaaaaaDbFFbFFbFFbFFbFb#
#aaaaaaaaaaaaDbFFbFFbFFbFFbFb#
#aaaaaaaaaaaaDbFFbFFbFFbFFbFb#
#aaaaaaaaaaaaDbbbbbbbbbbbbbbb#
#aaaaaaaaaaaa#bFFbFFbFFbFFbFb#
#aaaaaaaaaaaa#bFFbFFbFFbFFbFb#
##############################";

#[test]
fn a_room_full_of_furniture_is_too_narrow() {
    let planned = pictured("furniture-filled", FURNITURE_FILLED, &quick());
    assert_eq!(planned.why('b'), (NoWaypoint::TooNarrow, "it has no free place of 0.3 m around".to_owned()));
    assert!(planned.centre('a').is_some());
    // What of it shows through the door is scanned from outside.
    assert!(planned.scans().iter().all(|w| planned.name_of(w) != Some('b')));
    assert!(planned.space('b').n_faces > 0);
}
