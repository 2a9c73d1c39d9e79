//! Flight waypoints over drawn buildings, whose bodies are boxes: distances are those that a look at every box finds.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

mod support;

use frames::TENTHS_PER_M;
use messages::{Flight, FlightWaypointRecord, MissionPlan, NONE, NoFlight, ScheduleState, Site};
use proptest::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use support::{Archives, House, Planned};
use waypoints::{MissionPlanOptions, MissionPlanner};

type Place = [f64; 3];

/// Lower and upper corner, metres.
type Block = [Place; 2];

fn options(heights: &str, clearance_m: f64, spacing_m: f64) -> MissionPlanOptions {
    let text = format!(
        "waypoints = []\n[flight]\nheights_m = {heights}\nclearance_m = {clearance_m}\nspacing_m = {spacing_m}"
    );
    MissionPlanOptions::parse(&text).unwrap()
}

fn metres(tenths: [i32; 3]) -> Place {
    tenths.map(frames::metres)
}

/// The boxes of the elements that stand, with their elements, and of the rooms that are blocked.
fn blocks(archives: &Archives) -> (Vec<(u32, Block)>, Vec<Block>) {
    let (site, state) = (archives.site(), ScheduleState::open(archives.schedule_state.bytes()).unwrap());
    let mut standing = Vec::new();
    for (k, element) in site.elements.iter().enumerate().filter(|(k, _)| state.effective(*k).is_obstacle()) {
        for mesh in site.element_meshes(element) {
            let of = |pick: fn(i32, i32) -> i32| {
                [0, 1, 2].map(|axis| mesh.vertices.iter().map(|v| v[axis]).reduce(pick).unwrap())
            };
            standing.push((k as u32, [metres(of(i32::min)), metres(of(i32::max))]));
        }
    }
    let blocked = (0..site.spaces.len()).filter(|&k| state.is_blocked(k)).flat_map(|k| squares_of(&site, k)).collect();
    (standing, blocked)
}

/// The squares of a drawing that lie in a space, as boxes from its floor to its ceiling.
fn squares_of(site: &Site<'_>, space: usize) -> Vec<Block> {
    let record = &site.spaces[space];
    let polygon = site.floor_polygon(record);
    let Some(bounds) = polygon.bounds() else { return Vec::new() };
    let side = support::CHARACTER;
    let of = |k: usize| (bounds.min[k]..bounds.max[k]).step_by(side as usize);
    let [low, high] = [record.floor_z_tenths, record.floor_z_tenths + record.height_tenths];
    of(0)
        .flat_map(|x| of(1).map(move |y| [x, y]))
        .filter(|[x, y]| polygon.contains([f64::from(x + side / 2), f64::from(y + side / 2)]))
        .map(|[x, y]| [metres([x, y, low]), metres([x + side, y + side, high])])
        .collect()
}

/// How far a place lies outside of a box; 0 within it.
fn off([low, high]: &Block, at: Place) -> f64 {
    let off = [0, 1, 2].map(|k| (low[k] - at[k]).max(at[k] - high[k]).max(0.0));
    off.iter().map(|off| off * off).sum::<f64>().sqrt()
}

fn distance(all: &(Vec<(u32, Block)>, Vec<Block>), at: Place) -> f64 {
    let blocks = all.0.iter().map(|(_, block)| block).chain(&all.1);
    blocks.map(|block| off(block, at)).fold(f64::INFINITY, f64::min)
}

fn position(waypoint: &FlightWaypointRecord) -> Place {
    metres(waypoint.position_in_map_tenths)
}

fn plan_m(a: Place, b: Place) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// Connected parts by edges: of each waypoint the least that it hangs together with.
fn parts(flight: &Flight<'_>) -> Vec<usize> {
    let mut of: Vec<usize> = (0..flight.waypoints.len()).collect();
    loop {
        let before = of.clone();
        for [a, b] in flight.edges.iter().map(|edge| edge.map(|k| k as usize)) {
            let least = of[a].min(of[b]);
            (of[a], of[b]) = (least, least);
        }
        if of == before {
            return of;
        }
    }
}

