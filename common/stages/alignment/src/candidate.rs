//! A pose that was found, with what speaks for it.

use crate::held_out::{HeldOut, PoseHistory};
use crate::of_this_building::of_this_building;
use crate::refine::Refined;
use crate::score::Placed;
use messages::PoseEvidence;

/// A pose with its evidence.
#[derive(Debug, Clone)]
pub(crate) struct Candidate {
    pub(crate) refined: Refined,
    pub(crate) evidence: PoseEvidence,
    /// Log odds above the median of the other poses that a search of the whole reference found; `None` of a pose near a guess, and
    /// where few others were found.
    pub(crate) lead: Option<f64>,
    /// Empty for poses that are not compared with others.
    pub(crate) placed: Placed,
    /// What new places of a growing map say, and with them what earlier looks said; `None` for a pose that no look before found.
    pub(crate) new: Option<HeldOut>,
    pub(crate) history: Option<PoseHistory>,
}

impl Candidate {
    /// A pose that no look before found, and that is not compared with others yet.
    pub(crate) fn new(refined: Refined, evidence: PoseEvidence) -> Self {
        Self { refined, evidence, lead: None, placed: Placed::default(), new: None, history: None }
    }

    /// Log odds that the SLAM map is of this building and storey: by this look alone, or by an earlier one and what was new
    /// since, whichever says more.
    pub(crate) fn history(&self) -> PoseHistory {
        let of_this_building = of_this_building(&self.evidence, self.lead);
        let own = PoseHistory { of_this_building, held_out: HeldOut::default() };
        self.history.filter(|earlier| earlier.log_odds() > own.log_odds()).unwrap_or(own)
    }
}
