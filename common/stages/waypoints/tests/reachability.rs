//! Reachability: starts, tours, stairs and lifts, route graph.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

mod support;

use frames::{Map, Point2};
use messages::{
    EdgeKind, Grid, MissionPlan, NoWaypoint, NodeKind, RobotProfile, RouteEdgeRecord, Severity, WaypointKind,
};
use std::collections::BTreeSet;
use support::{Archives, GROUND, House, Planned, UPPER, brute_force, quick};
use waypoints::{MissionPlanOptions, MissionPlanner, Start};

const AT_A: Option<Start> = Some(Start { storey: 0, x_m: 1.5, y_m: 1.0 });

fn centres(planned: &Planned) -> String {
    "abcd".chars().filter(|s| planned.centre(*s).is_some()).collect()
}

fn two_storeys(climbs: bool, lifts: &[&str], start: Option<Start>) -> Planned {
    let mut house = House::drawn(&[GROUND, UPPER]);
    house.robot = RobotProfile { climbs_stairs: u32::from(climbs), ..RobotProfile::DEFAULT };
    let lifts = lifts.iter().map(|l| (*l).to_owned()).collect();
    house.planned(&MissionPlanOptions { lifts, start, ..quick() })
}

#[test]
fn rooms_above_are_reached_by_who_climbs_and_by_who_may_take_the_lift() {
    assert_eq!(centres(&two_storeys(false, &[], AT_A)), "ab");
    assert_eq!(centres(&two_storeys(true, &[], AT_A)), "abc");
    assert_eq!(centres(&two_storeys(false, &["*Transport*"], AT_A)), "abd");
    assert_eq!(centres(&two_storeys(false, &["another lift"], AT_A)), "ab");
    assert_eq!(centres(&two_storeys(true, &["IfcTransportElement-?"], AT_A)), "abcd");
    let planned = two_storeys(true, &[], AT_A);
    assert_eq!(planned.why('d').0, NoWaypoint::Unreachable);
    assert!(planned.mission_plan().waypoints.iter().all(|w| planned.name_of(w) != Some('d')));
}

#[test]
fn without_a_start_the_robot_is_put_onto_every_storey_that_no_way_leads_to() {
    let planned = two_storeys(false, &[], None);
    assert_eq!(centres(&planned), "abc", "the larger room above");
    // With a lift it comes to the smaller one: and does not start in the larger one then.
    assert_eq!(centres(&two_storeys(false, &["*"], None)), "abd");
}

#[test]
fn stairs_and_lifts_are_edges_of_the_graph_whether_or_not_the_robot_takes_them() {
    for (climbs, lifts, usable) in [(false, &[][..], [0, 0]), (true, &[], [1, 0]), (true, &["*"], [1, 1])] {
        let planned = two_storeys(climbs, lifts, AT_A);
        let mission_plan = planned.mission_plan();
        let edge = |kind: EdgeKind| {
            let mut edges = mission_plan.edges.iter().filter(|e| e.kind == kind);
            let edge = edges.next().unwrap();
            assert!(edges.next().is_none());
            edge
        };
        let (stair, lift) = (edge(EdgeKind::Stair), edge(EdgeKind::Lift));
        assert_eq!([stair.usable, lift.usable], usable);
        for edge in [stair, lift] {
            let [low, high] = edge.nodes.map(|n| mission_plan.nodes[n as usize]);
            assert_eq!([low.kind.get(), high.kind.get()], [NodeKind::Staging; 2]);
            assert_eq!([low.map_storey, high.map_storey], [0, 1]);
            assert!((edge.length_m - 3.0).abs() < 0.1, "one stands above the other: {}", edge.length_m);
        }
    }
}

