//! Deviations between drawn buildings and simulated SLAM maps of them.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

#[path = "../../../occupancy/tests/support/mod.rs"]
mod support;

use deviations::{DeviationInput, deviations};
use frames::{Map, PoseCovariance, Rigid2, Slam};
use grid::Class;
use messages::*;
use occupancy::OccupancyMap;
use proptest::prelude::*;
use support::{PLACES, Storey, Walls, flat, scanned, scanned_bent};

const VARIANCE: [[f64; 3]; 3] = [[1e-4, 0.0, 0.0], [0.0, 1e-4, 0.0], [0.0, 0.0, 1e-6]];

/// What was found: per element, and obstacles as (area, length, centroid).
struct Found {
    elements: Vec<ElementDeviationRecord>,
    absent_parts: Vec<AbsentPartRecord>,
    obstacles: Vec<ObstacleRecord>,
    residual_rms_m: f64,
}

impl Found {
    fn observation(&self, element: usize) -> (Observation, DeviationVerdict) {
        let record = self.of(element);
        (record.observation.get(), record.verdict.get())
    }

    fn of(&self, element: usize) -> &ElementDeviationRecord {
        self.elements.iter().find(|e| e.element == element as u32).unwrap()
    }

    fn reason(&self, element: usize) -> &'static str {
        self.of(element).reason.get().name()
    }
}

fn map_from_slam() -> Rigid2<Map, Slam> {
    Rigid2::new([3.0, -7.0], 0.4)
}

/// The frame of a map that does not bend.
fn rigid(map_from_slam: &Rigid2<Map, Slam>) -> SlamFrame {
    SlamFrame::rigid(&PoseRecord { map_from_slam: map_from_slam.x_y_yaw(), ..PoseRecord::NONE })
}

fn compared(
    storey: Storey,
    slam: &OccupancyMap,
    map_from_slam: Rigid2<Map, Slam>,
    plan: impl Fn(&mut ScheduleStateBuilder),
) -> Found {
    let site = storey.site();
    let site = Site::open(site.bytes()).unwrap();
    let mut schedule_state =
        ScheduleStateBuilder::everything_built(site.content_hash(), site.elements.len(), site.spaces.len());
    plan(&mut schedule_state);
    let schedule_state = schedule_state.finish();
    let archive = deviations(&DeviationInput {
        site: &site,
        schedule_state: &ScheduleState::open(schedule_state.bytes()).unwrap(),
        robot: &RobotProfile::DEFAULT,
        map_storey: 0,
        slam,
        slam_map_hash: ContentHash::from_bits(7),
        slam_frame: &rigid(&map_from_slam),
        about_m: [0.0; 2],
        covariance: PoseCovariance::from_rows(VARIANCE),
    });
    let found = Deviations::open(archive.bytes()).unwrap();
    found.check_site(&site).unwrap();
    Found {
        elements: found.elements.to_vec(),
        absent_parts: found.absent_parts.to_vec(),
        obstacles: found.obstacles.to_vec(),
        residual_rms_m: found.head.residual_rms_m,
    }
}

/// The flat as the model has it beside what was built.
fn as_built(built: &Walls) -> Found {
    compared(Storey::of(&flat()), &scanned(built, &PLACES, map_from_slam(), 0.05, 0.0), map_from_slam(), |_| {})
}

const ON_PLAN: (Observation, DeviationVerdict) = (Observation::Observed, DeviationVerdict::OnPlan);

fn assert_all_on_plan(found: &Found, but: &[usize]) {
    for element in (0..flat().len()).filter(|e| !but.contains(e)) {
        assert_eq!(found.observation(element), ON_PLAN, "{:?}", found.of(element));
        assert!(found.of(element).offset_m.abs() < 0.05, "{:?}", found.of(element));
    }
}

#[test]
fn a_flat_that_was_built_as_planned_has_no_deviation() {
    let found = as_built(&flat());
    assert_all_on_plan(&found, &[]);
    assert!(found.absent_parts.is_empty(), "{:?}", found.absent_parts);
    assert!(found.obstacles.is_empty(), "{:?}", found.obstacles);
}

/// The flat with a wall in three leafs; their elements are the wall's own and the two after all others.
fn with_leafs(element: usize) -> Storey {
    let mut model = flat();
    let [x0, y0, x1, y1] = model[element];
    let across = usize::from(x1 - x0 > y1 - y0);
    let leaf = |from: f64, to: f64| {
        let mut leaf = [x0, y0, x1, y1];
        let (near, far) = (leaf[across], leaf[across + 2]);
        (leaf[across], leaf[across + 2]) = (near + (far - near) * from, near + (far - near) * to);
        leaf
    };
    model[element] = leaf(0.0, 0.3);
    model.extend([leaf(0.3, 0.7), leaf(0.7, 1.0)]);
    Storey::of(&model)
}

