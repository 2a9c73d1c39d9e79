//! Properties on every map: waypoints are reachable, and a planner with history equals a fresh one.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

mod support;

use messages::{NoWaypoint, WaypointKind};
use proptest::prelude::*;
use support::{Archives, House, Planned, brute_force};
use waypoints::{MissionPlanOptions, MissionPlanner, Start};

const WIDTH: usize = 30;
const HEIGHT: usize = 18;

/// A thing on the floor of the drawing.
#[derive(Debug, Clone)]
struct Thing {
    character: char,
    at: [usize; 2],
    size: [usize; 2],
}

fn pieces(characters: Vec<char>, most: usize) -> impl Strategy<Value = Vec<Thing>> {
    let piece = (prop::sample::select(characters), 1..WIDTH - 1, 1..HEIGHT - 1, 1usize..8, 1usize..8);
    let piece = piece.prop_map(|(character, x, y, w, h)| Thing { character, at: [x, y], size: [w, h] });
    prop::collection::vec(piece, 0..most)
}

/// Rooms a and b beside a wall with a door, c below both behind another door; pieces on their floor.
fn drawing(split: [usize; 2], doors: [usize; 2], widths: [usize; 2], pieces: &[Thing]) -> String {
    let mut squares = vec![vec!['#'; WIDTH]; HEIGHT];
    for (y, row) in squares.iter_mut().enumerate().take(HEIGHT - 1).skip(1) {
        for (x, square) in row.iter_mut().enumerate().take(WIDTH - 1).skip(1) {
            *square = match (x.cmp(&split[0]), y.cmp(&split[1])) {
                (_, std::cmp::Ordering::Greater) => 'c',
                (_, std::cmp::Ordering::Equal) => '#',
                (std::cmp::Ordering::Less, _) => 'a',
                (std::cmp::Ordering::Equal, _) => '#',
                (std::cmp::Ordering::Greater, _) => 'b',
            };
        }
    }
    for piece in pieces {
        for row in squares.iter_mut().skip(piece.at[1]).take(piece.size[1]) {
            for square in row.iter_mut().skip(piece.at[0]).take(piece.size[0]) {
                if square.is_ascii_lowercase() {
                    *square = piece.character;
                }
            }
        }
    }
    // Doors last: what stands before them stays.
    let first = 1 + doors[0] % (split[1] - widths[0]).max(1);
    (first..(first + widths[0]).min(split[1])).for_each(|y| squares[y][split[0]] = 'D');
    let first = 1 + doors[1] % (split[0] - widths[1]).max(1);
    (first..(first + widths[1]).min(split[0])).for_each(|x| squares[split[1]][x] = 'D');
    squares.into_iter().map(|row| row.into_iter().collect::<String>()).collect::<Vec<_>>().join("\n")
}

fn drawings(characters: Vec<char>, most: usize) -> impl Strategy<Value = String> {
    let splits = [10usize..WIDTH - 8, 8usize..HEIGHT - 5];
    (splits, [0usize..20, 0usize..20], [3usize..7, 3usize..7], pieces(characters, most))
        .prop_map(|(split, doors, widths, pieces)| drawing(split, doors, widths, &pieces))
}

/// A stair in the upper left corner, and a lift in the lower right one.
fn with_ways_up(text: &str) -> String {
    let mut rows: Vec<Vec<char>> = text.lines().map(|l| l.chars().collect()).collect();
    rows[1][1..3].fill('S');
    rows[HEIGHT - 2][WIDTH - 4..WIDTH - 1].fill('L');
    rows.into_iter().map(|row| row.into_iter().collect::<String>()).collect::<Vec<_>>().join("\n")
}

/// A step of a schedule.
#[derive(Debug, Clone)]
enum Step {
    /// A wall is put up or taken down.
    Wall(char),
    /// A wall was finished at a time.
    Finished(char, i64),
    /// A room is blocked or opened.
    Block(char),
    /// A room will be blocked at a time, or never.
    Closes(char, Option<i64>),
    /// Nothing.
    Wait,
}

