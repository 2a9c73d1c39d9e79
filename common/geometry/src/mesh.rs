//! Triangle meshes as archives hold them.

use crate::polygon::Bounds;

/// True if every edge is passed as often in either direction, by vertex position.
///
/// Then the faces bound a solid, and horizontal sections consist of closed rings.
pub fn is_closed(vertices: &[[i32; 3]], triangles: &[[u32; 3]]) -> bool {
    let mut edges: Vec<([i32; 3], [i32; 3], i32)> = triangles
        .iter()
        .flat_map(|t| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])])
        .map(|(a, b)| (vertices[a as usize], vertices[b as usize]))
        .filter(|(a, b)| a != b)
        .map(|(a, b)| if a < b { (a, b, 1) } else { (b, a, -1) })
        .collect();
    edges.sort_unstable();
    edges.chunk_by(|e, f| (e.0, e.1) == (f.0, f.1)).all(|same| same.iter().map(|e| e.2).sum::<i32>() == 0)
}

/// A borrowed triangle mesh; vertices in tenths of a millimetre, outward faces counter-clockwise.
#[derive(Debug, Clone, Copy)]
pub struct MeshView<'a> {
    /// Vertex positions.
    pub vertices: &'a [[i32; 3]],
    /// Vertex indices, each below `vertices.len()`.
    pub triangles: &'a [[u32; 3]],
    /// True if every edge is passed as often in either direction.
    pub closed: bool,
}

impl<'a> MeshView<'a> {
    /// The corners of every triangle.
    pub fn corners(self) -> impl Iterator<Item = [[i32; 3]; 3]> + 'a {
        self.triangles.iter().map(move |t| t.map(|i| self.vertices[i as usize]))
    }

    /// Lowest and highest vertex; `None` without vertices.
    pub fn z_range(self) -> Option<(i32, i32)> {
        let z = || self.vertices.iter().map(|v| v[2]);
        Some((z().min()?, z().max()?))
    }

    /// Bounds in plan; `None` without vertices.
    pub fn plan_bounds(self) -> Option<Bounds> {
        Bounds::of(self.vertices.iter().map(|v| [v[0], v[1]]))
    }

    /// Signed volume in cubic metres around the middle of the vertices; negative if the faces look inward.
    pub fn volume_m3(self) -> f64 {
        let Some(origin) = self.vertices.first() else { return 0.0 };
        let metres =
            |v: [i32; 3]| [0, 1, 2].map(|k| (f64::from(v[k]) - f64::from(origin[k])) / f64::from(frames::TENTHS_PER_M));
        self.corners()
            .map(|t| {
                let [a, b, c] = t.map(metres);
                (a[0] * (b[1] * c[2] - b[2] * c[1])
                    + a[1] * (b[2] * c[0] - b[0] * c[2])
                    + a[2] * (b[0] * c[1] - b[1] * c[0]))
                    / 6.0
            })
            .sum()
    }
}
