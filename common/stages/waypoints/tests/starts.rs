//! Default start part (stair, lift or outer door) and the reported parts.

mod support;

use messages::{FloorPartRecord, NoWaypoint, SpaceRecord, WaypointKind, space_flags};
use support::{House, quick};
use waypoints::{MissionPlanOptions, Start, UnknownName, check_names, check_start};

fn centres() -> MissionPlanOptions {
    MissionPlanOptions { kinds: [WaypointKind::Centre].into(), ..quick() }
}

/// Parts of a storey, from large to small: room area in square metres, whether it is reached, whether it has a way in.
fn parts(house: &House, storey: u32) -> Vec<(f64, bool, bool)> {
    let planned = house.planned(&centres());
    let mission_plan = planned.mission_plan();
    let here = mission_plan.floor_parts.iter().filter(|p| p.map_storey == storey);
    let of = |p: &FloorPartRecord| ((p.room_m2 * 100.0).round() / 100.0, p.is_reached == 1, p.has_way_in == 1);
    here.map(of).collect()
}

/// A large room without a way in, and a smaller one.
const TWO_ROOMS: &str = "
#########################
#aaaaaaaaaaaa#bbbbbbbbbb#
#aaaaaaaaaaaa#bbbbbbbbbb#
#aaaaaaaaaaaa#bbbbbbbbbb#
#aaaaaaaaaaaa#bbbbbbbbbb#
#aaaaaaaaaaaa#bbbbbbbbbb#
#aaaaaaaaaaaa#bbbbbbbbbb#
#aaaaaaaaaaaa#bbbbbbbbbb#
#aaaaaaaaaaaa#bbbbbbbbbb#
#aaaaaaaaaaaa#bbbbbbbbbb#
#########################";

/// The same with a thing in a wall, from the fifth line on.
fn with(what: char, column: usize) -> String {
    let mut lines: Vec<Vec<char>> = TWO_ROOMS.lines().map(|l| l.chars().collect()).collect();
    for line in &mut lines[4..9] {
        line[column] = what;
    }
    lines.into_iter().map(|l| l.into_iter().collect::<String>() + "\n").collect()
}

#[test]
fn without_any_way_in_the_largest_room_is_the_first_part() {
    assert_eq!(parts(&House::drawn(&[TWO_ROOMS]), 0), [(2.8, true, false), (2.24, false, false)]);
}

#[test]
fn a_part_with_an_outer_door_is_preferred() {
    let house = House::drawn(&[&with('D', 24)]);
    let planned = house.planned(&centres());
    assert_eq!(planned.why('b').0, NoWaypoint::Has);
    assert_eq!(planned.why('a').0, NoWaypoint::Unreachable);
    let parts_found = parts(&house, 0);
    assert!(
        parts_found.contains(&(2.8, false, false)) && parts_found.iter().filter(|p| p.1).all(|p| p.2),
        "{parts_found:?}"
    );
}

#[test]
fn a_door_between_rooms_is_no_outer_door() {
    let parts_found = parts(&House::drawn(&[&with('D', 13)]), 0);
    assert!(parts_found.iter().all(|p| !p.2), "{parts_found:?}");
}

#[test]
fn a_part_with_a_stair_is_preferred() {
    let stairs = with('S', 23);
    let house = House::drawn(&[&stairs, &stairs]);
    for storey in [0, 1] {
        let parts_found = parts(&house, storey);
        assert_eq!(
            parts_found.iter().map(|p| (p.1, p.2)).collect::<Vec<_>>(),
            [(false, false), (true, true)],
            "{parts_found:?}"
        );
    }
}

#[test]
fn a_landing_is_not_preferred_to_a_storey() {
    // The landing has less than a tenth of the room area of the hall.
    let landing = "
#################################
#aaaaaaaaaaaaaaaaaaaaaaaaaa#bbbb#
#aaaaaaaaaaaaaaaaaaaaaaaaaa#bbbb#
#aaaaaaaaaaaaaaaaaaaaaaaaaa#bbbb#
#aaaaaaaaaaaaaaaaaaaaaaaaaa#bbbb#
#aaaaaaaaaaaaaaaaaaaaaaaaaa#SSSS#
#aaaaaaaaaaaaaaaaaaaaaaaaaa#SSSS#
#aaaaaaaaaaaaaaaaaaaaaaaaaa#SSSS#
#################################";
    let parts_found = parts(&House::drawn(&[landing, landing]), 0);
    assert_eq!((parts_found[0].1, parts_found[0].2), (true, false), "{parts_found:?}");
}

