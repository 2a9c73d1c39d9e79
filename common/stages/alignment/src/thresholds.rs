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

/// Weights of a pose's log odds. Between two poses of one map the difference is the log of their odds: it was fitted (conditional
/// logistic regression, McFadden 1974) to choose the true pose among all that were refined, in simulated pairs whose walls fit in
/// one pose only. In 1563 pairs, storeys left out in turn, the true pose came before the 16 best others in 98.7 %.
///
/// What the robot saw through counts most: furniture makes a map's walls unlike the model's, but never lets it see through a wall.
pub(crate) const WEIGHTS: Weights = Weights {
    precision: 7.3,
    seen_through: -1.15,
    in_walls: 15.7,
    outside: -3.3,
    free_in_walls: -84.0,
    free_outside: -2.0,
};

/// Factors of the parts of a pose's evidence.
pub(crate) struct Weights {
    /// Of the share of the SLAM map's walls that the reference has.
    pub(crate) precision: f64,
    /// Of the share of the reference's walls in sight that the robot saw through, times the root of their length in metres: so much
    /// more improbable is the same share of more walls.
    pub(crate) seen_through: f64,
    /// Of the shares of occupied cells in walls of the reference, and where that knows nothing.
    pub(crate) in_walls: f64,
    pub(crate) outside: f64,
    /// The same of free cells.
    pub(crate) free_in_walls: f64,
    pub(crate) free_outside: f64,
}

/// Logistic regression of the probability that the best pose is right.
pub(crate) struct Calibration {
    pub(crate) constant: f64,
    /// Of the lead in log odds over the next pose, at most [`MAX_LEAD`].
    pub(crate) lead: f64,
    pub(crate) log_odds: f64,
    /// Of ln(1 + metres of the reference's walls that were in sight and not seen through).
    pub(crate) matched: f64,
    pub(crate) precision: f64,
    pub(crate) recall: f64,
    pub(crate) seen_through: f64,
}

// The following were fitted on 1,588 simulated pairs of 60 storeys whose walls fit in one pose only, and on 3,809 with the map of
// another building or storey. With storeys left out in turn they accept 51 % of the former, none of them in a wrong pose, and one
// of the latter: a room of 13 m of wall that is in both buildings, for which there is [`MIN_MATCHED_M`]. Half of the pairs have
// more than half of the SLAM map's walls in no model. Probabilities are those of the pairs: of three maps two are of elsewhere.

/// The probability with the lead over the next pose, and that of a pose which fits whatever else does.
pub(crate) const WITH_LEAD: Calibration = Calibration {
    constant: -9.8,
    lead: 1.666,
    log_odds: 0.120,
    matched: 1.354,
    precision: 1.12,
    recall: 2.31,
    seen_through: -5.10,
};
pub(crate) const ALONE: Calibration = Calibration {
    constant: -11.93,
    lead: 0.0,
    log_odds: 0.258,
    matched: 2.606,
    precision: 3.52,
    recall: 1.92,
    seen_through: -4.64,
};

/// A larger lead says no more: models of buildings are never so alike to them.
pub(crate) const MAX_LEAD: f64 = 10.0;

/// A pose is accepted if it is wrong with a smaller probability.
pub(crate) const MAX_WRONG_PROBABILITY: f64 = 0.001;
/// It must explain so much of the model's walls: rooms of less are alike in many buildings. 1 % of what would be accepted has less.
pub(crate) const MIN_MATCHED_M: f64 = 15.0;
/// The robot may have seen through so much of the walls that would have been in sight: a map of the demo's ground floor lies on its
/// upper floor, whose outer walls are the same, with 22 %. 91 % of what would be accepted has less.
pub(crate) const MAX_SEEN_THROUGH: f64 = 0.15;
/// Poses that would be wrong with a smaller probability if there were no other are ambiguous, not refused: 75 % of the right ones.
pub(crate) const MAX_AMBIGUOUS_PROBABILITY: f64 = 0.3;
/// A pose that was accepted stays in effect while it is wrong with a smaller probability, whatever else fits: 99 % of the accepted
/// ones have less than 0.43. It is not searched, so that no other one is the best of many.
pub(crate) const MAX_TRACKED_PROBABILITY: f64 = 0.5;

/// Of two poses that are searched in different ways, or at different scales, one is better only if its odds are 20 times as high.
pub(crate) const RIVAL_LEAD: f64 = 3.0;

/// A refinement with wide scales alone, for distorted maps, must be better by this in log odds.
pub(crate) const SOFT_ADVANTAGE: f64 = 0.5;

/// Maximum scale that is tried for maps with unknown scale, and the factor between two of them: a building of 30 m is then
/// nowhere off by more than a refinement reaches.
pub(crate) const MAX_SCALE: f64 = 1.25;
pub(crate) const SCALE_STEP: f64 = 1.03;

/// Wall points of each map that a pose is followed with.
pub(crate) const N_TRACKED_POINTS: usize = 800;
/// Cells of each kind, too.
pub(crate) const N_TRACKED_CELLS: usize = 600;

/// A pose that is elsewhere must win so many searches, each of a newer map, before it is offered in the place of that which counts.
pub(crate) const N_WINS: u32 = 3;

/// Wall points that a SLAM map must have to be aligned at all: 5 m of wall.
pub(crate) const MIN_WALL_POINTS: usize = 100;
