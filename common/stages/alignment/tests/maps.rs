//! Alignment of drawn buildings with simulated SLAM maps of them.

#[path = "../../../occupancy/tests/support/mod.rs"]
mod support;

use alignment::{Alignment, Hint, PreparedMap, align_maps};
use frames::{Map, Rigid2, Slam, wrapped};
use messages::AlignmentVerdict;
use occupancy::{Cell, OccupancyMap};
use proptest::prelude::*;
use support::{PLACES, flat, model, scanned, twin};

fn align(reference: &OccupancyMap, slam: &OccupancyMap, hint: Option<&Hint>) -> Alignment {
    align_maps(&[PreparedMap::of_model(reference)], &PreparedMap::of_slam(slam), hint)
}

fn is_at(found: Rigid2<Map, Slam>, truth: Rigid2<Map, Slam>, at: [f64; 2]) -> bool {
    let found_at = found.apply(truth.apply_inverse(at));
    let turn_rad = wrapped(found.yaw_rad() - truth.yaw_rad());
    (found_at[0] - at[0]).hypot(found_at[1] - at[1]) < 0.05 && turn_rad.abs() < 0.01
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn a_flat_is_found_whatever_the_frame_and_the_resolution_of_the_robots_map(
        x_m in -50.0..50.0f64,
        y_m in -50.0..50.0f64,
        yaw_rad in -3.1..3.1f64,
        resolution_m in prop::sample::select(vec![0.02, 0.05, 0.08]),
        origin_yaw_rad in prop::sample::select(vec![0.0, 0.7]),
    ) {
        let truth = Rigid2::new([x_m, y_m], yaw_rad);
        let slam = scanned(&flat(), &PLACES, truth, resolution_m, origin_yaw_rad);
        let found = align(&model(&flat()), &slam, None);
        prop_assert_eq!(found.verdict, AlignmentVerdict::Accepted, "{}", found.reason);
        prop_assert!(is_at(found.poses[0].map_from_slam, truth, PLACES[0]), "{:?}", found.poses[0]);
        // The place that the covariance is told for is where the map is.
        let about = found.poses[0].map_from_slam.apply(found.poses[0].about_m);
        prop_assert!(about[0] > 0.0 && about[0] < 12.0 && about[1] > 0.0 && about[1] < 9.0);
    }
}

#[test]
fn a_building_that_is_its_own_half_turn_is_ambiguous_until_somebody_gives_a_hint() {
    let truth = Rigid2::new([3.0, -7.0], 0.4);
    let slam = scanned(&twin(), &[[1.0, 1.0], [9.0, 5.0], [5.0, 2.0], [5.0, 4.6]], truth, 0.05, 0.0);
    let found = align(&model(&twin()), &slam, None);
    assert_eq!(found.verdict, AlignmentVerdict::Ambiguous);
    assert!(found.poses.iter().any(|p| is_at(p.map_from_slam, truth, [5.0, 3.0])), "the true pose is among them");
    let other_yaw_rad = truth.yaw_rad() - std::f64::consts::PI;
    assert!(found.poses.iter().any(|p| (p.map_from_slam.yaw_rad() - other_yaw_rad).abs() < 0.01));
    let map_from_slam = Rigid2::new([3.4, -6.8], 0.3);
    let found = align(&model(&twin()), &slam, Some(&Hint { map_from_slam, radius_m: 2.0, radius_rad: 0.4 }));
    assert_eq!(found.verdict, AlignmentVerdict::Accepted, "{}", found.reason);
    assert!(is_at(found.poses[0].map_from_slam, truth, [5.0, 3.0]));
}

#[test]
fn of_two_wings_that_are_alike_both_are_told() {
    let quarter_turned = |[a, b, c, d]: &[f64; 4]| [27.0 - d, *a, 27.0 - b, *c];
    let wings: support::Walls = flat().into_iter().chain(flat().iter().map(quarter_turned)).collect();
    // Furniture, and a door to the yard through which a wall of another building is seen.
    let mut built: support::Walls = wings.iter().copied().filter(|wall| *wall != [0.0, 0.0, 0.2, 9.0]).collect();
    built.extend([[0.0, 0.0, 0.2, 1.0], [0.0, 2.0, 0.2, 9.0], [-6.0, -8.0, -5.8, 8.0]]);
    built.extend([[1.0, 8.0, 3.5, 8.8], [5.0, 6.2, 6.0, 7.5], [8.0, 0.2, 9.5, 1.0], [10.8, 6.0, 11.8, 7.0]]);
    let truth = Rigid2::new([3.0, -7.0], 0.4);
    let found = align(&model(&wings), &scanned(&built, &PLACES, truth, 0.05, 0.0), None);
    assert_eq!(found.verdict, AlignmentVerdict::Ambiguous, "{}", found.reason);
    let in_other_wing = &Rigid2::new([27.0, 0.0], std::f64::consts::FRAC_PI_2) * &truth;
    let [x, y] = PLACES[0];
    assert!(found.poses[..2].iter().any(|p| is_at(p.map_from_slam, truth, [x, y])));
    assert!(found.poses[..2].iter().any(|p| is_at(p.map_from_slam, in_other_wing, [27.0 - y, x])));
}

