//! Every number that differences are judged by, in one place, each with its reason.
//!
//! Lengths in metres. Counts are of samples, which lie [`SAMPLE_M`] apart.

/// Distance between samples on the sides of an element: that of the cells of most SLAM maps.
pub(crate) const SAMPLE_M: f64 = 0.05;

/// SLAM maps of finer cells are made this coarse: between the beams of a lidar fine cells stay unknown.
pub(crate) const LEAST_CELL_M: f64 = 0.05;

/// A surface is a side's own if it is nearer than this, beside a cell and what the pose is uncertain by: plaster, skirting boards,
/// and what builders are allowed to be off by.
pub(crate) const SAME_SIDE_M: f64 = 0.1;

/// As far as a surface is looked for on both sides of where it should be. What was built farther off is another thing.
pub(crate) const REACH_M: f64 = 0.6;

/// How far in front of a surface the map must be known to be free, and unknown cells are passed over.
pub(crate) const FRONT_M: f64 = 0.15;

/// Rays that enter a solid this deep beyond the tolerance have not met it, however thick it is.
pub(crate) const DEEP_M: f64 = 0.3;

/// Share of free cells on a line that passes through a solid: the others may be unknown, none occupied.
pub(crate) const FREE_SHARE: f64 = 0.85;

/// A side is covered if another element is this near in front of it: no ray gets between them.
pub(crate) const GAP_M: f64 = 0.15;

/// What is as thin as this on another element cannot be told from it: linings that were gone were called observed.
pub(crate) const LAYER_M: f64 = 0.15;

/// Beside another element a side is not looked at: surfaces there may be those of the other.
pub(crate) const BESIDE_M: f64 = 0.2;

/// A surface away from the side itself is another element's if it is nearer than this to it, and less than so much of the distance
/// to the side: short walls that were gone seemed to stand where a neighbour's face is 9 cm from theirs.
pub(crate) const OTHERS_M: f64 = 0.12;
pub(crate) const OWN_M: f64 = 0.05;
pub(crate) const NEARER: f64 = 0.6;

/// Displacements are told from this on, beside [`UNCERTAIN`] times what the bend of the map is uncertain by. Of a straight wall a
/// median over half a metre is good to two centimetres; builders' tolerances, plaster and half a cell make the rest.
pub(crate) const LEAST_DISPLACED_M: f64 = 0.1;
pub(crate) const UNCERTAIN: f64 = 1.5;

/// Surfaces this near to a displacement support it.
pub(crate) const SUPPORT_M: f64 = 0.06;

/// Samples that support a displacement: 0.4 m, so that a column can have moved; and as much more than those that support the place
/// in the model. With 5 samples parts of kitchens were displaced.
pub(crate) const LEAST_SUPPORT: usize = 8;
pub(crate) const SUPPORT_RATIO: f64 = 1.3;

/// A displacement is that of most of the side: share of the samples in that direction that anything is known of.
pub(crate) const SUPPORT_SHARE: f64 = 0.5;

/// Of what was judged of an element that left its place at most this share is still met there: half of a column's sides slide along
/// themselves. Sofas and lifts have parts at many depths.
pub(crate) const MOST_IN_PLACE: f64 = 0.6;

/// A side that seems to stand nearer, without a look at the place in the model, may be furniture in front of it. So much of the
/// whole side must seem so, over this many samples (a metre), and the other side must not be in its place.
pub(crate) const COVERING_SHARE: f64 = 0.7;
pub(crate) const LEAST_COVERING: usize = 20;

/// An element is absent if this share of what was judged is seen through, that is at least half a metre of its sides, and this share
/// of all of them: through a hole alone nothing is said of the rest.
pub(crate) const ABSENT_SHARE: f64 = 0.7;
pub(crate) const LEAST_ABSENT: usize = 10;
pub(crate) const ABSENT_OF_ALL: f64 = 0.25;

/// An element is observed if at least this share of what was judged is in its place, so many samples (0.3 m), and either a metre or this
/// share of all: of two short walls that were gone a sixth and a third seemed to stand, because of what stood beside them.
pub(crate) const OBSERVED_SHARE: f64 = 0.5;
pub(crate) const LEAST_OBSERVED: usize = 6;
pub(crate) const SURELY_OBSERVED: usize = 20;
pub(crate) const OBSERVED_OF_ALL: f64 = 0.4;

/// An element that should not be there yet needs more, because furniture and scaffolds stand anywhere: a metre, and this share
/// of all of its sides.
pub(crate) const LEAST_EARLY: usize = 20;
pub(crate) const EARLY_OF_ALL: f64 = 0.3;
pub(crate) const EARLY_SHARE: f64 = 0.7;

/// The bend of a SLAM map is told for squares of this side, from surfaces around them, weighted by distance.
pub(crate) const BEND_CELL_M: f64 = 1.0;
pub(crate) const BEND_SIGMA_M: f64 = 2.0;
/// Bends are looked for up to this: the drift of maps that can be aligned at all.
pub(crate) const MOST_BENT_M: f64 = 0.4;
/// A map may be bent by this before anything is known of it, and at least by this: half a cell.
pub(crate) const BENT_M: f64 = 0.1;
pub(crate) const LEAST_BENT_M: f64 = 0.02;
/// Deviation of a surface from a bent model, and how many samples say the same: half a metre of a wall.
pub(crate) const NOISE_M: f64 = 0.03;
pub(crate) const ALIKE: f64 = 10.0;
/// Deviation of an element from its place as far as the bend is concerned: it takes several elements to tell a bend from one that
/// was built elsewhere.
pub(crate) const BUILT_M: f64 = 0.05;

/// Obstacles are told from this size on: 0.3 m long or 0.1 m² of cells, and more than a stray hit or two.
pub(crate) const LEAST_LENGTH_M: f64 = 0.3;
pub(crate) const LEAST_AREA_M2: f64 = 0.1;
pub(crate) const LEAST_CELLS: usize = 4;
/// What stands this far above or below the lidar's plane explains a surface, too: floors are uneven and robots tilt.
pub(crate) const PLANE_M: f64 = 0.1;
/// Obstacles are looked for this far outside of the storey's bounds: beyond it is not the site of the model.
pub(crate) const OUTSIDE_M: f64 = 0.5;
