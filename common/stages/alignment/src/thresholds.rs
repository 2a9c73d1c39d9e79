//! All thresholds of an alignment, each with its reason.
//!
//! Lengths in metres, angles in radians. Values without another reason are those of the prototype with which the method was
//! measured.

/// Wall points farther from each other than this are no match, in metres.
pub(crate) const MAX_MATCH_M: f64 = 0.6;

/// Hypotheses that are looked at more closely.
pub(crate) const N_VOTED: usize = 64;
pub(crate) const N_CORRELATED: usize = 96;
pub(crate) const N_REFINED: usize = 16;
/// Of these, those that are looked for as twins of the best.
pub(crate) const N_TWIN_PEAKS: usize = 32;
pub(crate) const N_TWINS: usize = 8;

/// Two poses are one if they are at most this far apart, at the centre of the SLAM map.
pub(crate) const SAME_M: f64 = 0.4;
pub(crate) const SAME_RAD: f64 = 0.06;

/// A pose this close to the best at the centre of the SLAM map is no rival of it: it is the same place.
pub(crate) const BESIDE_M: f64 = 0.5;
pub(crate) const BESIDE_RAD: f64 = std::f64::consts::PI / 18.0;

/// Corners of two maps that are this close are one.
pub(crate) const NEAR_CORNER_M: f64 = 0.25;

// What follows was fitted by scripts/calibrate-alignment on simulated maps of real buildings and of generated offices, homes and
// halls. Weights of log odds: 72 storeys, 3,397 maps of the same building, of which 2,466 fit in one pose only, and 5,408 of another
// building or another storey; half of all have more than half of their walls in no model. Contrasts, and that the map is of this building:
// 374 storeys of about 120 buildings, 1,261 maps of the same building, of which 1,127 fit in one pose only, and 4,132 of elsewhere, of which
// 1,033 are of another storey, 605 of them with up to 97 % of the walls in common. With a fifth of the storeys left out in turn their log loss
// is 0.097; on the same maps it is 0.104 without corners, and 0.098 if poses beside the best are its rivals.

/// Weights of a pose's log odds. Between two poses of one map the difference is the log of their odds: it was fitted (conditional
/// logistic regression, McFadden 1974) to choose the true pose among all that were refined.
pub(crate) const WEIGHTS: Weights = Weights {
    precision: 2.87,
    distinct: 1.83,
    distinct_share: 2.89,
    seen_through: -2.07,
    in_walls: 5.97,
    outside: -1.24,
    free_in_walls: -3.93,
    free_outside: -0.587,
};

/// Factors of the parts of a pose's evidence.
pub(crate) struct Weights {
    /// Of ln([`MIN_PRECISION`] + share of the SLAM map's walls that the reference has).
    pub(crate) precision: f64,
    /// Of ln(1 + metres of distinct walls that match).
    pub(crate) distinct: f64,
    /// Of those metres, by the root of the length of all walls in metres.
    pub(crate) distinct_share: f64,
    /// Of ln(1 + metres of the reference's walls that the robot saw through).
    pub(crate) seen_through: f64,
    /// Of ln([`MIN_SHARE`] + share of the SLAM map's occupied cells in walls of the reference, and where that knows nothing).
    pub(crate) in_walls: f64,
    pub(crate) outside: f64,
    /// The same of free cells.
    pub(crate) free_in_walls: f64,
    pub(crate) free_outside: f64,
}

/// Added to shares before their logarithm: smaller ones are noise.
pub(crate) const MIN_PRECISION: f64 = 0.05;
pub(crate) const MIN_SHARE: f64 = 0.02;

/// Weights of a contrast's log odds.
pub(crate) const CONTRAST: ContrastWeights = ContrastWeights {
    in_walls: 1.02,
    free_outside: 0.433,
    distinct: 2.66,
    seen_through: 1.54,
    exact: 1.28,
    seen: -1.3,
    precision: 13.1,
    corners: 2.37,
};

/// Factors of the parts of a contrast.
pub(crate) struct ContrastWeights {
    pub(crate) in_walls: f64,
    pub(crate) free_outside: f64,
    pub(crate) distinct: f64,
    pub(crate) seen_through: f64,
    pub(crate) exact: f64,
    pub(crate) seen: f64,
    pub(crate) precision: f64,
    pub(crate) corners: f64,
}

/// A larger contrast says no more: models of buildings are never so alike to them.
pub(crate) const MAX_CONTRAST: f64 = 16.0;

/// The best pose is right if no other pose of this building is, and if the SLAM map is of this building and storey. Of each there are
/// log odds, and each was fitted together with the other: no fit makes up for another pose that fits as well, and no contrast with other
/// poses for walls that the robot saw through.
pub(crate) const OF_THIS_BUILDING: OfThisBuilding =
    OfThisBuilding { constant: -12.3, recall: 12.4, seen_through: -5.0, distinct: 1.01, lead: 0.635 };
