//! Scans: coverage, field of view, ranges, subsets, changed elements.

mod support;

use frames::{Map, Point2};
use messages::{Grid, ScanSensor, WaypointKind};
use std::f64::consts::{FRAC_PI_2, PI};
use support::brute_force::{self, Side, sides};
use support::{House, Planned, quick};
use waypoints::MissionPlanOptions;

const FLAT: &str = "
##############################
#aaaaaaaaaaaaaa#bbbbbbbbbbbbb#
#aaaaaaaaaaaaaa#bbbbbbbbbbbbb#
#aaaaaaaaaaaaaa#bbbbbbbbbbbbb#
#aaaaaFFaaaaaaaDbbbbbbbbbbbbb#
#aaaaaFFaaaaaaaDbbbbbbbbbbbbb#
#aaaaaaaaaaaaaaDbbbbbb1bbbbbb#
#aaaaaaaaaaaaaaDbbbbbb1bbbbbb#
#aaaaaaaaaaaaaaDbbbbbb1bbbbbb#
#aaaaaaaaaaaaaa#bbbbbb1bbbbbb#
#########DDDDD##bbbbbb1bbbbbb#
#ccccccccccccc##bbbbbb1bbbbbb#
#ccccccccccccc##bbbbbbbbbbbbb#
#ccccccccccccc##bbbbbbbbbbbbb#
#cccccFcccccccDDbbbbbbbbbbbbb#
#ccccccccccccc##bbbbbbbbbbbbb#
#ccccccccccccc################
#ccccccccccccc#
###############";

fn flat() -> House {
    House::drawn(&[FLAT])
}

/// Sides that some scan sees, step by step along the line.
fn seen<'s>(planned: &Planned, grid: &Grid<'_>, sides: &'s [Side]) -> Vec<&'s Side> {
    let mission_plan = planned.mission_plan();
    let scans = planned.scans();
    sides
        .iter()
        .filter(|side| scans.iter().any(|w| brute_force::sees(grid, &mission_plan.head.sensor, w, side)))
        .collect()
}

/// The mission plan's numbers against those of the slow version, within a hundredth.
fn assert_coverage(planned: &Planned) {
    let grid = planned.archives.grid(0);
    let sides = sides(&grid);
    let storey = planned.mission_plan().storeys[0];
    assert_eq!(storey.n_targets as usize, sides.len());
    let n_seen = seen(planned, &grid, &sides).len();
    let off = (n_seen as f64 - f64::from(storey.n_seen)).abs();
    assert!(off <= 0.01 * f64::from(storey.n_seen), "{n_seen} are seen, the mission plan says {}", storey.n_seen);
    assert!(storey.n_seen <= storey.n_faces && storey.n_faces <= storey.n_targets, "{storey:?}");
    for scan in planned.scans() {
        let n =
            sides.iter().filter(|s| brute_force::sees(&grid, &planned.mission_plan().head.sensor, &scan, s)).count();
        let off = (n as f64 - f64::from(scan.n_faces)).abs();
        assert!(off <= 0.02 * f64::from(scan.n_faces) + 2.0, "{n} are seen, the scan says {}", scan.n_faces);
    }
}

#[test]
fn coverage_is_what_rays_say_step_by_step() {
    assert_coverage(&flat().planned(&quick()));
    let narrow = ScanSensor { field_of_view_rad: 1.6, ..ScanSensor::DEFAULT };
    assert_coverage(&flat().planned(&MissionPlanOptions { sensor: narrow, ..quick() }));
    let short = ScanSensor { range_m: 2.5, min_range_m: 0.6, max_incidence_rad: 0.9, ..ScanSensor::DEFAULT };
    assert_coverage(&flat().planned(&MissionPlanOptions { sensor: short, ..quick() }));
}

