//! Candidate scan poses, their visible faces, and the selection.

use crate::options::MissionPlanOptions;
use crate::set_cover::cover;
use crate::set_cover_instance::SetCoverInstance;
use crate::space_centre::{SpaceCentre, StoreyInputs};
use crate::target_face::TargetFaces;
use crate::visible_faces::{ScanPose, SensorLimits};
use frames::{Map, Point2};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// A candidate place for scans.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ScanPlace {
    pub(crate) at: Point2<Map>,
    /// Part of the free space in which it lies.
    pub(crate) part: u32,
}

/// Candidate scan poses of a storey, their visible faces, and the chosen poses.
pub(crate) struct ScanSelection {
    pub(crate) faces: TargetFaces,
    pub(crate) places: Vec<ScanPlace>,
    /// Candidate poses: index of the place, and yaw.
    pub(crate) poses: Vec<(usize, f64)>,
    /// Visible faces of each pose, with coverage goals.
    pub(crate) instance: SetCoverInstance,
    /// Chosen poses.
    pub(crate) chosen: Vec<usize>,
}

/// Maximum number of places; the spacing is increased to stay below.
const MAX_PLACES: usize = 20_000;

impl ScanSelection {
    /// Computes the visible faces of all candidate poses and chooses few that see enough. `may_scan` tells whether scans may
    /// be made in a cell, `is_target` whether the face between an occupied and a free cell is a target.
    pub(crate) fn plan(
        storey: &StoreyInputs<'_>,
        options: &MissionPlanOptions,
        centres: &[SpaceCentre],
        may_scan: impl Fn(usize) -> bool + Sync,
        is_target: impl Fn(usize, usize) -> bool,
    ) -> Self {
        let free_space = storey.free_space;
        let faces = TargetFaces::of(storey.grid, is_target);
        let mut places = places(storey, options.spacing_m, centres, &may_scan);
        let reach = SensorLimits::of(&options.sensor, free_space.spec.resolution_m());
        let visible_from = |p: &ScanPlace| reach.visible_around(&free_space.sight, &faces, free_space.in_cells(p.at));
        let mut seen: Vec<Vec<u32>> = places.par_iter().map(visible_from).collect();
        let more = places_between(storey, options.spacing_m, &reach, &faces, &seen, &may_scan);
        seen.par_extend(more.par_iter().map(visible_from));
        places.extend(more);
        let headings = headings(options);
        let mut poses = Vec::with_capacity(places.len() * headings.len());
        let mut sets = Vec::with_capacity(poses.capacity());
        for (place, seen) in seen.into_iter().enumerate() {
            if options.sensor.sees_around() {
                poses.push((place, 0.0));
                sets.push(seen);
                continue;
            }
            for &yaw_rad in &headings {
                let at = free_space.in_cells(places[place].at);
                poses.push((place, yaw_rad));
                sets.push(reach.in_field_of_view(&faces, &seen, ScanPose { at, yaw_rad }));
            }
        }
        let groups = faces.all.iter().map(|f| u32::from(f.space)).collect();
        let instance = SetCoverInstance::new(sets, groups, options.coverage, options.space_coverage);
        let chosen = cover(&instance, options.search_steps).into_iter().map(|set| set as usize).collect();
        Self { faces, places, poses, instance, chosen }
    }

    /// The faces that a pose sees.
    pub(crate) fn seen(&self, pose: usize) -> &[u32] {
        &self.instance.sets[pose]
    }

    /// The place of a pose.
    pub(crate) fn place(&self, pose: usize) -> ScanPlace {
        self.places[self.poses[pose].0]
    }
}

/// Headings of a sensor with a limited field of view; neighbouring views overlap by half.
fn headings(options: &MissionPlanOptions) -> Vec<f64> {
    let n = (2.0 * TAU / options.sensor.field_of_view_rad).ceil() as u32;
    (0..n).map(|k| TAU * f64::from(k) / f64::from(n)).map(|a| if a > TAU / 2.0 { a - TAU } else { a }).collect()
}