/// All that flight waypoints promise, but for the distance of what was not tried.
fn prove(archives: &Archives, mission_plan: &MissionPlan<'_>) {
    let flight = mission_plan.flight.as_ref().unwrap();
    let (all, clearance_m) = (blocks(archives), flight.head.clearance_m);
    for waypoint in flight.waypoints {
        let at = position(waypoint);
        assert!(distance(&all, at) >= clearance_m - 1e-9, "{waypoint:?}");
        let standing = all.0.iter().map(|(k, block)| (off(block, at), *k)).min_by(|a, b| a.0.total_cmp(&b.0));
        let least = standing.map_or(5.0, |(least, _)| least.min(5.0));
        assert!((waypoint.clearance_m - least).abs() < 1e-9, "{waypoint:?} {least}");
        if waypoint.element == NONE {
            assert!(least >= 5.0);
        } else {
            let of_nearest = all.0.iter().filter(|(k, _)| *k == waypoint.element).map(|(_, block)| off(block, at));
            assert!((of_nearest.fold(f64::INFINITY, f64::min) - least).abs() < 1e-9);
        }
        let above_m =
            f64::from(waypoint.position_in_map_tenths[2] - waypoint.ground_z_tenths) / f64::from(TENTHS_PER_M);
        assert_eq!(above_m, flight.heights_m[waypoint.height as usize]);
        assert_eq!(waypoint.ground_z_tenths, waypoint.map_storey as i32 * support::STOREY);
    }
    for edge in flight.edges {
        let [a, b] = edge.map(|k| position(&flight.waypoints[k as usize]));
        assert!(plan_m(a, b) <= flight.head.spacing_m + 1e-9);
        for k in 0..=100 {
            let share = f64::from(k) / 100.0;
            let at = [0, 1, 2].map(|axis| a[axis] * (1.0 - share) + b[axis] * share);
            assert!(distance(&all, at) >= clearance_m - 1e-9, "{a:?} {b:?} {at:?}");
        }
    }
    let of = parts(flight);
    for (k, waypoint) in flight.waypoints.iter().enumerate() {
        assert_eq!(waypoint.part, flight.waypoints[of[k]].part);
    }
    let firsts: BTreeSet<usize> = of.iter().copied().collect();
    let numbers: BTreeSet<u32> = flight.waypoints.iter().map(|w| w.part).collect();
    assert!(firsts.len() == numbers.len() && numbers.len() == flight.head.n_parts as usize);
    for space in 0..mission_plan.spaces.len() {
        for (record, height) in flight.of_space(space).iter().zip(0..) {
            let is_here = |w: &&FlightWaypointRecord| w.space == space as u32 && w.height == height;
            assert_eq!(record.n_waypoints as usize, flight.waypoints.iter().filter(is_here).count());
            assert_eq!(record.why == NoFlight::Has, record.n_waypoints > 0);
        }
    }
}

/// Over each place of the lattice that is clear there is a waypoint near it, and where a space has none no place is clear.
fn prove_coverage(archives: &Archives, mission_plan: &MissionPlan<'_>) {
    let flight = mission_plan.flight.as_ref().unwrap();
    let (all, clearance_m) = (blocks(archives), flight.head.clearance_m);
    let mut largest: BTreeMap<(u32, usize), f64> = BTreeMap::new();
    for storey in 0..archives.grids.len() {
        let grid = archives.grid(storey);
        let (spec, step_m) = (grid.spec(), flight.head.step_m);
        for cell in (0..spec.n_cells()).filter(|&cell| grid.floor[cell] != 0) {
            let middle = spec.centre_of(spec.cell_of(cell)).coordinates_m();
            let offset_m = spec.resolution_m() / 2.0;
            let is_on_lattice = |c: f64| (((c - offset_m) / step_m).round() * step_m + offset_m - c).abs() < 1e-6;
            let space = u32::from(grid.space[cell]).wrapping_sub(1);
            if !middle.iter().all(|c| is_on_lattice(*c)) || why(flight, space) == Some(NoFlight::Blocked) {
                continue;
            }
            for (height, height_m) in flight.heights_m.iter().enumerate() {
                let at = [middle[0], middle[1], frames::metres(grid.head.floor_z_tenths) + height_m];
                let far = distance(&all, at);
                let most = largest.entry((space, height)).or_default();
                // A place within a body has no distance here, and that to its surface there.
                *most = most.max(far);
                let is_near = |w: &&FlightWaypointRecord| {
                    (w.space, w.height as usize) == (space, height)
                        && w.map_storey == storey as u32
                        && plan_m(position(w), at) <= flight.head.spacing_m / 2.0
                };
                if far >= clearance_m {
                    assert!(flight.waypoints.iter().any(|w| is_near(&w)), "{at:?} {far}");
                }
            }
        }
    }
    for ((space, height), most) in largest.into_iter().filter(|((space, _), _)| *space != NONE) {
        let record = flight.of_space(space as usize)[height];
        assert_eq!(record.why == NoFlight::Has, most >= clearance_m);
    }
}

fn why(flight: &Flight<'_>, space: u32) -> Option<NoFlight> {
    flight.of_space(space as usize).first().filter(|_| space != NONE).map(|record| record.why.get())
}

/// Numbers of the parts in which the waypoints over a space lie.
fn parts_over(planned: &Planned, space: char) -> BTreeSet<u32> {
    let place = planned.archives.names.iter().position(|name| *name == space).unwrap() as u32;
    let mission_plan = planned.mission_plan();
    mission_plan.flight.unwrap().waypoints.iter().filter(|w| w.space == place).map(|w| w.part).collect()
}

