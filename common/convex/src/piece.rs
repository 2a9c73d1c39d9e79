//! A convex piece of a solid: an oriented box or a convex polyhedron.

use frames::TENTHS_PER_M;
use geometry::Point;

/// Tolerance for corners of a box, in metres: 0.3 mm.
const SAME_M: f64 = 3e-4;

/// A convex piece; lengths in metres.
#[derive(Debug, Clone, PartialEq)]
pub struct Piece {
    /// Its shape.
    pub shape: Shape,
    /// Origin of the piece.
    pub made: Made,
    /// Maximum distance of its surface from that of its body.
    pub deviation_m: f64,
}

/// Origin of a piece.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Made {
    /// Equal to a part of the body except for rounding.
    Exact,
    /// A plate for a surface without thickness.
    Sheet,
    /// The convex hull of a nearly convex part.
    Hull,
    /// A hull of an approximate decomposition.
    Decomposed,
}

/// Shape of a piece.
#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    /// A box.
    Box(ConvexBox),
    /// A convex polyhedron.
    Hull(Hull),
}

/// An oriented box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConvexBox {
    /// Middle.
    pub centre_m: [f64; 3],
    /// Unit directions of its sides, right-handed; a vertical one is the last.
    pub axes: [[f64; 3]; 3],
    /// Lengths of its sides.
    pub size_m: [f64; 3],
}

/// The plane of a face of a hull.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FacePlane {
    /// Unit vector outward.
    normal: [f64; 3],
    /// Distance of the plane from the origin along the normal.
    offset_m: f64,
    /// Four times the area over the perimeter; the normals of narrow faces are inaccurate.
    pub(crate) width_m: f64,
}

impl FacePlane {
    /// Signed distance of a point in front of the face.
    pub(crate) fn before_m(&self, p: [f64; 3]) -> f64 {
        dot(self.normal, p) - self.offset_m
    }

    /// Signed distance of the second of three corners outside of the line through the others.
    pub(crate) fn bulge_m(&self, [a, b, c]: [[f64; 3]; 3]) -> f64 {
        let along = sub(c, a);
        dot(self.normal, cross(sub(b, a), along)) / length(along).max(f64::MIN_POSITIVE)
    }
}

/// A convex polyhedron.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Hull {
    /// Corners.
    pub vertices_m: Vec<[f64; 3]>,
    /// Faces as corners, counter-clockwise from outside.
    pub faces: Vec<Vec<u32>>,
}

impl Hull {
    /// The hull between a convex plan, counter-clockwise, and the same plan above: corners as (x, y, lower z, upper z) in tenths
    /// of a millimetre. Ends that meet at a corner make it one vertex.
    pub(crate) fn between(corners: impl ExactSizeIterator<Item = [f64; 4]>) -> Self {
        let scale = f64::from(TENTHS_PER_M);
        let n = corners.len();
        let mut vertices_m = Vec::with_capacity(2 * n);
        let (mut low, mut high) = (Vec::with_capacity(n), Vec::with_capacity(n));
        for [x, y, lo, hi] in corners {
            low.push(vertices_m.len() as u32);
            vertices_m.push([x / scale, y / scale, lo / scale]);
            if hi - lo > 0.5 {
                vertices_m.push([x / scale, y / scale, hi / scale]);
            }
            high.push(vertices_m.len() as u32 - 1);
        }
        let mut faces = vec![low.iter().rev().copied().collect(), high.clone()];
        for k in 0..n {
            let next = (k + 1) % n;
            let mut side = vec![low[k], low[next], high[next], high[k]];
            side.dedup();
            if side.first() == side.last() {
                side.pop();
            }
            if side.len() >= 3 {
                faces.push(side);
            }
        }
        Self { vertices_m, faces }
    }

    /// The hull with mapped corners.
    pub(crate) fn mapped(mut self, map: impl Fn([f64; 3]) -> [f64; 3]) -> Self {
        for vertex in &mut self.vertices_m {
            *vertex = map(*vertex);
        }
        self
    }

