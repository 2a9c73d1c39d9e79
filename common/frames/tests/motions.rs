//! Properties of rigid motions, and of covariances that they carry along.

use frames::{EarthFromWorld, Point2, Point3, PoseCovariance, Rigid2, UprightRigid3, World, wrapped};
use proptest::prelude::*;
use std::f64::consts::PI;

enum A {}
enum B {}
enum C {}
enum D {}

/// A motion by numbers: x and y in metres, yaw in radians.
type Numbers = ([f64; 2], f64);

fn numbers() -> impl Strategy<Value = Numbers> {
    ([-1.0..1.0f64, -1.0..1.0], -PI..PI)
}

fn motion<To, From>((translation_m, yaw_rad): Numbers) -> Rigid2<To, From> {
    Rigid2::new(translation_m, yaw_rad)
}

fn off<To, From>(a: &Rigid2<To, From>, b: &Rigid2<To, From>) -> f64 {
    let ([ax, ay], [bx, by]) = (a.translation_m(), b.translation_m());
    [ax - bx, ay - by, wrapped(a.yaw_rad() - b.yaw_rad())].map(f64::abs).into_iter().fold(0.0, f64::max)
}

proptest! {
    #[test]
    fn a_motion_and_its_inverse_cancel(b_from_a in numbers(), p in [-1.0..1.0f64, -1.0..1.0]) {
        let b_from_a = motion::<B, A>(b_from_a);
        let moved = b_from_a.apply(p);
        let ways_back = [b_from_a.apply_inverse(moved), b_from_a.inverse().apply(moved)];
        for back in ways_back {
            prop_assert!((0..2).all(|k| (back[k] - p[k]).abs() < 1e-12), "{back:?}");
        }
        let nowhere = motion::<A, A>(([0.0; 2], 0.0));
        prop_assert!(off(&(&b_from_a.inverse() * &b_from_a), &nowhere) < 1e-12);
        prop_assert!(off(&b_from_a.inverse().inverse(), &b_from_a) < 1e-12);
    }

    #[test]
    fn motions_can_be_composed_in_any_order_of_brackets(d in numbers(), c in numbers(), b in numbers()) {
        let (d_from_c, c_from_b, b_from_a) = (motion::<D, C>(d), motion::<C, B>(c), motion::<B, A>(b));
        let (left, right) = (&(&d_from_c * &c_from_b) * &b_from_a, &d_from_c * &(&c_from_b * &b_from_a));
        prop_assert!(off(&left, &right) < 1e-12);
    }

    #[test]
    fn a_composed_motion_moves_points_as_one_after_the_other(
        c in numbers(), b in numbers(), x in -1.0..1.0f64, y in -1.0..1.0f64,
    ) {
        let (c_from_b, b_from_a) = (motion::<C, B>(c), motion::<B, A>(b));
        let p = Point2::<A>::new(x, y);
        let one_after_the_other = &c_from_b * (&b_from_a * p);
        let composed = &(&c_from_b * &b_from_a) * p;
        prop_assert!(composed.distance_m(&one_after_the_other) < 1e-12);
    }

    #[test]
    fn an_upright_motion_is_that_of_the_plane_and_a_shift_along_z(b in numbers(), z in -1.0..1.0f64, p in [-1.0..1.0f64, -1.0..1.0, -1.0..1.0]) {
        let ([x_m, y_m], yaw_rad) = b;
        let b_from_a = UprightRigid3::<B, A>::new([x_m, y_m, z], yaw_rad);
        let [x, y] = b_from_a.in_plane().apply([p[0], p[1]]);
        prop_assert_eq!(b_from_a.apply(p), [x, y, p[2] + z]);
        let back = b_from_a.inverse().apply(b_from_a.apply(p));
        prop_assert!((0..3).all(|k| (back[k] - p[k]).abs() < 1e-12), "{back:?}");
    }

    #[test]
    fn a_covariance_comes_back_from_another_place_and_other_axes(
        d in [-1.0..1.0f64, -1.0..1.0], b in numbers(), s in [0.01..1.0f64, 0.01..1.0, 0.01..1.0],
    ) {
        let here = PoseCovariance::from_rows([[s[0], 0.0, 0.0], [0.0, s[1], 0.0], [0.0, 0.0, s[2]]]);
        let b_from_a = motion::<B, A>(b);
        let back = here.transported(d).transported(d.map(|c| -c)).turned(&b_from_a).turned(&b_from_a.inverse());
        let (expected, found) = (here.rows(), back.rows());
        prop_assert!((0..9).all(|k| (expected[k / 3][k % 3] - found[k / 3][k % 3]).abs() < 1e-12), "{found:?}");
        // No axes hold the place worse than the worst direction.
        let turned = here.turned(&b_from_a);
        let worst = s[0].max(s[1]).sqrt();
        prop_assert!((turned.worst_m() - worst).abs() < 1e-12 && turned.deviations()[0] <= worst + 1e-12);
    }

    #[test]
    fn a_point_comes_back_from_earth(
        origin_m in [-1e6..1e6f64, -1e6..1e6, -1e3..1e3], yaw_rad in -PI..PI, s in 0.9..1.1f64, p in [-1e2..1e2f64, -1e2..1e2, -1e2..1e2],
    ) {
        let (sin, cos) = libm::sincos(yaw_rad);
        let earth_from_world = EarthFromWorld::new(origin_m, [cos, sin], [s, s, 1.0]);
        let back = earth_from_world.apply_inverse(&earth_from_world * Point3::<World>::new(p[0], p[1], p[2])).coordinates_m();
        prop_assert!((0..3).all(|k| (back[k] - p[k]).abs() < 1e-9), "{back:?}");
        prop_assert!(wrapped(earth_from_world.yaw_rad() - yaw_rad).abs() < 1e-12);
    }

    #[test]
    fn an_angle_is_wrapped_to_half_a_turn(angle_rad in -100.0..100.0f64) {
        let found = wrapped(angle_rad);
        prop_assert!((-PI..=PI).contains(&found));
        prop_assert!((libm::sin(found) - libm::sin(angle_rad)).abs() < 1e-12);
        prop_assert!((libm::cos(found) - libm::cos(angle_rad)).abs() < 1e-12);
    }
}

