//! Alignment of a SLAM map with maps of the model: the public entry points.

use crate::candidate::Candidate;
use crate::candidates::sampled_points;
use crate::contrast::{Contrast, Ranked, ranked};
use crate::decision::Decision;
use crate::exclusion::Exclusion;
use crate::held_out::{HeldOut, PoseHistory};
use crate::looks::{Looks, storey_of};
use crate::pose::{Pose, is_same_pose};
use crate::pose_field::PoseField;
use crate::prepared_map::{PreparedMap, between_cells};
use crate::random_generator::RandomGenerator;
use crate::scale::{Scale, scale};
use crate::score::CornersInSight;
use crate::search::{PoseGuess, search};
use crate::thresholds::{MAX_UNBENT_PROBABILITY, MIN_DISTINCT_M, MIN_WALL_POINTS};
use crate::verdict::PoseVerdict;
use frames::{Map, PoseCovariance, Rigid2, Slam};
use messages::{AlignmentVerdict, PoseEvidence};

/// A pose that was found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AlignedPose {
    /// Which of the maps of the model.
    pub reference: usize,
    /// Pose of the SLAM map in the model's map.
    pub map_from_slam: Rigid2<Map, Slam>,
    /// Its score with the parts.
    pub evidence: PoseEvidence,
    /// Of the best pose that was found with this one; zeros where none are compared.
    pub contrast: Contrast,
    /// Zeros where none are compared.
    pub corners: CornersInSight,
    /// What new places of a growing map say about it; `None` if no earlier look found it.
    pub new: Option<HeldOut>,
    /// Log odds over looks that the SLAM map is of this building and storey.
    pub history: PoseHistory,
    /// The mean of the SLAM map's free cells, in its frame.
    pub about_m: [f64; 2],
    /// Of where that place lies in the model's map and of yaw.
    pub covariance: PoseCovariance,
}

impl AlignedPose {
    pub(crate) fn of(at: usize, reference: &PreparedMap<Map>, slam: &PreparedMap<Slam>, candidate: &Candidate) -> Self {
        let Candidate { refined, evidence, .. } = candidate;
        let centre = slam.features.centre;
        Self {
            reference: at,
            map_from_slam: &(reference.frame_from_cells() * &refined.pose) * &slam.frame_from_cells().inverse(),
            evidence: *evidence,
            contrast: Contrast::default(),
            corners: CornersInSight::default(),
            new: candidate.new,
            history: candidate.history(),
            about_m: slam.frame_from_cells().apply(centre),
            covariance: refined.covariance_at(centre).turned(reference.frame_from_cells()),
        }
    }

    /// The covariance of x, y and yaw of `map_from_slam` themselves.
    pub fn covariance_of_motion(&self) -> PoseCovariance {
        let ([x, y], [x_about, y_about]) = (self.map_from_slam.translation_m(), self.map_from_slam.apply(self.about_m));
        self.covariance.transported([x - x_about, y - y_about])
    }
}

/// The result of an alignment: verdict and poses.
#[derive(Debug, Clone, PartialEq)]
pub struct Alignment {
    /// The verdict.
    pub verdict: AlignmentVerdict,
    /// Why it is not accepted, and what is wrong with the SLAM map, which may also be said of one that is; else empty.
    pub reason: String,
    /// Probability that the best pose is wrong: another one is right, or the building is another.
    pub wrong_probability: f64,
    /// Poses after the best of which each alone keeps it from being accepted, were the building certain.
    pub n_rivals: usize,
    /// Poses that were found, best first.
    pub poses: Vec<AlignedPose>,
    /// The pose from place to place, from the best of them; `None` unless it is accepted.
    pub field: Option<PoseField>,
    /// Lengths of the SLAM map in the best of them; `None` if too little matches to tell.
    pub scale: Option<Scale>,
    /// What would decide between poses that fit alike; `None` before [`Alignment::decide`], and where that has nothing to do.
    pub decision: Option<Decision>,
    /// What each place hint excluded.
    pub exclusions: Vec<Exclusion>,
    /// What became of the pose that an earlier look accepted, if it is not accepted any more.
    pub change: Option<String>,
}

impl Alignment {
    /// The state before the first search.
    pub fn nothing_yet() -> Self {
        let reason = "no pose was searched yet".to_owned();
        Self {
            verdict: AlignmentVerdict::Refused,
            reason,
            wrong_probability: 1.0,
            n_rivals: 0,
            poses: Vec::new(),
            field: None,
            scale: None,
            decision: None,
            exclusions: Vec::new(),
            change: None,
        }
    }
}

/// An initial guess of the pose of a SLAM map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hint {
    /// The guess.
    pub map_from_slam: Rigid2<Map, Slam>,
    /// Maximum distance of the middle of the SLAM map from the guess.
    pub radius_m: f64,
    /// Maximum difference in yaw.
    pub radius_rad: f64,
}

impl Hint {
    /// A guess from x and y in metres and yaw in degrees.
    pub fn in_degrees([x_m, y_m, yaw_deg]: [f64; 3], radius_m: f64, radius_deg: f64) -> Self {
        let map_from_slam = Rigid2::new([x_m, y_m], yaw_deg.to_radians());
        Self { map_from_slam, radius_m, radius_rad: radius_deg.to_radians() }
    }
}

