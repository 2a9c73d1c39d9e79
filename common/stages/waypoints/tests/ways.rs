//! Ways between rooms and points, over storeys, and what is in the way where there is none.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

mod support;

use frames::{Map, Point2};
use messages::{DoorPassage, EdgeKind, Grid, MissionPlan, NoWaypoint, RobotProfile};
use proptest::prelude::*;
use std::collections::BTreeSet;
use support::planned::with_finder;
use support::{Archives, GROUND, House, UPPER, quick};
use waypoints::{MissionPlanOptions, NoWay, Way, WayEnd, WayLeg, WayObstacle};

fn room(archives: &Archives, name: char) -> WayEnd {
    WayEnd::Space(archives.names.iter().position(|n| *n == name).unwrap())
}

fn way(house: &House, lifts: &[&str], from: char, to: char) -> Result<Way, NoWay> {
    let options = MissionPlanOptions { lifts: lifts.iter().map(|l| (*l).to_owned()).collect(), ..quick() };
    with_finder(house, &options, |finder, archives, mission_plan| {
        let found = finder.way(room(archives, from), room(archives, to));
        if let Ok(way) = &found {
            check(way, archives, house, mission_plan);
        }
        found
    })
}

/// Every cell of a way is free for the robot, by distances to all cells that are not, and beside the cell before it; legs follow
/// each other where the portals between them begin and end.
fn check(way: &Way, archives: &Archives, house: &House, mission_plan: &MissionPlan<'_>) {
    let mut at: Option<(u32, Point2<Map>)> = None;
    for leg in &way.legs {
        match leg {
            WayLeg::Floor(leg) => {
                let grid = archives.grid(leg.map_storey as usize);
                assert!(leg.cells.iter().all(|cell| stands(&grid, *cell, house.robot.radius_m)), "{leg:?}");
                for pair in leg.cells.windows(2) {
                    assert!(is_step(&grid, pair[0], pair[1], house.robot.radius_m), "{pair:?}");
                }
                let [first, last] = [0, leg.cells.len() - 1].map(|k| middle(&grid, leg.cells[k]));
                assert!(at.is_none_or(|at| at == (leg.map_storey, first)), "it begins where the portal ends");
                assert_eq!([leg.line[0], *leg.line.last().unwrap()], [first, last]);
                let straight_m = first.distance_m(&last);
                assert!(straight_m <= leg.length_m + 1e-9, "{} {straight_m}", leg.length_m);
                at = Some((leg.map_storey, last));
            }
            WayLeg::Portal(leg) => {
                let edge = &mission_plan.edges[leg.edge];
                assert_eq!(edge.usable, 1);
                let mut nodes = edge.nodes.map(|node| mission_plan.nodes[node as usize]);
                if !leg.is_forward {
                    nodes.reverse();
                }
                let place = nodes.map(|n| (n.map_storey, Point2::new(n.position_in_map_m[0], n.position_in_map_m[1])));
                assert_eq!(at, Some(place[0]));
                at = Some(place[1]);
            }
        }
    }
}

fn middle(grid: &Grid<'_>, cell: usize) -> Point2<Map> {
    grid.spec().centre_of(grid.spec().cell_of(cell))
}

/// The slow, obvious version: no cell that is not free has its middle nearer than the radius.
fn stands(grid: &Grid<'_>, cell: usize, radius_m: f64) -> bool {
    let others = (0..grid.spec().n_cells()).filter(|other| grid.planning[*other] != 0);
    let nearest_m =
        others.map(|other| middle(grid, other).distance_m(&middle(grid, cell))).fold(f64::INFINITY, f64::min);
    grid.planning[cell] == 0 && !grid.is_keepout(cell) && nearest_m >= radius_m - 1e-4
}

/// Beside each other; across a corner only if both cells at the corner are free.
fn is_step(grid: &Grid<'_>, a: usize, b: usize, radius_m: f64) -> bool {
    let [p, q] = [a, b].map(|cell| grid.spec().cell_of(cell));
    let [columns, rows] = [p.column.abs_diff(q.column), p.row.abs_diff(q.row)];
    let corners = [grid::Cell { column: p.column, row: q.row }, grid::Cell { column: q.column, row: p.row }];
    match (columns, rows) {
        (1, 0) | (0, 1) => true,
        (1, 1) => corners.iter().all(|corner| stands(grid, grid.spec().index(*corner), radius_m)),
        _ => false,
    }
}

