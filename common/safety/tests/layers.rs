//! The layer on level floors: against a slow search, where rules meet, at stairs and doors.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

mod support;

use grid::{Class, fifths_of};
use messages::{NONE, SafetySubject, element_flags};
use proptest::prelude::*;
use support::{CELL_M, Drawn, Floor};

/// Fifths of a cell from the cells of one element to each open cell: steps are tried until none is shorter.
fn searched(floor: &Floor, drawn: &Drawn, element: usize) -> Vec<u32> {
    let (width, n) = (floor.size[0] as usize, drawn.open.len());
    let is_seed: Vec<bool> = (0..n).map(|cell| floor.overlaps(element, cell, 0.0)).collect();
    // Corners may be passed beside cells of any element that the rule is about.
    let mut found: Vec<u32> = is_seed.iter().map(|is_seed| if *is_seed { 0 } else { u32::MAX }).collect();
    let passes = |cell: usize| drawn.open[cell] || is_seed[cell];
    loop {
        let before = found.clone();
        for cell in (0..n).filter(|&cell| drawn.open[cell] && !is_seed[cell]) {
            let (x, y) = ((cell % width) as isize, (cell / width) as isize);
            for (dx, dy) in (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| (dx, dy))) {
                let is_in =
                    |x: isize, y: isize| 0 <= x && x < floor.size[0] as isize && 0 <= y && y < floor.size[1] as isize;
                let at = |x: isize, y: isize| (y * width as isize + x) as usize;
                if !is_in(x + dx, y + dy) || before[at(x + dx, y + dy)] == u32::MAX {
                    continue;
                }
                let is_corner = dx != 0 && dy != 0;
                let is_passed = !is_corner || passes(at(x + dx, y)) || passes(at(x, y + dy));
                if is_passed {
                    let length = before[at(x + dx, y + dy)] + if is_corner { 7 } else { 5 };
                    found[cell] = found[cell].min(length);
                }
            }
        }
        if found == before {
            return found;
        }
    }
}

/// The cost at a distance by the doc: from 90 per cent beside the element to 10 at the end of the distance.
fn cost_at(fifths: u32, reach: u32) -> u8 {
    (90 - 80 * fifths / reach) as u8
}

proptest! {
    /// One element of glass among walls: no cell is nearer than the layer says, and none is left out.
    #[test]
    fn distances_are_those_of_a_slow_search(
        glass in (0..20_i32, 0..14_i32, 1..4_i32),
        walls in prop::collection::vec((0..20_i32, 0..14_i32, 1..6_i32, any::<bool>()), 0..6),
        distance_m in prop::sample::select(vec![0.1, 0.35, 1.0, 3.0]),
    ) {
        let mut floor = Floor::new([24, 18]).rule(SafetySubject::Glass, distance_m, Some(0.3));
        let corner = |x: i32, y: i32, z: f64| [f64::from(x) * CELL_M, f64::from(y) * CELL_M, z];
        let (x, y, n) = glass;
        let pane = floor.add(Class::Window, element_flags::GLASS, [corner(x, y, 0.0), corner(x + n, y + 1, 2.0)]);
        for (x, y, n, along) in walls {
            let (dx, dy) = if along { (n, 1) } else { (1, n) };
            floor.add(Class::Wall, 0, [corner(x, y, 0.0), corner(x + dx, y + dy, 2.0)]);
        }
        let drawn = floor.drawn();
        let expected = searched(&floor, &drawn, pane);
        let reach = fifths_of(distance_m / CELL_M);
        for (cell, &fifths) in expected.iter().enumerate() {
            let is_near = drawn.open[cell] && fifths <= reach;
            let cost = if is_near { cost_at(fifths, reach) } else { 0 };
            prop_assert_eq!(drawn.layer.cost[cell], cost, "cell {:?}", floor.middle(cell));
            prop_assert_eq!(drawn.cost_element(cell), is_near.then_some(pane));
            prop_assert_eq!(drawn.layer.speed_m_s(cell), is_near.then_some(0.3));
        }
    }
}

