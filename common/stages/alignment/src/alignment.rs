//! Alignment of a SLAM map with maps of the model: the public entry points.

use crate::candidate::Candidate;
use crate::candidates::sampled_points;
use crate::contrast::{Contrast, Ranked, ranked};
use crate::decision::Decision;
use crate::exclusion::Exclusion;
use crate::features::Features;
use crate::pose::{Cells, Pose};
use crate::random_generator::RandomGenerator;
use crate::scale::{Scale, scale};
use crate::search::{PoseGuess, search};
use crate::thresholds::MIN_WALL_POINTS;
use crate::verdict::PoseVerdict;
use crate::wall_points::Surfaces;
use frames::{Map, PoseCovariance, Rigid2, Slam};
use messages::{AlignmentVerdict, PoseEvidence};
use occupancy::{OccupancyMap, Raster};

/// A map that is ready to be compared; `Frame` is that of the model's map or of the robot's.
pub struct PreparedMap<Frame> {
    pub(crate) features: Features,
    frame_from_cells: Rigid2<Frame, Cells<Frame>>,
}

impl PreparedMap<Map> {
    /// A map that was drawn from a model: its cells are occupied up to the surfaces of walls.
    pub fn of_model(map: &OccupancyMap) -> Self {
        Self::of(map, Surfaces { depth_m: 0.0, are_whole: true })
    }
}

impl PreparedMap<Slam> {
    /// A map that a robot made: a cell in which a surface was hit is occupied, and it lies anywhere in it.
    pub fn of_slam(map: &OccupancyMap) -> Self {
        Self::of(map, Surfaces { depth_m: map.resolution_m / 2.0, are_whole: false })
    }
}

impl<Frame> PreparedMap<Frame> {
    fn of(map: &OccupancyMap, surfaces: Surfaces) -> Self {
        let features = Features::of(Raster::of(&map.cells, map.width, map.resolution_m), surfaces);
        Self { features, frame_from_cells: Rigid2::of_x_y_yaw(map.origin) }
    }

    /// Length of the faces of its walls, in metres.
    pub fn walls_m(&self) -> f64 {
        self.features.walls_m()
    }

    pub(crate) fn frame_from_cells(&self) -> &Rigid2<Frame, Cells<Frame>> {
        &self.frame_from_cells
    }
}

impl<Frame> AsRef<Self> for PreparedMap<Frame> {
    fn as_ref(&self) -> &Self {
        self
    }
}

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
            map_from_slam: &(&reference.frame_from_cells * &refined.pose) * &slam.frame_from_cells.inverse(),
            evidence: *evidence,
            contrast: Contrast::default(),
            about_m: slam.frame_from_cells.apply(centre),
            covariance: refined.covariance_at(centre).turned(&reference.frame_from_cells),
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
    /// The reason if not accepted, else empty.
    pub reason: String,
    /// Probability that the best pose is wrong: another one is right, or the building is another.
    pub wrong_probability: f64,
    /// Poses after the best of which each alone keeps it from being accepted.
    pub n_rivals: usize,
    /// Poses that were found, best first.
    pub poses: Vec<AlignedPose>,
    /// Lengths of the SLAM map in the best of them; `None` if too little matches to tell.
    pub scale: Option<Scale>,
    /// What would decide between poses that fit alike; `None` before [`Alignment::decide`], and where that has nothing to do.
    pub decision: Option<Decision>,
    /// What each place hint excluded.
    pub exclusions: Vec<Exclusion>,
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
            scale: None,
            decision: None,
            exclusions: Vec::new(),
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
    judged(references, slam, &candidates_of(references, slam, hint))
}

/// The poses that fit any of the references, each with the index of its reference, best first.
pub(crate) fn candidates_of(
    references: &[impl AsRef<PreparedMap<Map>>],
    slam: &PreparedMap<Slam>,
    hint: Option<&Hint>,
) -> Vec<(usize, Candidate)> {
    let mut found: Vec<(usize, Candidate)> = Vec::new();
    for (at, reference) in references.iter().map(AsRef::as_ref).enumerate() {
        let near = hint.map(|hint| PoseGuess {
            pose: between_cells(reference, slam, &hint.map_from_slam),
            radius_m: hint.radius_m,
            radius_rad: hint.radius_rad,
        });
        if slam.features.wall_points.len() >= MIN_WALL_POINTS {
            found.extend(search(&reference.features, &slam.features, near.as_ref()).into_iter().map(|c| (at, c)));
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
    let ranked = ranked(found.iter().map(|(_, candidate)| candidate).collect());
    let PoseVerdict { verdict, reason, wrong_probability, n_rivals } = PoseVerdict::of(&slam.features, &ranked);
    let pose = |r: &Ranked<'_>| {
        let at = found[r.index].0;
        AlignedPose { contrast: r.contrast, ..AlignedPose::of(at, references[at].as_ref(), slam, r.candidate) }
    };
    let poses = ranked.iter().map(pose).collect();
    let scale = ranked.first().map(|r| &found[r.index]).and_then(|(at, best)| {
        let sampled_points = sampled_points(&slam.features, &mut RandomGenerator::new(1));
        scale(&references[*at].as_ref().features, &slam.features, &sampled_points, &best.refined.pose)
    });
    Alignment { verdict, reason, wrong_probability, n_rivals, poses, scale, ..Alignment::nothing_yet() }
}

/// The pose of the cells of two maps whose frames lie to each other by a motion.
pub(crate) fn between_cells(
    reference: &PreparedMap<Map>,
    slam: &PreparedMap<Slam>,
    map_from_slam: &Rigid2<Map, Slam>,
) -> Pose {
    &(&reference.frame_from_cells.inverse() * map_from_slam) * &slam.frame_from_cells
}
