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

/// How many standard deviations of the distortion a surface may be off in addition.
pub(crate) const WITHIN: f64 = 2.0;

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

/// Minimum displacement, and how many standard deviations of the element's place it must be: those of the distortion and of
/// [`BUILT_M`]. Of 4500 simulated elements in their place 43 seemed displaced with 2, 27 with 2.5 and 18 with 3; what is left is no
/// matter of standard deviations, but of other surfaces taken for the element.
pub(crate) const MIN_DISPLACED_M: f64 = 0.09;
pub(crate) const UNCERTAIN: f64 = 2.75;

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
pub(crate) const MAX_IN_PLACE: f64 = 0.45;

/// So much of all sides must have been seen, and of a displacement that is less than [`SLIGHT_M`] a metre of them: short pieces are
/// met beside their place more often than elements are displaced.
pub(crate) const DISPLACED_OF_ALL: f64 = 0.3;
pub(crate) const SLIGHT_M: f64 = 0.15;
pub(crate) const MIN_SLIGHT: u32 = 20;

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

/// The distortion is estimated for squares of this side, and the samples of a side in a square are one observation of it.
pub(crate) const DISTORTION_CELL_M: f64 = 1.0;
/// A piece of a side has this many samples.
pub(crate) const MIN_PIECE: usize = 3;
/// Maximum distortion: the drift of maps that can still be aligned.
pub(crate) const MAX_DISTORTION_M: f64 = 0.4;
/// Length over which drift is correlated, and how far and how many pieces of sides tell of it. Of 3, 4 and 8 m, and of an
/// exponential correlation, this foretells elements best that are left out.
pub(crate) const DISTORTION_LENGTH_M: f64 = 4.0;
pub(crate) const DISTORTION_REACH_M: f64 = 6.0;
pub(crate) const MAX_PIECES: usize = 60;
/// Standard deviations of drift, of which each map gets the one that foretells its own elements best. One for all maps is too
/// large for rigid ones and too small for bent ones.
pub(crate) const DRIFTS_M: [f64; 5] = [0.01, 0.02, 0.035, 0.06, 0.1];
/// A SLAM map that bends by more than this is taken as its frame bends; else in one pose, since drift follows the rest and is calibrated
/// for that: by Karto's walls the poses of parts are off by some centimetres, which is the least drift beside a frame that bends.
pub(crate) const BENT_M: f64 = 0.4;
pub(crate) const BENT_DRIFT_M: f64 = 0.06;
/// Pieces that decide this at most.
pub(crate) const MAX_SCORED: usize = 200;
/// Standard deviation of half a metre of a side from the distorted model: half a cell and what stands or hangs there.
pub(crate) const NOISE_M: f64 = 0.03;
/// Standard deviation of the place of an element, which all of its sides share: several elements must agree on a distortion.
pub(crate) const BUILT_M: f64 = 0.02;
/// Share of the sides that are hidden by something else, and the scale of residuals beyond which they lose weight; before a side
/// this much of it.
pub(crate) const HIDDEN_SHARE: f64 = 0.2;
pub(crate) const ROBUST_M: f64 = 0.06;
pub(crate) const AHEAD_SCALE: f64 = 0.6;
/// A place is corrected if the largest standard deviation of its distortion is at most this share of that without surfaces.
pub(crate) const CORRECTED_SHARE: f64 = 0.7;
/// Most of the uncertainty of an obstacle's place beside that of the pose.
pub(crate) const OBSTACLE_DISTORTION_M: f64 = 0.1;

/// Minimum size of obstacles: 0.3 m long or 0.1 m² of cells, and more than a stray hit or two.
pub(crate) const MIN_LENGTH_M: f64 = 0.3;
pub(crate) const MIN_AREA_M2: f64 = 0.1;
pub(crate) const MIN_CELLS: usize = 4;
/// Elements this far above or below the lidar's plane also explain surfaces: floors are uneven and robots tilt.
pub(crate) const PLANE_M: f64 = 0.1;
/// Margin around the storey's bounds within which obstacles are searched.
pub(crate) const OUTSIDE_M: f64 = 0.5;
