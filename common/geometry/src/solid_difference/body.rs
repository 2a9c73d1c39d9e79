//! Bodies of a difference: closed, outward, and with corners on the planes of others that they are next to.

use super::face_plane::{Facet, SLIVER_M};
use super::outlined::without_gaps;
use super::solid::{Extent, NEAR_M, Solid};
use crate::vertex_welder::VertexWelder;

/// Corners of a cutter at most so far from a plane of another body are put on it: thinner skins are in no archive.
const SNAP_M: f64 = 1e-4;

/// Planes of a body on which corners of others are put.
const MAX_PLANES_OF_SNAPS: usize = 256;

/// A closed solid whose faces look outward.
pub(super) struct Body {
    pub(super) solid: Solid,
    pub(super) extent: Extent,
    /// Planes of its larger triangles.
    pub(super) planes: Vec<Facet>,
}

impl Body {
    /// `None` if the solid is not closed or encloses nothing.
    pub(super) fn of(solid: &Solid) -> Option<Self> {
        let mut welder = VertexWelder::new(NEAR_M);
        let ids: Vec<u32> = solid.positions.iter().map(|p| welder.add(*p)).collect();
        let welded = solid.triangles.iter().map(|t| t.map(|k| ids[k as usize]));
        let triangles: Vec<[u32; 3]> = welded.filter(|[a, b, c]| a != b && b != c && c != a).collect();
        let mut solid = Solid { positions: welder.into_positions(), triangles };
        if !solid.is_closed() {
            // Faces that were triangulated apart have corners on each other's edges.
            solid = without_gaps(solid, NEAR_M)?;
        }
        let volume_m3 = solid.volume_m3();
        if volume_m3.abs() < 1e-9 {
            return None;
        }
        if volume_m3 < 0.0 {
            solid.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        let mut planes: Vec<Facet> = Vec::new();
        for triangle in &solid.triangles {
            let corners = solid.corners(*triangle);
            let Some((facet, _)) = Facet::of(corners).filter(|(_, height)| *height > SLIVER_M) else { continue };
            match planes.iter_mut().take(MAX_PLANES_OF_SNAPS).find(|plane| plane.has(&corners)) {
                Some(plane) => plane.extent = plane.extent.and(&facet.extent),
                None => planes.push(facet),
            }
        }
        planes.truncate(MAX_PLANES_OF_SNAPS);
        Some(Self { extent: Extent::of(&solid.positions), solid, planes })
    }
}

/// A cutter whose corners that are next to planes of other bodies are on them.
pub(super) fn snapped(cutter: &Solid, bodies: &[Body]) -> Option<Solid> {
    let mut cutter = cutter.clone();
    let extent = Extent::of(&cutter.positions);
    let near = bodies.iter().filter(|body| body.extent.meets(&extent)).flat_map(|body| &body.planes);
    let planes: Vec<&Facet> = near.filter(|plane| plane.extent.is_within(&extent, SNAP_M)).collect();
    if !cutter.positions.iter().flat_map(|p| p.iter()).all(|c| c.is_finite()) {
        return None;
    }
    for p in &mut cutter.positions {
        // Planes that are not at right angles move a corner off each other.
        for _ in 0..3 {
            for plane in planes.iter().filter(|plane| plane.extent.is_near(p, SNAP_M)).copied().collect::<Vec<_>>() {
                let distance = plane.distance(p);
                if distance != 0.0 && distance.abs() <= SNAP_M {
                    *p -= plane.normal * distance;
                }
            }
        }
    }
    Some(cutter)
}