#[test]
fn all_leafs_of_a_wall_that_is_gone_are_absent_and_those_of_a_moved_wall_displaced() {
    let leafs = [4, flat().len(), flat().len() + 1];
    let found_in = |built: &Walls| {
        compared(with_leafs(4), &scanned(built, &PLACES, map_from_slam(), 0.05, 0.0), map_from_slam(), |_| {})
    };
    let mut built = flat();
    built.remove(4);
    let found = found_in(&built);
    for leaf in leafs {
        assert_eq!(found.observation(leaf), (Observation::Absent, DeviationVerdict::Late), "{:?}", found.of(leaf));
    }
    assert_all_on_plan(&found, &[4]);
    let mut built = flat();
    built[4] = [0, 1, 2, 3].map(|k| built[4][k] + [0.3, 0.0][k % 2]);
    let found = found_in(&built);
    for leaf in leafs {
        assert_eq!(found.observation(leaf).0, Observation::Displaced, "{:?}", found.of(leaf));
    }
    let found = found_in(&flat());
    for leaf in leafs {
        assert!(
            matches!(found.observation(leaf).1, DeviationVerdict::OnPlan | DeviationVerdict::Unknown),
            "{:?}",
            found.of(leaf)
        );
    }
}

#[test]
fn a_hole_in_a_wall_is_an_absent_part_with_its_ends() {
    let [x0, y0, x1, y1] = flat()[4];
    let (from, to) = (y0 + 1.0, y0 + 2.2);
    let mut built = flat();
    built[4] = [x0, y0, x1, from];
    built.push([x0, to, x1, y1]);
    let slam = scanned(&built, &PLACES, map_from_slam(), 0.05, 0.0);
    for storey in [Storey::of(&flat()), with_leafs(4)] {
        let found = compared(storey, &slam, map_from_slam(), |_| {});
        let part = *found.absent_parts.iter().find(|p| p.element == 4).unwrap();
        assert_eq!(part.verdict, DeviationVerdict::Late);
        assert!((part.from_m - 1.0).abs() < 0.12 && (part.to_m - 2.2).abs() < 0.12, "{part:?}");
        assert!((part.ends_m[0][1] - from).abs() < 0.12 && (part.ends_m[1][1] - to).abs() < 0.12, "{part:?}");
        assert!(found.absent_parts.iter().all(|p| [4, 11, 12].contains(&p.element)), "{:?}", found.absent_parts);
    }
}

#[test]
fn a_wall_that_was_not_built_is_absent_and_late() {
    for element in [4, 6, 9] {
        let mut built = flat();
        built.remove(element);
        let found = as_built(&built);
        assert_eq!(
            found.observation(element),
            (Observation::Absent, DeviationVerdict::Late),
            "{:?}",
            found.of(element)
        );
        assert!(found.of(element).n_contradicted > 10 && found.of(element).offset_m == 0.0);
        assert_all_on_plan(&found, &[element]);
        assert!(found.obstacles.is_empty());
    }
}

#[test]
fn a_wall_that_was_built_elsewhere_is_displaced_by_as_much_and_is_no_obstacle() {
    for (element, by) in [(4, [0.3, 0.0]), (4, [-0.2, 0.0]), (6, [0.0, 0.2]), (6, [0.0, -0.3]), (9, [0.0, 0.0])] {
        let by = if element == 9 { [0.25, 0.0] } else { by };
        let mut built = flat();
        built[element] = [0, 1, 2, 3].map(|k| built[element][k] + by[k % 2]);
        let found = as_built(&built);
        let record = found.of(element);
        assert_eq!(
            found.observation(element),
            (Observation::Displaced, DeviationVerdict::Displaced),
            "{by:?}: {record:?}"
        );
        let off = [0, 1].map(|k| record.displacement_m[k] - by[k]);
        assert!(off[0].hypot(off[1]) < 0.04, "{by:?}: {record:?}");
        assert_all_on_plan(&found, &[element]);
        assert!(found.obstacles.is_empty(), "{by:?}: {:?}", found.obstacles);
    }
}

#[test]
fn a_wall_that_nobody_planned_is_an_obstacle_with_its_place() {
    let mut built = flat();
    built.push([6.0, 6.4, 6.1, 7.9]);
    let found = as_built(&built);
    assert_all_on_plan(&found, &[]);
    let [obstacle] = found.obstacles[..] else { panic!("{:?}", found.obstacles) };
    let [x, y] = obstacle.centroid_m;
    assert!((x - 6.05).abs() < 0.1 && (y - 7.15).abs() < 0.15, "{obstacle:?}");
    assert!((1.4..1.9).contains(&obstacle.length_m) && (0.05..0.3).contains(&obstacle.area_m2), "{obstacle:?}");
}