#[test]
fn scans_reach_the_goal_for_the_storey_and_for_each_space() {
    let planned = flat().planned(&MissionPlanOptions { coverage: 0.95, space_coverage: 0.9, ..quick() });
    let storey = planned.mission_plan().storeys[0];
    assert!(f64::from(storey.n_seen) >= 0.95 * f64::from(storey.n_faces), "{storey:?}");
    for space in planned.mission_plan().spaces {
        assert!(f64::from(space.n_seen) >= 0.9 * f64::from(space.n_faces), "{space:?}");
    }
}

#[test]
fn what_can_be_seen_from_anywhere_is_nearly_what_the_tried_places_see() {
    let planned = flat().planned(&quick());
    let grid = planned.archives.grid(0);
    let spec = grid.spec();
    let standing = brute_force::standing(&grid, 0.3);
    let reached = brute_force::first_part(&grid, &standing);
    let (sides, scans) = (sides(&grid), planned.scans());
    let sensor = planned.mission_plan().head.sensor;
    // Every second cell in both directions: a place between them sees little else.
    let cells =
        (0..spec.n_cells()).filter(|&c| reached[c] && spec.cell_of(c).column % 2 + spec.cell_of(c).row % 2 == 0);
    let places: Vec<_> = cells
        .map(|c| {
            let at = spec.centre_of(spec.cell_of(c));
            messages::WaypointRecord { position_in_map_m: [at.x_m(), at.y_m(), 0.0], ..scans[0] }
        })
        .collect();
    let n = sides.iter().filter(|s| places.iter().any(|p| brute_force::sees(&grid, &sensor, p, s))).count();
    let n_faces = planned.mission_plan().storeys[0].n_faces;
    assert!(f64::from(n_faces) >= 0.99 * n as f64, "{n_faces} from tried places, {n} from all");
}

#[test]
fn a_sensor_with_a_limited_field_of_view_looks_in_several_directions() {
    let sensor = ScanSensor { field_of_view_rad: FRAC_PI_2, ..ScanSensor::DEFAULT };
    let (around, narrow) = (flat().planned(&quick()), flat().planned(&MissionPlanOptions { sensor, ..quick() }));
    assert!(narrow.scans().len() > around.scans().len());
    let mut yaws: Vec<i64> = narrow.scans().iter().map(|w| (w.yaw_rad * 1e6).round() as i64).collect();
    assert!(narrow.scans().iter().all(|w| -PI <= w.yaw_rad && w.yaw_rad <= PI));
    yaws.sort_unstable();
    yaws.dedup();
    assert!(yaws.len() >= 3, "{yaws:?}");
    let storey = narrow.mission_plan().storeys[0];
    assert!(f64::from(storey.n_seen) >= 0.99 * f64::from(storey.n_faces), "{storey:?}");
}

#[test]
fn what_is_nearer_than_the_sensor_measures_needs_another_place() {
    // A closet: from its middle every wall is nearer than a metre and a half.
    let closet = "
############
#aaaaaaaaaa#
#aaaaaaaaaa#
#aaaaaaaaaa#
#aaaaaaaaaa#
#aaaaaaaaaa#
#aaaaaaaaaa#
#aaaaaaaaaa#
#aaaaaaaaaa#
############";
    let scans = |min_range_m: f64| {
        let sensor = ScanSensor { min_range_m, ..ScanSensor::DEFAULT };
        let planned = House::drawn(&[closet]).planned(&MissionPlanOptions { sensor, ..quick() });
        assert_coverage(&planned);
        planned.scans().len()
    };
    assert_eq!(scans(0.1), 1);
    assert!(scans(1.0) > 1);
}

