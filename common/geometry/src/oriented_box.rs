//! Oriented rectangles in plan.

use crate::polygon::{Point, Ring};

/// A rectangle along two perpendicular unit axes, in tenths of a millimetre.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrientedBox {
    /// Middle.
    pub centre: [f64; 2],
    /// Unit direction of the first side; the second is a quarter turn to the left.
    pub axis: [f64; 2],
    /// Half lengths along the first and second side.
    pub half: [f64; 2],
}

impl OrientedBox {
    /// True for a point inside or on the rim.
    pub fn contains(&self, [x, y]: [f64; 2]) -> bool {
        let (off, across) = ([x - self.centre[0], y - self.centre[1]], self.across());
        let along = |axis: [f64; 2]| (off[0] * axis[0] + off[1] * axis[1]).abs();
        along(self.axis) <= self.half[0] && along(across) <= self.half[1]
    }

    /// The smallest box with the given axis around points; `None` without points.
    pub fn around(points: impl IntoIterator<Item = Point>, axis: [f64; 2]) -> Option<Self> {
        let across = [-axis[1], axis[0]];
        let mut range: Option<[[f64; 2]; 2]> = None;
        for p in points {
            let p = p.map(f64::from);
            let at = [axis, across].map(|a| a[0] * p[0] + a[1] * p[1]);
            let r = range.get_or_insert([[at[0]; 2], [at[1]; 2]]);
            for k in 0..2 {
                r[k] = [r[k][0].min(at[k]), r[k][1].max(at[k])];
            }
        }
        let r = range?;
        let middle = r.map(|[lo, hi]| (lo + hi) / 2.0);
        Some(Self {
            centre: [0, 1].map(|k| axis[k] * middle[0] + across[k] * middle[1]),
            axis,
            half: r.map(|[lo, hi]| (hi - lo) / 2.0),
        })
    }

    /// The box of least area around points, sides along an edge of their convex hull; `None` without points.
    pub fn smallest_around(points: &[Point]) -> Option<Self> {
        let hull = convex_hull(points);
        let directions = hull.iter().zip(hull.iter().cycle().skip(1)).filter(|(a, b)| a != b).map(|(a, b)| {
            let d = [0, 1].map(|k| f64::from(b[k]) - f64::from(a[k]));
            let length = (d[0] * d[0] + d[1] * d[1]).sqrt();
            d.map(|c| c / length)
        });
        let boxes = directions.chain([[1.0, 0.0]]).filter_map(|axis| Self::around(hull.iter().copied(), axis));
        boxes.min_by(|a, b| (a.half[0] * a.half[1]).total_cmp(&(b.half[0] * b.half[1])))
    }

    /// Unit direction of the second side.
    pub fn across(&self) -> [f64; 2] {
        [-self.axis[1], self.axis[0]]
    }

    /// The point at `u` along the first and `v` along the second side from the centre.
    pub fn at(&self, u: f64, v: f64) -> [f64; 2] {
        let across = self.across();
        [0, 1].map(|k| self.centre[k] + u * self.axis[k] + v * across[k])
    }

    /// The corners, counter-clockwise, rounded.
    pub fn ring(&self) -> Ring {
        let [u, v] = self.half;
        [(-u, -v), (u, -v), (u, v), (-u, v)].map(|(u, v)| self.at(u, v).map(|c| c.round() as i32)).to_vec()
    }
}

/// Counter-clockwise convex hull by Andrew's monotone chain, without collinear points.
///
/// # Source
/// A. M. Andrew, "Another efficient algorithm for convex hulls in two dimensions", Information Processing Letters 9, 1979.
fn convex_hull(points: &[Point]) -> Ring {
    let mut sorted = points.to_vec();
    sorted.sort_unstable();
    sorted.dedup();
    if sorted.len() < 3 {
        return sorted;
    }
    let turn = |o: Point, a: Point, b: Point| {
        let d = |p: Point, k: usize| i128::from(p[k]) - i128::from(o[k]);
        d(a, 0) * d(b, 1) - d(a, 1) * d(b, 0)
    };
    let chain = |points: &mut dyn Iterator<Item = Point>| {
        let mut out: Ring = Vec::new();
        for p in points {
            while out.len() >= 2 && turn(out[out.len() - 2], out[out.len() - 1], p) <= 0 {
                out.pop();
            }
            out.push(p);
        }
        out.pop();
        out
    };
    let mut hull = chain(&mut sorted.iter().copied());
    hull.extend(chain(&mut sorted.iter().rev().copied()));
    hull
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_smallest_box_of_a_turned_rectangle_is_the_rectangle() {
        let points = [[0, 0], [3_000, 4_000], [2_200, 4_600], [-800, 600], [1_000, 2_000]];
        let found = OrientedBox::smallest_around(&points).unwrap();
        let mut sides = found.half.map(|h| (2.0 * h).round());
        sides.sort_by(f64::total_cmp);
        assert_eq!(sides, [1_000.0, 5_000.0]);
    }

    #[test]
    fn a_line_and_a_point_have_boxes_without_area() {
        assert_eq!(OrientedBox::smallest_around(&[[0, 0], [10, 0]]).unwrap().half[1], 0.0);
        assert_eq!(OrientedBox::smallest_around(&[[7, 7]]).unwrap().centre, [7.0, 7.0]);
        assert_eq!(OrientedBox::smallest_around(&[]), None);
    }
}