fn kinds(way: &Way, house: &House, lifts: &[&str]) -> Vec<String> {
    let options = MissionPlanOptions { lifts: lifts.iter().map(|l| (*l).to_owned()).collect(), ..quick() };
    with_finder(house, &options, |_, _, mission_plan| {
        let kind = |leg: &WayLeg| match leg {
            WayLeg::Floor(leg) => format!("floor {}", leg.map_storey),
            WayLeg::Portal(leg) => mission_plan.edges[leg.edge].kind.get().name().to_owned(),
        };
        way.legs.iter().map(kind).collect()
    })
}

fn climbing() -> House {
    let mut house = House::drawn(&[GROUND, UPPER]);
    house.robot = RobotProfile { climbs_stairs: 1, ..RobotProfile::DEFAULT };
    house
}

#[test]
fn a_way_leads_through_doors_and_rooms_in_their_order() {
    let house = House::drawn(&[GROUND]);
    let found = way(&house, &[], 'a', 'b').unwrap();
    let [WayLeg::Floor(leg)] = &found.legs[..] else { panic!("{found:?}") };
    assert_eq!((leg.spaces.len(), leg.doors.len()), (2, 1));
    assert_eq!(leg.doors[0].passage.get(), DoorPassage::Passable);
    let back = way(&house, &[], 'b', 'a').unwrap();
    assert!((found.length_m - back.length_m).abs() < 0.2, "{} {}", found.length_m, back.length_m);
}

#[test]
fn a_way_to_where_it_begins_has_no_length() {
    let found = way(&House::drawn(&[GROUND]), &[], 'a', 'a').unwrap();
    assert_eq!((found.legs.len(), found.length_m), (1, 0.0));
}

#[test]
fn stairs_and_lifts_are_legs_of_who_uses_them() {
    let house = climbing();
    let found = way(&house, &[], 'b', 'c').unwrap();
    assert_eq!(kinds(&found, &house, &[]), ["floor 0", "stair", "floor 1"]);
    let down = way(&house, &[], 'c', 'b').unwrap();
    assert_eq!(kinds(&down, &house, &[]), ["floor 1", "stair", "floor 0"]);
    let found = way(&house, &["*"], 'c', 'd').unwrap();
    assert_eq!(kinds(&found, &house, &["*"]), ["floor 1", "stair", "floor 0", "lift", "floor 1"]);
}

#[test]
fn who_uses_no_stair_is_told_which_one_it_would_be() {
    let house = House::drawn(&[GROUND, UPPER]);
    let none = way(&house, &[], 'a', 'c').unwrap_err();
    assert_eq!((&none.from, &none.to), (&None, &None));
    let [WayObstacle::Portal { kind, is_built, is_usable, .. }] = none.obstacles[..] else { panic!("{none:?}") };
    assert_eq!((kind, is_built, is_usable), (EdgeKind::Stair, true, Some(false)));
    // From the stair on it goes through both: they are told in the order of the way.
    let none = way(&house, &[], 'c', 'd').unwrap_err();
    let kinds: Vec<EdgeKind> = none
        .obstacles
        .iter()
        .map(|obstacle| match obstacle {
            WayObstacle::Portal { kind, .. } => *kind,
            other => panic!("{other:?}"),
        })
        .collect();
    assert_eq!(kinds, [EdgeKind::Stair, EdgeKind::Lift]);
}

#[test]
fn a_stair_that_is_not_built_is_missing() {
    let mut house = climbing();
    house.absent.insert('S');
    let none = way(&house, &[], 'a', 'c').unwrap_err();
    let [WayObstacle::Portal { kind, is_built, is_usable, .. }] = none.obstacles[..] else { panic!("{none:?}") };
    assert_eq!((kind, is_built, is_usable), (EdgeKind::Stair, false, Some(true)));
}