#[test]
fn only_faces_of_what_was_finished_since_are_targets() {
    let mut house = flat();
    house.finished.insert('1', 500_000);
    let since = |s: i64| house.planned(&MissionPlanOptions { changed_since_s: Some(s), ..quick() });
    let (all, changed, nothing) = (house.planned(&quick()), since(499_999), since(500_000));
    assert_eq!(
        (nothing.mission_plan().storeys[0].n_targets, nothing.scans().len()),
        (0, 0),
        "what was finished then is not new"
    );
    assert_eq!(nothing.mission_plan().head.changed_since_s, 500_000);

    let grid = all.archives.grid(0);
    let site = all.archives.site();
    let wall = site.elements.iter().find(|e| site.text(e.global_id) == "1-0").unwrap();
    let spec = grid.spec();
    let is_of_wall = |side: &&Side| {
        let at = spec.centre_of(spec.cell_of(side.cell));
        let inside =
            |k: usize, m: f64| frames::metres(wall.min_tenths[k]) < m && m < frames::metres(wall.max_tenths[k]);
        inside(0, at.x_m()) && inside(1, at.y_m())
    };
    let n_of_wall = sides(&grid).iter().filter(is_of_wall).count();
    assert_eq!(changed.mission_plan().storeys[0].n_targets as usize, n_of_wall);
    assert!(changed.mission_plan().storeys[0].n_seen as usize * 100 >= 99 * n_of_wall, "both of its sides");
    assert!(changed.scans().len() < all.scans().len());
    assert_eq!(changed.of_kind(WaypointKind::Centre).len(), 3, "centres are planned as ever");

    house.absent.insert('1');
    let gone = house.planned(&MissionPlanOptions { changed_since_s: Some(0), ..quick() });
    assert_eq!(gone.mission_plan().storeys[0].n_targets, 0, "what does not stand is nothing new");
}

#[test]
fn only_selected_spaces_are_planned() {
    for wanted in ["c", "space-c", "?pace-[c]", "space-*c"] {
        let planned = flat().planned(&MissionPlanOptions { spaces: vec![wanted.to_owned()], ..quick() });
        if wanted == "?pace-[c]" {
            assert!(planned.mission_plan().waypoints.is_empty(), "brackets are no pattern");
            continue;
        }
        assert!(planned.mission_plan().waypoints.iter().all(|w| planned.name_of(w) == Some('c')), "{wanted}");
        assert!(planned.centre('c').is_some() && !planned.scans().is_empty());
        // Faces that look into other rooms are no targets.
        let grid = planned.archives.grid(0);
        let c = planned.archives.names.iter().position(|n| *n == 'c').unwrap() as u16 + 1;
        let n_of_c = sides(&grid).iter().filter(|s| grid.space[s.front] == c).count();
        assert_eq!(planned.mission_plan().storeys[0].n_targets as usize, n_of_c);
    }
}

#[test]
fn no_scan_is_made_in_a_space_outdoors_or_blocked() {
    let (mut outdoors, mut blocked, mut closing) = (flat(), flat(), flat());
    outdoors.spaces.insert('b', |s| s.flags = messages::space_flags::EXTERNAL);
    blocked.blocked.insert('b', "task:screed");
    closing.closing.insert('b', 2_000_000);
    for house in [outdoors, blocked, closing] {
        let planned = house.planned(&quick());
        assert!(!planned.scans().is_empty());
        let grid = planned.archives.grid(0);
        let b = planned.archives.names.iter().position(|n| *n == 'b').unwrap() as u16 + 1;
        for scan in planned.scans() {
            let [x, y, _] = scan.position_in_map_m;
            let cell = grid.spec().index(grid.spec().cell_at(Point2::<Map>::new(x, y)).unwrap());
            assert_ne!(grid.space[cell], b);
        }
    }
}

#[test]
fn only_the_classes_that_were_asked_for_are_targets() {
    let furniture = 1 << grid::Class::Furniture.id();
    let planned = flat().planned(&MissionPlanOptions { classes: furniture, ..quick() });
    let grid = planned.archives.grid(0);
    let n = sides(&grid).iter().filter(|s| grid.class[s.cell] == grid::Class::Furniture.id()).count();
    assert_eq!(planned.mission_plan().storeys[0].n_targets as usize, n);
}

