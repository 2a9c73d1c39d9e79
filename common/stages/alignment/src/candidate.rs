//! A pose that was found, with what speaks for it.

use crate::refine::Refined;
use messages::PoseEvidence;
use occupancy::Cell;

/// A pose with its evidence.
#[derive(Debug, Clone)]
pub(crate) struct Candidate {
    pub(crate) refined: Refined,
    pub(crate) evidence: PoseEvidence,
    /// Empty for poses that are not compared with others.
    pub(crate) placed: Placed,
}

/// What the reference has where the drawn cells of a SLAM map lie by a pose.
#[derive(Debug, Clone, Default)]
pub(crate) struct Placed {
    pub(crate) occupied: Vec<Cell>,
    pub(crate) free: Vec<Cell>,
    /// Length of wall and area of floor that each cell stands for.
    pub(crate) occupied_m: f64,
    pub(crate) free_m2: f64,
}
