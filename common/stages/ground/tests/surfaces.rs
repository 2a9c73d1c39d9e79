//! Surfaces and connections of small sites: stairs, ramps, screeds, dates.

#[path = "support/small_site.rs"]
mod small_site;

use messages::*;
use small_site::{Body, block, field, ground_of, site};

/// Class and area of each surface, largest first.
fn surfaces(ground: &Ground<'_>) -> Vec<(GroundClass, f64)> {
    ground.surfaces.iter().map(|s| (s.class.get(), (s.area_m2 * 1e4).round() / 1e4)).collect()
}

fn connections(ground: &Ground<'_>) -> Vec<([u32; 2], GroundConnection, i32)> {
    ground.connections.iter().map(|c| (c.surfaces, c.kind.get(), c.step_tenths)).collect()
}

#[test]
fn a_screed_on_a_slab_is_the_ground_once_it_is_built_however_thick_it_is() {
    let slab = (GroundClass::Floor, block([0, 0, 100_000, 100_000], -2_000, [0; 4]));
    for thick in [150, 700] {
        let screed = (GroundClass::Floor, block([0, 0, 60_000, 100_000], 0, [thick; 4]));
        let site = site(&[slab.clone(), screed], false);
        let before = ground_of(&site, |k| k == 0);
        assert_eq!(surfaces(&Ground::open(before.bytes()).unwrap()), [(GroundClass::Floor, 100.0)]);
        let after = ground_of(&site, |_| true);
        let after = Ground::open(after.bytes()).unwrap();
        assert_eq!(surfaces(&after), [(GroundClass::Floor, 60.0), (GroundClass::Floor, 40.0)]);
        assert_eq!(connections(&after), [([0, 1], GroundConnection::Step, -thick)]);
        assert!((f64::from(after.connections[0].length_m) - 10.0).abs() < 0.2);
    }
}

#[test]
fn a_stair_joins_two_floors_tread_by_tread() {
    let mut bodies = vec![
        (GroundClass::Floor, block([0, 0, 100_000, 100_000], -2_000, [0; 4])),
        (GroundClass::Floor, block([0, 128_000, 100_000, 200_000], 6_000, [8_750; 4])),
    ];
    let step = |k: i32| -> Body {
        let y = 100_000 + k * 7_000;
        block([20_000, y, 32_000, y + 7_200], 0, [1_750 * (k + 1); 4])
    };
    bodies.extend((0..4).map(|k| (GroundClass::StairTread, step(k))));
    let ground = ground_of(&site(&bodies, false), |_| true);
    let ground = Ground::open(ground.bytes()).unwrap();
    assert_eq!(ground.surfaces.len(), 6);
    let stairs: Vec<_> = connections(&ground);
    assert_eq!(stairs.len(), 5, "{stairs:?}");
    assert!(stairs.iter().all(|(_, kind, step)| *kind == GroundConnection::Stair && step.abs() == 1_750), "{stairs:?}");
}

#[test]
fn a_ramp_joins_at_its_ends_by_shared_edges_and_its_sides_are_steps() {
    let bodies = [
        (GroundClass::Floor, block([0, 0, 100_000, 100_000], -3_000, [0; 4])),
        (GroundClass::Floor, block([140_000, 0, 200_000, 100_000], -3_000, [4_000; 4])),
        (GroundClass::Ramp, block([100_000, 20_000, 140_000, 34_000], -3_000, [0, 4_000, 4_000, 0])),
        (GroundClass::Landing, block([100_000, 50_000, 140_000, 65_000], -3_000, [0; 4])),
    ];
    let ground = ground_of(&site(&bodies, false), |_| true);
    let ground = Ground::open(ground.bytes()).unwrap();
    let classes: Vec<GroundClass> = ground.surfaces.iter().map(|s| s.class.get()).collect();
    assert_eq!(classes, [GroundClass::Floor, GroundClass::Floor, GroundClass::Landing, GroundClass::Ramp]);
    let found = connections(&ground);
    assert!(
        found.contains(&([0, 3], GroundConnection::Ramp, 0)) && found.contains(&([1, 3], GroundConnection::Ramp, 0))
    );
    assert!(found.contains(&([0, 2], GroundConnection::SharedEdge, 0)), "{found:?}");
    let slope = ground.faces_of(&ground.surfaces[3])[0].slope_rad;
    assert!((f64::from(slope) - libm::atan(0.1)).abs() < 1e-4);
}

#[test]
fn the_shape_of_the_site_is_always_there_and_an_element_of_terrain_once_it_is_built() {
    let heights: Vec<i32> = (0..16).map(|k| (k % 4) * 2_000).collect();
    let bodies = [(GroundClass::Terrain, field(4, 50_000, &heights))];
    for (is_site, is_built, area) in [(true, false, 225.0), (false, false, 0.0), (false, true, 225.0)] {
        let ground = ground_of(&site(&bodies, is_site), |_| is_built);
        let ground = Ground::open(ground.bytes()).unwrap();
        let sum: f64 = surfaces(&ground).iter().map(|s| s.1).sum();
        assert_eq!((sum, ground.bodies.len()), (area, 1), "{is_site} {is_built}");
        assert!(ground.faces.iter().all(|f| f.class == GroundClass::Terrain));
    }
}

#[test]
fn rims_of_stairs_steep_faces_and_bodies_without_class_are_no_ground() {
    let bodies = [
        (GroundClass::StairTread, block([0, 0, 100, 15_000], 0, [1_000; 4])),
        (GroundClass::Floor, block([0, 50_000, 10_000, 60_000], 0, [1_000, 12_000, 12_000, 1_000])),
        (GroundClass::None, block([0, 100_000, 10_000, 110_000], 0, [1_000; 4])),
    ];
    let ground = ground_of(&site(&bodies, false), |_| true);
    let ground = Ground::open(ground.bytes()).unwrap();
    assert!(ground.faces.is_empty() && ground.surfaces.is_empty() && ground.connections.is_empty());
    assert!(ground_of(&site(&[], false), |_| true).bytes().len() >= 64);
}

#[test]
fn a_state_of_another_site_is_refused() {
    let [one, other] =
        [0, 500].map(|z| site(&[(GroundClass::Floor, block([0, 0, 9_000, 9_000], -900, [z; 4]))], false));
    let (one, other) = (Site::open(one.bytes()).unwrap(), Site::open(other.bytes()).unwrap());
    let state = small_site::state(&other, |_| true);
    let mut out = GroundWriter::default();
    assert!(ground::ground(&one, &ScheduleState::open(state.bytes()).unwrap(), &mut out).is_err());
}
