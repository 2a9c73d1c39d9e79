//! The shape of a body wherever it stands: bodies that differ by a translation have one.

use crate::mesh::MeshView;
use std::hash::{Hash, Hasher};

/// The meshes of a body; equal to those of another if they differ by a translation only.
#[derive(Debug, Clone)]
pub struct BodyShape<'a>(pub Vec<MeshView<'a>>);

impl BodyShape<'_> {
    /// The first vertex; zero without any.
    pub fn origin(&self) -> [i32; 3] {
        self.0.iter().flat_map(|m| m.vertices.first()).next().copied().unwrap_or_default()
    }

    fn vertices(&self) -> impl Iterator<Item = [i64; 3]> {
        let origin = self.origin().map(i64::from);
        self.0.iter().flat_map(|m| m.vertices).map(move |v| [0, 1, 2].map(|k| i64::from(v[k]) - origin[k]))
    }

    fn triangles(&self) -> impl Iterator<Item = &[[u32; 3]]> {
        self.0.iter().map(|m| m.triangles)
    }

    fn sizes(&self) -> impl Iterator<Item = (usize, bool)> {
        self.0.iter().map(|m| (m.vertices.len(), m.closed))
    }
}

impl Hash for BodyShape<'_> {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.vertices().for_each(|v| v.hash(state));
        self.triangles().for_each(|t| t.len().hash(state));
    }
}

impl PartialEq for BodyShape<'_> {
    fn eq(&self, other: &Self) -> bool {
        self.sizes().eq(other.sizes()) && self.triangles().eq(other.triangles()) && self.vertices().eq(other.vertices())
    }
}

impl Eq for BodyShape<'_> {}
