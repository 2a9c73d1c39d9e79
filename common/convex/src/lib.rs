//! Convex pieces of bodies and plans: boxes, prisms and hulls for simulators.
//!
//! Input coordinates of meshes and plans are whole tenths of a millimetre, those of pieces metres. [`convex_pieces`]
//! decomposes a body, from exact to approximate, into boxes and prisms between plane faces, plates for sheets, or hulls of
//! an approximate decomposition; every piece has its origin and its deviation.
//!
//! # Guarantees
//!
//! - Pieces are exact wherever faces are plane: over the plan of a face that looks down, up to the first face that looks up,
//!   is material.
//! - Of an element with more than `element_max` pieces neighbours are joined, and the result says how far off it is.
//! - Hulls are those of the library where they are closed and convex on the lattice of files (hundredths of a millimetre),
//!   else computed by exact integers (`src/lattice_hull.rs`).
//!
//! # Where
//!
//! - convex pieces of a body: `src/pieces.rs`, `src/prisms.rs`, `src/hulls.rs`, `src/plates.rs`, `src/piece_merging.rs`

mod components;
mod convex_partition;
mod facets;
mod hulls;
mod lattice_hull;
mod options;
mod piece;
mod piece_merging;
mod pieces;
mod plates;
mod prisms;
mod soundness;
#[cfg(test)]
mod testing;

pub use convex_partition::convex_partition;
pub use lattice_hull::{LATTICE_PER_M, LatticeHull, PLATE_M, lattice_hull, lattice_plate};
pub use options::PieceOptions;
pub use piece::{ConvexBox, Hull, Made, Piece, Shape};
pub use pieces::convex_pieces;
pub use soundness::{dents_m, is_closed_and_convex};
