//! SLAM maps of two storeys: that they are is said, and nothing of the kind of maps of one.

#[path = "../../../occupancy/tests/support/mod.rs"]
mod support;

use alignment::{Alignment, PreparedMap, align_maps_within};
use frames::Rigid2;
use occupancy::{Cell, OccupancyMap};
use support::{Walls, model, scanned};

/// Rooms on both sides of a corridor of 18 m: the outer walls of every storey, and walls of its own at these places.
fn storey(below: &[f64], above: &[f64], corridor: [f64; 2], doors: [f64; 3]) -> Walls {
    let mut walls: Walls =
        vec![[0.0, 0.0, 18.0, 0.2], [0.0, 10.8, 18.0, 11.0], [0.0, 0.0, 0.2, 11.0], [17.8, 0.0, 18.0, 11.0]];
    for (k, y) in corridor.into_iter().enumerate() {
        let mut from = 0.2;
        for door in doors.map(|door| door + k as f64) {
            walls.push([from, y, door, y + 0.15]);
            from = door + 1.1;
        }
        walls.push([from, y, 17.8, y + 0.15]);
    }
    walls.extend(below.iter().map(|x| [*x, 0.2, x + 0.15, corridor[0]]));
    walls.extend(above.iter().map(|x| [*x, corridor[1], x + 0.15, 10.8]));
    walls
}

fn ground() -> Walls {
    storey(&[4.2, 9.8], &[3.0, 7.6, 13.1], [4.0, 6.0], [1.5, 7.0, 13.0])
}

fn upper() -> Walls {
    storey(&[6.0, 8.1, 14.0], &[5.4, 11.0], [3.1, 7.4], [2.5, 5.5, 11.5])
}

/// Where the robot looks around, up to a place along the corridor.
fn places(to_x: f64) -> Vec<[f64; 2]> {
    let along = |y: f64, step: f64| (0..).map(move |k| [1.2 + step * f64::from(k), y]).take_while(move |p| p[0] < to_x);
    std::iter::once([9.0, 5.4]).chain(along(5.4, 2.0)).chain(along(1.8, 2.3)).chain(along(9.3, 2.3)).collect()
}

fn truth() -> Rigid2<frames::Map, frames::Slam> {
    Rigid2::new([2.0, -3.0], 0.3)
}

fn map_of(walls: &Walls, to_x: f64) -> OccupancyMap {
    scanned(walls, &places(to_x), truth(), 0.05, 0.0)
}

fn aligned(slam: &OccupancyMap) -> Alignment {
    let references = [ground(), upper()].map(|walls| PreparedMap::of_model(&model(&walls)));
    align_maps_within(&references, &[0, 1], &PreparedMap::of_slam(slam), None, &[], None)
}

fn assert_both_are_named(found: &Alignment) {
    let names = ["are those of storey 1 and not of storey 0", "are those of storey 0 and not of storey 1"];
    assert!(names.iter().any(|name| found.reason.contains(name)), "{} {}", found.verdict.name(), found.reason);
    assert!(found.reason.contains("save a map for each"), "{}", found.reason);
}

#[test]
fn maps_of_one_storey_are_not_said_to_show_two() {
    for (walls, number) in [(ground(), 0), (upper(), 1)] {
        let found = aligned(&map_of(&walls, 17.0));
        assert_eq!((found.verdict.name(), found.poses[0].reference), ("accepted", number), "{}", found.reason);
        assert_eq!(found.reason, "");
    }
}

#[test]
fn a_storey_that_is_mapped_over_another_one_is_named() {
    // The robot takes a lift: its map goes on where it began.
    let (first, then) = (map_of(&ground(), 17.0), map_of(&upper(), 8.0));
    let cells = first.cells.iter().zip(&then.cells);
    let cells = cells.map(|(first, then)| if *then == Cell::Unknown { *first } else { *then }).collect();
    assert_both_are_named(&aligned(&OccupancyMap { cells, ..first }));
}

#[test]
fn a_storey_that_is_mapped_beside_another_one_is_named() {
    // It takes a stair: its map goes on where that ends.
    let (first, then) = (map_of(&ground(), 17.0), map_of(&upper(), 17.0));
    let height = first.cells.len() / first.width;
    let rows = |map: &OccupancyMap, row: usize| map.cells[row * map.width..(row + 1) * map.width].to_vec();
    let cells = (0..height).flat_map(|row| [rows(&first, row), rows(&then, row)].concat()).collect();
    let both = OccupancyMap { width: first.width + then.width, cells, ..first };
    assert_both_are_named(&aligned(&both));
}

#[test]
fn furniture_is_no_storey() {
    let mut furnished = ground();
    furnished.extend([[5.0, 1.0, 8.5, 1.6], [11.0, 0.8, 11.6, 3.4], [14.0, 8.0, 17.0, 8.6], [8.4, 8.8, 12.4, 9.4]]);
    let found = aligned(&map_of(&furnished, 17.0));
    assert!(!found.reason.contains("storey 1"), "{}", found.reason);
    assert_eq!(found.poses.first().unwrap().reference, 0);
}
