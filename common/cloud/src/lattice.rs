//! Intersections of triangles with the lines of a lattice along an axis, in whole numbers: each line meets the faces around an edge or a
//! corner once, so that a closed surface is met as often inwards as outwards.

/// A triangle, seen along an axis.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Seen {
    /// Corners in the plane across the axis and along it, counter-clockwise as seen against the axis.
    corners: [[i64; 3]; 3],
    /// Normal of the triangle by its corners as they are here, not of unit length: that along the axis is positive.
    normal: [i128; 3],
}

/// A meeting of a line and a triangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Meeting {
    /// Number of the line along the two axes across, `(2k + 1)` half spacings from the origin.
    pub(crate) line: [i32; 2],
    /// Place along the axis.
    pub(crate) depth: i32,
}

impl Seen {
    /// A triangle seen along an axis, 0 to 2, and +1 if it looks along the axis, -1 against it; `None` if it is seen edge on.
    pub(crate) fn of(corners: [[i32; 3]; 3], axis: usize) -> Option<(Self, i8)> {
        let [b, c] = [(axis + 1) % 3, (axis + 2) % 3];
        let mut corners = corners.map(|p| [i64::from(p[b]), i64::from(p[c]), i64::from(p[axis])]);
        let mut normal = normal(&corners);
        let sign = normal[2].signum() as i8;
        if sign == 0 {
            return None;
        }
        if sign < 0 {
            corners.swap(1, 2);
            normal = normal.map(|n| -n);
        }
        Some((Self { corners, normal }, sign))
    }

    /// Calls `meet` for each line that meets the triangle, row by row.
    pub(crate) fn meet(&self, half: i32, mut meet: impl FnMut(Meeting)) {
        let half = i64::from(half);
        let [low, high] = self.extent(1);
        for row in first_line(low, half)..=last_line(high, half) {
            let v = (2 * row + 1) * half;
            let Some([left, right]) = self.span(v) else { continue };
            // The ends of the span are rounded: the exact test is that of the point.
            for column in first_line(left, half) - 1..=last_line(right, half) + 1 {
                let u = (2 * column + 1) * half;
                if self.contains([u, v]) {
                    meet(Meeting { line: [column as i32, row as i32], depth: self.depth([u, v]) });
                }
            }
        }
    }

    /// The place along the axis at which a line parallel to it meets the triangle, by its coordinates across.
    pub(crate) fn depth_at(&self, place: [i64; 2]) -> Option<i32> {
        let is_near = (0..2).all(|k| self.extent(k)[0] <= place[k] && place[k] <= self.extent(k)[1]);
        (is_near && self.contains(place)).then(|| self.depth(place))
    }

    /// Least and greatest coordinate of the corners.
    fn extent(&self, axis: usize) -> [i64; 2] {
        let of = self.corners.map(|p| p[axis]);
        [of[0].min(of[1]).min(of[2]), of[0].max(of[1]).max(of[2])]
    }

    /// Where a row enters and leaves the triangle, rounded outwards; `None` where it passes it.
    fn span(&self, v: i64) -> Option<[i64; 2]> {
        let (mut left, mut right) = (i64::MAX, i64::MIN);
        for k in 0..3 {
            let (p, q) = (self.corners[k], self.corners[(k + 1) % 3]);
            if p[1].min(q[1]) > v || p[1].max(q[1]) < v {
                continue;
            }
            let [low, high] = if p[1] == q[1] {
                [p[0].min(q[0]), p[0].max(q[0])]
            } else {
                let along = i128::from(q[0] - p[0]) * i128::from(v - p[1]);
                let at = p[0] + along.div_euclid(i128::from(q[1] - p[1])) as i64;
                [at - 1, at + 1]
            };
            (left, right) = (left.min(low), right.max(high));
        }
        (left <= right).then_some([left, right])
    }

    /// True if a point lies inside, or on an edge that counts as inside: of two triangles at an edge it is in one.
    fn contains(&self, [u, v]: [i64; 2]) -> bool {
        (0..3).all(|k| {
            let (p, q) = (self.corners[k], self.corners[(k + 1) % 3]);
            let (du, dv) = (q[0] - p[0], q[1] - p[1]);
            let side = i128::from(du) * i128::from(v - p[1]) - i128::from(dv) * i128::from(u - p[0]);
            side > 0 || side == 0 && (dv < 0 || dv == 0 && du < 0)
        })
    }