/// Aligns a SLAM map with one of several maps of the model, one for each storey: anywhere, or near a guess. The same maps give
/// the same bits.
pub fn align_maps(
    references: &[impl AsRef<PreparedMap<Map>>],
    slam: &PreparedMap<Slam>,
    hint: Option<&Hint>,
) -> Alignment {
    let found = judged(references, slam, &candidates_of(references, &[], slam, hint, None));
    let found =
        if hint.is_none() { judged_unbent(found, references, slam).with_faults(references, slam) } else { found };
    found.with_storeys(references, &[], slam)
}

/// The same anywhere, without a word on what is wrong with the map.
pub(crate) fn judged_anywhere(references: &[impl AsRef<PreparedMap<Map>>], slam: &PreparedMap<Slam>) -> Alignment {
    judged(references, slam, &candidates_of(references, &[], slam, None, None))
}

/// The poses that fit any of the references, each with the index of its reference, best first; with what earlier looks say.
pub(crate) fn candidates_of(
    references: &[impl AsRef<PreparedMap<Map>>],
    storeys: &[u32],
    slam: &PreparedMap<Slam>,
    hint: Option<&Hint>,
    looks: Option<&Looks<'_>>,
) -> Vec<(usize, Candidate)> {
    let mut found: Vec<(usize, Candidate)> = Vec::new();
    for (at, reference) in references.iter().map(AsRef::as_ref).enumerate() {
        let near = hint.map(|hint| PoseGuess {
            pose: between_cells(reference, slam, &hint.map_from_slam),
            radius_m: hint.radius_m,
            radius_rad: hint.radius_rad,
        });
        if slam.features.n_wall_points() < MIN_WALL_POINTS {
            continue;
        }
        let storey = storey_of(storeys, at);
        let earlier: Vec<Pose> = looks.iter().flat_map(|looks| looks.poses_on(storey, reference, slam)).collect();
        for mut candidate in search(&reference.features, &slam.features, near.as_ref(), &earlier) {
            looks.iter().for_each(|looks| looks.carry(storey, reference, slam, &mut candidate));
            found.push((at, candidate));
        }
    }
    found.sort_by(|a, b| b.1.evidence.log_odds.total_cmp(&a.1.evidence.log_odds));
    found
}

/// The alignment that these poses make, best first.
pub(crate) fn judged(
    references: &[impl AsRef<PreparedMap<Map>>],
    slam: &PreparedMap<Slam>,
    found: &[(usize, Candidate)],
) -> Alignment {
    let ranked = ranked(found, slam.features.centre);
    let PoseVerdict { verdict, reason, wrong_probability, n_rivals } = PoseVerdict::of(&slam.features, &ranked);
    let pose = |r: &Ranked<'_>| {
        let at = found[r.index].0;
        let corners = r.candidate.placed.corners;
        AlignedPose { contrast: r.contrast, corners, ..AlignedPose::of(at, references[at].as_ref(), slam, r.candidate) }
    };
    let poses: Vec<AlignedPose> = ranked.iter().map(pose).collect();
    let accepted = poses.first().filter(|_| verdict == AlignmentVerdict::Accepted);
    let field = accepted.map(|best| PoseField::of(references[best.reference].as_ref(), slam, &best.map_from_slam));
    let scale = ranked.first().map(|r| &found[r.index]).and_then(|(at, best)| {
        let sampled_points = sampled_points(&slam.features, &mut RandomGenerator::new(1));
        scale(&references[*at].as_ref().features, &slam.features, &sampled_points, &best.refined.pose)
    });
    Alignment { verdict, reason, wrong_probability, n_rivals, poses, field, scale, ..Alignment::nothing_yet() }
}

/// An alignment that is refused although its best pose is likely to be right is judged again with the map as the poses of its parts
/// straighten it: a bend hides walls and corners from one pose. The field of poses stays that of the map as it is.
pub(crate) fn judged_unbent(
    found: Alignment,
    references: &[impl AsRef<PreparedMap<Map>>],
    slam: &PreparedMap<Slam>,
) -> Alignment {
    let is_likely = found.verdict == AlignmentVerdict::Refused && found.wrong_probability < MAX_UNBENT_PROBABILITY;
    // A map that shows little shows no more when it is straight.
    let is_enough = |best: &&AlignedPose| is_likely && best.evidence.distinct_m >= MIN_DISTINCT_M;
    let Some(best) = found.poses.first().filter(is_enough) else { return found };
    let field = PoseField::of(references[best.reference].as_ref(), slam, &best.map_from_slam);
    let Some(unbent) = slam.unbent(&field, &best.map_from_slam) else { return found };
    let judged = judged_anywhere(references, &unbent);
    let accepted = judged.poses.first().filter(|_| judged.verdict == AlignmentVerdict::Accepted).copied();
    let is_there = |pose: &AlignedPose| {
        pose.reference == best.reference && is_same_pose(&pose.map_from_slam, &best.map_from_slam, best.about_m)
    };
    match accepted.filter(is_there) {
        Some(pose) => {
            let field = PoseField::of(references[pose.reference].as_ref(), slam, &pose.map_from_slam);
            Alignment { field: Some(field), ..judged }
        }
        None => found,
    }
}
