//! Refines poses roughly, the best exactly, and looks for their twins.

use crate::candidate::Candidate;
use crate::correlation::{OtherFace, correlated};
use crate::features::Features;
use crate::pose::{Pose, is_same_pose, is_within, moved};
use crate::random_generator::RandomGenerator;
use crate::refine::{FINE, NARROW, SOFT, TIGHT, WIDE, refined};
use crate::rotations::{directions, turns};
use crate::score::{ComparedMaps, SlamCells, evidence, placed};
use crate::thresholds::{MIN_OTHERS, N_REFINED, N_TWIN_PEAKS, N_TWINS, SOFT_ADVANTAGE};
use crate::wall_points::{WallPoint, drawn_evenly};

/// Wall points and cells that are drawn.
const N_WALL_POINTS: usize = 1500;
const N_REFERENCE_POINTS: usize = 3000;
const N_OCCUPIED_CELLS: usize = 2000;
const N_FREE_CELLS: usize = 3000;
/// Starts of an exact refinement at one place, and how far they differ.
const N_STARTS: usize = 3;
const OTHER_START_M: f64 = 0.12;
const OTHER_START_RAD: f64 = 0.02;
/// Best places at which poses around are tried too, and how far off these are.
const N_SURROUNDED: usize = 6;
const AROUND_M: f64 = 0.3;
const AROUND_RAD: f64 = 0.04;
/// A wall point is explained by a face that is this close, with about the same normal.
const EXPLAINED_M: f64 = 0.15;
const EXPLAINED_AGREEMENT: f64 = 0.8;
/// Those that poses are compared by at first.
const N_COARSE_POINTS: usize = 350;
const N_COARSE_REFERENCE_POINTS: usize = 800;
const COARSE_CELL_STEP: usize = 4;

/// Refines all poses roughly and the best exactly, then the twins of the best if they are wanted; best first, no two the same.
pub(crate) fn candidates(reference: &Features, slam: &Features, poses: &[Pose], with_twins: bool) -> Vec<Candidate> {
    let mut random = RandomGenerator::new(1);
    let exact = Drawn::of(reference, slam, &mut random);
    let rough = exact.few(&mut random);
    let refinement = Refinement { exact: exact.maps(reference, slam), rough: rough.maps(reference, slam) };
    let about = slam.centre;
    let mut found = distinct(refinement.best_of(poses, N_REFINED, N_SURROUNDED), about);
    if let Some(best) = found.first().filter(|_| with_twins) {
        let mut twins = refinement.twins(&best.refined.pose);
        twins.retain(|twin| !found.iter().any(|other| is_same_pose(&other.refined.pose, twin, about)));
        found.extend(refinement.best_of(&twins, N_TWINS, 0));
        found = distinct(found, about);
        add_leads(&mut found);
    }
    for candidate in &mut found {
        candidate.refined = candidate.refined.with_distortion(reference, &exact.slam_points);
        candidate.placed = placed(&refinement.exact, &candidate.refined.pose);
    }
    found
}

/// What is compared of two maps: the same of the same maps.
struct Drawn {
    slam_points: Vec<WallPoint>,
    reference_points: Vec<WallPoint>,
    slam_cells: SlamCells,
}

impl Drawn {
    fn of(reference: &Features, slam: &Features, random: &mut RandomGenerator) -> Self {
        Self {
            slam_points: sampled_points(slam, random),
            reference_points: drawn_evenly(reference.wall_points(), N_REFERENCE_POINTS, random),
            slam_cells: SlamCells::drawn(&slam.raster, N_OCCUPIED_CELLS, N_FREE_CELLS),
        }
    }

    /// Some of them, to compare many poses.
    fn few(&self, random: &mut RandomGenerator) -> Self {
        Self {
            slam_points: drawn_evenly(&self.slam_points, N_COARSE_POINTS, random),
            reference_points: drawn_evenly(&self.reference_points, N_COARSE_REFERENCE_POINTS, random),
            slam_cells: self.slam_cells.thinned(COARSE_CELL_STEP),
        }
    }

    fn maps<'a>(&'a self, reference: &'a Features, slam: &'a Features) -> ComparedMaps<'a> {
        let Self { slam_points, reference_points, slam_cells } = self;
        ComparedMaps { slam, reference, slam_points, reference_points, slam_cells, scans: false }
    }
}

/// Refinement of many poses of two maps.
struct Refinement<'a> {
    exact: ComparedMaps<'a>,
    rough: ComparedMaps<'a>,
}

