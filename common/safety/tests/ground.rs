//! The layer where the ground is not level: on ramps and outdoors.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

mod support;

use grid::Class;
use messages::{FloorKind, GroundClass, SafetySubject, element_flags};
use proptest::prelude::*;
use support::{CELL_M, Floor, Heights};

/// A ramp of 20 % between two levels, 1 m apart.
const RAMP: Heights = |[x, _]| Some(((x - 1.0) * 0.2).clamp(0.0, 1.0));

/// Hills of a few metres, with a pit that has upright sides, and nothing beyond 7 m.
const HILLS: Heights = |[x, y]| {
    let hill = 100.0 + 0.8 * libm::sin(x) * libm::cos(0.7 * y);
    let is_pit = 4.0 < x && x < 5.0 && 1.0 < y && y < 3.0;
    (x < 7.0).then_some(if is_pit { hill - 2.0 } else { hill })
};

#[test]
fn on_a_ramp_what_stands_on_it_is_near_and_what_hangs_high_above_it_is_not() {
    let mut floor = Floor::on_ground([80, 20], FloorKind::Built, 0.0, RAMP).rule(SafetySubject::Glass, 0.3, None);
    // On the upper end, as a pane on a landing is; and overhead at its foot, where it would be in the way on the upper level.
    let upper = floor.add(Class::Window, element_flags::GLASS, [[7.0, 0.5, 1.0], [7.1, 1.5, 2.0]]);
    let overhead = floor.add(Class::Window, element_flags::GLASS, [[0.4, 0.5, 1.5], [0.5, 1.5, 2.0]]);
    let drawn = floor.drawn();
    assert_eq!(drawn.cost_element(drawn.at([6.75, 1.05])), Some(upper));
    assert_eq!(drawn.cost_element(drawn.at([6.55, 1.05])), None);
    assert!((0..drawn.open.len()).all(|cell| drawn.cost_element(cell) != Some(overhead)));
}

#[test]
fn what_stands_behind_an_edge_from_which_the_ground_breaks_off_is_near() {
    // Two cells of edge, a pane beside them that stands above who is on the other side of it, 2 m lower.
    let heights: Heights = |[x, _]| if x < 3.0 { Some(2.0 + 0.1 * x) } else { (x > 3.3).then_some(0.3) };
    let mut floor = Floor::on_ground([80, 20], FloorKind::Built, 0.0, heights).rule(SafetySubject::Glass, 1.0, None);
    let pane = floor.add(Class::Window, element_flags::GLASS, [[3.2, 0.0, 2.2], [3.3, 2.0, 4.0]]);
    let drawn = floor.drawn();
    assert_eq!(drawn.cost_element(drawn.at([2.85, 1.05])), Some(pane));
    assert!((0..drawn.open.len()).all(|cell| drawn.open[cell] || drawn.cost_element(cell).is_none()));
}

#[test]
fn the_map_of_the_ground_outdoors_tells_by_the_ground_there_and_not_by_its_own_height() {
    let layer = |floor_z_m: f64| {
        let mut floor = Floor::on_ground([80, 40], FloorKind::Ground, floor_z_m, HILLS).rule(
            SafetySubject::Class(Class::Column),
            0.5,
            Some(0.5),
        );
        let post = floor.add(Class::Column, 0, [[2.0, 2.0, 99.0], [2.1, 2.1, 102.0]]);
        // Deep below the ground, high above it, and where there is none.
        floor.add(Class::Column, 0, [[3.0, 1.0, 90.0], [3.1, 1.1, 98.0]]);
        floor.add(Class::Column, 0, [[3.0, 3.0, 103.0], [3.1, 3.1, 105.0]]);
        floor.add(Class::Column, 0, [[7.8, 3.0, 99.0], [7.9, 3.1, 105.0]]);
        let drawn = floor.drawn();
        let found: Vec<Option<usize>> = (0..drawn.open.len()).map(|cell| drawn.speed_element(cell)).collect();
        assert!(found.iter().flatten().all(|element| *element == post));
        assert_eq!(found[drawn.at([2.35, 2.05])], Some(post));
        drawn.layer.cost
    };
    assert!(layer(100.0) == layer(50.0) && layer(100.0) == layer(101.4));
}