fn steps() -> impl Strategy<Value = Vec<Step>> {
    let (digit, room) = (prop::sample::select(vec!['0', '1', '2']), prop::sample::select(vec!['a', 'b', 'c']));
    let step = prop_oneof![
        4 => digit.clone().prop_map(Step::Wall),
        2 => (digit, 0i64..1_000).prop_map(|(wall, at_s)| Step::Finished(wall, at_s)),
        1 => room.clone().prop_map(Step::Block),
        1 => (room, prop::option::of(0i64..1_000)).prop_map(|(room, at_s)| Step::Closes(room, at_s)),
        1 => Just(Step::Wait),
    ];
    prop::collection::vec(step, 1..7)
}

fn take(house: &mut House, step: &Step) {
    match *step {
        Step::Wall(wall) => {
            if !house.absent.remove(&wall) {
                house.absent.insert(wall);
            }
        }
        Step::Finished(wall, at_s) => {
            house.finished.insert(wall, at_s);
        }
        Step::Block(room) => {
            if house.blocked.remove(&room).is_none() {
                house.blocked.insert(room, "task:screed");
            }
        }
        Step::Closes(room, at_s) => {
            house.closing.remove(&room);
            house.closing.extend(at_s.map(|at_s| (room, at_s)));
        }
        Step::Wait => {}
    }
}

fn options(changed_since_s: Option<i64>, start: Option<Start>) -> MissionPlanOptions {
    MissionPlanOptions { search_steps: 3, tour_kicks: 3, changed_since_s, start, ..MissionPlanOptions::default() }
}

/// Every waypoint is clear by the radius, reachable, and inside its space.
fn check_waypoints(planned: &Planned, house: &House, start: Option<Start>) -> Result<(), TestCaseError> {
    let grid = planned.archives.grid(0);
    let (spec, radius_m) = (grid.spec(), house.robot.radius_m);
    let width = spec.width as usize;
    let standing = brute_force::standing(&grid, radius_m);
    let mission_plan = planned.mission_plan();
    let reached = match start {
        None if !house.storeys[0].has_floor_outside() => brute_force::first_part(&grid, &standing),
        _ => {
            // The part with the tour's first place: a door beside floor of no room is an outer one, at which a robot begins.
            let Some(first) = mission_plan.tour_points.first() else { return Ok(()) };
            // A centre between the middles of cells may be clear although its own cell is not.
            let own = spec.index(spec.cell_at(frames::Point2::new(first[0], first[1])).unwrap());
            let beside = [0, 1, width - 1, width, width + 1].into_iter().flat_map(|k| [own - k, own + k]);
            let cell = beside.into_iter().find(|&cell| standing[cell]);
            prop_assert!(cell.is_some(), "it begins where the robot can stand");
            brute_force::flood(&standing, width, cell.unwrap())
        }
    };
    for waypoint in mission_plan.waypoints {
        let at = [waypoint.position_in_map_m[0], waypoint.position_in_map_m[1]];
        let clearance_m = brute_force::clearance_m(&grid, at);
        prop_assert!(clearance_m >= radius_m - brute_force::TOLERANCE_M, "{clearance_m} m at {at:?}");
        prop_assert!((clearance_m - waypoint.clearance_m).abs() < 1e-9, "{clearance_m} m at {at:?}");
        prop_assert!(brute_force::is_at_or_beside(&grid, &reached, at), "{at:?} is unreachable");
        let cell = spec.index(spec.cell_at(frames::Point2::new(at[0], at[1])).unwrap());
        prop_assert!(!grid.is_keepout(cell));
        if let Some(name) = planned.name_of(waypoint) {
            prop_assert!(planned.is_in(name, at), "{:?} is not in {}", at, name);
        } else {
            prop_assert_eq!(waypoint.kind.get(), WaypointKind::Scan, "a centre has a space");
        }
    }
    // A space without a centre has none that is clear and reachable; one with a centre has it inside.
    for (place, space) in mission_plan.spaces.iter().enumerate() {
        let own = (0..spec.n_cells()).filter(|&c| usize::from(grid.space[c]) == place + 1);
        let n_standing = own.filter(|&c| reached[c]).count();
        if space.why != NoWaypoint::Has {
            prop_assert!(n_standing == 0 || house.closing.contains_key(&planned.archives.names[place]), "{space:?}");
        }
    }
    check_lines(planned, &reached)
}

