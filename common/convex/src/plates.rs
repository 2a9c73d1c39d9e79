//! Thin plates for surfaces without thickness.

use crate::convex_partition::convex_partition;
use crate::facets::{FLAT, Facet, dot, facets};
use crate::piece::{Hull, cross, length};
use geometry::MeshView;
use geometry::{FillRule, union};
use geometry::{Ring, ring_area_doubled};

/// Maximum number of planes for exact plates, and for any plates.
const MAX_PLANES: [usize; 2] = [96, 256];

/// Half the thickness of a plate: 1 mm.
const HALF_THICKNESS: f64 = 10.0;

/// Thin convex plates along the faces of a mesh, and their maximum distance (tenths of a millimetre) from it; `None` if
/// there are too many. If there are many, faces within one of the `tolerances` of a plane share a plate.
pub(crate) fn plates(mesh: MeshView<'_>, tolerances: [f64; 2]) -> Option<(Vec<Hull>, f64)> {
    let exact = facets(mesh, MAX_PLANES[0], FLAT, |_| true);
    let shared = || tolerances.iter().find_map(|t| facets(mesh, MAX_PLANES[1], t.max(FLAT), |_| true));
    let found = exact.or_else(shared)?;
    let deviation = HALF_THICKNESS + found.iter().map(|f| f.deviation).fold(0.0, f64::max);
    let mut plates = Vec::new();
    for facet in &found {
        let is_behind = |other: &&Facet| {
            std::ptr::eq(*other, facet) || (dot(other.normal, facet.normal) < -0.999 && lies_on(other, facet))
        };
        // A two-sided sheet is one plate.
        if !std::ptr::eq(found.iter().find(is_behind).unwrap_or(facet), facet) {
            continue;
        }
        plates.extend(plates_of(facet));
    }
    Some((plates, deviation))
}

fn lies_on(other: &Facet, facet: &Facet) -> bool {
    other.triangles.iter().flatten().all(|p| facet.distance(*p).abs() <= HALF_THICKNESS)
}

fn plates_of(facet: &Facet) -> Vec<Hull> {
    let normal = facet.normal;
    let least = (0..3).min_by(|a, b| normal[*a].abs().total_cmp(&normal[*b].abs())).unwrap_or(0);
    let mut helper = [0.0; 3];
    helper[least] = 1.0;
    let u = cross(helper, normal);
    let u = u.map(|c| c / length(u));
    let v = cross(normal, u);
    let ring = |t: &[[i32; 3]; 3]| {
        let mut ring: Ring = t.iter().map(|p| [u, v].map(|a| dot(a, p.map(f64::from)).round() as i32)).collect();
        if ring_area_doubled(&ring) < 0 {
            ring.reverse();
        }
        ring
    };
    let plan = union(&facet.triangles.iter().map(ring).collect::<Vec<_>>(), FillRule::NonZero);
    let ends = [facet.offset - HALF_THICKNESS, facet.offset + HALF_THICKNESS];
    let plate = |plan: Ring| {
        let corners: Vec<[f64; 4]> =
            plan.iter().map(|p| [f64::from(p[0]), f64::from(p[1]), ends[0], ends[1]]).collect();
        // `between` gives metres along u, v and the normal.
        Hull::between(corners.into_iter()).mapped(|p| [0, 1, 2].map(|k| p[0] * u[k] + p[1] * v[k] + p[2] * normal[k]))
    };
    convex_partition(&plan).into_iter().map(plate).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_sheet_is_one_thin_box() {
        let v = [[0, 0, 0], [10_000, 0, 0], [10_000, 0, 10_000], [0, 0, 10_000]];
        for triangles in [vec![[0, 1, 2], [0, 2, 3]], vec![[0, 1, 2], [0, 2, 3], [0, 2, 1], [0, 3, 2]]] {
            let mesh = MeshView { vertices: &v, triangles: &triangles, closed: triangles.len() == 4 };
            let (found, deviation) = plates(mesh, [200.0, 500.0]).unwrap();
            assert_eq!((found.len(), deviation), (1, HALF_THICKNESS));
            let mut size = found[0].as_box().unwrap().size_m;
            size.sort_by(f64::total_cmp);
            assert!([0.002, 1.0, 1.0].iter().zip(size).all(|(a, b)| (a - b).abs() < 1e-9), "{size:?}");
        }
    }
}
