//! All thresholds of an alignment, each with its reason.
//!
//! Lengths in metres, angles in radians. Values without another reason are those of the prototype with which the method was
//! measured.

/// Wall points farther from each other than this are no match, in metres.
pub(crate) const MAX_MATCH_M: f64 = 0.6;

/// Hypotheses that are looked at more closely.
pub(crate) const N_VOTED: usize = 64;
pub(crate) const N_CORRELATED: usize = 48;
pub(crate) const N_REFINED: usize = 16;

/// Two poses are one if they are at most this far apart, at the centre of the SLAM map.
pub(crate) const SAME_M: f64 = 0.4;
pub(crate) const SAME_RAD: f64 = 0.06;

/// Minimum score of a pose.
pub(crate) const MIN_SCORE: f64 = 0.45;
// The following were chosen on 402 simulated pairs of 22 storeys and 350 pairs of SLAM maps with other buildings. Together they
// accept 162 right poses and no wrong one; each threshold names what it alone refuses.

/// A pose is accepted only if so much of the SLAM map's walls are the reference's, and so much of the reference's walls that the
/// robot has seen are in the SLAM map. Two poses in other buildings had 0.47 and 0.68, 0.36 and 0.80.
pub(crate) const MIN_PRECISION: f64 = 0.5;
pub(crate) const MIN_RECALL: f64 = 0.75;

/// A pose is accepted only if walls hold it this well, as standard deviations at the middle of the SLAM map. A small building
/// that fits into a room of another was held to 0.031 m and 0.0079 rad; rooms of which too little was seen to 1 to 2 degrees.
pub(crate) const MAX_DEVIATION_M: f64 = 0.025;
pub(crate) const MAX_DEVIATION_RAD: f64 = 0.006;

/// A pose is the only one if the next best has at most this share of its score. Half turns of buildings that are their own twins
/// have 0.96 and more.
pub(crate) const RIVAL_SHARE: f64 = 0.93;

/// Maximum scale that is tried for maps with unknown scale, and the factor between two of them: a building of 30 m is then
/// nowhere off by more than a refinement reaches.
pub(crate) const MAX_SCALE: f64 = 1.25;
pub(crate) const SCALE_STEP: f64 = 1.03;

/// Wall points of each map that a pose is followed with.
pub(crate) const N_TRACKED_POINTS: usize = 800;

/// A pose that is elsewhere must win so many searches, each of a newer map, before it is offered in the place of that which counts.
pub(crate) const N_WINS: u32 = 3;

/// Wall points that a SLAM map must have to be aligned at all: 5 m of wall.
pub(crate) const MIN_WALL_POINTS: usize = 100;
