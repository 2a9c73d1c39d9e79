//! Polygons with holes, coordinates in whole tenths of a millimetre.

/// A point in the plane, in tenths of a millimetre.
pub type Point = [i32; 2];

/// A closed loop without its first point repeated.
pub type Ring = Vec<Point>;

/// A polygon: counter-clockwise exterior, clockwise holes.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Polygon {
    /// Outer boundary, counter-clockwise.
    pub exterior: Ring,
    /// Boundaries of the holes, clockwise.
    pub holes: Vec<Ring>,
}

/// Polygons whose interiors do not overlap.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct MultiPolygon(pub Vec<Polygon>);

/// Smallest upright rectangle around points, borders included.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Bounds {
    /// Lower left corner.
    pub min: Point,
    /// Upper right corner.
    pub max: Point,
}

impl Bounds {
    /// The bounds of the points; `None` without points.
    pub fn of(points: impl IntoIterator<Item = Point>) -> Option<Self> {
        points.into_iter().fold(None, |bounds: Option<Self>, [x, y]| {
            Some(bounds.map_or(Self { min: [x, y], max: [x, y] }, |b| Self {
                min: [b.min[0].min(x), b.min[1].min(y)],
                max: [b.max[0].max(x), b.max[1].max(y)],
            }))
        })
    }

    /// The smallest bounds around both.
    pub fn joined(self, other: Self) -> Self {
        Self {
            min: [self.min[0].min(other.min[0]), self.min[1].min(other.min[1])],
            max: [self.max[0].max(other.max[0]), self.max[1].max(other.max[1])],
        }
    }

    /// True if the rectangles share at least a point.
    pub fn meets(&self, other: &Self) -> bool {
        (0..2).all(|k| self.min[k] <= other.max[k] && other.min[k] <= self.max[k])
    }
}

/// Twice the signed area of a ring in square tenths of a millimetre; positive if counter-clockwise.
pub fn ring_area_doubled(ring: &[Point]) -> i128 {
    edges(ring).map(|(a, b)| i128::from(i64::from(a[0]) * i64::from(b[1]) - i64::from(b[0]) * i64::from(a[1]))).sum()
}

/// The directed edges of a ring.
pub fn edges(ring: &[Point]) -> impl Iterator<Item = (Point, Point)> {
    ring.iter().zip(ring.iter().cycle().skip(1)).map(|(a, b)| (*a, *b))
}

impl Polygon {
    /// The exterior, then the holes.
    pub fn rings(&self) -> impl Iterator<Item = &Ring> {
        std::iter::once(&self.exterior).chain(&self.holes)
    }

    /// Area in square metres.
    pub fn area_m2(&self) -> f64 {
        let doubled: i128 = self.rings().map(|r| ring_area_doubled(r)).sum();
        doubled as f64 / 2.0 / f64::from(frames::TENTHS_PER_M) / f64::from(frames::TENTHS_PER_M)
    }
}

impl MultiPolygon {
    /// True if there is no polygon.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// All rings of all polygons.
    pub fn rings(&self) -> impl Iterator<Item = &Ring> {
        self.0.iter().flat_map(Polygon::rings)
    }

    /// Area in square metres.
    pub fn area_m2(&self) -> f64 {
        self.0.iter().map(Polygon::area_m2).sum()
    }

    /// The bounds of all points; `None` if empty.
    pub fn bounds(&self) -> Option<Bounds> {
        Bounds::of(self.0.iter().flat_map(|p| p.exterior.iter().copied()))
    }

    /// Area centroid in tenths of a millimetre; `None` without area.
    pub fn centroid(&self) -> Option<[f64; 2]> {
        // Around the first point, so that large coordinates do not cancel.
        let origin = *self.0.first()?.exterior.first()?;
        let relative = |p: Point| [f64::from(p[0] - origin[0]), f64::from(p[1] - origin[1])];
        let (mut doubled, mut sum) = (0.0, [0.0; 2]);
        for (a, b) in self.rings().flat_map(|r| edges(r)) {
            let (a, b) = (relative(a), relative(b));
            let cross = a[0] * b[1] - b[0] * a[1];
            doubled += cross;
            sum = [sum[0] + (a[0] + b[0]) * cross, sum[1] + (a[1] + b[1]) * cross];
        }
        (doubled > 0.0).then(|| [0, 1].map(|k| f64::from(origin[k]) + sum[k] / (3.0 * doubled)))
    }

    /// True if the point (in tenths of a millimetre) lies inside; points on a border may go either way.
    pub fn contains(&self, [x, y]: [f64; 2]) -> bool {
        let mut inside = false;
        for (a, b) in self.rings().flat_map(|r| edges(r)) {
            let (a, b) = (a.map(f64::from), b.map(f64::from));
            if (a[1] > y) != (b[1] > y) && x < a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]) {
                inside = !inside;
            }
        }
        inside
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(x: i32, y: i32, side: i32) -> Ring {
        vec![[x, y], [x + side, y], [x + side, y + side], [x, y + side]]
    }

    fn with_hole() -> MultiPolygon {
        let mut hole = square(10_000, 10_000, 10_000);
        hole.reverse();
        MultiPolygon(vec![Polygon { exterior: square(0, 0, 40_000), holes: vec![hole] }])
    }

    #[test]
    fn a_hole_counts_against_area_and_centroid() {
        let p = with_hole();
        assert_eq!(p.area_m2(), 15.0);
        let [x, y] = p.centroid().unwrap();
        let expected = (16.0 * 20_000.0 - 15_000.0) / 15.0;
        assert!((x - expected).abs() < 1e-6 && (y - expected).abs() < 1e-6);
    }

    #[test]
    fn a_point_in_a_hole_is_outside() {
        let p = with_hole();
        assert!(p.contains([5_000.0, 5_000.0]));
        assert!(!p.contains([15_000.0, 15_000.0]));
        assert!(!p.contains([50_000.0, 5_000.0]));
    }
}
