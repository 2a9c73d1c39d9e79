//! Work of cutting with bodies that cross each other or have inner bounds, which is far more than their pairs of faces.
//!
//! Bodies that cross are united first: where three of their faces meet in a point, the kernel computes it exactly. A body
//! with many holes divides one face of another into as many pieces, each of which is compared with all. Both were measured
//! on the machine of the benchmarks; work is in pairs of faces, of which a second has two million.

use crate::bounding_boxes::Extent;
use nalgebra::Vector3;

/// Work above which cutting is left out: about as much as the process that meshes apart may take for an element.
pub(crate) const HARD_WORK_MAX: u64 = 20_000_000;

/// Work of three triangles of three bodies that cross each other, counted in both orders of the first two.
const WORK_PER_CROSSING: u64 = 22;

/// Triangles of a box. Of a body with more, those that cross another one grow with the root of their number.
const TRIANGLES_OF_BOX: u64 = 12;

/// Work of a pair of corners of inner bounds.
const WORK_PER_RING_PAIR: u64 = 32;

/// Least sine of an angle between axes that are not parallel.
const SINE_MIN: f64 = 1e-6;

/// Triangles of a body, and corners of the inner bounds of that of its faces which has most.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct FaceCount {
    pub(crate) triangles: u64,
    pub(crate) ring_corners: u64,
}

impl FaceCount {
    /// Of both bodies as one.
    pub(crate) fn and(self, other: Self) -> Self {
        Self {
            triangles: self.triangles.saturating_add(other.triangles),
            ring_corners: self.ring_corners.saturating_add(other.ring_corners),
        }
    }
}

/// A body that cuts or is united with others.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Cutter {
    pub(crate) count: FaceCount,
    /// Its box, if it is known: bodies that lie apart do not cross.
    pub(crate) extent: Option<Extent>,
    /// The axis of a prism: prisms along one axis are united in the plane, which is little work.
    pub(crate) axis: Option<Vector3<f64>>,
}

impl Cutter {
    /// Triangles of it that others may cross.
    fn n_crossing(&self) -> u64 {
        let n = self.count.triangles;
        if n <= TRIANGLES_OF_BOX { n } else { TRIANGLES_OF_BOX.saturating_mul(n).isqrt() }
    }

    fn crosses(&self, other: &Self) -> bool {
        let are_parallel = self.axis.zip(other.axis).is_some_and(|(a, b)| a.cross(&b).norm() < SINE_MIN);
        !are_parallel && self.extent.zip(other.extent).is_none_or(|(a, b)| a.meets(&b))
    }
}

/// Cutters of one body, and their work so far.
pub(crate) struct CrossingCutters {
    host: FaceCount,
    cutters: Vec<Cutter>,
    count: FaceCount,
    crossing_work: u64,
}

impl CrossingCutters {
    /// None yet, of a body of so many faces.
    pub(crate) fn of(host: FaceCount) -> Self {
        Self { host, cutters: Vec::new(), count: FaceCount::default(), crossing_work: 0 }
    }

    /// Adds a cutter, unless the work would be more than [`HARD_WORK_MAX`]. True if it did.
    pub(crate) fn admit(&mut self, cutter: Cutter) -> bool {
        let crossed = self.cutters.iter().filter(|other| cutter.crosses(other)).map(Cutter::n_crossing);
        let (sum, of_squares) = crossed.fold((0u64, 0u64), |(sum, of_squares), n| {
            (sum.saturating_add(n), of_squares.saturating_add(n.saturating_mul(n)))
        });
        let pairs = sum.saturating_mul(sum).saturating_sub(of_squares);
        let work = WORK_PER_CROSSING.saturating_mul(cutter.n_crossing()).saturating_mul(pairs);
        let crossing_work = self.crossing_work.saturating_add(work);
        let count = self.count.and(cutter.count);
        if crossing_work.saturating_add(ring_work(self.host, count)) > HARD_WORK_MAX {
            return false;
        }
        self.cutters.push(cutter);
        (self.count, self.crossing_work) = (count, crossing_work);
        true
    }