    /// The hull as a box, if it is one.
    pub fn as_box(&self) -> Option<ConvexBox> {
        let [first, others @ ..] = self.vertices_m.as_slice() else { return None };
        if others.len() != 7 {
            return None;
        }
        let sides: Vec<[f64; 3]> = others.iter().map(|v| sub(*v, *first)).collect();
        let is_square = |a: [f64; 3], b: [f64; 3]| dot(a, b).abs() <= SAME_M * length(a).max(length(b));
        for i in 0..7 {
            for j in (i + 1..7).filter(|j| is_square(sides[i], sides[*j])) {
                for k in (j + 1..7).filter(|k| is_square(sides[i], sides[*k]) && is_square(sides[j], sides[*k])) {
                    let edges = [sides[i], sides[j], sides[k]];
                    let corner = |bits: usize| {
                        (0..3).filter(|b| bits >> b & 1 == 1).fold(*first, |p, b| [0, 1, 2].map(|c| p[c] + edges[b][c]))
                    };
                    let is_there = |p: [f64; 3]| self.vertices_m.iter().any(|v| length(sub(*v, p)) <= SAME_M);
                    if (0..8).all(|bits| is_there(corner(bits))) {
                        return Some(ConvexBox::of(corner(7), *first, edges));
                    }
                }
            }
        }
        None
    }
}

impl ConvexBox {
    fn of(last: [f64; 3], first: [f64; 3], mut edges: [[f64; 3]; 3]) -> Self {
        let slope = |e: &[f64; 3]| e[2].abs() / length(*e);
        edges.sort_by(|a, b| slope(a).total_cmp(&slope(b)));
        let mut axes = edges.map(|e| e.map(|c| c / length(e)));
        if axes[2][2] < 0.0 {
            axes[2] = axes[2].map(|c| -c);
        }
        // The first axis is the one nearest to x, so that boxes along the map have no yaw.
        if axes[0][0].abs() < axes[1][0].abs() {
            axes.swap(0, 1);
            edges.swap(0, 1);
        }
        if axes[0][0] < 0.0 {
            axes[0] = axes[0].map(|c| -c);
        }
        axes[1] = cross(axes[2], axes[0]);
        Self { centre_m: [0, 1, 2].map(|k| (first[k] + last[k]) / 2.0), axes, size_m: edges.map(length) }
    }

    /// The box as a hull.
    pub fn hull(&self) -> Hull {
        let corner = |bits: u32| {
            let side = |axis: usize| if bits >> axis & 1 == 1 { 0.5 } else { -0.5 };
            [0, 1, 2]
                .map(|k| self.centre_m[k] + (0..3).map(|a| side(a) * self.size_m[a] * self.axes[a][k]).sum::<f64>())
        };
        let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        Hull { vertices_m: (0..8).map(corner).collect(), faces: faces.map(|f| f.to_vec()).to_vec() }
    }
}

impl Piece {
    /// The piece shifted by a vector.
    pub fn shifted(&self, by_m: [f64; 3]) -> Self {
        let moved = |p: [f64; 3]| [0, 1, 2].map(|k| p[k] + by_m[k]);
        let shape = match &self.shape {
            Shape::Box(b) => Shape::Box(ConvexBox { centre_m: moved(b.centre_m), ..*b }),
            Shape::Hull(hull) => Shape::Hull(hull.clone().mapped(moved)),
        };
        Self { shape, ..*self }
    }
}

impl Shape {
    /// True if it is a box.
    pub fn is_box(&self) -> bool {
        matches!(self, Self::Box(_))
    }

    /// The simplest shape of a hull.
    pub(crate) fn of(hull: Hull) -> Self {
        hull.as_box().map_or(Self::Hull(hull), Self::Box)
    }

    /// An upright prism over a convex plan, counter-clockwise, in tenths of a millimetre.
    pub fn prism(plan: &[Point], [low_m, high_m]: [f64; 2]) -> Self {
        let scale = f64::from(TENTHS_PER_M);
        let corner = |p: &Point| [f64::from(p[0]), f64::from(p[1]), low_m * scale, high_m * scale];
        Self::of(Hull::between(plan.iter().map(corner)))
    }

    /// Its corners and faces.
    pub fn hull(&self) -> Hull {
        match self {
            Self::Box(b) => b.hull(),
            Self::Hull(hull) => hull.clone(),
        }
    }
}

impl Hull {
    /// Horizontal projection of the part between two heights, counter-clockwise; may be empty.
    pub fn plan_between(&self, low_m: f64, high_m: f64) -> Vec<[f64; 2]> {
        let mut points: Vec<[f64; 2]> =
            self.vertices_m.iter().filter(|v| low_m <= v[2] && v[2] <= high_m).map(|v| [v[0], v[1]]).collect();
        for face in &self.faces {
            for (a, b) in face.iter().zip(face.iter().cycle().skip(1)) {
                let [a, b] = [a, b].map(|k| self.vertices_m[*k as usize]);
                for z in [low_m, high_m].into_iter().filter(|z| (a[2] < *z) != (b[2] < *z)) {
                    let part = (z - a[2]) / (b[2] - a[2]);
                    points.push([0, 1].map(|k| a[k] + part * (b[k] - a[k])));
                }
            }
        }
        convex_plan(points)
    }

