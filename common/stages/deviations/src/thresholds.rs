//! All thresholds of the comparison, each with its reason.
//!
//! Lengths in metres. Counts are of samples, which lie [`SAMPLE_M`] apart.

/// Distance between samples on the sides of an element: that of the cells of most SLAM maps.
pub(crate) const SAMPLE_M: f64 = 0.05;

/// SLAM maps of finer cells are made this coarse: between the beams of a lidar fine cells stay unknown.
pub(crate) const MIN_CELL_M: f64 = 0.05;

/// A surface is a side's own if it is nearer than this, beside a cell and what the pose is uncertain by: plaster, skirting boards,
/// and what builders are allowed to be off by.
pub(crate) const SAME_SIDE_M: f64 = 0.1;

/// Maximum distance of a surface from its place in the model, to both sides. Farther surfaces belong to other elements.
pub(crate) const REACH_M: f64 = 0.6;

/// Distance in front of a surface that must be known and free; unknown cells are skipped.
pub(crate) const FRONT_M: f64 = 0.15;

/// Rays that enter a solid this deep beyond the tolerance have passed it, independent of its thickness.
pub(crate) const DEEP_M: f64 = 0.3;

/// Distance behind a solid that is seen through over which a line goes on as free, if it does not end at a surface.
pub(crate) const BEYOND_M: f64 = 0.3;

/// Share of free cells on a line that passes through a solid: the others may be unknown, none occupied.
pub(crate) const FREE_SHARE: f64 = 0.85;

/// A side is covered if another element is this near in front of it: no ray gets between them.
pub(crate) const GAP_M: f64 = 0.15;

/// Layers as thin as this on another element cannot be distinguished from it: missing linings were reported as observed.
pub(crate) const LAYER_M: f64 = 0.15;

/// Elements that touch along this share of the border of one of them, with gaps no wider than that, are leafs of one wall: a long
/// side is nearly half of the border of a leaf, an end of a wall hardly a tenth.
pub(crate) const LEAF_SHARE: f64 = 0.35;
pub(crate) const LEAF_GAP_M: f64 = 0.03;

/// Sides this near to another element are not sampled: surfaces there may belong to the other.
pub(crate) const BESIDE_M: f64 = 0.2;

/// A surface away from the side itself is another element's if it is nearer than this to it, and less than so much of the distance
/// to the side: short walls that were gone seemed to stand where a neighbour's face is 9 cm from theirs.
pub(crate) const OTHERS_M: f64 = 0.12;
pub(crate) const OWN_M: f64 = 0.05;
pub(crate) const NEARER: f64 = 0.6;

/// Minimum displacement, in addition to [`UNCERTAIN`] times the standard deviation of the distortion. Of a straight wall a
/// median over half a metre is good to two centimetres; builders' tolerances, plaster and half a cell make the rest. Of 428
/// simulated elements in their place one in a hundred seems to be off by 0.09 m where the deviation is below 0.09 m, and by
/// 0.24 m where it is larger; with 2.0 times what the deviation has above 0.06 m, three times as many were displaced falsely.
pub(crate) const MIN_DISPLACED_M: f64 = 0.1;
pub(crate) const UNCERTAIN: f64 = 1.5;

/// Surfaces this near to a displacement support it.
pub(crate) const SUPPORT_M: f64 = 0.06;

/// Samples that support a displacement: 0.4 m, so that a column can have moved; and as much more than those that support the place
/// in the model. With 5 samples parts of kitchens were displaced.
pub(crate) const MIN_SUPPORT: usize = 8;
pub(crate) const SUPPORT_RATIO: f64 = 1.3;

/// A displacement is that of most of the side: share of the known samples in that direction.
pub(crate) const SUPPORT_SHARE: f64 = 0.5;

/// Of what was judged of an element that left its place at most this share is still met there: half of a column's sides slide along
/// themselves. Sofas and lifts have parts at many depths.
pub(crate) const MAX_IN_PLACE: f64 = 0.6;

/// Share of the samples in support of a displacement that see its surface behind their side, through the place in the model.
pub(crate) const BEHIND_SHARE: f64 = 0.3;

