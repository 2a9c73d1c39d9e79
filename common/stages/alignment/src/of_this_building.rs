//! Log odds that a SLAM map is of this building and storey, from the evidence of a pose.

use crate::thresholds::{MAX_DISTINCT_M, MAX_LEAD, NEAR_A_GUESS, OF_THIS_BUILDING, OfThisBuilding};
use messages::PoseEvidence;

/// Log odds that the SLAM map is of this building and storey, by a pose with this evidence and its lead over the other poses that a
/// search found.
pub(crate) fn of_this_building(evidence: &PoseEvidence, lead: Option<f64>) -> f64 {
    lead.map_or_else(|| NEAR_A_GUESS.logit(evidence, 0.0), |lead| OF_THIS_BUILDING.logit(evidence, lead))
}

impl OfThisBuilding {
    fn logit(&self, evidence: &PoseEvidence, lead: f64) -> f64 {
        self.constant
            + self.recall * evidence.recall
            + self.seen_through * evidence.seen_through
            + self.distinct * libm::log(1.0 + evidence.distinct_m.min(MAX_DISTINCT_M))
            + self.lead * lead.min(MAX_LEAD)
    }
}
