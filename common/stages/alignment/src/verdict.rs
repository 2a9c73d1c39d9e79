//! Verdict on the best pose: accepted, ambiguous or refused, by the probability that it is wrong.

use crate::features::Features;
use crate::search::Candidate;
use crate::thresholds::{
    ALONE, Calibration, MAX_AMBIGUOUS_PROBABILITY, MAX_LEAD, MAX_SEEN_THROUGH, MAX_TRACKED_PROBABILITY,
    MAX_WRONG_PROBABILITY, MIN_MATCHED_M, MIN_WALL_POINTS, WITH_LEAD,
};
use frames::counted;
use messages::{AlignmentVerdict, PoseEvidence};

/// A verdict with its reasons.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PoseVerdict {
    pub(crate) verdict: AlignmentVerdict,
    /// Empty if accepted.
    pub(crate) reason: String,
    /// Probability that the best pose is wrong: another one of this building is right, or the building is another.
    pub(crate) wrong_probability: f64,
    /// Poses after the best of which each alone keeps it from being accepted.
    pub(crate) n_rivals: usize,
}

impl PoseVerdict {
    /// On poses of one or several references, best first.
    pub(crate) fn of(slam: &Features, candidates: &[&Candidate]) -> Self {
        let refused = |reason| Self { verdict: AlignmentVerdict::Refused, reason, wrong_probability: 1.0, n_rivals: 0 };
        let n_wall_points = slam.wall_points.len();
        if n_wall_points < MIN_WALL_POINTS {
            let few = counted(n_wall_points, "cell");
            return refused(format!("the SLAM map shows too little of walls: {few} beside free space"));
        }
        let Some(best) = candidates.first() else {
            return refused("nothing of the SLAM map fits anywhere".to_owned());
        };
        let evidence = &best.evidence;
        let matched_m = matched_m(evidence);
        let is_enough = matched_m >= MIN_MATCHED_M;
        let lead = |other: &Candidate| evidence.log_odds - other.evidence.log_odds;
        let wrong_probability = WITH_LEAD.wrong_probability(evidence, candidates.get(1).map_or(MAX_LEAD, |c| lead(c)));
        let is_rival = |c: &&&Candidate| WITH_LEAD.wrong_probability(evidence, lead(c)) >= MAX_WRONG_PROBABILITY;
        let n_rivals = candidates.iter().skip(1).take_while(is_rival).count();
        let fits = ALONE.wrong_probability(evidence, 0.0) < MAX_AMBIGUOUS_PROBABILITY;
        let (verdict, reason) = match n_rivals {
            _ if !is_enough => {
                let reason = format!(
                    "the best pose explains {matched_m:.0} m of the model's walls, needed {MIN_MATCHED_M:.0}: rooms of less are alike"
                );
                (AlignmentVerdict::Refused, reason)
            }
            _ if evidence.seen_through > MAX_SEEN_THROUGH => {
                let reason = format!(
                    "in the best pose the robot saw through {:.0} % of the {:.0} m of walls in sight, at most {:.0} % may be: another \
                     storey, or walls that are not there",
                    100.0 * evidence.seen_through,
                    evidence.seen_m,
                    100.0 * MAX_SEEN_THROUGH
                );
                (AlignmentVerdict::Refused, reason)
            }
            _ if wrong_probability < MAX_WRONG_PROBABILITY => (AlignmentVerdict::Accepted, String::new()),
            1.. if fits => (AlignmentVerdict::Ambiguous, format!("{} poses fit almost alike", n_rivals + 1)),
            _ => (AlignmentVerdict::Refused, why_refused(evidence, wrong_probability)),
        };
        Self { verdict, reason, wrong_probability, n_rivals }
    }
}

/// Length of the faces of the reference's walls that were in sight and not seen through.
fn matched_m(evidence: &PoseEvidence) -> f64 {
    evidence.seen_m * (1.0 - evidence.seen_through)
}

/// True if a newer map bears out a pose that was accepted: it would fit, whatever else fits.
pub(crate) fn is_borne_out(candidate: &Candidate) -> bool {
    ALONE.wrong_probability(&candidate.evidence, 0.0) < MAX_TRACKED_PROBABILITY
}

fn why_refused(evidence: &PoseEvidence, wrong_probability: f64) -> String {
    let PoseEvidence { precision, recall, seen_m, seen_through, .. } = evidence;
    let [precision, recall, through] = [precision, recall, seen_through].map(|share| 100.0 * share);
    format!(
        "the best pose is wrong with a probability of {}: it explains {precision:.0} % of the SLAM map's walls; of the model's, \
         {seen_m:.0} m would have been in sight, of which the SLAM map has {recall:.0} % and the robot saw through {through:.0} %",
        percent(wrong_probability)
    )
}

/// A probability for people.
pub(crate) fn percent(probability: f64) -> String {
    match 100.0 * probability {
        percent if percent >= 1.0 => format!("{percent:.0} %"),
        percent if percent >= 0.01 => format!("{percent:.2} %"),
        _ => "less than 0.01 %".to_owned(),
    }
}

impl Calibration {
    /// Probability that a pose with this evidence and this lead in log odds over the next one is wrong.
    fn wrong_probability(&self, evidence: &PoseEvidence, lead: f64) -> f64 {
        let logit = self.constant
            + self.lead * lead.clamp(0.0, MAX_LEAD)
            + self.log_odds * evidence.log_odds
            + self.matched * libm::log(1.0 + matched_m(evidence))
            + self.precision * evidence.precision
            + self.recall * evidence.recall
            + self.seen_through * evidence.seen_through;
        1.0 / (1.0 + libm::exp(logit))
    }
}