/// A side that seems to stand nearer, without a look at the place in the model, may be a row of furniture: so much of the side must
/// seem so, over this many samples (two metres), no farther than that, and the other side must not be in its place. With 0.7, a
/// metre and any distance, half of all false displacements were cupboards and shelves.
pub(crate) const COVERING_SHARE: f64 = 0.9;
pub(crate) const MIN_COVERING: usize = 40;
pub(crate) const MAX_COVERING_M: f64 = 0.4;

/// An element is absent if this share of what was judged is seen through, that is at least half a metre of its sides, and this share
/// of all of them: through a hole alone nothing is said of the rest.
pub(crate) const ABSENT_SHARE: f64 = 0.7;
pub(crate) const MIN_ABSENT: usize = 10;
pub(crate) const ABSENT_OF_ALL: f64 = 0.25;

/// A part of an element that stands is absent if it is seen through over this length, with gaps no longer than that of which
/// nothing is known, and so much of it seen through: less than a leaf of a door is no hole that anybody asks for.
pub(crate) const MIN_PART_M: f64 = 0.5;
pub(crate) const MAX_PART_GAP_M: f64 = 0.15;
pub(crate) const PART_THROUGH_SHARE: f64 = 0.7;
/// Lines beside the border of a hole meet its cells: it begins this much before the first line that passes.
pub(crate) const PART_END_M: f64 = 0.05;
/// What is less long than this many times its width has no axis.
pub(crate) const MIN_SLENDERNESS: f64 = 2.0;
/// Parts this near to doors and windows are openings of the model.
pub(crate) const OPENING_M: f64 = 0.1;

/// An element is observed if at least this share of what was judged is in its place, so many samples (0.3 m), and either a metre or this
/// share of all: of two short walls that were gone a sixth and a third seemed to stand, because of what stood beside them.
pub(crate) const OBSERVED_SHARE: f64 = 0.5;
pub(crate) const MIN_OBSERVED: usize = 6;
pub(crate) const SURELY_OBSERVED: usize = 20;
pub(crate) const OBSERVED_OF_ALL: f64 = 0.4;

/// An element that should not be there yet needs more, because furniture and scaffolds stand anywhere: a metre, and this share
/// of all of its sides.
pub(crate) const MIN_EARLY: usize = 20;
pub(crate) const EARLY_OF_ALL: f64 = 0.3;
pub(crate) const EARLY_SHARE: f64 = 0.7;

/// The distortion is estimated for squares of this side, from surrounding surfaces weighted by distance.
pub(crate) const DISTORTION_CELL_M: f64 = 1.0;
pub(crate) const DISTORTION_SIGMA_M: f64 = 2.0;
/// Maximum distortion: the drift of maps that can still be aligned.
pub(crate) const MAX_DISTORTION_M: f64 = 0.4;
/// Prior standard deviation of the distortion, and its minimum: half a cell.
pub(crate) const PRIOR_DISTORTION_M: f64 = 0.1;
pub(crate) const MIN_DISTORTION_M: f64 = 0.02;
/// Standard deviation of a surface from the distorted model, and the number of correlated samples: half a metre of a wall.
pub(crate) const NOISE_M: f64 = 0.03;
pub(crate) const ALIKE: f64 = 10.0;
/// Standard deviation of the place of an element in the estimate of the distortion: several elements must agree on a
/// distortion.
pub(crate) const BUILT_M: f64 = 0.03;

/// Minimum size of obstacles: 0.3 m long or 0.1 m² of cells, and more than a stray hit or two.
pub(crate) const MIN_LENGTH_M: f64 = 0.3;
pub(crate) const MIN_AREA_M2: f64 = 0.1;
pub(crate) const MIN_CELLS: usize = 4;
/// Elements this far above or below the lidar's plane also explain surfaces: floors are uneven and robots tilt.
pub(crate) const PLANE_M: f64 = 0.1;
/// Margin around the storey's bounds within which obstacles are searched.
pub(crate) const OUTSIDE_M: f64 = 0.5;