/// Nodes are reachable, those of one part are connected, and lines of the graph and the tour run over free floor.
fn check_lines(planned: &Planned, reached: &[bool]) -> Result<(), TestCaseError> {
    let (mission_plan, grid) = (planned.mission_plan(), planned.archives.grid(0));
    let mut found = vec![false; mission_plan.nodes.len()];
    found.iter_mut().take(1).for_each(|f| *f = true);
    for _ in 0..mission_plan.nodes.len() {
        for [a, b] in mission_plan.edges.iter().map(|e| e.nodes.map(|n| n as usize)) {
            let either = found[a] || found[b];
            (found[a], found[b]) = (either, either);
        }
    }
    prop_assert!(found.iter().all(|f| *f), "of {} nodes are connected {:?}", found.len(), found);
    for node in mission_plan.nodes {
        let at = [node.position_in_map_m[0], node.position_in_map_m[1]];
        prop_assert!(brute_force::is_at_or_beside(&grid, reached, at), "the node at {at:?} is unreachable");
    }
    let in_plan = |edge| mission_plan.points_of(edge).iter().map(|[x, y, _]| [*x, *y]).collect::<Vec<_>>();
    let lines: Vec<Vec<[f64; 2]>> = mission_plan
        .edges
        .iter()
        .map(in_plan)
        .chain([mission_plan.tour_of(&mission_plan.storeys[0]).to_vec()])
        .collect();
    for ends in lines.iter().flat_map(|line| line.windows(2)) {
        for k in 0..=20 {
            let at = [0, 1].map(|c| ends[0][c] + (ends[1][c] - ends[0][c]) * f64::from(k) / 20.0);
            // A line may run along a side of a cell, and over its corner.
            let beside = [[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0]];
            let beside = beside.map(|d| [0, 1].map(|c| at[c] + 1e-6 * d[c]));
            let is_free = beside.iter().any(|p| planned.planning(0, *p) == 0);
            prop_assert!(is_free, "from {:?} to {:?} over what is not free at {:?}", ends[0], ends[1], at);
        }
    }
    Ok(())
}

/// Failures are minimal and shown: nothing is kept of them beside the source.
fn config() -> ProptestConfig {
    ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(48) }
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn waypoints_are_clear_can_be_got_to_and_lie_in_their_spaces(
        text in drawings(vec!['F', 'F', '1', '~', 'A', '.'], 9),
        start in prop::option::of((0.3f64..5.5, 0.3f64..3.0)),
        radius_m in prop::sample::select(vec![0.1, 0.2, 0.3, 0.37]),
    ) {
        let mut house = House::drawn(&[&text]);
        house.robot.radius_m = radius_m;
        let start = start.map(|(x_m, y_m)| Start { storey: 0, x_m, y_m });
        let planned = house.planned(&options(None, start));
        check_waypoints(&planned, &house, start)?;
    }

    #[test]
    fn a_planner_that_saw_other_schedule_states_plans_as_a_fresh_one(
        text in drawings(vec!['F', '0', '1', '2'], 7),
        upper in drawings(vec!['F', '0', '1', '2'], 5),
        steps in steps(),
        changed_since_s in prop::option::of(0i64..1_000),
        start in prop::option::of((0.5f64..5.0, 0.5f64..3.0)),
    ) {
        let upper = upper.replace('a', "d").replace('b', "e").replace('c', "f");
        let mut house = House::drawn(&[&with_ways_up(&text), &with_ways_up(&upper)]);
        house.absent.extend(['1', '2']);
        house.robot.climbs_stairs = 1;
        let start = start.map(|(x_m, y_m)| Start { storey: 0, x_m, y_m });
        let options = MissionPlanOptions { lifts: vec!["*".to_owned()], ..options(changed_since_s, start) };
        let mut planner = MissionPlanner::default();
        for step in &steps {
            take(&mut house, step);
            let archives = Archives::of(&house);
            let walked = archives.with(&options, |input| planner.plan(input));
            let fresh = archives.with(&options, |input| MissionPlanner::default().plan(input));
            prop_assert!(walked.bytes() == fresh.bytes(), "after {:?} in\n{}", step, text);
        }
    }
}