    /// Its volume in cubic metres.
    pub fn volume_m3(&self) -> f64 {
        let Some(origin) = self.vertices_m.first() else { return 0.0 };
        let at = |k: u32| sub(self.vertices_m[k as usize], *origin);
        let fan = |f: &Vec<u32>| (1..f.len() - 1).map(|k| dot(at(f[0]), cross(at(f[k]), at(f[k + 1])))).sum::<f64>();
        self.faces.iter().map(fan).sum::<f64>() / 6.0
    }

    /// The planes of its faces.
    pub(crate) fn planes(&self) -> impl Iterator<Item = FacePlane> {
        self.faces.iter().filter_map(|face| self.plane_of(face))
    }

    /// The plane of a face; `None` if it has no area.
    pub(crate) fn plane_of(&self, face: &[u32]) -> Option<FacePlane> {
        let at = |k: usize| self.vertices_m[face[k % face.len()] as usize];
        let origin = at(0);
        // The sum holds for faces with corners on straight runs.
        let fan = (1..face.len() - 1).map(|k| cross(sub(at(k), origin), sub(at(k + 1), origin)));
        let normal = fan.fold([0.0; 3], |sum, n| [0, 1, 2].map(|k| sum[k] + n[k]));
        let around: f64 = (0..face.len()).map(|k| length(sub(at(k + 1), at(k)))).sum();
        let size = length(normal);
        (size > 0.0).then(|| {
            let normal = normal.map(|c| c / size);
            FacePlane { normal, offset_m: dot(normal, origin), width_m: 2.0 * size / around }
        })
    }

    /// Lower and upper corner of the axis-aligned box around it.
    pub fn bounds_m(&self) -> [[f64; 3]; 2] {
        let start = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
        self.vertices_m
            .iter()
            .fold(start, |[lo, hi], v| [[0, 1, 2].map(|k| lo[k].min(v[k])), [0, 1, 2].map(|k| hi[k].max(v[k]))])
    }
}

/// Counter-clockwise convex hull of points in the plane by Andrew's monotone chain; empty without area.
fn convex_plan(mut points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    points.dedup();
    let turn = |o: [f64; 2], a: [f64; 2], b: [f64; 2]| (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0]);
    let chain = |points: &mut dyn Iterator<Item = [f64; 2]>| {
        let mut out: Vec<[f64; 2]> = Vec::new();
        for p in points {
            while out.len() >= 2 && turn(out[out.len() - 2], out[out.len() - 1], p) <= 0.0 {
                out.pop();
            }
            out.push(p);
        }
        out.pop();
        out
    };
    let mut hull = chain(&mut points.iter().copied());
    hull.extend(chain(&mut points.iter().rev().copied()));
    if hull.len() < 3 { Vec::new() } else { hull }
}

pub(crate) fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| a[k] - b[k])
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(crate) fn length(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turned_box_is_found_and_a_wedge_is_none() {
        let (sin, cos) = (libm::sin(0.4), libm::cos(0.4));
        let corners = [[0.0, 0.0], [30_000.0, 0.0], [30_000.0, 2_000.0], [0.0, 2_000.0]];
        let corners = corners.map(|[x, y]: [f64; 2]| [cos * x - sin * y, sin * x + cos * y]);
        let hull = Hull::between(corners.into_iter().map(|[x, y]| [x, y, 0.0, 25_000.0]));
        let found = hull.as_box().unwrap();
        assert!([3.0, 0.2, 2.5].iter().zip(found.size_m).all(|(a, b)| (a - b).abs() < 1e-9), "{found:?}");
        assert!((found.axes[0][1] - sin).abs() < 1e-9);
        let back = found.hull();
        assert!(back.vertices_m.iter().all(|v| hull.vertices_m.iter().any(|w| length(sub(*v, *w)) < 1e-9)));
        let plan = found.hull().plan_between(1.0, 2.0);
        assert_eq!(plan.len(), 4);
        assert!(found.hull().plan_between(2.6, 3.0).is_empty());
        let wedge = Hull::between(
            corners.into_iter().enumerate().map(|(k, [x, y])| [x, y, 0.0, if k < 2 { 0.0 } else { 5_000.0 }]),
        );
        assert_eq!((wedge.vertices_m.len(), wedge.faces.len()), (6, 5));
        assert!(wedge.as_box().is_none());
    }
}
