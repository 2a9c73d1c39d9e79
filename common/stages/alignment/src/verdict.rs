//! Acceptance of poses: accepted, ambiguous or refused, with the reason.

use crate::features::Features;
use crate::search::Candidate;
use crate::thresholds::{
    MAX_DEVIATION_M, MAX_DEVIATION_RAD, MIN_PRECISION, MIN_RECALL, MIN_SCORE, MIN_WALL_POINTS, RIVAL_SHARE,
};
use frames::counted;
use messages::{AlignmentVerdict, PoseEvidence};

/// Verdict on poses of one or several references, best first, with the reason if none is accepted.
pub(crate) fn verdict_of(slam: &Features, candidates: &[&Candidate]) -> (AlignmentVerdict, String) {
    let n_wall_points = slam.wall_points.len();
    if n_wall_points < MIN_WALL_POINTS {
        let reason =
            format!("the SLAM map shows too little of walls: {} beside free space", counted(n_wall_points, "cell"));
        return (AlignmentVerdict::Refused, reason);
    }
    let Some(best) = candidates.first() else {
        return (AlignmentVerdict::Refused, "nothing of the SLAM map fits anywhere".to_owned());
    };
    let PoseEvidence { score, precision, recall, .. } = best.evidence;
    if score <= MIN_SCORE {
        let reason = format!("the best pose explains too little: score {score:.2}, needed {MIN_SCORE}");
        return (AlignmentVerdict::Refused, reason);
    }
    let n_rivals = candidates.iter().skip(1).filter(|c| c.evidence.score >= RIVAL_SHARE * score).count();
    if n_rivals > 0 {
        return (AlignmentVerdict::Ambiguous, format!("{} poses fit almost alike", n_rivals + 1));
    }
    if precision < MIN_PRECISION || recall < MIN_RECALL {
        let reason = format!(
            "one pose fits best, but too little: {:.0} % of the SLAM map's walls and {:.0} % of the model's that were seen, \
             needed {:.0} and {:.0} %",
            100.0 * precision,
            100.0 * recall,
            100.0 * MIN_PRECISION,
            100.0 * MIN_RECALL
        );
        return (AlignmentVerdict::Refused, reason);
    }
    let [deviation_m, deviation_rad] = best.refined.standard_deviations(slam.centre);
    if !is_constrained(slam, best) {
        let degrees = deviation_rad.to_degrees();
        let reason =
            format!("the walls that were seen hold the pose to {deviation_m:.2} m and {degrees:.1} degrees only");
        return (AlignmentVerdict::Ambiguous, reason);
    }
    (AlignmentVerdict::Accepted, String::new())
}

/// True if a pose would be accepted without rivals.
pub(crate) fn is_acceptable(slam: &Features, candidate: &Candidate) -> bool {
    let PoseEvidence { score, precision, recall, .. } = candidate.evidence;
    score > MIN_SCORE && precision >= MIN_PRECISION && recall >= MIN_RECALL && is_constrained(slam, candidate)
}

/// True if the walls that were seen constrain the pose in all directions.
fn is_constrained(slam: &Features, candidate: &Candidate) -> bool {
    let [deviation_m, deviation_rad] = candidate.refined.standard_deviations(slam.centre);
    deviation_m <= MAX_DEVIATION_M && deviation_rad <= MAX_DEVIATION_RAD
}
