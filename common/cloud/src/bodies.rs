//! Bodies that fill cells of an octree: their triangles, and whether a place lies within them.

use crate::lattice::Seen;
use geometry::MeshView;

/// What a body does to the cells in it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Effect {
    /// They are occupied.
    Occupied,
    /// They are not known, whatever else is said of them but that they are occupied.
    Unknown,
    /// They are free.
    Free,
}

/// Triangles of a strip, at least; and strips, at most.
const PER_STRIP: usize = 8;
const MAX_STRIPS: usize = 256;

/// A mesh with its effect.
pub(crate) struct Filling<'a> {
    mesh: MeshView<'a>,
    pub(crate) effect: Effect,
    /// True if it encloses something; else it is a sheet.
    pub(crate) is_solid: bool,
    /// Strips along x, each with the triangles over it: those that a line along z can meet.
    low: i64,
    width: i64,
    strips: Vec<Vec<u32>>,
}

impl<'a> Filling<'a> {
    pub(crate) fn of(mesh: MeshView<'a>, effect: Effect) -> Self {
        let is_solid = mesh.closed && mesh.volume_m3() != 0.0;
        let mut filling = Self { mesh, effect, is_solid, low: 0, width: 1, strips: Vec::new() };
        if let (true, Some(bounds)) = (is_solid, mesh.plan_bounds()) {
            let n = (mesh.triangles.len() / PER_STRIP).clamp(1, MAX_STRIPS);
            filling.low = i64::from(bounds.min[0]);
            filling.width = (i64::from(bounds.max[0]) - filling.low) / n as i64 + 1;
            filling.strips = vec![Vec::new(); n];
            for (k, t) in (0..).zip(mesh.corners()) {
                let x = t.map(|p| i64::from(p[0]));
                let [from, to] = [x[0].min(x[1]).min(x[2]), x[0].max(x[1]).max(x[2])].map(|x| filling.strip(x));
                filling.strips[from..=to].iter_mut().for_each(|strip| strip.push(k));
            }
        }
        filling
    }

    fn strip(&self, x: i64) -> usize {
        ((x - self.low) / self.width) as usize
    }

    pub(crate) fn n_triangles(&self) -> u32 {
        self.mesh.triangles.len() as u32
    }

    pub(crate) fn triangle(&self, k: u32) -> [[i32; 3]; 3] {
        self.mesh.triangles[k as usize].map(|corner| self.mesh.vertices[corner as usize])
    }

    /// True if a place that is not on its surface lies within the solid: faces above it look out of the body more often than into it,
    /// or less often where it is wound inwards.
    pub(crate) fn contains(&self, place: [i64; 3]) -> bool {
        let is_beside = place[0] < self.low || self.strip(place[0]) >= self.strips.len();
        if !self.is_solid || is_beside {
            return false;
        }
        let above = self.strips[self.strip(place[0])].iter().filter_map(|&k| {
            let (seen, sign) = Seen::of(self.triangle(k), 2)?;
            let depth = seen.depth_at([place[0], place[1]])?;
            (i64::from(depth) > place[2]).then_some(i32::from(sign))
        });
        above.sum::<i32>() != 0
    }
}