#[test]
fn a_stair_to_a_storey_without_floor_is_told_if_it_is_not_for_the_robot() {
    let bare = UPPER.replace(['c', 'd', 'L'], " ").replacen("    ", "CCCC", 1);
    let mut house = House::drawn(&[&GROUND.replace('L', "b"), &bare]);
    let none = way(&house, &[], 'a', 'c').unwrap_err();
    assert_eq!(none.to.unwrap().why, NoWaypoint::NoFloor);
    let [WayObstacle::Portal { kind, is_built: true, is_usable: Some(false), .. }] = none.obstacles[..] else {
        panic!("{:?}", none.obstacles)
    };
    assert_eq!(kind, EdgeKind::Stair);
    house.robot = RobotProfile { climbs_stairs: 1, ..RobotProfile::DEFAULT };
    assert_eq!(way(&house, &[], 'a', 'c').unwrap_err().obstacles, [], "nothing but the floor is missing");
}

#[test]
fn a_door_that_is_closed_to_the_robot_is_missing() {
    let house = House::drawn(&[&GROUND.replace('D', "X")]);
    let none = way(&house, &[], 'a', 'b').unwrap_err();
    let [WayObstacle::Door(passage)] = none.obstacles[..] else { panic!("{none:?}") };
    assert_eq!(passage.passage.get(), DoorPassage::CannotOpen);
}

#[test]
fn a_closed_room_is_an_end_without_a_place_or_lies_between() {
    let rooms = "
##################
#aaaaaDbbbbbDcccc#
#aaaaaDbbbbbDcccc#
#aaaaaDbbbbbDcccc#
#aaaaaDbbbbbDcccc#
#aaaaaDbbbbbDcccc#
##################";
    let mut house = House::drawn(&[rooms]);
    assert!(way(&house, &[], 'a', 'c').is_ok());
    house.blocked.insert('b', "task:T");
    let none = way(&house, &[], 'a', 'c').unwrap_err();
    assert_eq!(none.obstacles, [WayObstacle::Space(1)]);
    let none = way(&house, &[], 'a', 'b').unwrap_err();
    assert_eq!((none.to.unwrap().why, none.obstacles), (NoWaypoint::Blocked, Vec::new()));
    let none = way(&house, &[], 'b', 'c').unwrap_err();
    assert_eq!((none.from.unwrap().why, none.obstacles), (NoWaypoint::Blocked, Vec::new()));
}

#[test]
fn floor_on_which_nothing_stands_is_missing_where_it_is_keepout_or_narrow() {
    let keepout = "
####################
#aaaaaaaa~~bbbbbbbb#
#aaaaaaaa~~bbbbbbbb#
#aaaaaaaa~~bbbbbbbb#
#aaaaaaaa~~bbbbbbbb#
####################";
    let none = way(&House::drawn(&[keepout]), &[], 'a', 'b').unwrap_err();
    let [WayObstacle::Floor { is_keepout: true, at, .. }] = none.obstacles[..] else { panic!("{none:?}") };
    assert!((1.7..2.2).contains(&at.x_m()), "{at:?}");
    // A gap of 0.4 m between pieces of furniture; the robot needs 0.6 m.
    let narrow = "
####################
#aaaaaaaaFFbbbbbbbb#
#aaaaaaaaaabbbbbbbb#
#aaaaaaaaaabbbbbbbb#
#aaaaaaaaFFbbbbbbbb#
####################";
    let none = way(&House::drawn(&[narrow]), &[], 'a', 'b').unwrap_err();
    assert!(matches!(none.obstacles[..], [WayObstacle::Floor { is_keepout: false, .. }]), "{none:?}");
}

#[test]
fn a_closed_room_without_a_door_is_met_over_open_floor() {
    let open_plan = "
##################
#aaaaabbbbbbccccc#
#aaaaabbbbbbccccc#
#aaaaabbbbbbccccc#
#aaaaabbbbbbccccc#
#aaaaabbbbbbccccc#
##################";
    let mut house = House::drawn(&[open_plan]);
    assert!(way(&house, &[], 'a', 'c').is_ok());
    house.blocked.insert('b', "private");
    let none = way(&house, &[], 'a', 'c').unwrap_err();
    assert_eq!(none.obstacles, [WayObstacle::Space(1)]);
    house.blocked.insert('c', "private");
    let none = way(&house, &[], 'a', 'c').unwrap_err();
    assert_eq!((none.to.unwrap().why, none.obstacles), (NoWaypoint::Blocked, vec![WayObstacle::Space(1)]));
}