    /// The place along the axis at a point of the plane, rounded.
    fn depth(&self, [u, v]: [i64; 2]) -> i32 {
        let p = self.corners[0];
        let [nu, nv, n] = self.normal;
        let down = nu * i128::from(u - p[0]) + nv * i128::from(v - p[1]);
        let [low, high] = self.extent(2);
        let at = i128::from(p[2]) - (2 * down + n).div_euclid(2 * n);
        at.clamp(i128::from(low), i128::from(high)) as i32
    }
}

fn normal(corners: &[[i64; 3]; 3]) -> [i128; 3] {
    let side = |k: usize| [0, 1, 2].map(|i| i128::from(corners[k][i] - corners[0][i]));
    let (p, q) = (side(1), side(2));
    [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]
}

/// The first line at a coordinate or above it.
fn first_line(low: i64, half: i64) -> i64 {
    -(half - low).div_euclid(2 * half)
}

/// The last line at a coordinate or below it.
fn last_line(high: i64, half: i64) -> i64 {
    (high - half).div_euclid(2 * half)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn meetings(corners: [[i32; 3]; 3], axis: usize) -> Vec<Meeting> {
        let mut met = Vec::new();
        if let Some((seen, _)) = Seen::of(corners, axis) {
            seen.meet(5, |meeting| met.push(meeting));
        }
        met
    }

    #[test]
    fn the_lines_through_a_square_are_met_once_by_its_halves() {
        let [a, b, c, d] = [[0, 0, 7], [100, 0, 7], [100, 100, 7], [0, 100, 7]];
        let mut met = meetings([a, b, c], 2);
        met.extend(meetings([a, c, d], 2));
        met.sort();
        let wanted: Vec<Meeting> =
            (0..10).flat_map(|u| (0..10).map(move |v| Meeting { line: [u, v], depth: 7 })).collect();
        assert_eq!(met, wanted);
        assert!(meetings([a, b, c], 0).is_empty(), "it is seen edge on");
    }

    #[test]
    fn a_triangle_looks_to_where_its_corners_turn_left() {
        let corners = [[0, 0, 0], [10, 0, 0], [0, 10, 0]];
        assert_eq!(Seen::of(corners, 2).unwrap().1, 1);
        assert_eq!(Seen::of([corners[0], corners[2], corners[1]], 2).unwrap().1, -1);
    }

    proptest! {
        #[test]
        fn a_closed_body_is_met_as_often_inwards_as_outwards(
            corners in proptest::array::uniform4(proptest::array::uniform3(-60i32..60)),
        ) {
            // The four faces of a tetrahedron, each with its corners turning the same way seen from outside, or from inside.
            let faces = [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]];
            for axis in 0..3 {
                let mut balance = std::collections::BTreeMap::<[i32; 2], i32>::new();
                for face in faces {
                    let Some((seen, sign)) = Seen::of(face.map(|k: usize| corners[k]), axis) else { continue };
                    seen.meet(5, |meeting| *balance.entry(meeting.line).or_default() += i32::from(sign));
                }
                prop_assert!(balance.values().all(|sum| *sum == 0), "{balance:?}");
            }
        }

        #[test]
        fn meetings_lie_in_the_plane_of_the_triangle(
            corners in proptest::array::uniform3(proptest::array::uniform3(-2000i32..2000)),
            axis in 0usize..3,
        ) {
            let [b, c] = [(axis + 1) % 3, (axis + 2) % 3];
            let [p, q, r] = corners.map(|corner| corner.map(f64::from));
            let (u, v) = ([0, 1, 2].map(|k| q[k] - p[k]), [0, 1, 2].map(|k| r[k] - p[k]));
            let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
            for Meeting { line, depth } in meetings(corners, axis) {
                let mut at = [0.0; 3];
                (at[axis], at[b], at[c]) =
                    (f64::from(depth), f64::from((2 * line[0] + 1) * 5), f64::from((2 * line[1] + 1) * 5));
                let off: f64 = (0..3).map(|k| n[k] * (at[k] - p[k])).sum::<f64>() / n[axis].abs();
                prop_assert!(off.abs() <= 0.500_1, "{off}");
            }
        }
    }
}