/// The same of poses that were looked for near a guess alone, or that are followed from map to map, fitted on the maps of the weights of
/// log odds. Of those of the contrasts it bears out 99 % of the right poses, and 28 % of the best ones of elsewhere.
pub(crate) const NEAR_A_GUESS: OfThisBuilding =
    OfThisBuilding { constant: -12.9, recall: 10.3, seen_through: -5.97, distinct: 4.7, lead: 0.0 };

/// Regression of the probability that the SLAM map is of this building and storey.
pub(crate) struct OfThisBuilding {
    pub(crate) constant: f64,
    pub(crate) recall: f64,
    pub(crate) seen_through: f64,
    /// Of ln(1 + metres of distinct walls that match, at most [`MAX_DISTINCT_M`]).
    pub(crate) distinct: f64,
    /// Of the pose's log odds above the median of the other poses that were found, at most [`MAX_LEAD`]: where a map is of elsewhere
    /// the best is the best of many that fit by chance, and stands little above them.
    pub(crate) lead: f64,
}

/// A larger lead says no more: a storey with the same outer walls has it, too.
pub(crate) const MAX_LEAD: f64 = 12.0;
/// Of fewer other poses the median says little.
pub(crate) const MIN_OTHERS: usize = 5;

/// More distinct walls do not tell a building: its storeys have the outer walls in common. Without this bound no more maps are
/// accepted.
pub(crate) const MAX_DISTINCT_M: f64 = 10.0;

/// Above this logit poses are wrong more rarely than that says: what is beyond counts more. Wrong poses with so high logits are too few
/// to fit how much more. A pose is accepted from a logit of 3.38 on, where 3.3 % would be wrong by the regressions alone. Of the maps that
/// were fitted to, with a fifth of the storeys left out in turn, none of the same building and one of elsewhere is accepted in a wrong pose:
/// it shows the outer walls of a hall, which another storey of it has in common.
pub(crate) const SURE_LOGIT: f64 = 2.21;
pub(crate) const SURE_GAIN: f64 = 3.0;

/// A pose is accepted if it is wrong with a smaller probability.
pub(crate) const MAX_WRONG_PROBABILITY: f64 = 0.001;
/// A pose that is refused, but wrong with a smaller probability than this, is judged again with the SLAM map straightened; that must be
/// accepted in the same pose. Where another one beside it was taken, of 54 poses of maps of MRPT one was 0.7 m off.
pub(crate) const MAX_UNBENT_PROBABILITY: f64 = 0.2;
/// Less than three lines of walls fit in many rooms. Of 2,036 right poses that would be accepted 7 have less, and one of elsewhere with the
/// probability said to be far below the limit: a corner of a hall in another hall.
pub(crate) const MIN_DISTINCT_M: f64 = 1.5;
/// For each metre of the model's walls that the robot saw through, and one more, the SLAM map must have so many of the corners in sight, and
/// one more: storeys have outer walls and stairs in common. Of 7 maps of another storey that fit well enough 5 have less, and of 1,005 right
/// poses 8. A whole map of the demo's ground floor, without furniture, has 0.26 on its upper floor, and would be accepted there. Where storeys
/// have nine walls of ten in common this does not do: what tells them apart is the other storey, and it must be given.
pub(crate) const MIN_CORNERS_PER_M: f64 = 0.4;
/// A map that is of elsewhere with a smaller probability is ambiguous, not refused, if other poses fit as well.
pub(crate) const MAX_ELSEWHERE_PROBABILITY: f64 = 0.3;
/// A pose that was accepted stays in effect while the map is of elsewhere with a smaller probability, whatever else fits: it is
/// not searched, so that no other one is the best of many. 99 % of the accepted ones have less than 0.01.
pub(crate) const MAX_TRACKED_PROBABILITY: f64 = 0.5;

/// Weights of what new places of a growing map say. Fitted by `scripts/calibrate-alignment --growing` on 200 drives in the building
/// of the model and 260 elsewhere, each looked at six times: a right pose was tested at 433 looks, one of elsewhere at 157. With a
/// fifth of the storeys left out in turn, right poses have log odds of -0.5 to 3.6 (5 to 95 %), those of elsewhere -7.8 to 1.6.
pub(crate) const HELD_OUT: HeldOutWeights = HeldOutWeights { constant: -1.31, recalled: 2.6, through: -2.61 };

/// Regression of the log odds that a map is of this building by new places alone, of each natural logarithm of
/// (1 + metres of walls that came in sight there).
pub(crate) struct HeldOutWeights {
    pub(crate) constant: f64,
    /// Of the share of those walls that the SLAM map has.
    pub(crate) recalled: f64,
    /// Of the share that the robot saw through.
    pub(crate) through: f64,
}

/// A look counts if so much is new, as a share of what was known: maps that come often do not get more chances.
pub(crate) const MIN_NEW_SHARE: f64 = 0.1;
/// A map that knows less of what was known is another one.
pub(crate) const MIN_CONTINUED_SHARE: f64 = 0.5;

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