#[test]
fn a_terrace_with_an_outer_door_is_no_first_part() {
    // The door is closed to the robot: terrace and room are two parts, and both have it.
    let mut house = House::drawn(&[&with('D', 13).replace('D', "X")]);
    house.spaces.insert('a', |space: &mut SpaceRecord| space.flags = space_flags::EXTERNAL);
    let parts_found = parts(&house, 0);
    assert_eq!(parts_found, [(0.0, false, true), (2.24, true, true)], "the terrace is larger, and no room");
}

#[test]
fn figures_of_the_parts_are_those_of_the_storey() {
    let house = House::drawn(&[TWO_ROOMS]);
    let planned = house.planned(&centres());
    let mission_plan = planned.mission_plan();
    let sum = |reached: u32| {
        mission_plan.floor_parts.iter().filter(|p| p.is_reached == reached).map(|p| p.area_m2).sum::<f64>()
    };
    assert!((sum(1) - mission_plan.storeys[0].reached_m2).abs() < 1e-9);
    assert!((sum(0) - mission_plan.storeys[0].unreached_m2).abs() < 1e-9);
}

#[test]
fn a_storey_that_is_not_asked_for_is_a_way_and_has_no_waypoints() {
    let stairs = with('S', 23);
    let mut house = House::drawn(&[&stairs, &stairs.replace('a', "c").replace('b', "d")]);
    house.robot.climbs_stairs = 1;
    let all = house.planned(&centres());
    let upper = house.planned(&MissionPlanOptions { storeys: vec![1], ..centres() });
    assert_eq!((upper.why('b').0, upper.why('d').0), (NoWaypoint::NotAsked, NoWaypoint::Has));
    let mission_plan = upper.mission_plan();
    assert!(
        mission_plan.waypoints.iter().all(|w| w.map_storey == 1)
            && mission_plan.nodes.iter().all(|n| n.map_storey == 1)
    );
    assert!(
        mission_plan.edges.iter().all(|e| e.kind != messages::EdgeKind::Stair),
        "it leads to a storey that is left out"
    );
    assert!(
        mission_plan.nodes.iter().any(|n| n.kind == messages::NodeKind::Staging),
        "one stands before it all the same"
    );
    assert_eq!(
        mission_plan.storeys[1].reached_m2,
        all.mission_plan().storeys[1].reached_m2,
        "what is reached is a fact of the building"
    );
}

#[test]
fn spaces_lifts_and_storeys_that_do_not_exist_are_errors_with_the_nearest_names() {
    let archives = support::Archives::of(&House::drawn(&[TWO_ROOMS]));
    let site = archives.site();
    let check = |options: MissionPlanOptions| check_names(&site, &options);
    assert_eq!(check(MissionPlanOptions { spaces: vec!["a".to_owned(), "space-?".to_owned()], ..quick() }), Ok(()));
    let typo = check(MissionPlanOptions { spaces: vec!["a".to_owned(), "spcae-b".to_owned()], ..quick() }).unwrap_err();
    assert!(matches!(&typo, UnknownName::Space { asked, .. } if asked == "spcae-b"));
    assert!(
        typo.to_string().contains("\"spcae-b\" matches no space") && typo.to_string().contains("\"space-b\""),
        "{typo}"
    );
    assert_eq!(check(MissionPlanOptions { lifts: vec!["*".to_owned()], ..quick() }), Ok(()), "all there are");
    assert!(
        check(MissionPlanOptions { lifts: vec!["Lift 1".to_owned()], ..quick() })
            .unwrap_err()
            .to_string()
            .contains("no lift")
    );
    let start = Some(Start { storey: 3, x_m: 1.0, y_m: 1.0 });
    let why = check(MissionPlanOptions { start, ..quick() }).unwrap_err().to_string();
    assert!(why.contains("there is no storey 3") && why.contains("\"Storey 0\""), "{why}");
}

#[test]
fn a_start_off_the_floor_is_an_error_that_names_the_nearest_place() {
    let archives = support::Archives::of(&House::drawn(&[TWO_ROOMS]));
    let check = |x_m: f64, y_m: f64| {
        let start = Start { storey: 0, x_m, y_m };
        archives.with(&MissionPlanOptions { start: Some(start), ..quick() }, |input| check_start(input, start))
    };
    assert_eq!(check(1.2, 1.0), Ok(true));
    assert_eq!(check(0.3, 1.0), Ok(true), "it is moved by less than 0.3 m");
    let outside = check(-0.1, 1.0).unwrap_err();
    assert!(outside.contains("storey 0 \"Storey 0\"") && outside.contains("no floor"), "{outside}");
    assert!(outside.contains("in \"a\", ") && outside.contains("nearest place"), "{outside}");
    assert!(check(90.0, 1.0).unwrap_err().contains("outside of the map"));
}