#[test]
fn a_stair_to_a_room_that_is_filled_up_is_no_place_to_go_to_any_more() {
    let filled = UPPER.replace('c', "1").replacen('1', "c", 1);
    let mut house = House::drawn(&[GROUND, &filled]);
    house.absent.insert('1');
    let options = MissionPlanOptions { start: AT_A, ..quick() };
    let mut planner = MissionPlanner::default();
    let mut n_stagings = |house: &House| {
        let archives = Archives::of(house);
        let bytes = archives.with(&options, |input| planner.plan(input));
        let mission_plan = MissionPlan::open(bytes.bytes()).unwrap();
        let site = archives.site();
        let is_of_stair = |of: u32| site.text(site.elements[of as usize].global_id) == "IfcStair-S";
        mission_plan.nodes.iter().filter(|n| n.kind == NodeKind::Staging && is_of_stair(n.of)).count()
    };
    assert_eq!(n_stagings(&house), 2);
    house.absent.clear();
    assert_eq!(n_stagings(&house), 0, "nor below, where nothing else changed");
    house.absent.insert('1');
    assert_eq!(n_stagings(&house), 2);
}

#[test]
fn storeys_are_visited_in_the_order_in_which_they_are_come_to() {
    let above = Some(Start { storey: 1, x_m: 1.5, y_m: 1.0 });
    let planned = two_storeys(true, &[], above);
    let storeys: Vec<u32> = planned.mission_plan().waypoints.iter().map(|w| w.map_storey).collect();
    assert_eq!((storeys[0], *storeys.last().unwrap()), (1, 0));
    assert!(storeys.windows(2).all(|s| s[1] <= s[0]));
    let orders: Vec<u32> = planned.mission_plan().waypoints.iter().map(|w| w.order).collect();
    assert_eq!(orders, (0..orders.len() as u32).collect::<Vec<_>>());
}

#[test]
fn a_robot_in_a_wall_gets_nowhere_and_is_told() {
    let thick = GROUND.replace("bbbbbbbbbbbbb#", "##############").replace("bbbbbbbbbbLLL#", "##############");
    // In the middle of two and a half metres of wall, outside of the building, outside of the map.
    for [x_m, y_m] in [[4.4, 1.1], [-0.1, 1.0], [-50.0, 0.0], [4e9, 1e300]] {
        let start = Some(Start { storey: 0, x_m, y_m });
        let planned = House::drawn(&[&thick]).planned(&MissionPlanOptions { start, ..quick() });
        let mission_plan = planned.mission_plan();
        assert_eq!(
            (planned.codes(), mission_plan.waypoints.len()),
            (vec!["start_blocked".to_owned()], 0),
            "{x_m} {y_m}"
        );
        assert_eq!(
            (mission_plan.diagnostics[0].severity.get(), mission_plan.storeys[0].n_tour_points),
            (Severity::Error, 0)
        );
        assert_eq!(mission_plan.storeys[0].reached_m2, 0.0);
        assert_eq!(planned.why('a').0, NoWaypoint::Unreachable);
    }
}

#[test]
fn a_start_on_no_storey_is_blocked_and_one_beside_a_wall_is_not() {
    let at = |storey: u32, x_m: f64, y_m: f64| {
        House::drawn(&[GROUND]).planned(&MissionPlanOptions { start: Some(Start { storey, x_m, y_m }), ..quick() })
    };
    assert_eq!(at(1, 1.5, 1.0).codes(), ["start_blocked"]);
    // Where it stands is known to a few decimetres only.
    let near_wall = at(0, 1.5, 0.3);
    assert!(near_wall.codes().is_empty() && near_wall.centre('a').is_some());
}

#[test]
fn closed_tours_come_back() {
    for start in [None, AT_A] {
        let planned =
            |closed_tours| House::drawn(&[GROUND]).planned(&MissionPlanOptions { closed_tours, start, ..quick() });
        let (open, closed) = (planned(false), planned(true));
        let ends = |planned: &Planned| {
            let mission_plan = planned.mission_plan();
            let tour = mission_plan.tour_of(&mission_plan.storeys[0]);
            (tour[0], *tour.last().unwrap())
        };
        assert_eq!(ends(&closed).0, ends(&closed).1);
        assert_ne!(ends(&open).0, ends(&open).1);
        assert!(closed.mission_plan().storeys[0].tour_m > open.mission_plan().storeys[0].tour_m);
        assert_eq!((open.mission_plan().head.closed_tours, closed.mission_plan().head.closed_tours), (0, 1));
    }
}

