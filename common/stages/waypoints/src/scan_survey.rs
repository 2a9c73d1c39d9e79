//! Candidate scan poses of a storey, the target faces that each sees, and the order in which a plan grows from them.

use crate::options::MissionPlanOptions;
use crate::scan_growth::{GrownScan, grow};
use crate::scan_places::{ScanPlace, near_places, places, places_around, places_for_unseen};
use crate::scan_registration::Registration;
use crate::set_cover_instance::{FaceOwners, SetCoverInstance};
use crate::space_centre::{SpaceCentre, StoreyInputs};
use crate::target_face::TargetFaces;
use crate::visible_faces::{ScanPose, SensorLimits};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Candidate scan poses of a storey and what they see.
#[derive(Default)]
pub(crate) struct ScanSurvey {
    pub(crate) faces: TargetFaces,
    pub(crate) places: Vec<ScanPlace>,
    /// Candidate poses: index of the place, and yaw.
    pub(crate) poses: Vec<(usize, f64)>,
    /// Visible faces of each pose, with coverage goals.
    pub(crate) instance: SetCoverInstance,
    /// The poses that see each face.
    pub(crate) owners: FaceOwners,
    /// Part of each pose.
    pub(crate) parts: Vec<u32>,
    /// The poses in the order in which a plan grows.
    pub(crate) growth: Vec<GrownScan>,
}

/// Spacing of the first places that are tried, in spacings of the options: a place sees nearly what one beside it sees.
const COARSE: f64 = 2.0;

/// Side of a window in which scans are exchanged, in ranges of the sensor: most faces of a scan are seen from its window.
const WINDOW_RANGES: f64 = 4.0;

impl ScanSurvey {
    /// Computes the visible faces of all candidate poses. `may_scan` tells whether scans may be made in a cell, `is_target`
    /// whether the face between an occupied and a free cell is a target.
    pub(crate) fn of(
        storey: &StoreyInputs<'_>,
        options: &MissionPlanOptions,
        centres: &[SpaceCentre],
        may_scan: impl Fn(usize) -> bool + Sync,
        is_target: impl Fn(usize, usize) -> bool,
    ) -> Self {
        let free_space = storey.free_space;
        let faces = TargetFaces::of(storey.grid, is_target);
        let limits = SensorLimits::of(&options.sensor, free_space.spec.resolution_m());
        let mut survey = Self { faces, ..Self::default() };
        if survey.faces.all.is_empty() {
            return survey;
        }
        let visible_from =
            |faces: &TargetFaces, p: &ScanPlace| limits.visible_around(storey.sight, faces, free_space.in_cells(p.at));
        // Within a distance that the robot keeps only what is seen from nowhere else is scanned.
        let may_scan_off = |cell: usize| may_scan(cell) && !free_space.is_kept_off(cell);
        let mut places = places(storey, COARSE * options.spacing_m, centres, &may_scan_off);
        let mut seen: Vec<Vec<u32>> = places.par_iter().map(|place| visible_from(&survey.faces, place)).collect();
        let more = places_for_unseen(storey, &limits, &survey.faces, &seen, [&may_scan_off, &may_scan]);
        seen.par_extend(more.par_iter().map(|place| visible_from(&survey.faces, place)));
        places.extend(more);
        survey.add(storey, options, &limits, places, seen);
        // Around the scans of a first plan finer places are tried.
        let first: Vec<usize> = survey.growth_to_goal().iter().map(|scan| survey.poses[scan.set as usize].0).collect();
        let more = places_around(storey, &survey.places, first.into_iter(), options.spacing_m, &may_scan_off);
        let seen = more.par_iter().map(|place| visible_from(&survey.faces, place)).collect();
        survey.add(storey, options, &limits, more, seen);
        survey
    }

    /// Adds places with the faces that are visible all around from each.
    fn add(
        &mut self,
        storey: &StoreyInputs<'_>,
        options: &MissionPlanOptions,
        limits: &SensorLimits,
        more: Vec<ScanPlace>,
        seen: Vec<Vec<u32>>,
    ) {
        let (mut more_poses, mut more_sets) = poses(storey, options, limits, &self.faces, &more, seen);
        more_poses.iter_mut().for_each(|pose| pose.0 += self.places.len());
        self.places.extend(more);
        self.poses.append(&mut more_poses);
        let mut sets = std::mem::take(&mut self.instance.sets);
        sets.append(&mut more_sets);
        let groups = self.faces.all.iter().map(|f| u32::from(f.space)).collect();
        let mut instance = SetCoverInstance::new(sets, groups, options.coverage, options.space_coverage);
        instance.conflicts = conflicts(&self.places, &self.poses, options.separation_m);
        let window_m = WINDOW_RANGES * options.sensor.range_m;
        instance.windows = windows(self.poses.iter().map(|pose| self.places[pose.0].at.coordinates_m()), window_m);
        self.parts = self.poses.iter().map(|pose| self.places[pose.0].part).collect();
        self.owners = instance.owners();
        self.growth = grow(&instance, &self.owners, &self.parts, options.overlap);
        limit_goal(&mut instance, &self.growth, options.min_gain_m / storey.free_space.spec.resolution_m());
        self.instance = instance;
    }

