//! The ground against a slow version of it: rays from above through all faces of all bodies.

#[path = "support/small_site.rs"]
mod small_site;

use messages::*;
use proptest::prelude::*;
use small_site::{Body, block, field, ground_of, site};

/// Faces within this height cover each other, in tenths of a millimetre.
const COVER: f64 = 200.0;

/// A face above or below a place.
#[derive(Debug, Clone, Copy)]
struct Hit {
    z: f64,
    body: usize,
    looks_up: bool,
    slope_rad: f64,
}

/// All faces that an upright line meets; `None` if it passes near an edge.
fn hits(bodies: &[(GroundClass, Body)], [x, y]: [f64; 2]) -> Option<Vec<Hit>> {
    let mut found = Vec::new();
    for (body, (_, (vertices, triangles))) in bodies.iter().enumerate() {
        for t in triangles.iter().map(|t| t.map(|i| vertices[i as usize].map(f64::from))) {
            let area =
                |a: [f64; 3], b: [f64; 3], c: [f64; 3]| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
            let [a, b, c] = t;
            let whole = area(a, b, c);
            if whole == 0.0 {
                continue;
            }
            let p = [x, y, 0.0];
            let w = [area(p, b, c), area(a, p, c), area(a, b, p)].map(|w| w / whole);
            let is_near_edge = w.iter().any(|w| w.abs() < 2e-3) && w.iter().all(|w| *w > -2e-3);
            if is_near_edge {
                return None;
            }
            if w.iter().all(|w| *w > 0.0) {
                let z = w.iter().zip(&t).map(|(w, v)| w * v[2]).sum();
                let side = |k: usize| [0, 1, 2].map(|i| t[k][i] - t[0][i]);
                let (u, v) = (side(1), side(2));
                let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
                let slope_rad = libm::acos(n[2].abs() / n.iter().map(|c| c * c).sum::<f64>().sqrt());
                found.push(Hit { z, body, looks_up: whole > 0.0, slope_rad });
            }
        }
    }
    Some(found)
}

/// Heights and bodies of the ground at a place by brute force; `None` where a height is at the limit.
fn expected(bodies: &[(GroundClass, Body)], is_there: &[bool], at: [f64; 2]) -> Option<Vec<(usize, f64)>> {
    let hits = hits(bodies, at)?;
    let is_sheet = |body: usize| bodies[body].0 == GroundClass::Terrain;
    let there: Vec<Hit> = hits.into_iter().filter(|hit| is_there[hit.body]).collect();
    let carries = |hit: &&Hit| hit.looks_up || is_sheet(hit.body);
    let steepest = |hit: &Hit| if bodies[hit.body].0 == GroundClass::StairTread { 0.05 } else { ground::MAX_SLOPE_RAD };
    if there.iter().any(|hit| (hit.slope_rad - steepest(hit)).abs() < 2e-3) {
        return None;
    }
    let tops: Vec<Hit> = there.iter().filter(carries).filter(|hit| hit.slope_rad <= steepest(hit)).copied().collect();
    let bottoms: Vec<Hit> = there.iter().filter(|hit| !carries(hit)).copied().collect();
    let is_at_limit = |d: f64| (d.abs() - COVER).abs() < 4.0 || (1.0..4.0).contains(&d.abs());
    let all = || tops.iter().chain(&bottoms);
    if tops.iter().any(|a| all().any(|b| a.body != b.body && is_at_limit(b.z - a.z))) {
        return None;
    }
    let has_tops = |body: usize| tops.iter().any(|hit| hit.body == body);
    let covered = |a: &Hit| {
        tops.iter().any(|b| {
            let d = b.z - a.z;
            b.body != a.body && ((1.0..COVER).contains(&d) || d.abs() <= 1.0 && b.body > a.body)
        }) || bottoms.iter().any(|b| b.body != a.body && has_tops(b.body) && (-1.0..COVER).contains(&(b.z - a.z)))
    };
    let mut kept: Vec<(usize, f64)> = tops.iter().filter(|a| !covered(a)).map(|a| (a.body, a.z)).collect();
    kept.sort_by(|a, b| a.1.total_cmp(&b.1));
    Some(kept)
}

/// Heights and bodies of an archive at a place, by brute force.
fn found(ground: &Ground<'_>, [x, y]: [f64; 2]) -> Vec<(usize, f64)> {
    let mut all: Vec<(usize, f64)> = Vec::new();
    for face in ground.faces {
        let t = ground.corners(face).map(|v| v.map(f64::from));
        let area =
            |a: [f64; 2], b: [f64; 2], c: [f64; 2]| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        let [a, b, c] = t.map(|v| [v[0], v[1]]);
        let whole = area(a, b, c);
        assert!(whole > 0.0, "counter-clockwise from above");
        let w = [area([x, y], b, c), area(a, [x, y], c), area(a, b, [x, y])].map(|w| w / whole);
        if w.iter().all(|w| *w > 0.0) {
            let body = &ground.bodies[face.body as usize];
            let number = if body.element == NONE { body.terrain } else { body.element };
            all.push((number as usize, w.iter().zip(&t).map(|(w, v)| w * v[2]).sum()));
        }
    }
    all.sort_by(|a, b| a.1.total_cmp(&b.1));
    all
}