#[test]
fn what_flies_is_at_half_the_height_of_its_space() {
    let upper = FLAT.replace('a', "d").replace('b', "e").replace('c', "f");
    let house = House::drawn(&[FLAT, &upper]);
    let (flies, drives) = (house.planned(&MissionPlanOptions { flies: true, ..quick() }), house.planned(&quick()));
    for waypoint in flies.mission_plan().waypoints.iter().filter(|w| w.space != messages::NONE) {
        let floor_m = f64::from(waypoint.map_storey) * 3.0;
        assert_eq!((waypoint.position_in_map_m[2], waypoint.sensor_in_map_m[2]), (floor_m, floor_m + 1.25));
    }
    for waypoint in drives.mission_plan().waypoints {
        assert_eq!(waypoint.sensor_in_map_m[2], f64::from(waypoint.map_storey) * 3.0 + 1.2);
    }
}

#[test]
fn waypoints_on_a_slope_stand_along_its_normal_and_those_on_level_ground_upright() {
    let level = flat().planned(&quick());
    assert!(level.mission_plan().waypoints.iter().all(|w| !w.attitude().is_tilted()));
    // It rises by 8 % to the east, and by 6 % to the north.
    let mut house = flat();
    house.relief = Some(|[x, y]| 0.08 * x + 0.06 * y);
    let planned = house.planned(&quick());
    assert_eq!(planned.mission_plan().waypoints.len(), level.mission_plan().waypoints.len());
    let up = [-0.08, -0.06, 1.0].map(|c| c / libm::sqrt(1.01));
    for w in planned.mission_plan().waypoints {
        assert!((0..3).all(|k| (w.up_in_map[k] - up[k]).abs() < 1e-4), "{w:?}");
        let [x, y, z] = w.position_in_map_m;
        assert!((z - 0.08 * x - 0.06 * y).abs() < 0.01, "{w:?}");
        assert!((0..3).all(|k| (w.sensor_in_map_m[k] - w.position_in_map_m[k] - 1.2 * up[k]).abs() < 1e-3), "{w:?}");
    }
    let flies = house.planned(&MissionPlanOptions { flies: true, ..quick() });
    assert!(flies.mission_plan().waypoints.iter().all(|w| !w.attitude().is_tilted()));
}

#[test]
fn a_sensor_that_is_tilted_sees_other_parts_of_meshes() {
    // Rays in the plane of the robot alone: on level ground they meet walls at one height.
    let sensor = ScanSensor { min_elevation_rad: -0.02, max_elevation_rad: 0.02, ..ScanSensor::DEFAULT };
    let options = MissionPlanOptions { mesh_check: true, sensor, ..quick() };
    let mut house = flat();
    let on_level = house.planned(&options).mission_plan().storeys[0].n_mesh_points;
    house.relief = Some(|[x, _]| 0.2 * (x - 3.0));
    let on_slope = house.planned(&options).mission_plan().storeys[0].n_mesh_points;
    assert!(on_level > 0 && on_slope > 2 * on_level, "{on_level} points, {on_slope} on a slope");
}

#[test]
fn centres_and_scans_can_be_planned_alone() {
    let centres = flat().planned(&MissionPlanOptions { kinds: [WaypointKind::Centre].into(), ..quick() });
    assert_eq!((centres.scans().len(), centres.of_kind(WaypointKind::Centre).len()), (0, 3));
    let scans = flat().planned(&MissionPlanOptions { kinds: [WaypointKind::Scan].into(), ..quick() });
    assert_eq!(scans.of_kind(WaypointKind::Centre).len(), 0);
    assert!(!scans.scans().is_empty() && scans.mission_plan().spaces.iter().all(|s| s.centre == messages::NONE));
}

#[test]
fn each_scan_registers_with_those_before_it_in_the_order_of_registration() {
    let planned = flat().planned(&MissionPlanOptions { overlap: 0.2, ..quick() });
    assert!(planned.codes().is_empty(), "{:?}", planned.codes());
    let mut scans = planned.scans();
    scans.sort_by_key(|scan| scan.registration_order);
    assert!(scans.iter().map(|scan| scan.registration_order as usize).eq(0..scans.len()));
    assert!(scans.len() > 1 && scans[1..].iter().all(|s| s.registration_overlap >= 0.2), "{scans:?}");
    assert_eq!(scans[0].registration_overlap, 0.0);
}

