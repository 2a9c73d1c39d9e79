//! Alignment of a SLAM map with maps of the model: the public entry points.

use crate::chance::Chance;
use crate::features::Features;
use crate::refine::Refined;
use crate::scale::{Scale, scale};
use crate::search::{Candidate, Near, drawn, search};
use crate::thresholds::LEAST_FACES;
use crate::verdict::judged;
use messages::{Evidence, Verdict};
use occupancy::{MapFromSlam, OccupancyMap, Pose, Raster, congruent, transported, wrapped};

/// A map that is ready to be compared.
pub struct PreparedMap {
    pub(crate) features: Features,
    origin: Pose,
}

impl PreparedMap {
    /// A map that was drawn from a model: its cells are occupied up to the surfaces of walls.
    pub fn of_model(map: &OccupancyMap) -> Self {
        Self::of(map, 0.0)
    }

    /// A map that a robot made: a cell in which a surface was hit is occupied, and it lies anywhere in it.
    pub fn of_slam(map: &OccupancyMap) -> Self {
        Self::of(map, map.resolution_m / 2.0)
    }

    fn of(map: &OccupancyMap, depth_m: f64) -> Self {
        let [x, y, yaw] = map.origin;
        let features = Features::of(Raster::of(&map.cells, map.width, map.resolution_m), depth_m);
        Self { features, origin: Pose::new([x, y], yaw) }
    }
}

impl AsRef<Self> for PreparedMap {
    fn as_ref(&self) -> &Self {
        self
    }
}

/// A pose that was found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AlignedPose {
    /// Which of the maps of the model.
    pub reference: usize,
    /// Where the SLAM map lies in the model's map.
    pub map_from_slam: MapFromSlam,
    /// What speaks for it.
    pub evidence: Evidence,
    /// The mean of the SLAM map's free cells, in its frame.
    pub about_m: [f64; 2],
    /// Of where that place lies in the model's map (x, y) and of yaw; metres and radians.
    pub covariance: [[f64; 3]; 3],
}

impl AlignedPose {
    pub(crate) fn of(at: usize, reference: &PreparedMap, slam: &PreparedMap, candidate: &Candidate) -> Self {
        Self {
            reference: at,
            map_from_slam: motion(reference, slam, &candidate.refined.pose),
            evidence: candidate.evidence,
            about_m: slam.origin.apply(slam.features.centre),
            covariance: covariance(reference, slam, &candidate.refined),
        }
    }

    /// The covariance of x, y and yaw of `map_from_slam` themselves.
    pub fn covariance_of_motion(&self) -> [[f64; 3]; 3] {
        let [x, y] = self.map_from_slam.apply(self.about_m);
        transported(&self.covariance, [self.map_from_slam.x_m - x, self.map_from_slam.y_m - y])
    }
}

/// The pose of a SLAM map in the model's map, and how sure it is.
#[derive(Debug, Clone, PartialEq)]
pub struct Alignment {
    /// How sure.
    pub verdict: Verdict,
    /// Why it is not accepted; empty if it is.
    pub reason: String,
    /// Poses that were found, best first.
    pub poses: Vec<AlignedPose>,
    /// Lengths of the SLAM map in the best of them; `None` if too little matches to tell.
    pub scale: Option<Scale>,
}

impl Alignment {
    /// Before anything was searched.
    pub fn nothing_yet() -> Self {
        let reason = "no pose was searched yet".to_owned();
        Self { verdict: Verdict::Refused, reason, poses: Vec::new(), scale: None }
    }
}

/// A guess of where a SLAM map lies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hint {
    /// The guess.
    pub map_from_slam: MapFromSlam,
    /// How far the middle of the SLAM map may be from where the guess has it.
    pub radius_m: f64,
    /// How much the yaw may differ.
    pub radius_rad: f64,
}

impl Hint {
    /// A guess in degrees, as people write them: x and y of the motion in metres and its yaw.
    pub fn in_degrees([x_m, y_m, yaw_deg]: [f64; 3], radius_m: f64, radius_deg: f64) -> Self {
        let map_from_slam = MapFromSlam { x_m, y_m, yaw_rad: yaw_deg.to_radians() };
        Self { map_from_slam, radius_m, radius_rad: radius_deg.to_radians() }
    }
}

/// Aligns a SLAM map with one of several maps of the model, one for each storey: anywhere, or near a guess. The same maps give
/// the same bits.
pub fn align_maps(references: &[impl AsRef<PreparedMap>], slam: &PreparedMap, hint: Option<&Hint>) -> Alignment {
    let mut found: Vec<(usize, Candidate)> = Vec::new();
    for (at, reference) in references.iter().map(AsRef::as_ref).enumerate() {
        let near = hint.map(|hint| Near {
            pose: between_corners(reference, slam, &hint.map_from_slam),
            radius_m: hint.radius_m,
            radius_rad: hint.radius_rad,
        });
        if slam.features.faces.len() >= LEAST_FACES {
            found.extend(search(&reference.features, &slam.features, near.as_ref()).into_iter().map(|c| (at, c)));
        }
    }
    found.sort_by(|a, b| b.1.evidence.score.total_cmp(&a.1.evidence.score));
    let (verdict, reason) = judged(&slam.features, &found.iter().map(|f| &f.1).collect::<Vec<_>>());
    let poses = found.iter().map(|(at, c)| AlignedPose::of(*at, references[*at].as_ref(), slam, c)).collect();
    let scale = found.first().and_then(|(at, best)| {
        let drawn = drawn(&slam.features, &mut Chance::new(1));
        scale(&references[*at].as_ref().features, &slam.features, &drawn, &best.refined.pose)
    });
    Alignment { verdict, reason, poses, scale }
}

/// From the corners of the maps to their frames.
fn motion(reference: &PreparedMap, slam: &PreparedMap, pose: &Pose) -> MapFromSlam {
    let yaw_rad = wrapped(reference.origin.yaw_rad + pose.yaw_rad - slam.origin.yaw_rad);
    let corner = reference.origin.apply(pose.t);
    // The SLAM map's corner lies there.
    let turned = Pose::new([0.0; 2], yaw_rad).turn(slam.origin.t);
    MapFromSlam { x_m: corner[0] - turned[0], y_m: corner[1] - turned[1], yaw_rad }
}

/// From the frames of the maps to their corners.
pub(crate) fn between_corners(reference: &PreparedMap, slam: &PreparedMap, motion: &MapFromSlam) -> Pose {
    let corner = reference.origin.undo(motion.apply(slam.origin.t));
    Pose::new(corner, wrapped(motion.yaw_rad + slam.origin.yaw_rad - reference.origin.yaw_rad))
}

/// From the place that a refinement turned around to the middle of the SLAM map, in the axes of the model's map.
fn covariance(reference: &PreparedMap, slam: &PreparedMap, refined: &Refined) -> [[f64; 3]; 3] {
    let at_middle = refined.covariance_at(slam.features.centre);
    let [ex, ey] = [[1.0, 0.0], [0.0, 1.0]].map(|axis| reference.origin.turn(axis));
    congruent(&[[ex[0], ey[0], 0.0], [ex[1], ey[1], 0.0], [0.0, 0.0, 1.0]], &at_middle)
}
