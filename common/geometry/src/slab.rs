//! Clipping triangles to a slab of heights.

use crate::polygon::Point;

/// Heights from `lo` to `hi` in tenths of a millimetre.
///
/// The slab's faces lie half a unit inside its bounds, so no vertex is ever on them: a top at `lo` is below the
/// slab, a bottom at `hi` is above it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Slab {
    /// Lower bound.
    pub lo: i32,
    /// Upper bound, above `lo`.
    pub hi: i32,
}

impl Slab {
    /// True if the heights from `z_min` to `z_max` reach into the slab.
    pub fn meets(self, z_min: i32, z_max: i32) -> bool {
        z_min < self.hi && self.lo < z_max
    }
}

/// Where the edge from `a` to `b` passes the height `plane_doubled / 2`, which is strictly between its ends.
///
/// The result does not depend on the order of the ends, so that neighbouring triangles agree.
pub(crate) fn crossing(a: [i32; 3], b: [i32; 3], plane_doubled: i64) -> Point {
    let (a, b) = if a <= b { (a, b) } else { (b, a) };
    let part = (plane_doubled - 2 * i64::from(a[2])) as f64 / (2 * (i64::from(b[2]) - i64::from(a[2]))) as f64;
    [0, 1].map(|k| {
        let step = part * (f64::from(b[k]) - f64::from(a[k]));
        (f64::from(a[k]) + step).round() as i32
    })
}

/// The plan of the part of a triangle inside the slab: a convex polygon of up to five points, in the triangle's sense.
///
/// Points are appended to `out`, which is cleared first. Vertical triangles give degenerate polygons.
pub fn clip_to_slab(triangle: &[[i32; 3]; 3], slab: Slab, out: &mut Vec<Point>) {
    out.clear();
    let planes = [2 * i64::from(slab.lo) + 1, 2 * i64::from(slab.hi) - 1];
    for k in 0..3 {
        let (a, b) = (triangle[k], triangle[(k + 1) % 3]);
        let (za, zb) = (2 * i64::from(a[2]), 2 * i64::from(b[2]));
        if planes[0] < za && za < planes[1] {
            out.push([a[0], a[1]]);
        }
        // An edge going up meets the lower plane first, one going down the upper.
        let order = if za <= zb { planes } else { [planes[1], planes[0]] };
        for plane in order {
            if (za < plane) != (zb < plane) {
                out.push(crossing(a, b, plane));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flat_top_at_the_lower_bound_is_outside() {
        let mut plan = Vec::new();
        clip_to_slab(&[[0, 0, 500], [100, 0, 500], [0, 100, 500]], Slab { lo: 500, hi: 900 }, &mut plan);
        assert!(plan.is_empty());
        clip_to_slab(&[[0, 0, 501], [100, 0, 501], [0, 100, 501]], Slab { lo: 500, hi: 900 }, &mut plan);
        assert_eq!(plan, [[0, 0], [100, 0], [0, 100]]);
    }

    #[test]
    fn a_triangle_through_both_planes_keeps_its_middle() {
        let mut plan = Vec::new();
        clip_to_slab(&[[0, 0, 0], [1000, 0, 1000], [0, 1000, 0]], Slab { lo: 250, hi: 750 }, &mut plan);
        assert_eq!(plan.len(), 4);
        assert!(plan.iter().all(|p| 250 <= p[0] && p[0] <= 751), "{plan:?}");
    }
}
