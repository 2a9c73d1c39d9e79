//! Upward faces of floor elements between two heights, as polygons in plan.

use crate::model::cell_area::cells_around;
use crate::model::storey_slice::FloorPiece;
use geometry::{Ring, floor_faces};
use grid::GridSpec;
use messages::{ElementRecord, Site, element_flags};

/// Faces in the robot's slab steeper than this belong to a ramp or a roof, not to the floor of another level.
pub(crate) const LEVEL_SLOPE_RAD: f64 = 0.01;

/// Upward faces between two heights.
pub(crate) fn floor_pieces(site: &Site<'_>, spec: &GridSpec, heights: [i32; 2], max_slope_rad: f64) -> Vec<FloorPiece> {
    let [lowest, highest] = heights;
    let is_near = |e: &ElementRecord| e.min_tenths[2] <= highest && lowest <= e.max_tenths[2];
    let elements = site.elements.iter().enumerate().filter(|(_, e)| e.has(element_flags::FLOOR) && is_near(e));
    let pieces = elements.map(|(k, e)| {
        let faces = |mesh| floor_faces(mesh, lowest, highest, max_slope_rad);
        let rings: Vec<Ring> = site.element_meshes(e).flat_map(faces).collect();
        let rect = cells_around(rings.iter().flatten().map(|p| p.map(f64::from)), 0.0, spec);
        FloorPiece { element: k as u32, rings, rect }
    });
    pieces.filter(|p| !p.rings.is_empty()).collect()
}