#[test]
fn what_nobody_looked_at_is_unseen_and_never_absent() {
    let mut built = flat();
    built.retain(|w| *w != flat()[9]);
    // Only the left rooms are visited, and the wall that is missing lies right.
    let slam = scanned(&built, &PLACES[..2], map_from_slam(), 0.05, 0.0);
    let found = compared(Storey::of(&flat()), &slam, map_from_slam(), |_| {});
    assert_eq!(found.observation(9), (Observation::Unseen, DeviationVerdict::Unknown));
    assert_eq!((found.reason(9), found.of(9).n_visible), ("not_seen", 0));
    assert_eq!(found.observation(10), ON_PLAN);
}

#[test]
fn glass_and_what_the_lidar_passes_over_is_unseen_whether_it_is_there_or_not() {
    let mut storey = Storey::of(&flat());
    let glass = storey.add(Class::Wall, [5.0, 6.6, 7.0, 6.65], [0.0, 2.5]);
    storey.builder.elements[glass].flags = element_flags::GLASS;
    let shelf = storey.add(Class::Furniture, [5.0, 1.0, 6.0, 1.4], [0.8, 1.0]);
    let slam = scanned(&flat(), &PLACES, map_from_slam(), 0.05, 0.0);
    let found = compared(storey, &slam, map_from_slam(), |_| {});
    assert_eq!((found.observation(glass).0, found.reason(glass)), (Observation::Unseen, "glass"));
    assert_eq!((found.observation(shelf).0, found.reason(shelf)), (Observation::Unseen, "no_section"));
    assert_all_on_plan(&found, &[]);
}

#[test]
fn a_door_is_observed_while_it_is_closed_and_unseen_while_it_is_open() {
    let door = [0.2 + 1.8, 6.4, 4.0, 6.55];
    let door = [door[0], door[1], door[0] + 0.9, door[3]];
    let storey = || {
        let mut storey = Storey::of(&flat());
        storey.door(door);
        storey
    };
    let mut closed = flat();
    closed.push(door);
    let found = compared(storey(), &scanned(&closed, &PLACES, map_from_slam(), 0.05, 0.0), map_from_slam(), |_| {});
    assert_eq!(found.observation(11), ON_PLAN, "{:?}", found.of(11));
    // Its leaf stands out into the room.
    let mut open = flat();
    open.push([2.0, 5.5, 2.05, 6.4]);
    let found = compared(storey(), &scanned(&open, &PLACES, map_from_slam(), 0.05, 0.0), map_from_slam(), |_| {});
    assert_eq!((found.observation(11).0, found.reason(11)), (Observation::Unseen, "door"));
    assert!(found.obstacles.is_empty(), "a leaf is no obstacle: {:?}", found.obstacles);
}

#[test]
fn furniture_before_a_wall_hides_it_and_is_an_obstacle() {
    let mut built = flat();
    built.push([9.6, 8.3, 10.8, 8.8]);
    built.push([11.4, 6.0, 11.8, 6.8]);
    let found = as_built(&built);
    assert_all_on_plan(&found, &[]);
    assert_eq!(found.obstacles.len(), 2, "{:?}", found.obstacles);
    // Furniture that hides all of it: the short wall is not seen, and nobody calls it absent.
    let mut built = flat();
    built[9] = [10.0, 5.2, 11.8, 5.35];
    built.push([9.9, 5.6, 11.8, 6.0]);
    let slam = scanned(&built, &[[9.5, 7.0], [10.5, 7.5]], map_from_slam(), 0.05, 0.0);
    let found = compared(Storey::of(&flat()), &slam, map_from_slam(), |_| {});
    assert_ne!(found.observation(9).0, Observation::Absent);
    assert_ne!(found.observation(9).0, Observation::Observed);
}

#[test]
fn the_plan_decides_what_an_observation_means() {
    let mut built = flat();
    built.remove(4);
    let slam = scanned(&built, &PLACES, map_from_slam(), 0.05, 0.0);
    let judged = |element: usize, state: ElementState| {
        let plan =
            |schedule_state: &mut ScheduleStateBuilder| schedule_state.set_element(element, state, ElementState::Built);
        compared(Storey::of(&flat()), &slam, map_from_slam(), plan).observation(element)
    };
    assert_eq!(judged(6, ElementState::NotStarted), (Observation::Observed, DeviationVerdict::Early));
    assert_eq!(judged(6, ElementState::Removed), (Observation::Observed, DeviationVerdict::Late));
    assert_eq!(judged(6, ElementState::InProgress), ON_PLAN);
    assert_eq!(judged(4, ElementState::NotStarted), (Observation::Absent, DeviationVerdict::OnPlan));
    assert_eq!(judged(4, ElementState::Built), (Observation::Absent, DeviationVerdict::Late));
}