fn outcome(planned: &Planned, space: char, height: usize) -> (NoFlight, f64) {
    let place = planned.archives.names.iter().position(|name| *name == space).unwrap();
    let record = planned.mission_plan().flight.unwrap().of_space(place)[height];
    (record.why.get(), record.largest_clearance_m)
}

/// Two rooms with a wall between them, in which a stretch is an element of its own.
const ROOMS: &str = "
#####################
#aaaaaaaaaaaaa#bbbbb#
#aaaaaaaaaaaaa#bbbbb#
#aaaaaaaaaaaaa#bbbbb#
#aaaaaaaaaaaaa1bbbbb#
#aaaFFFaaaaaaa1bbbbb#
#aaaFFFaaaaaaa1bbbbb#
#aaaFFFaaaaaaa1bbbbb#
#aaaaaaaaaaaaa1bbbbb#
#aaaaaaaaaaaaa#bbbbb#
#aaaaaaaaaaaaa#bbbbb#
#aaaaaaaaaaaaa#bbbbb#
#####################";

#[test]
fn rooms_hang_together_through_an_open_hole_and_not_through_what_stands_in_it() {
    let options = options("[1.2]", 0.3, 2.0);
    let mut house = House::drawn(&[ROOMS]);
    let closed = house.planned(&options);
    prove(&closed.archives, &closed.mission_plan());
    assert_eq!(parts_over(&closed, 'a'), BTreeSet::from([0]));
    assert_eq!(parts_over(&closed, 'b'), BTreeSet::from([1]));
    house.absent.insert('1');
    let open = house.planned(&options);
    prove(&open.archives, &open.mission_plan());
    prove_coverage(&open.archives, &open.mission_plan());
    assert_eq!((parts_over(&open, 'a'), parts_over(&open, 'b')), (BTreeSet::from([0]), BTreeSet::from([0])));
    // The hole is 1 m wide.
    let large = house.planned(&self::options("[1.2]", 0.55, 2.0));
    assert_eq!((parts_over(&large, 'a'), parts_over(&large, 'b')), (BTreeSet::from([0]), BTreeSet::from([1])));
    // The walls are 2.5 m high, and nothing is above them.
    let over = house.planned(&self::options("[1.2, 3.2]", 0.55, 2.0));
    prove(&over.archives, &over.mission_plan());
    assert_eq!((parts_over(&over, 'a'), parts_over(&over, 'b')), (BTreeSet::from([0]), BTreeSet::from([0])));
}

