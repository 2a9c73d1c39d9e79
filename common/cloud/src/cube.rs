//! The test of a triangle and a cube for meeting, in whole numbers.

/// A cube along the axes, in tenths of a millimetre.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Cube {
    pub(crate) centre: [i64; 3],
    pub(crate) half: i64,
}

impl Cube {
    /// True if the triangle meets the inside of the cube; with `touching` also if it meets a face, edge or corner only.
    ///
    /// # Source
    /// Akenine-Möller, "Fast 3D Triangle-Box Overlap Testing", Journal of Graphics Tools 6, 2001.
    pub(crate) fn meets(&self, triangle: &[[i32; 3]; 3], touching: bool) -> bool {
        let is_apart = |low: i128, high: i128, reach: i128| {
            if touching { low > reach || high < -reach } else { low >= reach || high <= -reach }
        };
        let half = i128::from(self.half);
        let corners = triangle.map(|p| [0, 1, 2].map(|k| i128::from(i64::from(p[k]) - self.centre[k])));
        for axis in 0..3 {
            let of = corners.map(|p| p[axis]);
            if is_apart(of[0].min(of[1]).min(of[2]), of[0].max(of[1]).max(of[2]), half) {
                return false;
            }
        }
        let sides = [0, 1, 2].map(|k| [0, 1, 2].map(|i| corners[(k + 1) % 3][i] - corners[k][i]));
        let normal = cross(sides[0], sides[1]);
        let across = sides.iter().flat_map(|side| [0, 1, 2].map(|axis| cross(*side, unit(axis))));
        across.chain([normal]).all(|direction| {
            let reach = half * direction.iter().map(|c| c.abs()).sum::<i128>();
            let of = corners.map(|p| (0..3).map(|k| p[k] * direction[k]).sum::<i128>());
            // A direction of no length tells nothing.
            reach == 0 || !is_apart(of[0].min(of[1]).min(of[2]), of[0].max(of[1]).max(of[2]), reach)
        })
    }
}

fn unit(axis: usize) -> [i128; 3] {
    [0, 1, 2].map(|k| i128::from(k == axis))
}

fn cross(a: [i128; 3], b: [i128; 3]) -> [i128; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const UNIT: Cube = Cube { centre: [5, 5, 5], half: 5 };

    #[test]
    fn a_triangle_in_a_face_touches_the_cube_and_does_not_enter_it() {
        for z in [0, 10] {
            let triangle = [[0, 0, z], [10, 0, z], [0, 10, z]];
            assert!(UNIT.meets(&triangle, true) && !UNIT.meets(&triangle, false), "{z}");
        }
        assert!(UNIT.meets(&[[0, 0, 5], [10, 0, 5], [0, 10, 5]], false));
        assert!(UNIT.meets(&[[-90, -90, 1], [90, -90, 1], [0, 190, 1]], false), "around it");
        assert!(!UNIT.meets(&[[-90, -90, 11], [90, -90, 11], [0, 190, 11]], true));
    }

    #[test]
    fn the_box_of_a_triangle_is_not_the_triangle() {
        let triangle = [[13, -2, 5], [-2, 13, 5], [13, 13, 5]];
        assert!(UNIT.meets(&triangle, false));
        let beyond = [[30, -2, 5], [-2, 30, 5], [30, 30, 5]];
        assert!(!UNIT.meets(&beyond, true));
    }

    proptest! {
        #[test]
        fn a_point_of_the_triangle_inside_means_that_they_meet(
            triangle in proptest::array::uniform3(proptest::array::uniform3(-30i32..40)),
            shares in proptest::array::uniform2(0i64..=100),
        ) {
            let [s, t] = if shares[0] + shares[1] > 100 { shares.map(|c| 100 - c) } else { shares };
            let at = |k: usize| {
                let [a, b, c] = [0, 1, 2].map(|i| i64::from(triangle[i][k]));
                100 * a + s * (b - a) + t * (c - a)
            };
            if (0..3).all(|k| 0 < at(k) && at(k) < 1_000) {
                prop_assert!(UNIT.meets(&triangle, false));
            }
            if (0..3).all(|k| 0 <= at(k) && at(k) <= 1_000) {
                prop_assert!(UNIT.meets(&triangle, true));
            }
        }
    }
}