    /// Work of those that were admitted.
    pub(crate) fn work(&self) -> u64 {
        self.crossing_work.saturating_add(ring_work(self.host, self.count))
    }

    /// Triangles of the body and of those that were admitted.
    pub(crate) fn triangles(&self) -> u64 {
        self.host.and(self.count).triangles
    }
}

/// Most work of cutters of so many faces in all, whatever their boxes and axes are.
pub(crate) fn most_work(host: FaceCount, cutters: FaceCount) -> u64 {
    let n = cutters.triangles;
    let crossing_work = n.saturating_mul(n).saturating_mul(n).saturating_mul(WORK_PER_CROSSING) / 3;
    crossing_work.saturating_add(ring_work(host, cutters))
}

/// Holes of the body are work where those of a cutter meet them.
fn ring_work(host: FaceCount, cutters: FaceCount) -> u64 {
    let n = cutters.ring_corners.saturating_add(host.ring_corners.min(cutters.ring_corners));
    n.saturating_mul(n).saturating_mul(WORK_PER_RING_PAIR)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point3;

    fn cutter(at: f64, axis: [f64; 3], ring_corners: u64) -> Cutter {
        let extent = Extent { low: Point3::new(at, 0.0, 0.0), high: Point3::new(at + 1.0, 1.0, 1.0) };
        let count = FaceCount { triangles: 12, ring_corners };
        Cutter { count, extent: Some(extent), axis: Some(Vector3::from(axis).normalize()) }
    }

    fn n_admitted(host: FaceCount, cutters: impl Iterator<Item = Cutter>) -> usize {
        let mut admitted = CrossingCutters::of(host);
        cutters.take_while(|cutter| admitted.admit(*cutter)).count()
    }

    #[test]
    fn a_dozen_boxes_that_cross_each_other_are_the_limit_and_those_apart_or_parallel_have_none() {
        let wall = FaceCount { triangles: 12, ring_corners: 0 };
        let turned = |k: usize| [0.0, 1.0, 0.01 * k as f64];
        assert_eq!(n_admitted(wall, (0..200).map(|k| cutter(0.0, turned(k), 0))), 12);
        assert_eq!(n_admitted(wall, (0..200).map(|k| cutter(2.0 * k as f64, turned(k), 0))), 200);
        assert_eq!(n_admitted(wall, (0..200).map(|_| cutter(0.0, [0.0, 1.0, 0.0], 0))), 200);
        // Of round bodies few faces cross those of others.
        let round =
            |k: usize| Cutter { count: FaceCount { triangles: 300, ring_corners: 0 }, ..cutter(0.0, turned(k), 0) };
        assert_eq!(n_admitted(wall, (0..200).map(round)), 3);
    }

    #[test]
    fn inner_bounds_of_a_cutter_are_work_and_more_where_the_body_has_some() {
        let admits = |host, ring_corners| {
            let host = FaceCount { triangles: 12, ring_corners: host };
            n_admitted(host, std::iter::once(cutter(0.0, [0.0, 1.0, 0.0], ring_corners))) == 1
        };
        // Plates with 13 x 13 and 15 x 15 square holes.
        assert!(admits(0, 4 * 13 * 13) && !admits(0, 4 * 15 * 15));
        assert!(admits(4 * 9 * 9, 4 * 9 * 9) && !admits(4 * 13 * 13, 4 * 13 * 13));
        assert!(admits(100_000, 0));
    }

    #[test]
    fn the_most_work_is_no_less_than_that_of_the_cutters() {
        let host = FaceCount { triangles: 12, ring_corners: 40 };
        let cutters: Vec<Cutter> = (0..9).map(|k| cutter(0.0, [0.0, 1.0, 0.1 * f64::from(k)], 8)).collect();
        let mut admitted = CrossingCutters::of(host);
        assert!(cutters.iter().all(|cutter| admitted.admit(*cutter)));
        let all = cutters.iter().fold(FaceCount::default(), |sum, cutter| sum.and(cutter.count));
        assert!(admitted.work() <= most_work(host, all));
    }
}
