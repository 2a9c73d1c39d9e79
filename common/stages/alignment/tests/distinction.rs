//! Places that tell poses apart, in drawn buildings of which a simulated robot has seen a part.

#[path = "../../../occupancy/tests/support/mod.rs"]
mod support;

use alignment::{AlignedPose, Contrast, CornersInSight, Distinction, HeldOut, PoseHistory, PreparedMap, distinction};
use frames::{Map, PoseCovariance, Rigid2, Slam};
use messages::PoseEvidence;
use occupancy::{Cell, OccupancyMap};
use proptest::prelude::*;
use support::{Walls, flat, inside, model, scanned};

/// The flat with another wall.
fn flat_with(wall: [f64; 4]) -> Walls {
    flat().into_iter().chain([wall]).collect()
}

fn pose(reference: usize, map_from_slam: Rigid2<Map, Slam>) -> AlignedPose {
    let (evidence, covariance) = (PoseEvidence::default(), PoseCovariance::from_rows([[0.0; 3]; 3]));
    let history = PoseHistory { of_this_building: 0.0, held_out: HeldOut::default() };
    let (contrast, corners, about_m) = (Contrast::default(), CornersInSight::default(), [0.0; 2]);
    AlignedPose { reference, map_from_slam, evidence, contrast, corners, new: None, history, about_m, covariance }
}

/// What tells storeys apart for a robot that has seen a part of one of them, which lies alike in all.
fn distinction_of(storeys: &[Walls], slam: &OccupancyMap, truth: Rigid2<Map, Slam>) -> Distinction {
    let references: Vec<_> = storeys.iter().map(|walls| PreparedMap::of_model(&model(walls))).collect();
    let poses: Vec<AlignedPose> = (0..storeys.len()).map(|storey| pose(storey, truth)).collect();
    distinction(&references, &PreparedMap::of_slam(slam), &poses)
}

/// The cell of a SLAM map at a point of its frame.
fn cell_at(map: &OccupancyMap, point: [f64; 2]) -> Cell {
    let [column, row] = Rigid2::<Slam, Map>::of_x_y_yaw(map.origin).apply_inverse(point);
    let [column, row] = [column, row].map(|m| (m / map.resolution_m).floor());
    if column < 0.0 || row < 0.0 || column >= map.width as f64 {
        return Cell::Unknown;
    }
    map.cells.get(row as usize * map.width + column as usize).copied().unwrap_or(Cell::Unknown)
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(24) })]

    #[test]
    fn places_are_unseen_free_and_in_view_of_what_differs(
        x_m in 5.0..10.0f64,
        y_m in 6.1..8.1f64,
        length_m in 0.8..1.6f64,
        truth in (-20.0..20.0f64, -20.0..20.0f64, -3.1..3.1f64),
        origin_yaw_rad in prop::sample::select(vec![0.0, 0.7]),
    ) {
        let truth = Rigid2::new([truth.0, truth.1], truth.2);
        let wall = [x_m, y_m, x_m + length_m, y_m + 0.15];
        let slam = scanned(&flat(), &[[2.0, 2.0]], truth, 0.05, origin_yaw_rad);
        let found = distinction_of(&[flat(), flat_with(wall)], &slam, truth);
        prop_assert_eq!(&found.undecided, &Vec::<[usize; 2]>::new());
        prop_assert!(!found.places.is_empty());
        for place in &found.places {
            prop_assert_eq!(cell_at(&slam, place.in_slam_m), Cell::Unknown, "{:?}", place);
            prop_assert_eq!(&place.decided, &vec![[0, 1]]);
            let [x, y] = place.in_map_m[0];
            prop_assert!(!inside(&flat(), [x, y]), "{place:?}");
            let far_m = [x.clamp(wall[0], wall[2]) - x, y.clamp(wall[1], wall[3]) - y];
            prop_assert!(libm::hypot(far_m[0], far_m[1]) < 8.5, "{place:?}");
        }
    }
}

#[test]
fn storeys_that_are_alike_have_no_place_that_decides() {
    let truth = Rigid2::new([1.0, 2.0], 0.3);
    let slam = scanned(&flat(), &[[2.0, 2.0]], truth, 0.05, 0.0);
    let found = distinction_of(&[flat(), flat()], &slam, truth);
    assert_eq!(found, Distinction { places: Vec::new(), undecided: vec![[0, 1]] });
}