#[test]
fn joining_scans_name_a_scan_that_does_not_register_without_them() {
    // Much must have been seen: few scans that see all do not register by themselves.
    let planned = flat().planned(&MissionPlanOptions { overlap: 0.6, ..quick() });
    let waypoints = planned.mission_plan().waypoints;
    let joining: Vec<_> =
        waypoints.iter().filter(|w| w.purpose().scan().is_some_and(|scan| scan.joins.is_some())).collect();
    assert!(!joining.is_empty());
    assert_eq!(planned.mission_plan().storeys[0].n_connecting as usize, joining.len());
    for join in joining {
        let joined = waypoints[join.joins as usize];
        assert!(joined.kind == WaypointKind::Scan && joined.id != join.id);
        assert!(join.overlap_without < 0.6 && joined.registration_overlap >= 0.6, "{join:?} {joined:?}");
    }
}

#[test]
fn no_two_scans_are_nearer_than_the_separation() {
    for separation_m in [0.5, 1.2] {
        let scans = flat().planned(&MissionPlanOptions { coverage: 1.0, separation_m, ..quick() }).scans();
        let places: Vec<Point2<Map>> =
            scans.iter().map(|w| Point2::new(w.position_in_map_m[0], w.position_in_map_m[1])).collect();
        for (k, a) in places.iter().enumerate() {
            assert!(places[..k].iter().all(|b| a.distance_m(b) > separation_m - 1e-6), "{a:?}");
        }
    }
}

#[test]
fn a_room_that_needs_two_scans_side_by_side_has_them() {
    // From nowhere are all walls farther away than the sensor measures at least.
    let closet = "
#######
#aaaaa#
#aaaaa#
#aaaaa#
#aaaaa#
#######";
    let sensor = ScanSensor { min_range_m: 0.45, ..ScanSensor::DEFAULT };
    let options = MissionPlanOptions { sensor, space_coverage: 1.0, coverage: 1.0, separation_m: 5.0, ..quick() };
    let planned = House::drawn(&[closet]).planned(&options);
    let storey = planned.mission_plan().storeys[0];
    assert!(planned.scans().len() > 1 && storey.n_seen == storey.n_faces, "{storey:?}");
}

#[test]
fn furniture_is_scanned_only_where_its_class_is_asked_for() {
    let targets = |classes: u32| {
        let planned = flat().planned(&MissionPlanOptions { classes, ..quick() });
        planned.mission_plan().storeys[0].n_targets as usize
    };
    let planned = flat().planned(&quick());
    let grid = planned.archives.grid(0);
    let furniture = sides(&grid).iter().filter(|s| grid.class[s.cell] == grid::Class::Furniture.id()).count();
    assert!(furniture > 0);
    assert_eq!(targets(MissionPlanOptions::default().classes) + furniture, targets(!0));
}

#[test]
fn a_storey_without_the_classes_that_are_asked_for_is_noticed() {
    let ramp = 1 << grid::Class::Ramp.id();
    let planned = flat().planned(&MissionPlanOptions { classes: ramp, ..quick() });
    assert_eq!((planned.scans().len(), planned.codes()), (0, vec!["no_target_faces".to_owned()]));
}

#[test]
fn a_scan_that_adds_less_than_it_is_worth_is_not_made() {
    let with = |min_gain_m: f64| flat().planned(&MissionPlanOptions { coverage: 1.0, min_gain_m, ..quick() });
    let (all, worth) = (with(0.0), with(1.0));
    assert!(worth.scans().len() < all.scans().len());
    let [all, worth] = [all, worth].map(|planned| planned.mission_plan().storeys[0]);
    assert!(all.n_seen == all.n_faces && worth.n_seen < all.n_seen);
    assert!(f64::from(worth.n_seen) > 0.9 * f64::from(all.n_seen), "{worth:?}");
}