/// One reachable place per square of the spacing, the cell nearest to its middle, and the centres of the spaces. The squares
/// are aligned to the map frame, so that places do not depend on the size of the grid.
fn places(
    storey: &StoreyInputs<'_>,
    spacing_m: f64,
    centres: &[SpaceCentre],
    may_scan: &impl Fn(usize) -> bool,
) -> Vec<ScanPlace> {
    let free_space = storey.free_space;
    let spec = &free_space.spec;
    let fits = |cell: usize| storey.is_reached(cell) && may_scan(cell);
    let mut side = (spacing_m / spec.resolution_m()).round().max(1.0) as i32;
    let cells = loop {
        let cells = one_per_square(spec, side, &fits);
        if cells.len() <= MAX_PLACES {
            break cells;
        }
        side *= 2;
    };
    let place = |cell: usize| ScanPlace { at: free_space.middle(cell), part: free_space.part(cell) };
    let mut places: Vec<ScanPlace> = cells.into_iter().map(place).collect();
    for centre in centres {
        let cell = spec.cell_at(centre.at).map(|c| spec.index(c)).filter(|&c| fits(c));
        places.extend(cell.map(|c| ScanPlace { at: centre.at, part: free_space.part(c) }));
    }
    places
}

/// Additional places that see faces not visible from the others, such as those seen through a door or past a column from few
/// cells only. They are searched at half and a quarter of the spacing.
fn places_between(
    storey: &StoreyInputs<'_>,
    spacing_m: f64,
    reach: &SensorLimits,
    faces: &TargetFaces,
    seen: &[Vec<u32>],
    may_scan: &(impl Fn(usize) -> bool + Sync),
) -> Vec<ScanPlace> {
    let free_space = storey.free_space;
    let fits = |cell: usize| storey.is_reached(cell) && may_scan(cell);
    let mut is_seen = vec![false; faces.all.len()];
    seen.iter().flatten().for_each(|&face| is_seen[face as usize] = true);
    let mut places = Vec::new();
    for part in [2.0, 4.0] {
        let side = (spacing_m / part / free_space.spec.resolution_m()).round().max(1.0) as i32;
        let rest = faces.without(&is_seen);
        let cells = one_per_square(&free_space.spec, side, &fits);
        if rest.all.is_empty() || cells.len() > 4 * MAX_PLACES {
            break;
        }
        let visible_from = |&cell: &usize| {
            reach.visible_around(&free_space.sight, &rest, free_space.in_cells(free_space.middle(cell)))
        };
        let found: Vec<Vec<u32>> = cells.par_iter().map(visible_from).collect();
        // Greedily the place that sees most of the remaining faces.
        let mut order: Vec<usize> = (0..cells.len()).filter(|&k| !found[k].is_empty()).collect();
        order.sort_by_key(|&k| (std::cmp::Reverse(found[k].len()), cells[k]));
        for k in order {
            let numbers = found[k].iter().map(|&face| rest.numbers[face as usize] as usize);
            let new: Vec<usize> = numbers.filter(|&face| !is_seen[face]).collect();
            if !new.is_empty() {
                new.into_iter().for_each(|face| is_seen[face] = true);
                places.push(ScanPlace { at: free_space.middle(cells[k]), part: free_space.part(cells[k]) });
            }
        }
    }
    places
}

fn one_per_square(spec: &grid::GridSpec, side: i32, fits: &impl Fn(usize) -> bool) -> Vec<usize> {
    let square = |k: usize, c: u32| (spec.first_cell[k] + c as i32).div_euclid(side);
    let n_wide = (square(0, spec.width - 1) - square(0, 0) + 1) as usize;
    let n_high = (square(1, spec.height - 1) - square(1, 0) + 1) as usize;
    let mut best: Vec<Option<(i32, usize)>> = vec![None; n_wide * n_high];
    for index in (0..spec.n_cells()).filter(|&c| fits(c)) {
        let cell = spec.cell_of(index);
        let off = |k: usize, c: u32| (spec.first_cell[k] + c as i32).rem_euclid(side) * 2 + 1 - side;
        let (x, y) = (off(0, cell.column), off(1, cell.row));
        let at =
            (square(1, cell.row) - square(1, 0)) as usize * n_wide + (square(0, cell.column) - square(0, 0)) as usize;
        let far = x * x + y * y;
        if best[at].is_none_or(|b| (far, index) < b) {
            best[at] = Some((far, index));
        }
    }
    best.into_iter().flatten().map(|b| b.1).collect()
}
