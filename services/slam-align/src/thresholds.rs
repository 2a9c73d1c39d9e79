//! Every number that an alignment is judged by, in one place, each with its reason.
//!
//! Lengths in metres, angles in radians. The method is that of `align`; values without another reason are those of the
//! prototype that it was measured with.

/// Both maps are resampled to cells of this size.
pub(crate) const CELL_M: f64 = 0.05;

/// Of a cell made from finer ones: the share that makes it occupied, else free.
pub(crate) const OCCUPIED_SHARE: f64 = 0.15;
pub(crate) const FREE_SHARE: f64 = 0.3;

/// Hypotheses that are looked at more closely.
pub(crate) const N_VOTED: usize = 64;
pub(crate) const N_CORRELATED: usize = 48;
pub(crate) const N_REFINED: usize = 16;

/// Two poses are one if they are at most this far apart, at the centre of the SLAM map.
pub(crate) const SAME_M: f64 = 0.4;
pub(crate) const SAME_RAD: f64 = 0.06;

/// A pose is believed from this score on.
pub(crate) const LEAST_SCORE: f64 = 0.45;
/// A pose is accepted only if so much of the SLAM map's walls are the reference's, and so much of the reference's walls that the
/// robot has seen are in the SLAM map. On 42 pairs of ten storeys the right poses had at least 0.46 and 0.82, one accepted pose
/// of a wrong building had 0.47 and 0.68, another 0.36.
pub(crate) const LEAST_PRECISION: f64 = 0.5;
pub(crate) const LEAST_RECALL: f64 = 0.75;

/// A pose is accepted only if walls hold it this well, as standard deviations at the middle of the SLAM map. On 70 accepted pairs of
/// 23 storeys the three wrong poses had 0.013 rad and more, the right ones 0.0093 or less where they were held in place at all.
pub(crate) const MOST_LOOSE_M: f64 = 0.1;
pub(crate) const MOST_LOOSE_RAD: f64 = 0.0105;

/// A pose is the only one if the next best has at most this share of its score.
pub(crate) const RIVAL_SHARE: f64 = 0.90;

/// Faces that a SLAM map must have to be aligned at all: 5 m of wall.
pub(crate) const LEAST_FACES: usize = 100;