impl Refinement<'_> {
    fn about(&self) -> [f64; 2] {
        self.exact.slam.centre
    }

    fn refined(&self, maps: &ComparedMaps<'_>, pose: &Pose, scales: &[f64]) -> Option<Candidate> {
        let refined = refined(maps.reference, maps.slam_points, *pose, scales)?;
        Some(Candidate::new(refined, evidence(maps, &refined.pose)))
    }

    /// The poses at the `n` places that look best, refined exactly; at the first of them poses around are tried too.
    fn best_of(&self, poses: &[Pose], n: usize, n_surrounded: usize) -> Vec<Candidate> {
        let roughly = |pose: &Pose| [&WIDE[..], &NARROW].map(|scales| self.refined(&self.rough, pose, scales));
        let mut places = starts(poses.iter().flat_map(roughly).flatten().collect(), self.about());
        places.truncate(n);
        for starts in places.iter_mut().take(n_surrounded) {
            let around = surroundings(&starts[0], self.about());
            let found = around.iter().filter_map(|pose| self.refined(&self.rough, pose, &NARROW)).reduce(better);
            starts.extend(found.map(|best| best.refined.pose));
        }
        places.iter().filter_map(|starts| self.exactly(starts)).collect()
    }

    /// The best that comes of these starts at one place, at scales for maps that are sharp or distorted.
    fn exactly(&self, starts: &[Pose]) -> Option<Candidate> {
        let first = starts.first()?;
        let tight = self.refined(&self.exact, first, &TIGHT);
        let fine = starts.iter().filter_map(|pose| self.refined(&self.exact, pose, &FINE));
        let sharp = tight.into_iter().chain(fine).reduce(better);
        match (sharp, self.refined(&self.exact, first, &SOFT)) {
            (Some(sharp), Some(soft)) if soft.evidence.log_odds > sharp.evidence.log_odds + SOFT_ADVANTAGE => {
                Some(soft)
            }
            (sharp, soft) => sharp.or(soft),
        }
    }

    /// Poses by which the walls that the reference has by a pose lie on other walls of it, as in wings that are alike: furniture,
    /// and what was seen of other buildings, keep them from being found with the whole map.
    fn twins(&self, pose: &Pose) -> Vec<Pose> {
        let ComparedMaps { slam, reference, slam_points, .. } = self.exact;
        let is_explained = |wall_point: &&WallPoint| {
            let normal = pose.rotate(wall_point.normal);
            reference.nearest(pose.apply(wall_point.at)).is_some_and(|(nearest, squared)| {
                squared <= EXPLAINED_M * EXPLAINED_M
                    && normal[0] * nearest.normal[0] + normal[1] * nearest.normal[1] > EXPLAINED_AGREEMENT
            })
        };
        let explained: Vec<WallPoint> = slam_points.iter().filter(is_explained).copied().collect();
        let turns = turns(&directions(&explained), reference.directions());
        correlated(slam, &explained, reference, &turns, OtherFace::Ignored, N_TWIN_PEAKS)
    }
}

/// Adds to candidates, best first, how far each stands above the median of the others.
fn add_leads(candidates: &mut [Candidate]) {
    let log_odds: Vec<f64> = candidates.iter().map(|c| c.evidence.log_odds).collect();
    for (k, candidate) in candidates.iter_mut().enumerate() {
        candidate.lead = lead(&log_odds, k);
    }
}

/// Log odds of the `k`-th above the median of the others, of a list in descending order; `None` if others are few.
fn lead(log_odds: &[f64], k: usize) -> Option<f64> {
    let others: Vec<f64> =
        log_odds.iter().enumerate().filter(|(other, _)| *other != k).map(|(_, value)| *value).collect();
    let n = others.len();
    let median = (others.get(n / 2)? + others.get(n.saturating_sub(1) / 2)?) / 2.0;
    (n >= MIN_OTHERS).then(|| log_odds[k] - median)
}

fn better(a: Candidate, b: Candidate) -> Candidate {
    if b.evidence.log_odds > a.evidence.log_odds { b } else { a }
}

/// The wall points of a SLAM map that are compared.
pub(crate) fn sampled_points(slam: &Features, random: &mut RandomGenerator) -> Vec<WallPoint> {
    let wall_points = slam.wall_points();
    let numbers = random.draw(wall_points.iter().map(|f| f.weight), N_WALL_POINTS);
    numbers.into_iter().map(|k| wall_points[k as usize]).collect()
}

/// Poses from which to refine exactly: of each place the best, and those that differ by more than a fine refinement reaches. What
/// looks best at first may be drawn away by furniture.
fn starts(mut candidates: Vec<Candidate>, about: [f64; 2]) -> Vec<Vec<Pose>> {
    candidates.sort_by(|a, b| b.evidence.log_odds.total_cmp(&a.evidence.log_odds));
    let mut places: Vec<Vec<Pose>> = Vec::new();
    for candidate in candidates {
        let pose = candidate.refined.pose;
        match places.iter_mut().find(|starts| is_same_pose(&starts[0], &pose, about)) {
            None => places.push(vec![pose]),
            Some(starts) => {
                let is_other = |start: &Pose| !is_within(start, &pose, about, OTHER_START_M, OTHER_START_RAD);
                if starts.len() < N_STARTS && starts.iter().all(is_other) {
                    starts.push(pose);
                }
            }
        }
    }
    places
}

/// Poses around one, to each side.
fn surroundings(pose: &Pose, about: [f64; 2]) -> Vec<Pose> {
    let middle = pose.apply(about);
    let sides = |step: f64| [-step, 0.0, step];
    let mut poses = Vec::new();
    for x in sides(AROUND_M) {
        for y in sides(AROUND_M) {
            poses.extend(sides(AROUND_RAD).map(|turn| moved(pose, [x, y, turn], middle)));
        }
    }
    poses
}

/// Best first, without those that are the same as a better one.
fn distinct(mut candidates: Vec<Candidate>, about: [f64; 2]) -> Vec<Candidate> {
    candidates.sort_by(|a, b| b.evidence.log_odds.total_cmp(&a.evidence.log_odds));
    let mut kept: Vec<Candidate> = Vec::new();
    for candidate in candidates {
        if !kept.iter().any(|k| is_same_pose(&k.refined.pose, &candidate.refined.pose, about)) {
            kept.push(candidate);
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lead_is_that_over_the_median_of_the_others() {
        let log_odds = [9.0, 4.0, 3.0, 2.0, 1.0, 0.0, -1.0];
        assert_eq!(lead(&log_odds, 0), Some(9.0 - 1.5));
        assert_eq!(lead(&log_odds, 2), Some(3.0 - 1.5));
        assert_eq!(lead(&log_odds[..6], 0), Some(9.0 - 2.0));
        assert_eq!(lead(&log_odds[..MIN_OTHERS], 0), None);
        assert_eq!(lead(&log_odds[..1], 0), None);
    }
}
