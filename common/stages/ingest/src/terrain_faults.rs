//! Faces of terrain that carry nobody: without area, vertical, turned over.

use geometry::{MeshView, unit_normal};

/// Steeper faces of an open surface count as vertical: 85 degrees.
const UPRIGHT: f64 = 0.087;

/// What of the faces of terrain carries nobody.
#[derive(Debug, Default)]
pub(crate) struct FaceFaults {
    n_without_area: usize,
    n_vertical: usize,
    /// Of open parts: turned otherwise than most of their part.
    n_turned: usize,
    /// Area in plan of all faces.
    pub(crate) plan_m2: f64,
}

impl FaceFaults {
    pub(crate) fn of<'a>(meshes: impl Iterator<Item = MeshView<'a>>) -> Self {
        let mut faults = Self::default();
        for mesh in meshes {
            let (mut n_up, mut n_down, mut n_vertical) = (0, 0, 0);
            for triangle in mesh.corners() {
                let d = |k: usize, i: usize| f64::from(triangle[k][i]) - f64::from(triangle[0][i]);
                faults.plan_m2 += (d(1, 0) * d(2, 1) - d(2, 0) * d(1, 1)).abs() / 2.0 / 1e8;
                match unit_normal(&triangle).map(|normal| normal[2]) {
                    None => faults.n_without_area += 1,
                    Some(z) if z.abs() < UPRIGHT => n_vertical += 1,
                    Some(z) if z > 0.0 => n_up += 1,
                    Some(_) => n_down += 1,
                }
            }
            // A solid has all kinds of faces.
            if !mesh.closed {
                faults.n_turned += usize::min(n_up, n_down);
                faults.n_vertical += n_vertical;
            }
        }
        faults
    }

    /// What is to be told of a terrain of so many triangles.
    pub(crate) fn message(&self, n_triangles: usize) -> Option<String> {
        let faults = [
            (self.n_without_area, "without area"),
            (self.n_vertical, "vertical"),
            (self.n_turned, "turned over or folded"),
        ];
        let told: Vec<String> = faults.iter().filter(|(n, _)| *n > 0).map(|(n, what)| format!("{n} {what}")).collect();
        (!told.is_empty()).then(|| format!("of its triangles ({n_triangles}): {}", told.join(", ")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(triangles: &[[u32; 3]]) -> Option<String> {
        let vertices = [[0, 0, 0], [10_000, 0, 0], [0, 10_000, 0], [0, 0, 10_000], [10_000, 10_000, 0]];
        let mesh = MeshView { vertices: &vertices, triangles, closed: false };
        FaceFaults::of(std::iter::once(mesh)).message(triangles.len())
    }

    #[test]
    fn faces_without_use_are_counted_by_what_is_wrong_with_them() {
        assert_eq!(message(&[[0, 1, 2], [1, 4, 2]]), None);
        let all = message(&[[0, 1, 2], [2, 4, 1], [1, 4, 2], [0, 1, 3], [0, 0, 1]]).unwrap();
        assert_eq!(all, "of its triangles (5): 1 without area, 1 vertical, 1 turned over or folded");
    }
}
