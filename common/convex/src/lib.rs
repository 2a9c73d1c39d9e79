//! Convex pieces of bodies and plans: boxes, prisms and hulls for simulators.
//!
//! Coordinates of meshes and plans are whole tenths of a millimetre in, those of pieces metres out. How a body is taken apart, from
//! the exact to the approximate: boxes and prisms between flat facets ([`convex_pieces`]), plates of sheets, hulls of a
//! decomposition; every piece says how it was made and how far it deviates.

mod columns;
mod components;
mod convex_partition;
mod facets;
mod fewer;
mod hulls;
mod options;
mod piece;
mod pieces;
mod sheets;
#[cfg(test)]
mod testing;

pub use convex_partition::convex_partition;
pub use options::PieceOptions;
pub use piece::{ConvexBox, Hull, Made, Piece, Shape};
pub use pieces::convex_pieces;
