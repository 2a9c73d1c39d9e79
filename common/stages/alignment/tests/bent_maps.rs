//! Maps that bend, or that show more than the model has: for which part of them a pose holds.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

#[path = "../../../occupancy/tests/support/mod.rs"]
mod support;

use alignment::{Alignment, HOLDS_M, LocalPose, PoseField, PreparedMap, align_maps};
use frames::{Map, Rigid2, Slam};
use messages::AlignmentVerdict;
use occupancy::{Cell, OccupancyMap};
use support::{Walls, model, scanned_bent};

/// Rooms on both sides of a corridor of 27 m, no two of which are alike.
fn wing() -> Walls {
    let mut walls: Walls =
        vec![[0.0, 0.0, 27.0, 0.2], [0.0, 11.8, 27.0, 12.0], [0.0, 0.0, 0.2, 12.0], [26.8, 0.0, 27.0, 12.0]];
    // Walls along the corridor with doors of 1.2 m, then the walls between rooms.
    let doors = [2.0, 7.5, 11.0, 17.5, 22.0];
    for [low, high, shift] in [[4.8, 5.0, 0.0], [7.0, 7.2, 1.3]] {
        let mut from = 0.2;
        for door in doors.map(|door| door + shift) {
            walls.push([from, low, door, high]);
            from = door + 1.2;
        }
        walls.push([from, low, 26.8, high]);
    }
    walls.extend([4.6, 10.1, 14.4, 20.2].map(|x| [x, 0.2, x + 0.15, 4.8]));
    walls.extend([6.9, 11.2, 17.0, 21.9].map(|x| [x, 7.2, x + 0.15, 11.8]));
    walls
}

/// Everywhere the robot looks around: in the corridor and in each room.
fn places() -> Vec<[f64; 2]> {
    let along = |y: f64, step: f64| (0..).map(move |k| [1.5 + step * f64::from(k), y]).take_while(|[x, _]| *x < 26.0);
    let middle = [13.5, 6.0];
    std::iter::once(middle).chain(along(6.0, 2.0)).chain(along(2.5, 2.6)).chain(along(9.5, 2.6)).collect()
}

/// Where a robot that turns too far from x = 9 m on takes a place for.
fn bent([x, y]: [f64; 2]) -> [f64; 2] {
    let beyond = (x - 9.0).max(0.0);
    // One in nine at the end, 1 m off.
    [x, y + beyond * beyond / 324.0]
}

fn aligned(reference: &OccupancyMap, slam: &OccupancyMap) -> (Alignment, PoseField) {
    let found = align_maps(&[PreparedMap::of_model(reference)], &PreparedMap::of_slam(slam), None);
    assert_eq!(found.verdict, AlignmentVerdict::Accepted, "{}", found.reason);
    let field = found.field.clone().unwrap();
    (found, field)
}

/// How far each place lies from where its local pose puts it, with the pose: `slam_from_map` is the truth of a map without a bend.
fn errors(
    field: &PoseField,
    slam_from_map: &Rigid2<Slam, Map>,
    bent: &dyn Fn([f64; 2]) -> [f64; 2],
) -> Vec<(f64, LocalPose, [f64; 2])> {
    let error = |place: [f64; 2]| {
        let in_slam = slam_from_map.apply(bent(place));
        let local = field.at(in_slam)?;
        let at = local.map_from_slam.apply(in_slam);
        Some(((at[0] - place[0]).hypot(at[1] - place[1]), local, in_slam))
    };
    places().into_iter().filter_map(error).collect()
}

fn is_inside(outline_m: &[Vec<Vec<[f64; 2]>>], [x, y]: [f64; 2]) -> bool {
    let crossings = |ring: &Vec<[f64; 2]>| {
        let ends = ring.iter().zip(ring.iter().cycle().skip(1));
        ends.filter(|(a, b)| (a[1] > y) != (b[1] > y) && x < a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0])).count()
    };
    outline_m.iter().flatten().map(crossings).sum::<usize>() % 2 == 1
}

#[test]
fn a_straight_map_is_held_by_one_pose() {
    let truth = Rigid2::new([3.0, -7.0], 0.4);
    let slam = scanned_bent(&wing(), &places(), truth, 0.05, 0.0, &|p| p);
    let (found, field) = aligned(&model(&wing()), &slam);
    let pose = found.poses[0].map_from_slam;
    let extent = field.extent_of(&pose);
    assert!(extent.walls_share > 0.95 && extent.largest_off_m < HOLDS_M, "{extent:?}");
    assert!(extent.unknown_share.is_sign_positive(), "nothing is not less than nothing: {extent:?}");
    assert!(field.covariance_of(&pose).unwrap().worst_m() < 0.1);
    assert!(errors(&field, &truth.inverse(), &|p| p).iter().all(|(error_m, ..)| *error_m < 0.1));
}