#[test]
fn of_three_storeys_the_two_that_are_alike_stay_undecided() {
    let truth = Rigid2::new([0.0; 2], 0.0);
    let slam = scanned(&flat(), &[[2.0, 2.0]], truth, 0.05, 0.0);
    let found = distinction_of(&[flat(), flat_with([6.0, 7.0, 7.5, 7.15]), flat()], &slam, truth);
    assert_eq!(found.undecided, [[0, 2]]);
    assert_eq!(found.places.first().unwrap().decided, [[0, 1], [1, 2]]);
}

#[test]
fn what_was_seen_and_what_cannot_be_reached_decide_nothing() {
    let truth = Rigid2::new([0.0; 2], 0.0);
    let everywhere = [[2.0, 2.0], [2.0, 7.5], [5.5, 3.5], [9.5, 7.0], [6.0, 7.5], [9.5, 3.0], [5.0, 1.0]];
    let slam = scanned(&flat(), &everywhere, truth, 0.05, 0.0);
    let seen = distinction_of(&[flat(), flat_with([6.0, 7.0, 7.5, 7.15])], &slam, truth);
    assert!(seen.places.is_empty(), "{:?}", seen.places);
    // The door to the room with the wall is closed by another wall on both storeys.
    let closed = flat_with([4.0, 3.6, 4.15, 4.6]);
    let other: Walls = closed.iter().copied().chain([[6.0, 7.0, 7.5, 7.15]]).collect();
    let slam = scanned(&closed, &[[2.0, 2.0]], truth, 0.05, 0.0);
    let found = distinction_of(&[closed, other], &slam, truth);
    assert_eq!(found, Distinction { places: Vec::new(), undecided: vec![[0, 1]] });
}

#[test]
fn a_wall_right_behind_what_was_seen_is_met_at_its_border() {
    let truth = Rigid2::new([0.0; 2], 0.0);
    let mut slam = scanned(&flat(), &[[2.0, 2.0]], truth, 0.05, 0.0);
    // The robot saw nothing at y above 4 m: there one storey has a wall across the whole room.
    let spec = Rigid2::<Map, Slam>::of_x_y_yaw(slam.origin);
    for (k, cell) in slam.cells.iter_mut().enumerate() {
        let middle = [k % slam.width, k / slam.width].map(|c| (c as f64 + 0.5) * slam.resolution_m);
        if spec.apply(middle)[1] > 4.0 {
            *cell = Cell::Unknown;
        }
    }
    let found = distinction_of(&[flat(), flat_with([0.2, 4.0, 4.0, 4.2])], &slam, truth);
    let [_, y] = found.places.first().unwrap().in_map_m[0];
    assert!((4.0..4.3).contains(&y), "{found:?}");
    assert!(found.undecided.is_empty());
}

#[test]
fn a_half_turn_is_told_apart_where_one_end_differs() {
    // A corridor with a door to each side, the same after a half turn but for one box.
    let half: Walls = vec![[0.0, 0.0, 12.0, 0.2], [0.0, 0.0, 0.2, 4.5], [3.0, 0.2, 3.15, 3.0]];
    let turned = half.iter().map(|[a, b, c, d]| [12.0 - c, 9.0 - d, 12.0 - a, 9.0 - b]);
    let mut walls: Walls = half.iter().copied().chain(turned).collect();
    walls.push([0.5, 7.5, 1.5, 8.0]);
    let truth = Rigid2::new([0.0; 2], 0.0);
    let mut slam = scanned(&walls, &[[6.0, 4.5]], truth, 0.05, 0.0);
    let spec = Rigid2::<Map, Slam>::of_x_y_yaw(slam.origin);
    for (k, cell) in slam.cells.iter_mut().enumerate() {
        let middle = [k % slam.width, k / slam.width].map(|c| (c as f64 + 0.5) * slam.resolution_m);
        let [x, y] = spec.apply(middle);
        if (x - 6.0).hypot(y - 4.5) > 3.5 {
            *cell = Cell::Unknown;
        }
    }
    let references = [PreparedMap::of_model(&model(&walls))];
    let half_turn = Rigid2::new([12.0, 9.0], std::f64::consts::PI);
    let found = distinction(&references, &PreparedMap::of_slam(&slam), &[pose(0, truth), pose(0, half_turn)]);
    let place = found.places.first().unwrap();
    let [first, second] = [place.in_map_m[0], place.in_map_m[1]];
    assert!((first[0] + second[0] - 12.0).abs() < 1e-9 && (first[1] + second[1] - 9.0).abs() < 1e-9);
    let near_m = [first, second].map(|[x, y]| (x - 1.0).hypot(y - 7.75));
    assert!(near_m.iter().any(|m| *m < 8.5), "{place:?}");
    assert!(found.undecided.is_empty());
}