    /// The growth until the goal is reached.
    pub(crate) fn growth_to_goal(&self) -> &[GrownScan] {
        let mut n_seen = 0;
        let is_needed = |scan: &&GrownScan| {
            let is_needed = n_seen < self.instance.goal;
            n_seen += scan.n_new as usize;
            is_needed
        };
        &self.growth[..self.growth.iter().take_while(is_needed).count()]
    }

    /// The faces that a pose sees.
    pub(crate) fn seen(&self, pose: u32) -> &[u32] {
        &self.instance.sets[pose as usize]
    }

    /// The place of a pose.
    pub(crate) fn place(&self, pose: u32) -> ScanPlace {
        self.places[self.poses[pose as usize].0]
    }

    /// Registration of poses with each other.
    pub(crate) fn registration(&self, overlap: f64) -> Registration<'_> {
        Registration { instance: &self.instance, owners: &self.owners, parts: &self.parts, overlap }
    }
}

/// The poses of all places, with the faces that each sees.
fn poses(
    storey: &StoreyInputs<'_>,
    options: &MissionPlanOptions,
    limits: &SensorLimits,
    faces: &TargetFaces,
    places: &[ScanPlace],
    seen: Vec<Vec<u32>>,
) -> (Vec<(usize, f64)>, Vec<Vec<u32>>) {
    if options.sensor.sees_around() {
        return ((0..places.len()).map(|place| (place, 0.0)).collect(), seen);
    }
    let headings = headings(options);
    let all = places.iter().enumerate().flat_map(|(k, place)| headings.iter().map(move |&yaw_rad| (k, place, yaw_rad)));
    let pose = |(k, place, yaw_rad): (usize, &ScanPlace, f64)| {
        let at = storey.free_space.in_cells(place.at);
        ((k, yaw_rad), limits.in_field_of_view(faces, &seen[k], ScanPose { at, yaw_rad }))
    };
    all.map(pose).unzip()
}

/// Headings of a sensor with a limited field of view; neighbouring views overlap by half.
fn headings(options: &MissionPlanOptions) -> Vec<f64> {
    let n = (2.0 * TAU / options.sensor.field_of_view_rad).ceil() as u32;
    (0..n).map(|k| TAU * f64::from(k) / f64::from(n)).map(|a| if a > TAU / 2.0 { a - TAU } else { a }).collect()
}

/// For each pose those at other places that are too near.
fn conflicts(places: &[ScanPlace], poses: &[(usize, f64)], separation_m: f64) -> Vec<Vec<u32>> {
    let mut first_pose = vec![0u32; places.len() + 1];
    poses.iter().for_each(|pose| first_pose[pose.0 + 1] += 1);
    for k in 1..first_pose.len() {
        first_pose[k] += first_pose[k - 1];
    }
    let near = near_places(places, separation_m);
    let poses_of = |place: &u32| first_pose[*place as usize]..first_pose[*place as usize + 1];
    poses.iter().map(|pose| near[pose.0].iter().flat_map(poses_of).collect()).collect()
}

/// Numbers of the squares of a lattice in which points lie, without gaps.
fn windows(points_m: impl Iterator<Item = [f64; 2]>, side_m: f64) -> Vec<u32> {
    let squares: Vec<[i64; 2]> = points_m.map(|[x, y]| [y, x].map(|c| (c / side_m).floor() as i64)).collect();
    let mut sorted = squares.clone();
    sorted.sort_unstable();
    sorted.dedup();
    squares.iter().map(|square| sorted.partition_point(|other| other < square) as u32).collect()
}

/// Lowers the goal to what scans see that are worth their time: from where no later one adds `min_gain` faces.
fn limit_goal(instance: &mut SetCoverInstance, growth: &[GrownScan], min_gain: f64) {
    let n_worth = growth.iter().rposition(|scan| f64::from(scan.n_new) >= min_gain).map_or(0, |last| last + 1);
    let n_seen: usize = growth[..n_worth].iter().map(|scan| scan.n_new as usize).sum();
    instance.goal = instance.goal.min(n_seen);
}
