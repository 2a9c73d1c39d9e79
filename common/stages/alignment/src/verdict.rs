//! Verdict on the best pose: accepted, ambiguous or refused, by the probability that it is wrong.

use crate::contrast::Ranked;
use crate::features::Features;
use crate::of_this_building::of_this_building;
use crate::score::CornersInSight;
use crate::thresholds::{
    MAX_CONTRAST, MAX_ELSEWHERE_PROBABILITY, MAX_TRACKED_PROBABILITY, MAX_WRONG_PROBABILITY, MIN_CORNERS_PER_M,
    MIN_DISTINCT_M, MIN_WALL_POINTS, RIVAL_LEAD, SURE_GAIN, SURE_LOGIT,
};
use diagnostics::counted;
use messages::{AlignmentVerdict, PoseEvidence};

/// A verdict with its reasons.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PoseVerdict {
    pub(crate) verdict: AlignmentVerdict,
    /// Empty if accepted.
    pub(crate) reason: String,
    /// Probability that the best pose is wrong: another one of this building is right, or the building is another.
    pub(crate) wrong_probability: f64,
    /// Poses after the best of which each alone keeps it from being accepted, were the building certain.
    pub(crate) n_rivals: usize,
}

impl PoseVerdict {
    /// On poses of one or several references.
    pub(crate) fn of(slam: &Features, ranked: &[Ranked<'_>]) -> Self {
        let refused = |reason| Self { verdict: AlignmentVerdict::Refused, reason, wrong_probability: 1.0, n_rivals: 0 };
        let n_wall_points = slam.n_wall_points();
        if n_wall_points < MIN_WALL_POINTS {
            let few = counted(n_wall_points, "cell");
            return refused(format!("the SLAM map shows too little of walls: {few} beside free space"));
        }
        let Some((best, others)) = ranked.split_first() else {
            return refused("nothing of the SLAM map fits anywhere".to_owned());
        };
        let evidence = &best.candidate.evidence;
        let rivals = others.iter().filter(|other| !other.is_beside);
        let contrasts: Vec<f64> = rivals.map(|other| other.contrast.log_odds()).collect();
        let unrivalled = unrivalled(&contrasts);
        let of_this_building = best.candidate.history().log_odds();
        let wrong_probability = wrong_probability(of_this_building, unrivalled);
        let least = contrasts.first().copied().unwrap_or(MAX_CONTRAST).max(0.0);
        // Each alone keeps it from being accepted, were the building certain.
        let is_rival = |&&contrast: &&f64| {
            contrast < least + RIVAL_LEAD && self::wrong_probability(f64::INFINITY, contrast) >= MAX_WRONG_PROBABILITY
        };
        let n_rivals = contrasts.iter().take_while(is_rival).count();
        let elsewhere_probability = 1.0 - probability(of_this_building);
        let why_not = match wrong_probability < MAX_WRONG_PROBABILITY {
            true => why_in_doubt(evidence, best.candidate.placed.corners),
            false => Some(why_refused(evidence, wrong_probability)),
        };
        let (verdict, reason) = match why_not {
            None => (AlignmentVerdict::Accepted, String::new()),
            Some(_) if n_rivals > 0 && elsewhere_probability < MAX_ELSEWHERE_PROBABILITY => {
                (AlignmentVerdict::Ambiguous, format!("{} poses fit almost alike", n_rivals + 1))
            }
            Some(reason) => (AlignmentVerdict::Refused, reason),
        };
        Self { verdict, reason, wrong_probability, n_rivals }
    }
}

/// True if a newer map bears out a pose that was accepted: it would be of this building, whatever else fits.
pub(crate) fn is_borne_out(evidence: &PoseEvidence) -> bool {
    1.0 - probability(of_this_building(evidence, None)) < MAX_TRACKED_PROBABILITY
}

/// Log odds that none of the other poses is right, by the contrasts of the best with each: of the poses of one map at most one is.
fn unrivalled(contrasts: &[f64]) -> f64 {
    let odds: f64 = contrasts.iter().map(|contrast| libm::exp(-contrast)).sum();
    -libm::log(odds.max(libm::exp(-MAX_CONTRAST)))
}

/// Probability that a pose is wrong: from the log odds that the map is of this building, and that no other pose
/// of it is right.
fn wrong_probability(of_this_building: f64, unrivalled: f64) -> f64 {
    let right = probability(unrivalled) * probability(of_this_building);
    let logit = libm::log(right / (1.0 - right).max(f64::MIN_POSITIVE));
    1.0 - probability(logit + SURE_GAIN * (logit - SURE_LOGIT).max(0.0))
}

fn probability(logit: f64) -> f64 {
    1.0 / (1.0 + libm::exp(-logit))
}

/// Why a pose is not accepted however well it fits; `None` if nothing keeps it from that. Two walls of a room lie in many rooms. On another
/// storey the outer walls stand, but those within do not, and their corners are elsewhere; furniture hides them in both.
fn why_in_doubt(evidence: &PoseEvidence, corners: CornersInSight) -> Option<String> {
    let PoseEvidence { distinct_m, seen_m, seen_through, .. } = evidence;
    let CornersInSight { n_seen, n_found } = corners;
    let through_m = seen_m * seen_through;
    let least_corners = MIN_CORNERS_PER_M * (1.0 + through_m) - 1.0;
    if *distinct_m < MIN_DISTINCT_M {
        return Some(format!(
            "the best pose fits, but by {distinct_m:.1} m of distinct walls: {MIN_DISTINCT_M} m are needed, or it may be another room"
        ));
    }
    ((n_found as f64) < least_corners).then(|| {
        format!(
            "the best pose fits, but the robot saw through {through_m:.0} m of the {seen_m:.0} m of walls in sight, and the SLAM map has \
             {n_found} of the {} in sight: it must have {}, or it may be another storey",
            counted(n_seen, "corner"),
            least_corners.ceil()
        )
    })
}

fn why_refused(evidence: &PoseEvidence, wrong_probability: f64) -> String {
    let PoseEvidence { precision, recall, seen_m, seen_through, distinct_m, .. } = evidence;
    let [precision, recall, through] = [precision, recall, seen_through].map(|share| 100.0 * share);
    format!(
        "the best pose is wrong with a probability of {}: it explains {precision:.0} % of the SLAM map's walls, {distinct_m:.1} m of \
         them distinct; of the model's, {seen_m:.0} m would have been in sight, of which the SLAM map has {recall:.0} % and the \
         robot saw through {through:.0} %",
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::thresholds::MAX_LEAD;

    /// A map with some furniture, in the right pose.
    fn evidence() -> PoseEvidence {
        PoseEvidence {
            precision: 0.6,
            recall: 0.92,
            free: 0.97,
            seen_m: 60.0,
            seen_through: 0.03,
            in_walls: 0.35,
            outside: 0.02,
            free_in_walls: 0.01,
            distinct_m: 12.0,
            ..PoseEvidence::default()
        }
    }

    #[test]
    fn a_pose_is_right_only_if_it_has_no_rival_and_the_map_is_of_this_building() {
        let good = evidence();
        let wrong_probability = |evidence: &PoseEvidence, lead: f64, contrasts: &[f64]| {
            super::wrong_probability(of_this_building(evidence, Some(lead)), unrivalled(contrasts))
        };
        assert!(wrong_probability(&good, MAX_LEAD, &[12.0, 13.0]) < MAX_WRONG_PROBABILITY);
        assert!(wrong_probability(&good, MAX_LEAD, &[0.0, 13.0]) >= 0.5, "another pose fits as well");
        assert!(
            wrong_probability(&good, 0.0, &[12.0, 13.0]) >= MAX_WRONG_PROBABILITY,
            "it is one of many that fit by chance"
        );
        let other_storey = PoseEvidence { seen_through: 0.5, recall: 0.5, seen_m: 400.0, distinct_m: 60.0, ..good };
        let probability = wrong_probability(&other_storey, 6.0, &[MAX_CONTRAST]);
        assert!(probability >= MAX_WRONG_PROBABILITY, "no outer walls make up for what was seen through");
        let is_in_doubt = |evidence: &PoseEvidence, n_found: usize| {
            why_in_doubt(evidence, CornersInSight { n_seen: 20, n_found }).is_some()
        };
        assert!(is_in_doubt(&other_storey, 20), "no corners make up for most walls");
        let some_glass = PoseEvidence { seen_through: 0.1, ..good };
        assert!(!is_in_doubt(&good, 1) && is_in_doubt(&some_glass, 1) && !is_in_doubt(&some_glass, 2));
        assert!(is_in_doubt(&PoseEvidence { distinct_m: 1.4, ..good }, 20), "two walls are in many rooms");
        assert!(!is_borne_out(&PoseEvidence { seen_through: 0.6, recall: 0.4, ..good }));
        assert!(is_borne_out(&good));
    }

    #[test]
    fn many_poses_that_are_hard_to_tell_count_together() {
        assert_eq!(unrivalled(&[]), MAX_CONTRAST);
        assert!((unrivalled(&[5.0]) - 5.0).abs() < 1e-12);
        assert!((unrivalled(&[5.0; 8]) - (5.0 - libm::log(8.0))).abs() < 1e-12);
        assert!(unrivalled(&[5.0, -1.0]) < 0.0, "one fits better");
    }
}