#[test]
fn where_two_rules_meet_the_lower_speed_and_the_higher_cost_count_each_with_its_element() {
    let mut floor = Floor::new([60, 20]).rule(SafetySubject::Glass, 2.0, Some(0.8)).rule(
        SafetySubject::Class(Class::Column),
        1.0,
        Some(0.3),
    );
    let glass = floor.add(Class::Window, element_flags::GLASS, [[1.0, 0.0, 0.0], [1.1, 2.0, 2.0]]);
    let column = floor.add(Class::Column, 0, [[3.0, 0.9, 0.0], [3.1, 1.1, 2.0]]);
    let drawn = floor.drawn();
    // Beside the glass, between both, beside the column, beyond it.
    for (x, speed, cost) in [
        (1.15, Some((0.8, glass)), Some(glass)),
        (2.25, Some((0.3, column)), Some(glass)),
        (2.95, Some((0.3, column)), Some(column)),
        (3.95, Some((0.3, column)), Some(column)),
        (4.25, None, None),
    ] {
        let cell = drawn.at([x, 1.05]);
        let found = drawn.layer.speed_m_s(cell).zip(drawn.speed_element(cell));
        assert_eq!((found, drawn.cost_element(cell)), (speed, cost), "at {x} m");
    }
    // The larger of two distances to one element counts.
    let mut twice = Floor::new([60, 20]).rule(SafetySubject::Glass, 0.5, None).rule(SafetySubject::Glass, 1.5, None);
    twice.add(Class::Window, element_flags::GLASS, [[1.0, 0.0, 0.0], [1.1, 2.0, 2.0]]);
    let drawn = twice.drawn();
    assert!(drawn.layer.is_within_distance(drawn.at([2.55, 1.05])));
    assert!(!drawn.layer.is_within_distance(drawn.at([2.75, 1.05])));
}

#[test]
fn the_edge_at_which_a_stair_leads_down_keeps_its_distance_and_one_that_leads_up_has_none() {
    // A hole of 1 x 2 m in the floor.
    let mut floor = Floor::new([60, 40]).rule(SafetySubject::StairEdge, 0.6, Some(0.2));
    floor.heights = |[x, y]| if 2.0 < x && x < 3.0 && 1.0 < y && y < 3.0 { None } else { Some(0.0) };
    let down = floor.add(Class::Stair, 0, [[2.0, 1.0, -3.0], [3.0, 3.0, 0.0]]);
    let up = floor.add(Class::Stair, 0, [[4.5, 1.0, 0.0], [5.0, 3.0, 3.0]]);
    let drawn = floor.drawn();
    for (x, is_near) in [(1.35, false), (1.45, true), (1.95, true), (3.05, true), (3.55, true), (3.65, false)] {
        let cell = drawn.at([x, 2.05]);
        assert_eq!(drawn.cost_element(cell), is_near.then_some(down), "at {x} m");
    }
    assert!((0..drawn.open.len()).all(|cell| drawn.cost_element(cell) != Some(up)));
}

#[test]
fn a_door_swings_over_a_quarter_of_a_circle_on_its_side_and_not_through_a_wall() {
    let door_in = |wall: Option<[[f64; 3]; 2]>| {
        let mut floor = Floor::new([40, 40]).rule(SafetySubject::DoorSwing, 0.0, Some(0.2));
        let door = floor.door([1.5, 2.5], 1.0, 0.0, 0);
        wall.map(|corners| floor.add(Class::Wall, 0, corners));
        (door, floor.drawn(), floor)
    };
    let (door, drawn, floor) = door_in(None);
    let hinge = [1.5, 1.05];
    for cell in (0..drawn.open.len()).filter(|&cell| drawn.open[cell]) {
        let [x, y] = floor.middle(cell);
        let from_hinge = (x - hinge[0]).hypot(y - hinge[1]);
        let is_swept = x > hinge[0] && y > 1.1 && from_hinge < 1.0;
        let is_beside = x < hinge[0] - CELL_M || y < 1.0 || from_hinge > 1.0 + 1.5 * CELL_M;
        let found = drawn.speed_element(cell);
        assert!(!is_swept || found == Some(door), "the leaf passes ({x}, {y})");
        assert!(!is_beside || found.is_none(), "the leaf does not come to ({x}, {y})");
    }
    // Behind a wall across the way the leaf is not.
    let (_, drawn, _) = door_in(Some([[1.0, 1.5, 0.0], [3.0, 1.6, 2.0]]));
    assert_eq!(drawn.speed_element(drawn.at([1.75, 1.75])), None);
    assert!(drawn.speed_element(drawn.at([1.75, 1.35])).is_some());
}

#[test]
fn a_door_of_another_storey_does_not_swing_here() {
    let mut floor = Floor::new([40, 40]).rule(SafetySubject::DoorSwing, 0.0, Some(0.2));
    floor.site.map_storeys.push(messages::MapStoreyRecord {
        floor_z_tenths: 30_000,
        floor: messages::FloorKind::Built.into(),
        ..bytemuck::Zeroable::zeroed()
    });
    floor.door([1.5, 2.5], 1.0, 0.0, 1);
    let nowhere = floor.door([1.5, 2.5], 3.0, 0.0, NONE);
    let drawn = floor.drawn();
    let found: Vec<usize> = (0..drawn.open.len()).filter_map(|cell| drawn.speed_element(cell)).collect();
    assert!(!found.is_empty() && found.iter().all(|element| *element == nowhere));
}
