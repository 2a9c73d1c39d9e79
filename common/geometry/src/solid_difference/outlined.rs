//! Solids as outlines of faces on planes, and their meshes without gaps.

use super::face_plane::{FacePlane, Facet};
use super::solid::{Extent, NEAR_M, Solid};
use crate::polygon::{MultiPolygon, Point, Ring};
use crate::triangulated::triangulated_with_all_points;
use crate::vertex_welder::VertexWelder;
use nalgebra::Point3;
use std::collections::BTreeMap;

/// Corners of the difference at most so far from each other are one: planes that cross at a small angle move them.
pub(super) const WELD_M: f64 = 4e-5;

/// Gaps at most so wide are closed: a tenth of a millimetre and its diagonal.
const GAP_M: f64 = 2e-4;

/// A face of the difference: rings of vertices, and whether it looks along the normal of its plane.
pub(super) struct Outline {
    pub(super) plane: usize,
    pub(super) rings: Vec<Vec<u32>>,
    pub(super) looks_along: bool,
}

/// The difference as outlines on planes.
pub(super) struct Outlined {
    pub(super) planes: Vec<FacePlane>,
    pub(super) welder: VertexWelder,
    pub(super) outlines: Vec<Outline>,
    /// Triangles that get the vertices on their edges.
    pub(super) split: Vec<[u32; 3]>,
    /// Triangles that stay as they are.
    pub(super) whole: Vec<[u32; 3]>,
}

impl Outlined {
    pub(super) fn add(&mut self, plane: usize, region: &MultiPolygon, looks_along: bool) {
        for polygon in &region.0 {
            let mut ring_of = |ring: &Ring| -> Vec<u32> {
                let mut ring: Vec<u32> =
                    ring.iter().map(|p| self.welder.add(self.planes[plane].in_space(*p))).collect();
                ring.dedup();
                while ring.len() > 1 && ring.first() == ring.last() {
                    ring.pop();
                }
                ring
            };
            let exterior = ring_of(&polygon.exterior);
            if exterior.len() < 3 {
                continue;
            }
            let holes = polygon.holes.iter().map(&mut ring_of).filter(|ring| ring.len() > 2);
            let rings = std::iter::once(exterior).chain(holes.collect::<Vec<_>>()).collect();
            self.outlines.push(Outline { plane, rings, looks_along });
        }
    }

    /// The difference as a closed mesh; `None` if it is none.
    pub(super) fn closed(self) -> Option<Solid> {
        let solid = self.mesh(WELD_M)?;
        if solid.is_closed() { Some(solid) } else { without_gaps(solid, GAP_M) }
    }

    /// The difference as a mesh with all vertices that are so near to edges on them.
    pub(super) fn mesh(mut self, reach: f64) -> Option<Solid> {
        let mut of_split = Vec::new();
        let edges = EdgeSplitter::of(&self, reach);
        let mut triangles = std::mem::take(&mut self.whole);
        for triangle in std::mem::take(&mut self.split) {
            let ring = edges.split(&triangle, self.welder.positions());
            if ring.len() == 3 {
                triangles.push(triangle);
            } else {
                of_split.push((triangle, ring));
            }
        }
        for outline in &mut self.outlines {
            for ring in &mut outline.rings {
                *ring = edges.split(ring, self.welder.positions());
            }
        }
        for ([a, b, c], ring) in of_split {
            let corners = [a, b, c].map(|k| self.welder.positions()[k as usize]);
            // A triangle without area whose longest edge has its third corner on it: both sides of it are one line.
            let Some((facet, _)) = Facet::of(corners).filter(|(_, height)| *height > reach) else { continue };
            self.planes.push(FacePlane::new(facet));
            self.outlines.push(Outline { plane: self.planes.len() - 1, rings: vec![ring], looks_along: true });
        }
        for outline in std::mem::take(&mut self.outlines) {
            self.triangulate(&outline, &mut triangles)?;
        }
        Some(Solid { positions: self.welder.into_positions(), triangles }.compact())
    }

