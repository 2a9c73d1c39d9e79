//! Compares two poses of one SLAM map by what only one of them explains: what both explain, or neither, as furniture, tells
//! nothing about which is right.

use crate::candidate::Candidate;
use crate::pose::is_within;
use crate::score::Placed;
use crate::thresholds::{BESIDE_M, BESIDE_RAD, CONTRAST, MAX_CONTRAST};
use occupancy::{CELL_M, Cell};

/// What tells a pose from another one: natural logarithms of ratios, and a difference.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Contrast {
    /// Of the SLAM map's walls that lie in walls of the model by one pose only.
    pub in_walls: f64,
    /// Of its floor that lies where the model knows nothing, by one pose only.
    pub free_outside: f64,
    /// Of the length of distinct walls that match.
    pub distinct: f64,
    /// Of the length of walls that the robot saw through, above 0 if it did so by the other pose.
    pub seen_through: f64,
    /// Of the SLAM map's walls that lie on faces of the model exactly by one pose only.
    pub exact: f64,
    /// Of the length of the model's walls that were in sight.
    pub seen: f64,
    /// Difference of the shares of the SLAM map's walls that the model has.
    pub precision: f64,
    /// Of the number of corners of the model that were in sight and that the SLAM map has.
    pub corners: f64,
}

impl Contrast {
    /// Of a pose with another one of the same SLAM map, also if they are of different references.
    pub(crate) fn of(pose: &Candidate, other: &Candidate) -> Self {
        let (own, others) = (&pose.placed, &other.placed);
        let only = |a: &[Cell], b: &[Cell], cell: Cell| {
            a.iter().zip(b).filter(|(a, b)| **a == cell && **b != cell).count() as f64
        };
        let in_walls = |a: &Placed, b: &Placed| only(&a.occupied, &b.occupied, Cell::Occupied) * a.occupied_m;
        let outside = |a: &Placed, b: &Placed| only(&a.free, &b.free, Cell::Unknown) * a.free_m2;
        let exact = |a: &Placed, b: &Placed| {
            a.is_exact.iter().zip(&b.is_exact).filter(|(a, b)| **a && !**b).count() as f64 * CELL_M
        };
        let through_m = |candidate: &Candidate| candidate.evidence.seen_m * candidate.evidence.seen_through;
        Self {
            in_walls: ratio(in_walls(own, others), in_walls(others, own)),
            free_outside: ratio(outside(others, own), outside(own, others)),
            distinct: ratio(pose.evidence.distinct_m, other.evidence.distinct_m),
            seen_through: ratio(through_m(other), through_m(pose)),
            exact: ratio(exact(own, others), exact(others, own)),
            seen: ratio(pose.evidence.seen_m, other.evidence.seen_m),
            precision: pose.evidence.precision - other.evidence.precision,
            corners: ratio(own.corners.n_found as f64, others.corners.n_found as f64),
        }
    }

    /// Log odds that the pose is right, if one of both is; at most [`MAX_CONTRAST`] either way.
    pub fn log_odds(&self) -> f64 {
        let sum = CONTRAST.in_walls * self.in_walls
            + CONTRAST.free_outside * self.free_outside
            + CONTRAST.distinct * self.distinct
            + CONTRAST.seen_through * self.seen_through
            + CONTRAST.exact * self.exact
            + CONTRAST.seen * self.seen
            + CONTRAST.precision * self.precision
            + CONTRAST.corners * self.corners;
        sum.clamp(-MAX_CONTRAST, MAX_CONTRAST)
    }
}

/// The logarithm of the ratio of two amounts, in metres, square metres or corners, of which less than one says little.
fn ratio(a: f64, b: f64) -> f64 {
    libm::log1p(a) - libm::log1p(b)
}

/// The candidate that none contrasts with, or comes last in a circle of those; then the others, those first that contrast least
/// with it, and at the end those beside it. Candidates are given with their references, and `about` is the middle of the SLAM map.
pub(crate) fn ranked(found: &[(usize, Candidate)], about: [f64; 2]) -> Vec<Ranked<'_>> {
    let candidates: Vec<&Candidate> = found.iter().map(|(_, candidate)| candidate).collect();
    let Some((best, contrasts)) = best(&candidates) else { return Vec::new() };
    let is_beside = |(reference, candidate): &(usize, Candidate)| {
        let pose = &found[best].1.refined.pose;
        *reference == found[best].0 && is_within(&candidate.refined.pose, pose, about, BESIDE_M, BESIDE_RAD)
    };
    let mut ranked: Vec<Ranked<'_>> = (found.iter().zip(contrasts).enumerate())
        .map(|(index, (of, contrast))| {
            let is_beside = index != best && is_beside(of);
            Ranked { index, candidate: &of.1, contrast, is_beside }
        })
        .collect();
    ranked.sort_by(|a, b| {
        let place = |r: &Ranked<'_>| (r.index != best, r.is_beside);
        place(a).cmp(&place(b)).then(a.contrast.log_odds().total_cmp(&b.contrast.log_odds()))
    });
    ranked
}