#[test]
fn a_closed_door_below_is_named_for_a_room_above() {
    let mut house = climbing();
    house.storeys[0] = House::drawn(&[&GROUND.replace('D', "X")]).storeys.remove(0);
    let none = way(&house, &[], 'b', 'c').unwrap_err();
    assert!(matches!(none.obstacles[..], [WayObstacle::Door(_)]), "{none:?}");
}

#[test]
fn where_walls_have_no_door_nothing_is_missing() {
    let house = House::drawn(&[&GROUND.replace('D', "#")]);
    let none = way(&house, &[], 'a', 'b').unwrap_err();
    assert_eq!(none, NoWay::default());
}

#[test]
fn a_point_is_an_end_if_the_robot_can_stand_near_it() {
    let house = House::drawn(&[GROUND]);
    with_finder(&house, &quick(), |finder, archives, _| {
        let point = |x_m: f64, y_m: f64| WayEnd::Point { map_storey: 0, at: Point2::new(x_m, y_m) };
        let found = finder.way(point(1.5, 1.5), room(archives, 'b')).unwrap();
        let WayLeg::Floor(leg) = &found.legs[0] else { panic!("{found:?}") };
        assert!(leg.line[0].distance_m(&Point2::new(1.5, 1.5)) < 0.1);
        let none = finder.way(point(-3.0, 1.5), room(archives, 'b')).unwrap_err();
        assert!(none.from.unwrap().reason.contains("outside of the map"));
        let elsewhere = WayEnd::Point { map_storey: 7, at: Point2::new(1.5, 1.5) };
        assert_eq!(finder.way(elsewhere, room(archives, 'b')).unwrap_err().from.unwrap().why, NoWaypoint::NotMapped);
    });
}

/// Rooms with pieces of furniture and gaps in the walls at random.
fn any_storey() -> impl Strategy<Value = String> {
    proptest::collection::vec(0u8..100, 18 * 12).prop_map(|dice| {
        let character = |k: usize, die: u8| {
            let (x, y) = (k % 18, k / 18);
            match (x, y) {
                (0 | 17, _) | (_, 0 | 11) => '#',
                (8, _) if die < 80 => '#',
                _ if die < 4 => 'F',
                _ if die < 6 => '~',
                (..8, _) => 'a',
                _ => 'b',
            }
        };
        let all: Vec<char> = dice.into_iter().enumerate().map(|(k, die)| character(k, die)).collect();
        all.chunks(18).map(|row| row.iter().collect::<String>()).collect::<Vec<_>>().join("\n")
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    /// A way is one of steps over free cells; there is one exactly if a slow flood fill from a place in one room gets to the other.
    #[test]
    fn a_way_is_found_exactly_where_there_is_one(storey in any_storey()) {
        let house = House::drawn(&[&storey]);
        let archives = Archives::of(&house);
        prop_assume!(archives.names == ['a', 'b']);
        let found = way(&house, &[], 'a', 'b');
        let grid = archives.grid(0);
        let radius_m = house.robot.radius_m;
        let free: Vec<bool> = (0..grid.spec().n_cells()).map(|cell| stands(&grid, cell, radius_m)).collect();
        let mut reached: BTreeSet<usize> = (0..free.len()).filter(|cell| free[*cell] && grid.space[*cell] == 1).collect();
        let mut waiting: Vec<usize> = reached.iter().copied().collect();
        let width = grid.spec().width as usize;
        while let Some(cell) = waiting.pop() {
            for next in [cell - 1, cell + 1, cell - width, cell + width] {
                if free[next] && reached.insert(next) {
                    waiting.push(next);
                }
            }
        }
        let leads_there = reached.iter().any(|cell| grid.space[*cell] == 2);
        prop_assert_eq!(found.is_ok(), leads_there);
    }
}