    pub(super) fn triangulate(&mut self, outline: &Outline, triangles: &mut Vec<[u32; 3]>) -> Option<()> {
        let plane = &self.planes[outline.plane];
        let mut ids: BTreeMap<Point, u32> = BTreeMap::new();
        let mut rings = Vec::new();
        for ring in &outline.rings {
            let positions = self.welder.positions();
            let points: Ring =
                ring.iter().map(|id| plane.on_lattice(&positions[*id as usize])).collect::<Option<_>>()?;
            ids.extend(std::iter::zip(points.iter().copied(), ring.iter().copied()));
            rings.push(points);
        }
        for triangle in triangulated_with_all_points(&rings) {
            let [a, b, c] = triangle
                .map(|p| *ids.entry(p).or_insert_with(|| self.welder.add(self.planes[outline.plane].in_space(p))));
            if a != b && b != c && c != a {
                triangles.push(if outline.looks_along { [a, b, c] } else { [a, c, b] });
            }
        }
        Some(())
    }
}

/// The same with one vertex where ends of open edges are near each other, and corners that lie on edges in both faces;
/// `None` if it is not closed then.
pub(super) fn without_gaps(solid: Solid, reach: f64) -> Option<Solid> {
    let open = solid.open_vertices();
    let mut welder = VertexWelder::new(reach);
    let of_open: BTreeMap<u32, u32> = open.into_iter().map(|k| (k, welder.add(solid.positions[k as usize]))).collect();
    let mut first: BTreeMap<u32, u32> = BTreeMap::new();
    let ids: Vec<u32> = (0..solid.positions.len() as u32)
        .map(|k| of_open.get(&k).map_or(k, |place| *first.entry(*place).or_insert(k)))
        .collect();
    let welded = solid.triangles.iter().map(|t| t.map(|k| ids[k as usize]));
    let welded = welded.filter(|[a, b, c]| a != b && b != c && c != a);
    let at_gap = |t: &[u32; 3]| t.iter().filter(|k| of_open.contains_key(*k)).count() > 1;
    let (split, whole) = welded.partition(at_gap);
    let welder = VertexWelder::of(NEAR_M, solid.positions);
    let solid = Outlined { planes: Vec::new(), welder, outlines: Vec::new(), split, whole }.mesh(reach)?;
    solid.is_closed().then_some(solid)
}

/// Finds the vertices that lie on edges.
struct EdgeSplitter {
    /// Vertices in use, by their coordinate along the axis.
    sorted: Vec<(f64, u32)>,
    axis: usize,
    reach: f64,
}

impl EdgeSplitter {
    fn of(difference: &Outlined, reach: f64) -> Self {
        let positions = difference.welder.positions();
        let of_outlines = difference.outlines.iter().flat_map(|outline| outline.rings.iter().flatten());
        let mut used: Vec<u32> =
            of_outlines.chain(difference.split.iter().chain(&difference.whole).flatten()).copied().collect();
        used.sort_unstable();
        used.dedup();
        let Extent { low, high } = Extent::of(used.iter().map(|k| &positions[*k as usize]));
        let axis = if used.is_empty() { 0 } else { (high - low).imax() };
        let mut sorted: Vec<(f64, u32)> = used.into_iter().map(|k| (positions[k as usize][axis], k)).collect();
        sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
        Self { sorted, axis, reach }
    }

    /// The ring with all vertices that lie on its edges.
    fn split(&self, ring: &[u32], positions: &[Point3<f64>]) -> Vec<u32> {
        let mut all = Vec::with_capacity(ring.len());
        for (k, &from) in ring.iter().enumerate() {
            let to = ring[(k + 1) % ring.len()];
            all.push(from);
            let [a, b] = [from, to].map(|k| positions[k as usize]);
            let (along, length) = (b - a, (b - a).norm());
            if length <= 2.0 * self.reach {
                continue;
            }
            let along = along / length;
            let (low, high) =
                (a[self.axis].min(b[self.axis]) - self.reach, a[self.axis].max(b[self.axis]) + self.reach);
            let first = self.sorted.partition_point(|v| v.0 < low);
            let near = self.sorted[first..].iter().take_while(|v| v.0 <= high).filter(|v| v.1 != from && v.1 != to);
            let mut on_edge: Vec<(f64, u32)> = near
                .filter_map(|&(_, vertex)| {
                    let offset = positions[vertex as usize] - a;
                    let at = offset.dot(&along);
                    let is_on = 0.0 < at && at < length && (offset - along * at).norm() <= self.reach;
                    is_on.then_some((at, vertex))
                })
                .collect();
            on_edge.sort_by(|a, b| a.0.total_cmp(&b.0));
            all.extend(on_edge.into_iter().map(|(_, vertex)| vertex));
        }
        all
    }
}