#[test]
fn a_room_between_thin_walls_is_its_own_half_turn_however_much_furniture_stands_in_it() {
    let attic = vec![
        // Knee walls, and around them the outer walls, whose rooms the robot does not see.
        [0.0, 0.0, 20.2, 0.2],
        [0.0, 10.0, 20.2, 10.2],
        [0.0, 0.0, 0.2, 10.2],
        [20.0, 0.0, 20.2, 10.2],
        [2.9, 2.9, 17.3, 3.0],
        [2.9, 7.2, 17.3, 7.3],
        [2.9, 2.9, 3.0, 7.3],
        [17.2, 2.9, 17.3, 7.3],
    ];
    let mut built = attic.clone();
    built.extend([[3.8, 6.5, 6.0, 7.2], [7.6, 6.3, 10.1, 7.2], [10.1, 6.6, 17.2, 7.2], [3.5, 3.0, 4.6, 3.6]]);
    built.extend([[11.4, 3.0, 16.6, 3.6], [16.6, 3.0, 17.2, 5.6]]);
    let truth = Rigid2::new([3.0, -7.0], 0.4);
    let places = [[4.5, 5.0], [10.0, 4.5], [15.5, 5.0]];
    let found = align(&model(&attic), &scanned(&built, &places, truth, 0.05, 0.0), None);
    assert_eq!(found.verdict, AlignmentVerdict::Ambiguous, "{}", found.reason);
    let turned = &Rigid2::new([20.2, 10.2], std::f64::consts::PI) * &truth;
    for (pose, at) in [(truth, [10.0, 5.0]), (turned, [10.2, 5.2])] {
        assert!(found.poses[..2].iter().any(|p| is_at(p.map_from_slam, pose, at)), "{:?}", &found.poses[..2]);
    }
}

#[test]
fn maps_that_show_too_little_are_refused_with_the_reason() {
    let all = |cell: Cell| OccupancyMap { width: 200, cells: vec![cell; 40_000], resolution_m: 0.05, origin: [0.0; 3] };
    let mut one_wall = all(Cell::Free);
    (20..180).for_each(|k| one_wall.cells[100 * 200 + k] = Cell::Occupied);
    let reference = model(&flat());
    for (what, slam) in [("free", all(Cell::Free)), ("unknown", all(Cell::Unknown)), ("occupied", all(Cell::Occupied))]
    {
        let found = align(&reference, &slam, None);
        assert_eq!(found.verdict, AlignmentVerdict::Refused, "{what}");
        assert!(found.reason.contains("too little of walls"), "{what}: {}", found.reason);
    }
    let nothing = OccupancyMap { width: 0, cells: Vec::new(), resolution_m: 0.05, origin: [0.0; 3] };
    assert_eq!(align(&reference, &nothing, None).verdict, AlignmentVerdict::Refused);
    let found = align(&reference, &one_wall, None);
    assert_ne!(found.verdict, AlignmentVerdict::Accepted, "{:?}", found.poses);
    assert!(!found.reason.is_empty());
}

#[test]
fn another_building_is_not_accepted() {
    let truth = Rigid2::new([0.0; 2], 1.0);
    let slam = scanned(&twin(), &[[1.0, 1.0], [9.0, 5.0], [5.0, 2.0]], truth, 0.05, 0.0);
    let found = align(&model(&flat()), &slam, None);
    assert_ne!(found.verdict, AlignmentVerdict::Accepted);
    assert!(!found.reason.is_empty());
}

#[test]
fn the_corners_of_walls_that_stand_are_found_and_those_of_walls_that_do_not_are_missed() {
    let truth = Rigid2::new([4.0, 5.0], 1.3);
    let corners = |built: &support::Walls| {
        align(&model(&flat()), &scanned(built, &PLACES, truth, 0.05, 0.0), None).poses[0].corners
    };
    let as_planned = corners(&flat());
    assert!(as_planned.n_seen >= 8 && as_planned.n_found + 1 >= as_planned.n_seen, "{as_planned:?}");
    let inner_stubs = [[7.3, 0.2, 7.45, 2.0], [7.3, 3.0, 7.45, 5.2], [0.2, 6.4, 2.0, 6.55], [10.0, 5.2, 11.8, 5.35]];
    let built = flat().into_iter().filter(|wall| !inner_stubs.contains(wall)).collect();
    let without = corners(&built);
    assert!(
        without.n_seen >= as_planned.n_seen && without.n_found < as_planned.n_found,
        "{without:?} of {as_planned:?}"
    );
}

