//! The pose of a SLAM map in a reference, and how sure it is.

use crate::chance::Chance;
use crate::correlation::correlated;
use crate::faces::Face;
use crate::features::Features;
use crate::pose::Pose;
use crate::refine::{COARSE, Refined, SOFT, TIGHT, refined};
use crate::rotations::turns;
use crate::score::{Evidence, SCALES, Sides, evidence};
use crate::thresholds::{LEAST_FACES, LEAST_SCORE, N_REFINED, RIVAL_SHARE};
use crate::votes::voted;

/// Faces that are drawn.
const N_FACES: usize = 1500;
const N_COARSE_FACES: usize = 500;
const N_REFERENCE_FACES: usize = 3000;
/// A bent map's refinement has to be better by this.
const SOFT_ADVANTAGE: f64 = 0.02;
const COARSE_SCALE: [f64; 1] = [0.3];

/// A pose with its score.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Candidate {
    pub(crate) refined: Refined,
    pub(crate) evidence: Evidence,
}

/// How sure an alignment is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// One pose, and no other comes near.
    Accepted,
    /// Several poses that cannot be told apart.
    Ambiguous,
    /// No pose is to be believed.
    Refused,
}

/// What was found: candidates best first.
pub(crate) struct Found {
    pub(crate) verdict: Verdict,
    pub(crate) reason: String,
    pub(crate) candidates: Vec<Candidate>,
}

/// Searches everywhere.
pub(crate) fn align(reference: &Features, slam: &Features) -> Found {
    let refused = |reason: String| Found { verdict: Verdict::Refused, reason, candidates: Vec::new() };
    if slam.faces.len() < LEAST_FACES {
        return refused(format!(
            "the SLAM map shows too little of walls: {} cells beside free space",
            slam.faces.len()
        ));
    }
    if reference.faces.len() < LEAST_FACES {
        return refused(format!("the reference shows too little of walls: {} cells", reference.faces.len()));
    }
    let turns = turns(&slam.directions, &reference.directions);
    let mut poses = voted(&slam.corners, &reference.corners, &turns);
    poses.extend(correlated(slam, reference, &turns));
    let candidates = candidates(reference, slam, &poses);
    let Some(best) = candidates.first() else {
        return refused("nothing of the SLAM map fits anywhere".to_owned());
    };
    if best.evidence.score <= LEAST_SCORE {
        let reason =
            format!("the best pose explains too little: score {:.2}, needed {LEAST_SCORE}", best.evidence.score);
        return Found { verdict: Verdict::Refused, reason, candidates };
    }
    let n_rivals = candidates.iter().skip(1).filter(|c| c.evidence.score >= RIVAL_SHARE * best.evidence.score).count();
    if n_rivals > 0 {
        let reason = format!("{} poses fit almost as well", n_rivals + 1);
        return Found { verdict: Verdict::Ambiguous, reason, candidates };
    }
    Found { verdict: Verdict::Accepted, reason: String::new(), candidates }
}

/// Refines all poses roughly and the best exactly; best first, no two the same.
fn candidates(reference: &Features, slam: &Features, poses: &[Pose]) -> Vec<Candidate> {
    let mut chance = Chance::new(1);
    let pick = |numbers: Vec<u32>, faces: &[Face]| numbers.into_iter().map(|k| faces[k as usize]).collect::<Vec<_>>();
    let slam_faces = pick(chance.draw(slam.faces.iter().map(|f| f.weight), N_FACES), &slam.faces);
    let reference_faces = pick(chance.draw(reference.faces.iter().map(|_| 1.0), N_REFERENCE_FACES), &reference.faces);
    let few = pick(chance.draw(slam_faces.iter().map(|_| 1.0), N_COARSE_FACES), &slam_faces);
    // Drawn by weight: they are not weighted again.
    let sides = Sides { slam, reference, slam_faces: &slam_faces, reference_faces: &reference_faces };
    let rough = Sides { slam_faces: &few, ..sides };
    let about = slam.centre();
    let scored = |sides: &Sides<'_>, refined: Refined, scales: &[f64]| Candidate {
        refined,
        evidence: evidence(sides, &refined.pose, scales),
    };
    let coarse = poses.iter().filter_map(|pose| refined(reference, &few, *pose, &COARSE));
    let coarse = distinct(coarse.map(|r| scored(&rough, r, &COARSE_SCALE)).collect(), about);
    let exact = coarse.into_iter().take(N_REFINED).filter_map(|c| {
        let [tight, soft] = [&TIGHT[..], &SOFT[..]]
            .map(|scales| refined(reference, &slam_faces, c.refined.pose, scales).map(|r| scored(&sides, r, &SCALES)));
        match (tight, soft) {
            (Some(tight), Some(soft)) if soft.evidence.score > tight.evidence.score + SOFT_ADVANTAGE => Some(soft),
            (tight, soft) => tight.or(soft),
        }
    });
    distinct(exact.collect(), about)
}

/// Best first, without those that are the same as a better one.
fn distinct(mut candidates: Vec<Candidate>, about: [f64; 2]) -> Vec<Candidate> {
    candidates.sort_by(|a, b| b.evidence.score.total_cmp(&a.evidence.score));
    let mut kept: Vec<Candidate> = Vec::new();
    for candidate in candidates {
        if !kept.iter().any(|k| k.refined.pose.is_same(&candidate.refined.pose, about)) {
            kept.push(candidate);
        }
    }
    kept
}