#[test]
fn what_stands_at_the_bottom_of_a_pit_or_on_its_edge_is_near_to_who_is_there() {
    let mut floor =
        Floor::on_ground([80, 40], FloorKind::Ground, 100.0, HILLS).rule(SafetySubject::Glass, 0.3, Some(0.2));
    let deep = floor.add(Class::Window, element_flags::GLASS, [[4.5, 2.0, 97.0], [4.6, 2.1, 98.2]]);
    let edge = floor.add(Class::Window, element_flags::GLASS, [[5.0, 1.5, 99.0], [5.1, 2.5, 101.0]]);
    let drawn = floor.drawn();
    assert_eq!(drawn.speed_element(drawn.at([4.35, 2.05])), Some(deep));
    assert_eq!(drawn.speed_element(drawn.at([5.25, 2.05])), Some(edge));
}

#[test]
fn work_on_terrain_is_near_and_terrain_that_is_finished_is_what_is_driven_on() {
    let layer = |in_progress: bool, ground: GroundClass| {
        let mut floor = Floor::on_ground([80, 40], FloorKind::Ground, 100.0, HILLS)
            .rule(SafetySubject::Work, 0.2, Some(0.5))
            .rule(SafetySubject::Class(Class::Other), 0.2, Some(0.4));
        let earth = floor.add(Class::Other, 0, [[4.0, 1.0, 97.0], [5.0, 3.0, 100.0]]);
        floor.site.elements[earth].ground = ground.into();
        floor.in_progress = if in_progress { vec![earth] } else { Vec::new() };
        let drawn = floor.drawn();
        // On the edge of the pit that it fills.
        drawn.layer.speed_m_s(drawn.at([3.95, 2.05]))
    };
    assert_eq!(layer(true, GroundClass::Terrain), Some(0.5));
    assert_eq!(layer(false, GroundClass::Terrain), None);
    assert_eq!(layer(false, GroundClass::None), Some(0.4));
}

#[test]
fn a_stair_that_leads_down_from_the_ground_outdoors_has_an_edge() {
    let heights: Heights = |[x, y]| if 2.0 < x && x < 3.0 && 1.0 < y && y < 3.0 { None } else { Some(100.0 + 0.1 * x) };
    let mut floor =
        Floor::on_ground([60, 40], FloorKind::Ground, 90.0, heights).rule(SafetySubject::StairEdge, 0.6, None);
    let down = floor.add(Class::Stair, 0, [[2.0, 1.0, 97.0], [3.0, 3.0, 100.2]]);
    let up = floor.add(Class::Stair, 0, [[4.5, 1.0, 100.45], [5.0, 3.0, 103.0]]);
    let drawn = floor.drawn();
    assert_eq!(drawn.cost_element(drawn.at([1.75, 2.05])), Some(down));
    assert_eq!(drawn.cost_element(drawn.at([3.35, 2.05])), Some(down));
    assert!((0..drawn.open.len()).all(|cell| drawn.cost_element(cell) != Some(up)));
}

#[test]
fn a_door_swings_outdoors_if_it_opens_at_the_height_of_the_ground_before_it() {
    let mut floor = Floor::on_ground([80, 40], FloorKind::Ground, 90.0, |[x, _]| Some(100.0 + 0.1 * x)).rule(
        SafetySubject::DoorSwing,
        0.0,
        Some(0.2),
    );
    floor.site.map_storeys.push(messages::MapStoreyRecord {
        floor_z_tenths: 1_001_000,
        floor: FloorKind::Built.into(),
        ..bytemuck::Zeroable::zeroed()
    });
    let entrance = floor.door([1.0, 2.0], 1.0, 100.15, 1);
    let balcony = floor.door([4.0, 5.0], 1.0, 103.0, 1);
    let drawn = floor.drawn();
    assert_eq!(drawn.speed_element(drawn.at([1.45, 1.45])), Some(entrance));
    assert!((0..drawn.open.len()).all(|cell| drawn.speed_element(cell) != Some(balcony)));
}