#[test]
fn of_several_storeys_the_right_one_is_named_and_two_that_are_alike_are_ambiguous() {
    let truth = Rigid2::new([4.0, 5.0], 1.3);
    let slam = PreparedMap::of_slam(&scanned(&flat(), &PLACES, truth, 0.05, 0.0));
    let storeys = [twin(), flat()].map(|walls| PreparedMap::of_model(&model(&walls)));
    let found = align_maps(&storeys, &slam, None);
    assert_eq!((found.verdict, found.poses[0].reference), (AlignmentVerdict::Accepted, 1), "{}", found.reason);
    let storeys = [flat(), twin(), flat()].map(|walls| PreparedMap::of_model(&model(&walls)));
    let found = align_maps(&storeys, &slam, None);
    assert_eq!(found.verdict, AlignmentVerdict::Ambiguous);
    let mut alike = [found.poses[0].reference, found.poses[1].reference];
    alike.sort_unstable();
    assert_eq!(alike, [0, 2]);
}

#[test]
fn a_corner_of_two_walls_holds_no_scale() {
    let hall = vec![[0.0, 0.0, 30.0, 0.2], [0.0, 0.0, 0.2, 16.0], [29.8, 0.0, 30.0, 16.0], [0.0, 15.8, 30.0, 16.0]];
    let truth = Rigid2::new([1.0, 2.0], 0.3);
    let corner = scanned(&hall[..2].to_vec(), &[[3.0, 3.0], [5.0, 2.0]], truth, 0.05, 0.0);
    let found = align(&model(&hall), &corner, None);
    assert!(
        found.scale.is_none_or(|scale| scale.deviation > 0.1 && (0.8..1.25).contains(&scale.value)),
        "{:?}",
        found.scale
    );
    let flat = align(&model(&flat()), &scanned(&flat(), &PLACES, truth, 0.05, 0.0), None);
    assert!(flat.scale.is_some_and(|scale| (scale.value - 1.0).abs() < 0.005), "{:?}", flat.scale);
}

#[test]
fn the_same_maps_give_the_same_bits() {
    let truth = Rigid2::new([1.0, 2.0], -2.0);
    let slam = scanned(&flat(), &PLACES, truth, 0.05, 0.0);
    let first = align(&model(&flat()), &slam, None);
    for _ in 0..3 {
        assert_eq!(align(&model(&flat()), &slam, None), first);
    }
}

#[test]
fn a_map_file_says_the_same_in_every_way_that_map_servers_write_it() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).unwrap();
    write("m.pgm", b"P5\n3 2\n255\n\x00\xcd\xfe\xfe\x00\xcd");
    write("n.pgm", b"P5\n3 2\n255\n\xff\x32\x01\x01\xff\x32");
    write("r.pgm", b"P5\n3 2\n255\n\x64\xff\x00\x00\x64\xff");
    let read = |yaml: &str| {
        write("m.yaml", yaml.as_bytes());
        OccupancyMap::read(&folder.path().join("m.yaml"))
    };
    let thresholds = "occupied_thresh: 0.65\nfree_thresh: 0.196\n";
    let plain =
        read(&format!("image: m.pgm\nresolution: 0.05\norigin: [1.0, -2, 0.5]\nnegate: 0\n{thresholds}")).unwrap();
    use Cell::{Free, Occupied, Unknown};
    assert_eq!(plain.cells, [Free, Occupied, Unknown, Occupied, Unknown, Free], "from the lower left corner");
    assert_eq!((plain.width, plain.resolution_m, plain.origin), (3, 0.05, [1.0, -2.0, 0.5]));
    for other in [
        "image: n.pgm\nresolution: 0.05\norigin: [1.0, -2, 0.5]\nnegate: 1\nfree_thresh: 0.196\noccupied_thresh: 0.65",
        "image: n.pgm\nmode: trinary\nresolution: 5e-2\norigin: [1.0, -2.0, 0.5]\nnegate: true\nfree_thresh: 0.196",
        "mode: raw\nimage: r.pgm\nresolution: 0.05\norigin:\n- 1.0\n- -2\n- 0.5\n",
        "image: m.pgm\nresolution: 0.05\norigin: [1.0, -2, 0.5]\nnegate: 0\nfree_thresh: 0.25\noccupied_thresh: 0.65",
        "mode: scale\nimage: m.pgm\nresolution: 0.05\norigin: [1.0, -2, 0.5]\nfree_thresh: 0.196 # a comment",
    ] {
        assert_eq!(read(other).unwrap(), plain, "{other}");
    }
    write("large.pgm", &[&b"P5\n60 60\n255\n"[..], &[254; 3600]].concat());
    for (yaml, word) in [
        ("image: m.pgm\nresolution: 0\norigin: [0, 0, 0]", "resolution"),
        ("image: m.pgm\nresolution: 0.05\norigin: [0]", "origin"),
        ("image: none.pgm\nresolution: 0.05\norigin: [0, 0, 0]", "none.pgm"),
        ("image: m.yaml\nresolution: 0.05\norigin: [0, 0, 0]", "m.yaml"),
        ("resolution: 0.05\norigin: [0, 0, 0]", "image"),
        ("image: large.pgm\nresolution: 10\norigin: [0, 0, 0]", "600 x 600 m"),
        ("image: m.pgm\nresolution: .nan\norigin: [0, 0, 0]", "resolution"),
    ] {
        let error = read(yaml).unwrap_err();
        let source = std::error::Error::source(&error).unwrap();
        assert!(source.to_string().contains(word), "{source} for {yaml}");
    }
}