#[test]
fn of_a_bent_map_one_pose_holds_for_a_part_and_the_pose_of_each_place_is_told() {
    let truth = Rigid2::new([3.0, -7.0], 0.4);
    let slam = scanned_bent(&wing(), &places(), truth, 0.05, 0.0, &bent);
    let (found, field) = aligned(&model(&wing()), &slam);
    let pose = found.poses[0].map_from_slam;
    let extent = field.extent_of(&pose);
    assert!(extent.walls_share < 0.8 && extent.largest_off_m > 0.4, "{extent:?}");
    assert!(field.covariance_of(&pose).unwrap().worst_m() > 0.15, "nobody may use it for all of the map");
    let errors = errors(&field, &truth.inverse(), &bent);
    let known: Vec<_> = errors.iter().filter(|(_, local, _)| local.covariance.worst_m() <= 0.1).collect();
    assert!(known.len() as f64 > 0.7 * errors.len() as f64, "{} of {}", known.len(), errors.len());
    for (error_m, local, in_slam) in known {
        assert!(*error_m < (3.0 * local.covariance.worst_m()).max(0.15), "{error_m} m off at {in_slam:?}");
    }
    let is_held = |place: [f64; 2]| is_inside(&extent.outline_m, truth.inverse().apply(bent(place)));
    let off_m = |place: [f64; 2]| {
        let at = pose.apply(truth.inverse().apply(bent(place)));
        (at[0] - place[0]).hypot(at[1] - place[1])
    };
    let held: Vec<[f64; 2]> = places().into_iter().filter(|place| is_held(*place)).collect();
    assert!(held.len() > 10 && held.iter().all(|place| off_m(*place) < 0.25), "{held:?}");
    assert!(places().into_iter().any(|place| off_m(place) > 0.4 && !is_held(place)));
}

#[test]
fn where_the_model_has_nothing_nobody_says_that_the_pose_holds() {
    // The model ends where the drawings end: 14 m along the corridor.
    let whole = model(&wing());
    let columns = (14.0 / 0.05) as usize + 20;
    let cell = |k: usize| if k % whole.width < columns { whole.cells[k] } else { Cell::Unknown };
    let half = OccupancyMap { cells: (0..whole.cells.len()).map(cell).collect(), ..whole };
    let truth = Rigid2::new([3.0, -7.0], 0.4);
    let (found, field) = aligned(&half, &scanned_bent(&wing(), &places(), truth, 0.05, 0.0, &|p| p));
    let extent = field.extent_of(&found.poses[0].map_from_slam);
    assert!(extent.unknown_share > 0.3 && extent.area_share < 0.65, "{extent:?}");
    let local = |place: [f64; 2]| field.at(truth.inverse().apply(place)).unwrap();
    assert!(local([6.0, 6.0]).covariance.worst_m() < 0.1);
    assert!(local([25.0, 6.0]).covariance.worst_m() > 0.1, "11 m beyond the model");
    assert_eq!(field.at(truth.inverse().apply([80.0, 6.0])), None);
}

#[test]
fn a_bend_that_hides_walls_and_corners_from_one_pose_does_not_keep_it_from_being_accepted() {
    // The corridor bends on a circle: 1.6 m off at the end, and one pose sees through a quarter of the walls.
    const RADIUS_M: f64 = 100.0;
    let bent = |[x, y]: [f64; 2]| {
        let (sin, cos) = libm::sincos((x - 9.0).max(0.0) / RADIUS_M);
        let inside_m = RADIUS_M - (y - 6.0);
        [x.min(9.0) + inside_m * sin, 6.0 + RADIUS_M - inside_m * cos]
    };
    let truth = Rigid2::new([3.0, -7.0], 0.4);
    let (_, field) = aligned(&model(&wing()), &scanned_bent(&wing(), &places(), truth, 0.05, 0.0, &bent));
    let known: Vec<_> = errors(&field, &truth.inverse(), &bent)
        .into_iter()
        .filter(|(_, local, _)| local.covariance.worst_m() <= 0.1)
        .collect();
    assert!(known.len() as f64 > 0.5 * places().len() as f64, "{}", known.len());
    let is_beyond =
        |(error_m, local, _): &&(f64, LocalPose, _)| *error_m > (3.0 * local.covariance.worst_m()).max(0.15);
    let n_beyond = known.iter().filter(is_beyond).count();
    assert!((n_beyond as f64) < 0.05 * known.len() as f64, "{n_beyond} of {}", known.len());
    assert!(known.iter().all(|(error_m, ..)| *error_m < 0.3));
}
