//! Earlier looks at a growing SLAM map: what they said about poses is tested by what is new, and goes on to the next look.

use crate::candidate::Candidate;
use crate::held_out::{HeldOut, PoseHistory};
use crate::known_cells::{NewPlaces, PlacedRaster};
use crate::pose::{Pose, is_same_pose};
use crate::prepared_map::{PreparedMap, between_cells};
use crate::thresholds::{MIN_CONTINUED_SHARE, MIN_NEW_SHARE};
use frames::{Map, Rigid2, Slam};
use messages::{AlignmentEvidence, ContentHash, NONE, PoseHistoryRecord};
use xxhash_rust::xxh3::Xxh3;

/// Earlier looks at a SLAM map that has grown since.
pub struct Looks<'a> {
    pub(crate) evidence: AlignmentEvidence<'a>,
    new_places: NewPlaces,
    /// True if enough is new for another look.
    pub(crate) has_grown: bool,
}

impl<'a> Looks<'a> {
    /// The looks that this evidence is of, if the SLAM map goes on with them: at the same maps of the model, and most of what was
    /// known is known. A robot that began another map starts anew.
    ///
    /// `references_hash` is that of [`references_hash`].
    pub fn of(evidence: AlignmentEvidence<'a>, references_hash: ContentHash, slam: &PreparedMap<Slam>) -> Option<Self> {
        let map = placed_raster(slam);
        let [n_known, n_kept] = map.kept_of(&evidence);
        let is_continued = n_kept as f64 >= MIN_CONTINUED_SHARE * n_known as f64;
        if evidence.head.references_hash != references_hash || !is_continued {
            return None;
        }
        let new_places = NewPlaces::of(map, &evidence);
        let has_grown = new_places.n_known(map.raster) as f64 >= MIN_NEW_SHARE * n_known as f64;
        Some(Self { evidence, new_places, has_grown })
    }

    /// Poses of earlier looks on a map of the model; a search fits them to the newest map.
    pub(crate) fn poses_on<'s>(
        &'s self,
        storey: u32,
        reference: &'s PreparedMap<Map>,
        slam: &'s PreparedMap<Slam>,
    ) -> impl Iterator<Item = Pose> + 's {
        let here = self.evidence.poses.iter().filter(move |pose| pose.map_storey == storey);
        here.map(|pose| between_cells(reference, slam, &pose.map_from_slam()))
    }

    /// Adds to candidates what earlier looks and new places say.
    pub(crate) fn carry(
        &self,
        storey: u32,
        reference: &PreparedMap<Map>,
        slam: &PreparedMap<Slam>,
        candidate: &mut Candidate,
    ) {
        let pose = candidate.refined.pose;
        let map_from_slam = &(reference.frame_from_cells() * &pose) * &slam.frame_from_cells().inverse();
        let Some(earlier) = self.evidence.poses.iter().find(|e| is_same(e, storey, &map_from_slam)) else { return };
        let new = HeldOut::of(&reference.features, &slam.features, &pose, &self.new_places);
        let PoseHistoryRecord { of_this_building, seen_m, recalled_m, through_m, .. } = *earlier;
        let held_out = HeldOut { seen_m, recalled_m, through_m }.and(&new);
        candidate.new = Some(new);
        candidate.history = Some(PoseHistory { of_this_building, held_out });
    }
}

/// What identifies maps of the model: evidence of others says nothing about them. `storeys` are those of the references.
pub fn references_hash(references: &[impl AsRef<PreparedMap<Map>>], storeys: &[u32]) -> ContentHash {
    let mut hash = Xxh3::new();
    for (reference, storey) in references.iter().map(AsRef::as_ref).zip(storeys) {
        let raster = &reference.features.raster;
        hash.update(&storey.to_le_bytes());
        hash.update(&(raster.width as u64).to_le_bytes());
        reference.frame_from_cells().x_y_yaw().iter().for_each(|c| hash.update(&c.to_le_bytes()));
        hash.update(&raster.cells.iter().map(|cell| *cell as u8).collect::<Vec<u8>>());
    }
    ContentHash::from_bits(hash.digest())
}

pub(crate) fn placed_raster(slam: &PreparedMap<Slam>) -> PlacedRaster<'_> {
    PlacedRaster { raster: &slam.features.raster, slam_from_cells: slam.frame_from_cells() }
}

pub(crate) fn storey_of(storeys: &[u32], reference: usize) -> u32 {
    storeys.get(reference).copied().unwrap_or(NONE)
}

/// True if a pose is that of an earlier look: compared where the map was known then.
pub(crate) fn is_same(earlier: &PoseHistoryRecord, storey: u32, map_from_slam: &Rigid2<Map, Slam>) -> bool {
    earlier.map_storey == storey && is_same_pose(&earlier.map_from_slam(), map_from_slam, earlier.about_m)
}
