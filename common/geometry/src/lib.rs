//! Meshes, slabs, sections, footprints, floor faces: one question per file.
//!
//! Coordinates are whole tenths of a millimetre (`frames::tenths`) but those of solids that are cut, so that faces on one plane stay on it and results
//! do not depend on noise. This crate knows no IFC, no grid and no file.
//!
//! # Guarantees
//!
//! - The planes of a slab lie half a unit inside its bounds: no vertex is ever on them.
//! - Rings that meet neither themselves nor each other need no overlay (`src/simple_rings.rs`): most sections are such.
//! - The footprint of a closed mesh is the plan of its clipped faces and one section. Meshes with gaps are cut at several
//!   levels, and upright sheets are lines that stop a robot.
//! - The difference of solids (`src/solid_difference`), which is made before coordinates are rounded, is closed or refused.

mod body_shape;
mod clusters;
mod decimated;
mod disjoint_sets;
mod floor_faces;
mod footprint;
mod mesh;
mod oriented_box;
mod overlay;
mod plane;
mod polygon;
mod section;
mod simple_parts;
mod simple_rings;
mod simplified;
mod slab;
mod slopes;
mod solid_difference;
mod surfaces;
mod treads;
mod triangle_distance;
mod triangle_tree;
mod triangulated;
mod vertex_welder;

pub use body_shape::BodyShape;
pub use decimated::{Decimated, decimated};
pub use disjoint_sets::DisjointSets;
pub use floor_faces::{floor_faces, upward_triangles};
pub use footprint::{Footprint, LazyFootprint, SlabCut, footprint};
pub use mesh::{MeshView, is_closed, unit_normal};
pub use oriented_box::OrientedBox;
pub use overlay::{FillRule, close_gaps, difference, intersection, offset, union, union_of};
pub use plane::Plane;
pub use polygon::{Bounds, MultiPolygon, Point, Polygon, Ring, edges, ring_area_doubled};
pub use section::{Section, section};
pub use simple_parts::simple_parts;
pub use simplified::simplified;
pub use slab::{Slab, clip_to_slab};
pub use slopes::ramp_faces;
pub use solid_difference::{Solid, difference_of_solids};
pub use surfaces::{SurfacePoint, Surfaces, surface_points};
pub use treads::{Tread, treads};
pub use triangle_tree::{NearestBody, TriangleTree};
pub use triangulated::triangulated;