/// Bodies at random: slabs, screeds on them, ramps, treads, and terrain around and through all.
fn drawn() -> impl Strategy<Value = Vec<(GroundClass, Body)>> {
    let side = || (0i32..60_000, 3_000i32..40_000);
    let solid = (side(), side(), -3_000i32..4_000, 20i32..3_000, prop::array::uniform4(0i32..12_000), 0u8..5);
    let solid = solid.prop_map(|((x, dx), (y, dy), z, thick, tilt, kind)| {
        let plan = [x, y, x + dx, y + dy];
        // The other two corners follow, so that the top is a plane.
        let ramp = [0, tilt[0], tilt[0] + tilt[1], tilt[1]].map(|rise| z + thick + rise / 4);
        match kind {
            0 | 1 => (GroundClass::Floor, block(plan, z, [z + thick; 4])),
            2 => (GroundClass::StairTread, block(plan, z, ramp)),
            3 => (GroundClass::Ramp, block(plan, z, ramp)),
            _ => (GroundClass::Floor, block(plan, 0, [thick.min(180); 4])),
        }
    });
    let terrain = prop::collection::vec(-1_500i32..1_500, 36).prop_map(|heights| field(6, 20_000, &heights));
    (prop::collection::vec(solid, 1..7), prop::option::of(terrain)).prop_map(|(mut bodies, terrain)| {
        bodies.extend(terrain.map(|terrain| (GroundClass::Terrain, terrain)));
        bodies
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]
    #[test]
    fn at_every_place_there_is_what_rays_from_above_find(
        bodies in drawn(),
        built in any::<u64>(),
        places in prop::collection::vec((0i32..100_000, 0i32..100_000), 120),
    ) {
        let archive = site(&bodies, false);
        let is_there: Vec<bool> = (0..bodies.len()).map(|k| built >> k & 3 != 0).collect();
        let ground = ground_of(&archive, |k| is_there[k]);
        let again = ground_of(&archive, |k| is_there[k]);
        prop_assert_eq!(ground.bytes(), again.bytes());
        let ground = Ground::open(ground.bytes()).unwrap();
        prop_assert!(ground.check_site(&Site::open(archive.bytes()).unwrap()).is_ok());
        for (x, y) in places {
            let at = [f64::from(x) + 0.37, f64::from(y) + 0.61];
            let Some(expected) = expected(&bodies, &is_there, at) else { continue };
            let found = found(&ground, at);
            let is_same = found.len() == expected.len()
                && found.iter().zip(&expected).all(|(a, b)| a.0 == b.0 && (a.1 - b.1).abs() < 3.0);
            prop_assert!(is_same, "at {at:?}: {found:?} instead of {expected:?}");
        }
        for face in ground.faces {
            prop_assert!(f64::from(face.slope_rad) <= ground.head.max_slope_rad + 1e-6);
        }
    }
}

/// Heights of nine terraces of 4 x 4 m side by side.
fn terraces(heights: [i32; 9]) -> Vec<(GroundClass, Body)> {
    let block = |(k, z): (usize, &i32)| {
        let [x, y] = [(k % 3) as i32 * 40_000, (k / 3) as i32 * 40_000];
        (GroundClass::Floor, block([x, y, x + 40_000, y + 40_000], -50_000, [*z; 4]))
    };
    heights.iter().enumerate().map(block).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    #[test]
    fn terraces_at_one_height_are_a_surface_and_steps_between_others_are_connections(
        heights in prop::array::uniform9(prop::sample::select(vec![0, 1_000, 2_400, 2_900, 6_000])),
    ) {
        let ground = ground_of(&site(&terraces(heights), false), |_| true);
        let ground = Ground::open(ground.bytes()).unwrap();
        // The surface of each terrace, by flooding those at its height.
        let beside = |k: usize| {
            let (x, y) = (k % 3, k / 3);
            (0..9usize).filter(move |o| (o % 3).abs_diff(x) + (o / 3).abs_diff(y) == 1)
        };
        let mut part: [usize; 9] = std::array::from_fn(|k| k);
        for _ in 0..9 {
            for k in 0..9 {
                for o in beside(k).filter(|&o| heights[o] == heights[k]) {
                    part[k] = part[k].min(part[o]);
                }
            }
        }
        let surface_of = |k: usize| {
            let at = [(k % 3) as f64 * 40_000.0 + 15_000.0, (k / 3) as f64 * 40_000.0 + 11_000.0];
            let face = ground.faces.iter().find(|f| {
                let t = ground.corners(f).map(|v| v.map(f64::from));
                (0..3).all(|i| {
                    let (a, b) = (t[i], t[(i + 1) % 3]);
                    (b[0] - a[0]) * (at[1] - a[1]) - (b[1] - a[1]) * (at[0] - a[0]) > 0.0
                })
            });
            face.unwrap().surface
        };
        let surfaces: Vec<u32> = (0..9).map(surface_of).collect();
        for (a, b) in (0..9).flat_map(|a| (0..9).map(move |b| (a, b))) {
            prop_assert_eq!(part[a] == part[b], surfaces[a] == surfaces[b]);
        }
        for (a, b) in (0..9).flat_map(|a| (0..9).map(move |b| (a, b))).filter(|(a, b)| surfaces[*a] < surfaces[*b]) {
            let pair = [surfaces[a], surfaces[b]];
            let borders = (0..9).flat_map(|k| beside(k).map(move |o| (k, o)));
            let n_borders = borders.filter(|(k, o)| [surfaces[*k], surfaces[*o]] == pair).count();
            let step = heights[b] - heights[a];
            let connection = ground.connections.iter().find(|c| c.surfaces == pair);
            if n_borders == 0 || step.abs() > 3_000 {
                prop_assert!(connection.is_none());
            } else {
                let connection = connection.unwrap();
                prop_assert_eq!(connection.step_tenths, step);
                prop_assert!((f64::from(connection.length_m) - 4.0 * n_borders as f64).abs() < 0.3, "{connection:?}");
                prop_assert_eq!(connection.kind.get(), GroundConnection::Step);
            }
        }
        let area: f64 = ground.surfaces.iter().map(|s| s.area_m2).sum();
        prop_assert!((area - 144.0).abs() < 1e-9);
    }
}