/// Shares that the first scans of the growth see of a plan.
fn curve(planned: &Planned) -> Vec<f64> {
    let plan = planned.mission_plan();
    let n_faces: u32 = plan.storeys.iter().map(|storey| storey.n_faces).sum();
    let sum = |n_seen: &mut u32, n_new: u32| {
        *n_seen += n_new;
        Some(*n_seen)
    };
    let seen = plan.growth.iter().map(|scan| scan.n_new).scan(0, |n_seen, n_new| sum(n_seen, n_new));
    seen.map(|n_seen| f64::from(n_seen) / f64::from(n_faces)).collect()
}

fn coverage(planned: &Planned) -> f64 {
    let storeys = planned.mission_plan().storeys;
    let sum = |of: fn(&messages::MissionPlanStoreyRecord) -> u32| f64::from(storeys.iter().map(of).sum::<u32>());
    sum(|storey| storey.n_seen) / sum(|storey| storey.n_faces)
}

fn two_storeys() -> House {
    House::drawn(&[FLAT, &FLAT.replace('a', "d").replace('b', "e").replace('c', "f")])
}

#[test]
fn the_curve_grows_to_all_that_can_be_seen() {
    let curve = curve(&two_storeys().planned(&quick()));
    assert!(curve.len() > 2 && curve.is_sorted() && curve[0] > 0.1 && curve[curve.len() - 1] == 1.0, "{curve:?}");
}

#[test]
fn a_budget_of_scans_is_used_up_and_sees_at_least_what_the_curve_says() {
    let everything = two_storeys().planned(&quick());
    let curve = curve(&everything);
    let mut before = 0.0;
    for n in 1..=curve.len() + 1 {
        let options = MissionPlanOptions { scans_max: Some(n as u32), coverage: 1.0, ..quick() };
        let planned = two_storeys().planned(&options);
        let n_scans = planned.scans().len();
        // A scan that joins another is left out without it.
        assert!(n_scans <= n && n_scans + 1 >= n.min(curve.len()), "{n_scans} of {n}");
        let now = coverage(&planned);
        assert!(n_scans == 0 || now >= curve[n_scans.min(curve.len()) - 1] - 1e-9, "{n}: {now}");
        assert!(now >= before - 0.02, "{n}: {now} after {before}");
        before = now;
    }
    assert_eq!(before, 1.0);
}

#[test]
fn a_budget_of_minutes_is_kept_and_nearly_used_up() {
    let minutes = |planned: &Planned| planned.mission_plan().head.mission_s.iter().sum::<f64>() / 60.0;
    for minutes_max in [3.0, 4.5] {
        let options = MissionPlanOptions { minutes_max: Some(minutes_max), coverage: 1.0, ..quick() };
        let planned = two_storeys().planned(&options);
        assert!(planned.codes().is_empty() && !planned.scans().is_empty());
        let taken = minutes(&planned);
        assert!(minutes_max - 2.0 < taken && taken <= minutes_max, "{taken} of {minutes_max}");
    }
    let planned = two_storeys().planned(&MissionPlanOptions { minutes_max: Some(0.1), ..quick() });
    assert_eq!((planned.scans().len(), planned.codes()), (0, vec!["budget_too_small".to_owned()]));
    assert_eq!(planned.of_kind(WaypointKind::Centre).len(), 6, "centres are planned as ever");
}

#[test]
fn scans_count_the_floor_that_none_before_them_saw() {
    let planned = flat().planned(&quick());
    let (grid, scans) = (planned.archives.grid(0), planned.scans());
    let cell_m2 = grid.spec().resolution_m().powi(2);
    let free_m2 = grid.planning.iter().filter(|p| **p == 0).count() as f64 * cell_m2;
    let covered_m2: f64 = scans.iter().map(|s| s.covers_m2).sum();
    // A line that ends on the side of a wall may count the wall's cell.
    assert!(0.97 * free_m2 <= covered_m2 && covered_m2 <= 1.005 * free_m2, "{covered_m2} of {free_m2} m2");
    assert!(scans.iter().all(|s| 0.0 <= s.overlap && s.overlap <= 1.0) && scans[0].overlap == 0.0);
    assert!(planned.of_kind(WaypointKind::Centre).iter().all(|c| c.covers_m2 == 0.0 && c.n_faces == 0));
}
