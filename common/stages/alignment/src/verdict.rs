//! Acceptance of poses: accepted, ambiguous or refused, with the reason.

use crate::features::Features;
use crate::search::Candidate;
use crate::thresholds::{
    LEAST_FACES, LEAST_PRECISION, LEAST_RECALL, LEAST_SCORE, MOST_LOOSE_M, MOST_LOOSE_RAD, RIVAL_SHARE,
};
use frames::counted;
use messages::{Evidence, Verdict};

/// Judges poses, best first, of one reference or of several; with the reason if none is accepted.
pub(crate) fn judged(slam: &Features, candidates: &[&Candidate]) -> (Verdict, String) {
    let n_faces = slam.faces.len();
    if n_faces < LEAST_FACES {
        let reason = format!("the SLAM map shows too little of walls: {} beside free space", counted(n_faces, "cell"));
        return (Verdict::Refused, reason);
    }
    let Some(best) = candidates.first() else {
        return (Verdict::Refused, "nothing of the SLAM map fits anywhere".to_owned());
    };
    let Evidence { score, precision, recall, .. } = best.evidence;
    if score <= LEAST_SCORE {
        let reason = format!("the best pose explains too little: score {score:.2}, needed {LEAST_SCORE}");
        return (Verdict::Refused, reason);
    }
    let n_rivals = candidates.iter().skip(1).filter(|c| c.evidence.score >= RIVAL_SHARE * score).count();
    if n_rivals > 0 {
        return (Verdict::Ambiguous, format!("{} poses fit almost alike", n_rivals + 1));
    }
    if precision < LEAST_PRECISION || recall < LEAST_RECALL {
        let reason = format!(
            "one pose fits best, but too little: {:.0} % of the SLAM map's walls and {:.0} % of the model's that were seen, \
             needed {:.0} and {:.0} %",
            100.0 * precision,
            100.0 * recall,
            100.0 * LEAST_PRECISION,
            100.0 * LEAST_RECALL
        );
        return (Verdict::Refused, reason);
    }
    let [loose_m, loose_rad] = best.refined.loose(slam.centre);
    if !is_held(slam, best) {
        let degrees = loose_rad.to_degrees();
        let reason = format!("the walls that were seen hold the pose to {loose_m:.2} m and {degrees:.1} degrees only");
        return (Verdict::Ambiguous, reason);
    }
    (Verdict::Accepted, String::new())
}

/// True if a pose would be accepted, were it the only one.
pub(crate) fn is_borne_out(slam: &Features, candidate: &Candidate) -> bool {
    let Evidence { score, precision, recall, .. } = candidate.evidence;
    score > LEAST_SCORE && precision >= LEAST_PRECISION && recall >= LEAST_RECALL && is_held(slam, candidate)
}

/// True if the walls that were seen hold a pose in all directions.
fn is_held(slam: &Features, candidate: &Candidate) -> bool {
    let [loose_m, loose_rad] = candidate.refined.loose(slam.centre);
    loose_m <= MOST_LOOSE_M && loose_rad <= MOST_LOOSE_RAD
}