#[test]
fn furniture_is_flown_over_and_not_through() {
    let mut house = House::drawn(&["
########
#FFFFFF#
#FaaaaF#
#FaaaaF#
#FFFFFF#
########"]);
    // Furniture is 0.8 m high, walls are 2.5 m: of the places 0.1 m apart none is farther than 0.35 m from a wall.
    let narrow = house.planned(&options("[1.5, 3.5]", 0.7, 2.0));
    assert_eq!(outcome(&narrow, 'a', 0), (NoFlight::TooNarrow, 0.35));
    assert_eq!(outcome(&narrow, 'a', 1), (NoFlight::Has, 0.0));
    prove(&narrow.archives, &narrow.mission_plan());
    house.storeys = House::drawn(&[&"FFFFFFFFFFFFFFFF\n".repeat(16)]).storeys;
    let over = house.planned(&options("[0.8, 1.4]", 0.6, 2.0));
    let heights: BTreeSet<u32> = over.mission_plan().flight.unwrap().waypoints.iter().map(|w| w.height).collect();
    assert_eq!(heights, BTreeSet::from([1]), "0.6 m above the furniture is kept exactly");
    prove(&over.archives, &over.mission_plan());
}

#[test]
fn a_blocked_room_is_not_flown_into_and_its_open_side_is_kept_away_from() {
    let mut house = House::drawn(&[ROOMS]);
    house.absent.insert('1');
    house.blocked.insert('b', "task:42");
    let planned = house.planned(&options("[1.2]", 0.5, 2.0));
    prove(&planned.archives, &planned.mission_plan());
    prove_coverage(&planned.archives, &planned.mission_plan());
    assert_eq!(outcome(&planned, 'b', 0).0, NoFlight::Blocked);
    assert_eq!(outcome(&planned, 'a', 0).0, NoFlight::Has);
}

#[test]
fn what_lies_within_a_body_is_no_air() {
    let mut rows = vec![String::new(); 30];
    (rows[0], rows[29]) = ("a".repeat(30), "a".repeat(30));
    rows[1..29].iter_mut().for_each(|row| *row = format!("a{}a", "L".repeat(28)));
    let planned = House::drawn(&[&rows.join("\n")]).planned(&options("[1.2]", 1.0, 4.0));
    // A lift car of 5.6 m: its surface is far from its middle, which belongs to the room around it.
    let mission_plan = planned.mission_plan();
    let flight = mission_plan.flight.as_ref().unwrap();
    assert!(flight.waypoints.is_empty(), "{:?}", flight.waypoints);
    assert_eq!(outcome(&planned, 'a', 0).0, NoFlight::WithinBody);
}

#[test]
fn only_spaces_that_are_asked_for_have_flight_waypoints() {
    let house = House::drawn(&[ROOMS]);
    let asked = MissionPlanOptions { spaces: vec!["b".to_owned()], ..options("[1.2]", 0.3, 2.0) };
    let planned = house.planned(&asked);
    prove(&planned.archives, &planned.mission_plan());
    assert_eq!(outcome(&planned, 'a', 0).0, NoFlight::NotAsked);
    assert_eq!(outcome(&planned, 'b', 0).0, NoFlight::Has);
}

#[test]
fn storeys_hang_together_where_nothing_is_between_them() {
    let above = "
#####################
#ccccccccccccc#ddddd#
#ccccccccccccc#ddddd#
#ccccccccccccc#ddddd#
#ccccccccccccc#ddddd#
#ccccccccccccc#ddddd#
#####################";
    let planned = House::drawn(&[ROOMS, above]).planned(&options("[1.2]", 0.3, 2.0));
    prove(&planned.archives, &planned.mission_plan());
    // There are no slabs in these drawings.
    assert_eq!(parts_over(&planned, 'c'), parts_over(&planned, 'a'));
    let flight = planned.mission_plan().flight.unwrap();
    let crosses = |edge: &&[u32; 2]| {
        let [a, b] = edge.map(|k| flight.waypoints[k as usize].map_storey);
        a != b
    };
    assert!(flight.edges.iter().filter(crosses).count() > 0);
}

#[test]
fn a_plan_without_the_section_has_no_flight_waypoints_and_one_of_too_large_cells_says_so() {
    let house = House::drawn(&[ROOMS]);
    let planned = house.planned(&MissionPlanOptions::default());
    assert!(planned.mission_plan().flight.is_none());
    let planned = house.planned(&options("[1.2]", 0.3, 0.3));
    assert!(planned.mission_plan().flight.unwrap().waypoints.is_empty());
    assert_eq!(outcome(&planned, 'a', 0).0, NoFlight::TooLarge);
    assert!(planned.codes().contains(&"flight_too_large".to_owned()));
    let mission_plan = planned.mission_plan();
    let mut messages = mission_plan.diagnostics.iter().map(|d| mission_plan.text(d.message));
    assert!(messages.any(|message| message.contains("cells of the maps are 0.1 m wide")));
}

/// A drawing of things on floor, the second room behind a wall of which a stretch is an element.
fn drawing(things: &[(char, [usize; 2], [usize; 2])]) -> String {
    let mut rows: Vec<Vec<char>> = ROOMS.trim().lines().map(|line| line.chars().collect()).collect();
    for (character, at, size) in things {
        for row in rows.iter_mut().skip(at[1]).take(size[1]) {
            for square in row.iter_mut().skip(at[0]).take(size[0]).filter(|square| square.is_ascii_lowercase()) {
                *square = *character;
            }
        }
    }
    rows.into_iter().map(|row| row.into_iter().collect::<String>()).collect::<Vec<_>>().join("\n")
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]
    #[test]
    fn waypoints_and_edges_keep_what_they_promise_and_a_planner_with_history_equals_a_fresh_one(
        things in proptest::collection::vec(
            (prop::sample::select(vec!['#', 'F', '2', ' ', '~']), [1usize..20, 1usize..12], [1usize..4, 1usize..4]), 0..6),
        absent in proptest::collection::btree_set(prop::sample::select(vec!['1', '2']), 0..2),
        is_blocked in any::<bool>(),
        clearance in 2u32..8,
        spacing in 8u32..30,
    ) {
        let mut house = House::drawn(&[&drawing(&things)]);
        let options = options("[1.0, 2.2]", f64::from(clearance) / 10.0, f64::from(spacing) / 10.0);
        let mut planner = MissionPlanner::default();
        let before = Archives::of(&house);
        before.with(&options, |input| planner.plan(input));
        house.absent = absent;
        if is_blocked {
            house.blocked.insert('b', "task:42");
        }
        let planned = house.planned(&options);
        let mission_plan = planned.mission_plan();
        prove(&planned.archives, &mission_plan);
        prove_coverage(&planned.archives, &mission_plan);
        let again = planned.archives.with(&options, |input| planner.plan(input));
        prop_assert!(again.bytes() == planned.bytes.bytes());
    }
}