/// Slopes of up to 30 % with a step between two parts, for the properties.
const STEPPED: Heights = |[x, y]| Some(0.3 * x - 0.2 * y + if x > 2.0 { 0.6 } else { 0.0 });

proptest! {
    /// What a robot meets that stands in a cell is not overlooked there, and what none could meet is not counted.
    #[test]
    fn distances_are_never_too_small_and_nothing_is_near_that_no_robot_meets(
        boxes in prop::collection::vec((0.0..3.8_f64, 0.0..3.8_f64, -1.0..3.0_f64, 0.05..0.6_f64, 0.02..1.0_f64), 1..8),
        kind in prop::sample::select(vec![FloorKind::Built, FloorKind::Ground]),
    ) {
        let mut floor = Floor::on_ground([40, 40], kind, 0.0, STEPPED).rule(SafetySubject::Glass, CELL_M, None);
        for (x, y, z, side, height) in boxes {
            floor.add(Class::Window, element_flags::GLASS, [[x, y, z], [x + side, y + side, z + height]]);
        }
        let drawn = floor.drawn();
        let [low, high] = Floor::slab_m();
        for cell in (0..drawn.open.len()).filter(|&cell| drawn.open[cell]) {
            let ground = STEPPED(floor.middle(cell)).unwrap();
            let near = |element: &usize| {
                let [bottom, top] = floor.z_of(*element);
                // What lies within a cell beside it is within the distance.
                floor.overlaps(*element, cell, 0.9) && bottom + 1e-3 < ground + high && ground + low < top - 1e-3
            };
            let n = drawn.layer.sources.len();
            let met = (0..floor.site_len()).find(near);
            // Corners of boxes lie across a corner of the cell: at 7 fifths, beyond the distance of 5.
            let is_straight = |element: usize| {
                let [x, y] = floor.middle(cell);
                floor.overlaps_at(element, [x, y], [0.5 + 0.9, 0.4]) || floor.overlaps_at(element, [x, y], [0.4, 0.5 + 0.9])
            };
            if met.is_some_and(is_straight) {
                prop_assert!(drawn.layer.cost[cell] > 0, "{:?} of {n}: {:?}", floor.middle(cell), met);
            }
            if let Some(element) = drawn.cost_element(cell) {
                let around = |sign: f64| {
                    let offsets = [-4.0, -3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0, 4.0].map(|k| k * CELL_M);
                    let [x, y] = floor.middle(cell);
                    let heights = offsets.iter().flat_map(|dx| offsets.iter().filter_map(move |dy| STEPPED([x + dx, y + dy])));
                    heights.map(|z| z * sign).fold(f64::NEG_INFINITY, f64::max) * sign
                };
                let [bottom, top] = floor.z_of(element);
                let is_possible = bottom < around(1.0) + high + 0.021 && around(-1.0) + low - 0.021 < top;
                prop_assert!(is_possible, "{:?}: {bottom}..{top}", floor.middle(cell));
            }
        }
    }

    /// A map with heights that are all that of the storey has the layer of one without.
    #[test]
    fn heights_that_are_level_change_nothing(
        boxes in prop::collection::vec((0.0..3.5_f64, 0.0..3.5_f64, -0.5..1.5_f64, 0.05..0.6_f64), 0..8),
    ) {
        let layer = |has_heights: bool| {
            let mut floor = Floor::new([40, 40])
                .rule(SafetySubject::Glass, 0.6, Some(0.4))
                .rule(SafetySubject::Work, 0.3, None)
                .rule(SafetySubject::StairEdge, 0.5, None)
                .rule(SafetySubject::DoorSwing, 0.0, Some(0.1));
            floor.has_heights = has_heights;
            floor.door([1.0, 2.0], 2.0, 0.0, 0);
            for (k, (x, y, z, side)) in boxes.iter().copied().enumerate() {
                let class = [Class::Window, Class::Stair][k % 2];
                let corners = [[x, y, z - 0.5], [x + side, y + side, z + 0.4]];
                let element = floor.add(class, element_flags::GLASS, corners);
                floor.in_progress.extend((k % 3 == 0).then_some(element));
            }
            floor.drawn().layer
        };
        prop_assert_eq!(layer(true).content_hash(), layer(false).content_hash());
    }
}