#[test]
fn a_yaw_of_zero_is_exact() {
    let b_from_a = UprightRigid3::<B, A>::new([0.0; 3], 0.0);
    assert_eq!(b_from_a.apply([0.1, 0.2, 0.3]), [0.1, 0.2, 0.3]);
    let b_from_a = Rigid2::<B, A>::new([0.0; 2], 0.0);
    assert_eq!((b_from_a.apply([0.1, 0.2]), b_from_a.rotate([0.3, 0.4])), ([0.1, 0.2], [0.3, 0.4]));
}

#[test]
fn products_and_sums_are_taken_in_the_order_that_grids_were_drawn_with() {
    let (x, y, yaw_rad, p) = (103.7, -21.9, 0.7, [11.3, 5.1]);
    let (sin, cos) = libm::sincos(yaw_rad);
    let b_from_a = Rigid2::<B, A>::new([x, y], yaw_rad);
    assert_eq!(b_from_a.apply(p), [cos * p[0] - sin * p[1] + x, sin * p[0] + cos * p[1] + y]);
    let back = [-(cos * x + sin * y), sin * x - cos * y];
    assert_eq!(b_from_a.inverse().translation_m(), back);
}

#[test]
fn a_small_turn_moves_a_place_that_lies_aside() {
    let rows = [[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 1e-4]];
    let covariance = PoseCovariance::from_rows(rows).transported([3.0, 0.0]);
    assert!((covariance.deviations()[1] - 0.03).abs() < 1e-12 && covariance.deviations()[0] < 1e-12);
    assert_eq!(covariance.rows()[1][2], covariance.rows()[2][1]);
}