#[test]
fn what_stands_in_the_place_of_something_that_is_not_there_yet_does_not_make_it_early() {
    let mut storey = Storey::of(&flat());
    // A lining in front of a wall that stands, and a wall that will replace another.
    let lining = storey.add(Class::Wall, [4.15, 5.35, 9.0, 5.4], [0.0, 2.5]);
    let next = storey.add(Class::Wall, [4.0, 0.2, 4.15, 3.6], [0.0, 2.5]);
    let slam = scanned(&flat(), &PLACES, map_from_slam(), 0.05, 0.0);
    let found = compared(storey, &slam, map_from_slam(), |schedule_state| {
        schedule_state.set_element(lining, ElementState::NotStarted, ElementState::NotStarted);
        schedule_state.set_element(next, ElementState::NotStarted, ElementState::NotStarted);
    });
    assert_eq!(found.observation(lining).1, DeviationVerdict::Unknown, "{:?}", found.of(lining));
    assert_eq!(found.observation(next).1, DeviationVerdict::Unknown, "{:?}", found.of(next));
    assert_all_on_plan(&found, &[]);
}

#[test]
fn a_layer_on_a_wall_is_neither_observed_nor_absent_whether_it_is_there_or_not() {
    let mut storey = Storey::of(&flat());
    let lining = storey.add(Class::Wall, [4.15, 5.35, 9.0, 5.4], [0.0, 2.5]);
    let slam = scanned(&flat(), &PLACES, map_from_slam(), 0.05, 0.0);
    let found = compared(storey, &slam, map_from_slam(), |_| {});
    assert_eq!(found.observation(lining), (Observation::Unseen, DeviationVerdict::Unknown), "{:?}", found.of(lining));
}

#[test]
fn a_bent_map_displaces_nothing_and_its_bend_is_told() {
    // Up to 0.2 m off in the right half of the flat.
    let believed = |[x, y]: [f64; 2]| [x + 0.2 * (x / 12.0).powi(2), y + 0.12 * libm::sin(x / 9.0)];
    let slam = scanned_bent(&flat(), &PLACES, map_from_slam(), 0.05, 0.0, &believed);
    let found = compared(Storey::of(&flat()), &slam, map_from_slam(), |_| {});
    for element in 0..flat().len() {
        assert_eq!(found.observation(element), ON_PLAN, "{:?}", found.of(element));
    }
    assert!(found.residual_rms_m > 0.03, "{}", found.residual_rms_m);
    assert!(as_built(&flat()).residual_rms_m < 0.03);
}

#[test]
fn the_same_input_gives_the_same_bytes() {
    let slam = scanned(&flat(), &PLACES, map_from_slam(), 0.08, 0.7);
    let first = compared(Storey::of(&flat()), &slam, map_from_slam(), |_| {});
    let again = compared(Storey::of(&flat()), &slam, map_from_slam(), |_| {});
    assert_eq!(first.elements, again.elements);
    assert_eq!(first.obstacles, again.obstacles);
    assert_all_on_plan(&first, &[]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(10))]

    #[test]
    fn an_element_near_which_nothing_is_known_is_unseen(
        element in 0usize..11,
        removed in 0usize..11,
        yaw_rad in -3.1..3.1f64,
        resolution_m in prop::sample::select(vec![0.03, 0.05, 0.1]),
    ) {
        let pose = Rigid2::new([3.0, -7.0], yaw_rad);
        let mut built = flat();
        built.remove(removed);
        let mut slam = scanned(&built, &PLACES, pose, resolution_m, 0.0);
        let [x0, y0, x1, y1] = flat()[element];
        for k in 0..slam.cells.len() {
            let corner = [k % slam.width, k / slam.width].map(|c| (c as f64 + 0.5) * resolution_m);
            let at = pose.apply([slam.origin[0] + corner[0], slam.origin[1] + corner[1]]);
            if x0 - 1.0 < at[0] && at[0] < x1 + 1.0 && y0 - 1.0 < at[1] && at[1] < y1 + 1.0 {
                slam.cells[k] = occupancy::Cell::Unknown;
            }
        }
        let found = compared(Storey::of(&flat()), &slam, pose, |_| {});
        prop_assert_eq!(found.observation(element), (Observation::Unseen, DeviationVerdict::Unknown));
        prop_assert_eq!(found.of(element).n_visible, 0);
    }
}