/// Length of the lines between points.
fn length_m(points: &[[f64; 2]]) -> f64 {
    points.windows(2).map(|p| (p[1][0] - p[0][0]).hypot(p[1][1] - p[0][1])).sum()
}

#[test]
fn a_tour_passes_its_stops_in_order_over_free_floor_and_is_as_long_as_it_says() {
    let planned = House::drawn(&[GROUND]).planned(&MissionPlanOptions { start: AT_A, ..quick() });
    let (mission_plan, grid) = (planned.mission_plan(), planned.archives.grid(0));
    let storey = &mission_plan.storeys[0];
    let tour = mission_plan.tour_of(storey);
    assert!((length_m(tour) - storey.tour_m).abs() < 1e-6, "{} {}", length_m(tour), storey.tour_m);
    let legs_m: f64 = mission_plan.waypoints.iter().map(|w| w.leg_m).sum();
    assert!((legs_m - storey.tour_m).abs() < 1e-6, "{legs_m}");
    assert!(storey.tour_bound_m <= storey.tour_m + 0.01);
    assert!((mission_plan.head.mission_s[0] - storey.tour_m / 0.5).abs() < 1e-6);
    assert_eq!(mission_plan.head.mission_s[1], f64::from(storey.n_scans) * 60.0);
    let mut rest = tour.iter();
    for waypoint in mission_plan.waypoints {
        let [x, y, _] = waypoint.position_in_map_m;
        assert!(rest.any(|p| *p == [x, y]), "the tour passes all stops in their order");
    }
    assert_free(&grid, tour, 0.3);
}

/// Every place on the line keeps nearly the robot's radius from what is not free: lines go from cell to cell.
fn assert_free(grid: &Grid<'_>, line: &[[f64; 2]], radius_m: f64) {
    let slack_m = grid.spec().resolution_m();
    for ends in line.windows(2) {
        let n = (length_m(ends) / 0.05).ceil().max(1.0);
        for k in 0..=n as usize {
            let at = [0, 1].map(|c| ends[0][c] + (ends[1][c] - ends[0][c]) * k as f64 / n);
            let clearance_m = brute_force::clearance_m(grid, at);
            assert!(clearance_m >= radius_m - slack_m, "{clearance_m} m at {at:?}");
        }
    }
}

/// Nodes connected with a node over edges that the robot can use.
fn connected(mission_plan: &MissionPlan<'_>, first: u32) -> BTreeSet<u32> {
    let mut found = BTreeSet::from([first]);
    loop {
        let more = mission_plan.edges.iter().filter(|e| e.usable == 1);
        let more = more.flat_map(|e| [(e.nodes[0], e.nodes[1]), (e.nodes[1], e.nodes[0])]);
        let new: Vec<u32> = more.filter(|(a, b)| found.contains(a) && !found.contains(b)).map(|(_, b)| b).collect();
        if new.is_empty() {
            return found;
        }
        found.extend(new);
    }
}

fn assert_edge_is_whole(planned: &Planned, edge: &RouteEdgeRecord) {
    let mission_plan = planned.mission_plan();
    let line = mission_plan.points_of(edge);
    let ends = edge.nodes.map(|n| mission_plan.nodes[n as usize].position_in_map_m);
    assert_eq!([line[0], *line.last().unwrap()], ends);
    let points: &[[f64; 2]] = &line.iter().map(|[x, y, _]| [*x, *y]).collect::<Vec<_>>();
    if !matches!(edge.kind.get(), EdgeKind::Floor | EdgeKind::Door) {
        return;
    }
    assert!((length_m(points) - edge.length_m).abs() < 1e-9);
    let storey = mission_plan.nodes[edge.nodes[0] as usize].map_storey;
    assert_free(&planned.archives.grid(storey as usize), points, 0.3);
    assert!(edge.clearance_m >= 0.3 - brute_force::TOLERANCE_M, "{edge:?}");
}

