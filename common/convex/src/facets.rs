//! The plane faces of a mesh.

use geometry::{MeshView, unit_normal};

/// Corners within this distance of a plane lie in it: 0.5 mm, the error of rounding and single-precision meshes.
pub(crate) const FLAT: f64 = 5.0;

/// Triangles of equal orientation in one plane. They need not touch.
#[derive(Debug, Clone)]
pub(crate) struct Facet {
    /// Unit normal.
    pub(crate) normal: [f64; 3],
    /// The plane: `normal . p = offset`, in tenths of a millimetre.
    pub(crate) offset: f64,
    /// Corners of its triangles.
    pub(crate) triangles: Vec<[[i32; 3]; 3]>,
    /// Maximum distance of a corner from the plane.
    pub(crate) deviation: f64,
}

impl Facet {
    /// Signed distance of a point from the plane.
    pub(crate) fn distance(&self, p: [i32; 3]) -> f64 {
        dot(self.normal, p.map(f64::from)) - self.offset
    }
}

pub(crate) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Groups the triangles for which `keep` is true by plane, largest first; corners may lie `flat` off the plane. `None` if
/// there are more than `max` planes.
///
/// Triangles too narrow to define a plane join a plane in which they lie, or are left out; their area is negligible.
pub(crate) fn facets(
    mesh: MeshView<'_>,
    max: usize,
    flat: f64,
    keep: impl Fn(&[[i32; 3]; 3]) -> bool,
) -> Option<Vec<Facet>> {
    let mut sorted: Vec<(f64, [[i32; 3]; 3])> =
        mesh.corners().filter(|t| keep(t)).map(|t| (area_doubled(&t), t)).collect();
    // Equal areas keep the order of the mesh.
    sorted.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut found: Vec<Facet> = Vec::new();
    for (_, triangle) in sorted {
        let Some(normal) = unit_normal(&triangle) else { continue };
        let lies_in = |f: &&mut Facet| {
            triangle.iter().all(|p| f.distance(*p).abs() <= flat) && (dot(f.normal, normal) > 0.0 || is_thin(&triangle))
        };
        if let Some(facet) = found.iter_mut().find(lies_in) {
            let off = triangle.iter().map(|p| facet.distance(*p).abs()).fold(0.0, f64::max);
            facet.deviation = facet.deviation.max(off);
            facet.triangles.push(triangle);
        } else if !is_thin(&triangle) {
            if found.len() == max {
                return None;
            }
            let offset = dot(normal, triangle[0].map(f64::from));
            found.push(Facet { normal, offset, triangles: vec![triangle], deviation: 0.0 });
        }
    }
    Some(found)
}

/// Twice the area, in square tenths of a millimetre.
fn area_doubled(triangle: &[[i32; 3]; 3]) -> f64 {
    let side = |k: usize| [0, 1, 2].map(|i| f64::from(triangle[k][i]) - f64::from(triangle[0][i]));
    let (u, v) = (side(1), side(2));
    let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    dot(n, n).sqrt()
}

/// True if the triangle is nowhere wider than [`FLAT`].
fn is_thin(triangle: &[[i32; 3]; 3]) -> bool {
    let longest = (0..3)
        .map(|k| {
            let d = [0, 1, 2].map(|i| f64::from(triangle[(k + 1) % 3][i]) - f64::from(triangle[k][i]));
            dot(d, d).sqrt()
        })
        .fold(0.0, f64::max);
    area_doubled(triangle) <= FLAT * longest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::cuboid;

    #[test]
    fn a_box_has_six_faces() {
        let (v, t) = cuboid([0; 3], [10_000, 20_000, 30_000]);
        let mesh = MeshView { vertices: &v, triangles: &t, closed: true };
        let found = facets(mesh, 10, FLAT, |_| true).unwrap();
        assert_eq!(found.len(), 6);
        assert!(found.iter().all(|f| f.triangles.len() == 2 && f.deviation == 0.0));
        assert!(facets(mesh, 5, FLAT, |_| true).is_none());
    }
}
