//! Places carried from a drawn building into bent SLAM maps of it.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

#[path = "../../../occupancy/tests/support/mod.rs"]
mod support;

use deviations::{DeviationInput, LocalTransform, SlamPlace};
use frames::{Map, PoseCovariance, Rigid2, Slam};
use messages::{ContentHash, PoseRecord, RobotProfile, ScheduleState, ScheduleStateBuilder, Site, SlamFrame};
use support::{PLACES, Storey, flat, inside, scanned_bent};

const VARIANCE: [[f64; 3]; 3] = [[1e-4, 0.0, 0.0], [0.0, 1e-4, 0.0], [0.0, 0.0, 1e-6]];
/// 95 % of the squares of two standard normal numbers are below this sum.
const GATE: f64 = 5.99;

fn map_from_slam() -> Rigid2<Map, Slam> {
    Rigid2::new([3.0, -7.0], 0.4)
}

/// The given places in the map of a robot that takes places for others.
fn carried(believed: &dyn Fn([f64; 2]) -> [f64; 2], places: &[[f64; 2]]) -> Vec<SlamPlace> {
    let slam = scanned_bent(&flat(), &PLACES, map_from_slam(), 0.05, 0.0, believed);
    let site = Storey::of(&flat()).site();
    let site = Site::open(site.bytes()).unwrap();
    let schedule_state =
        ScheduleStateBuilder::everything_built(site.content_hash(), site.elements.len(), site.spaces.len()).finish();
    let schedule_state = ScheduleState::open(schedule_state.bytes()).unwrap();
    let pose = PoseRecord { map_from_slam: map_from_slam().x_y_yaw(), ..PoseRecord::NONE };
    let slam_frame = SlamFrame::rigid(&pose);
    let transform = LocalTransform::of(&DeviationInput {
        site: &site,
        schedule_state: &schedule_state,
        robot: &RobotProfile::DEFAULT,
        map_storey: 0,
        slam: &slam,
        slam_map_hash: ContentHash::from_bits(7),
        slam_frame: &slam_frame,
        about_m: map_from_slam().apply_inverse([6.0, 4.5]),
        covariance: PoseCovariance::from_rows(VARIANCE),
    });
    places.iter().map(|place| transform.slam_place(*place, 0.3).unwrap()).collect()
}

/// Places in the rooms, a metre apart.
fn rooms() -> Vec<[f64; 2]> {
    let grid = (1..12).flat_map(|x| (1..9).map(move |y| [f64::from(x), f64::from(y)]));
    grid.filter(|place| !inside(&flat(), *place)).collect()
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// Square of the error of a place in its own standard deviations.
fn normalized(place: &SlamPlace, truth: [f64; 2]) -> f64 {
    let [[xx, xy, _], [_, yy, _], _] = place.covariance.rows();
    let [x, y] = [truth[0] - place.at_m[0], truth[1] - place.at_m[1]];
    (yy * x * x - 2.0 * xy * x * y + xx * y * y) / (xx * yy - xy * xy)
}

#[test]
fn places_in_bent_maps_lie_inside_their_gates_and_nearer_than_by_the_rigid_pose() {
    let (mut n_inside, mut n, mut local_m, mut rigid_m, mut n_corrected) = (0, 0, 0.0, 0.0, 0);
    for k in 0..8 {
        let phase = f64::from(k) * 0.8;
        let bend_m = 0.03 + 0.015 * f64::from(k);
        let believed = move |[x, y]: [f64; 2]| {
            [x + bend_m * libm::sin(x / 6.0 + y / 9.0 + phase), y + bend_m * libm::sin(x / 7.0 - y / 8.0 + 2.0 * phase)]
        };
        let places = rooms();
        for (place, found) in places.iter().zip(carried(&believed, &places)) {
            let truth = map_from_slam().apply_inverse(believed(*place));
            n += 1;
            n_inside += usize::from(normalized(&found, truth) <= GATE);
            n_corrected += usize::from(found.is_corrected);
            local_m += distance(found.at_m, truth);
            rigid_m += distance(map_from_slam().apply_inverse(*place), truth);
        }
    }
    let share = n_inside as f64 / n as f64;
    assert!((0.9..=0.98).contains(&share), "{share} of {n} inside");
    assert!(2 * n_corrected > n, "{n_corrected} of {n} corrected");
    assert!(local_m < 0.6 * rigid_m, "{} against {} m", local_m / n as f64, rigid_m / n as f64);
}

#[test]
fn a_rigid_map_is_not_corrected_beyond_the_noise_of_its_cells() {
    for (place, found) in rooms().iter().zip(carried(&|place| place, &rooms())) {
        let rigid = map_from_slam().apply_inverse(*place);
        assert!(distance(found.at_m, rigid) < 0.025, "{place:?}: {found:?}");
        assert!(normalized(&found, rigid) <= GATE, "{place:?}: {found:?}");
        assert!((found.yaw_rad - (0.3 - 0.4)).abs() < 1e-12, "{found:?}");
    }
}

#[test]
fn a_place_far_from_all_surfaces_has_the_rigid_pose_and_a_larger_deviation() {
    let places = [[2.0, 2.0], [60.0, 4.5]];
    let believed = |[x, y]: [f64; 2]| [x + 0.08 * libm::sin(x / 6.0), y + 0.06];
    let [near, far] = carried(&believed, &places)[..] else { panic!("two places") };
    assert!(near.is_corrected && !far.is_corrected, "{near:?} {far:?}");
    assert!(distance(far.at_m, map_from_slam().apply_inverse(places[1])) < 1e-9, "{far:?}");
    assert!(far.covariance.worst_m() > 2.0 * near.covariance.worst_m(), "{near:?} {far:?}");
}