#[test]
fn the_graph_joins_all_that_can_be_reached_over_free_floor() {
    let planned = two_storeys(true, &["*"], AT_A);
    let mission_plan = planned.mission_plan();
    assert_eq!(connected(&mission_plan, 0).len(), mission_plan.nodes.len());
    mission_plan.edges.iter().for_each(|edge| assert_edge_is_whole(&planned, edge));
    let of_kind = |kind: NodeKind| mission_plan.nodes.iter().filter(|n| n.kind == kind).count();
    assert_eq!((of_kind(NodeKind::Space), of_kind(NodeKind::Door)), (4, 1));
    for node in mission_plan.nodes {
        let grid = planned.archives.grid(node.map_storey as usize);
        let [x, y, z] = node.position_in_map_m;
        assert_eq!(z, f64::from(node.map_storey) * 3.0);
        assert!((node.clearance_m - brute_force::clearance_m(&grid, [x, y])).abs() < 1e-9, "{node:?}");
        let cell = grid.spec().index(grid.spec().cell_at(Point2::<Map>::new(x, y)).unwrap());
        assert_eq!(u32::from(grid.space[cell]), node.space.wrapping_add(1));
    }
}

#[test]
fn a_door_is_a_node_between_two_ways_through_it() {
    let planned = House::drawn(&[GROUND]).planned(&quick());
    let mission_plan = planned.mission_plan();
    let door = mission_plan.nodes.iter().position(|n| n.kind == NodeKind::Door).unwrap() as u32;
    let through: Vec<&RouteEdgeRecord> = mission_plan.edges.iter().filter(|e| e.kind == EdgeKind::Door).collect();
    assert_eq!(through.len(), 2);
    assert!(through.iter().all(|e| e.nodes.contains(&door) && e.of == 0), "{through:?}");
    let sides = through.iter().map(|e| e.nodes.into_iter().find(|n| *n != door).unwrap());
    let sides: Vec<_> = sides.map(|n| mission_plan.nodes[n as usize]).collect();
    let middle_x = mission_plan.nodes[door as usize].position_in_map_m[0];
    assert!((middle_x - 2.9).abs() < 0.1, "{middle_x}");
    let side_xs: Vec<f64> = sides.iter().map(|n| n.position_in_map_m[0]).collect();
    assert!(side_xs.iter().any(|x| *x < middle_x - 0.3) && side_xs.iter().any(|x| middle_x + 0.3 < *x), "{side_xs:?}");
}

#[test]
fn a_waypoint_looks_where_it_was_come_from_to_or_where_the_first_leg_leads() {
    let planned = House::drawn(&[GROUND]).planned(&MissionPlanOptions {
        kinds: [WaypointKind::Centre].into(),
        start: AT_A,
        ..quick()
    });
    let mission_plan = planned.mission_plan();
    let tour = mission_plan.tour_of(&mission_plan.storeys[0]);
    for waypoint in planned.of_kind(WaypointKind::Centre) {
        let [x, y, _] = waypoint.position_in_map_m;
        let at = tour.iter().position(|p| *p == [x, y]).unwrap();
        if let Some(before) = at.checked_sub(1).map(|k| tour[k]) {
            let yaw_rad = libm::atan2(y - before[1], x - before[0]);
            assert!((yaw_rad - waypoint.yaw_rad).abs() < 1e-9, "{yaw_rad} {}", waypoint.yaw_rad);
        }
    }
}

#[test]
fn a_storey_says_how_the_robot_comes_there_and_a_room_above_which_stair_is_missing() {
    let entries = |planned: &Planned| -> Vec<_> {
        planned.mission_plan().storeys.iter().map(|storey| storey.entry.get().name()).collect()
    };
    assert_eq!(entries(&two_storeys(true, &[], AT_A)), [Some("start"), Some("portal")]);
    let planned = two_storeys(false, &[], AT_A);
    assert_eq!(entries(&planned), [Some("start"), None]);
    let (why, reason) = planned.why('c');
    assert_eq!(why, NoWaypoint::Unreachable);
    assert!(reason.starts_with("this robot does not climb the stair IfcStair"), "{reason}");
    assert!(
        planned.why('d').1.starts_with("this robot does not take the lift IfcTransportElement"),
        "{:?}",
        planned.why('d')
    );
    // Without a start it is put onto the upper storey, which has no outer door.
    assert_eq!(entries(&two_storeys(false, &[], None))[1], Some("placed"));
}