/// A candidate in its place.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ranked<'a> {
    /// Where it was.
    pub(crate) index: usize,
    pub(crate) candidate: &'a Candidate,
    /// Of the best candidate with this one.
    pub(crate) contrast: Contrast,
    /// True if it is the best one's place: which of both is better is told by the contrast, and how well by the covariance.
    pub(crate) is_beside: bool,
}

/// From the one with the best evidence to that which it contrasts with most, and on; with its contrasts with all.
fn best(candidates: &[&Candidate]) -> Option<(usize, Vec<Contrast>)> {
    let mut best = 0;
    let mut was_best = vec![false; candidates.len()];
    loop {
        let first = candidates.get(best)?;
        let contrasts: Vec<Contrast> = candidates.iter().map(|other| Contrast::of(first, other)).collect();
        let log_odds = |k: usize| contrasts[k].log_odds();
        let strongest = (0..contrasts.len()).min_by(|a, b| log_odds(*a).total_cmp(&log_odds(*b)))?;
        if was_best[best] || log_odds(strongest) >= 0.0 {
            return Some((best, contrasts));
        }
        was_best[best] = true;
        best = strongest;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pose::Pose;
    use crate::refine::Refined;
    use crate::score::CornersInSight;
    use frames::PoseCovariance;
    use messages::PoseEvidence;

    fn candidate(occupied: &[Cell], distinct_m: f64) -> Candidate {
        let (pose, covariance) = (Pose::new([0.0; 2], 0.0), PoseCovariance::from_rows([[0.0; 3]; 3]));
        let placed = Placed {
            occupied: occupied.to_vec(),
            free: vec![Cell::Free; 8],
            is_exact: occupied.iter().map(|cell| *cell == Cell::Occupied).collect(),
            corners: CornersInSight::default(),
            occupied_m: 1.0,
            free_m2: 1.0,
        };
        let evidence = PoseEvidence { distinct_m, ..PoseEvidence::default() };
        Candidate { placed, ..Candidate::new(Refined { pose, covariance, about: [0.0; 2] }, evidence) }
    }

    /// Of eight cells these are in walls.
    fn in_walls(cells: std::ops::Range<usize>) -> Candidate {
        let occupied: Vec<Cell> =
            (0..8).map(|k| if cells.contains(&k) { Cell::Occupied } else { Cell::Free }).collect();
        candidate(&occupied, 3.0)
    }

    #[test]
    fn what_both_poses_explain_tells_nothing() {
        assert_eq!(Contrast::of(&in_walls(0..8), &in_walls(0..8)).log_odds(), 0.0);
        let (of_all, of_few) =
            (Contrast::of(&in_walls(0..8), &in_walls(1..8)), Contrast::of(&in_walls(0..2), &in_walls(1..2)));
        assert_eq!(of_all, of_few);
        assert!(of_all.log_odds() > 0.0);
    }

    #[test]
    fn a_contrast_speaks_as_much_for_one_pose_as_against_the_other() {
        let (a, b) = (candidate(&[Cell::Occupied, Cell::Free, Cell::Unknown], 3.0), candidate(&[Cell::Free; 3], 5.0));
        assert_eq!(Contrast::of(&a, &b).log_odds(), -Contrast::of(&b, &a).log_odds());
    }

    #[test]
    fn the_best_comes_first_then_those_that_are_harder_to_tell_from_it() {
        let all = [in_walls(0..3), in_walls(0..6), in_walls(0..8)];
        // Each on another storey: the same place, but not the same pose.
        let apart: Vec<(usize, Candidate)> = all.into_iter().enumerate().collect();
        assert_eq!(indices(&apart), [2, 1, 0]);
        assert!(ranked(&[], [0.0; 2]).is_empty());
    }

    #[test]
    fn a_pose_beside_the_best_comes_last_and_one_of_another_place_does_not() {
        let at = |candidate: Candidate, x_m: f64| {
            let pose = Pose::new([x_m, 0.0], 0.0);
            (0, Candidate { refined: Refined { pose, ..candidate.refined }, ..candidate })
        };
        let all = [at(in_walls(0..7), BESIDE_M - 0.1), at(in_walls(0..3), BESIDE_M + 0.1), at(in_walls(0..8), 0.0)];
        assert_eq!(indices(&all), [2, 1, 0]);
        let beside: Vec<bool> = ranked(&all, [0.0; 2]).iter().map(|r| r.is_beside).collect();
        assert_eq!(beside, [false, false, true]);
    }

    fn indices(found: &[(usize, Candidate)]) -> Vec<usize> {
        ranked(found, [0.0; 2]).iter().map(|r| r.index).collect()
    }
}
