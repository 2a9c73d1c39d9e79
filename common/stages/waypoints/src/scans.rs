//! Candidate scan poses, their visible faces, and the selection.

use crate::centre::{Centre, Storey};
use crate::face::Faces;
use crate::instance::Instance;
use crate::options::PlanOptions;
use crate::set_cover::cover;
use crate::visible::{Pose, Reach};
use frames::{Map, Point2};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// A place from which scans are tried.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Place {
    pub(crate) at: Point2<Map>,
    /// Part of the ground that it lies in.
    pub(crate) part: u32,
}

/// Everything about scans of a storey: what could be seen from where, and what was chosen.
pub(crate) struct Scans {
    pub(crate) faces: Faces,
    pub(crate) places: Vec<Place>,
    /// Places and headings from which scans are possible.
    pub(crate) poses: Vec<(usize, f64)>,
    /// The faces that each pose sees, and what is to be covered.
    pub(crate) instance: Instance,
    /// Poses that are chosen.
    pub(crate) chosen: Vec<usize>,
}

/// Places are thinned out until there are at most this many.
const MAX_PLACES: usize = 20_000;

impl Scans {
    /// Looks from everywhere, and chooses few poses that see enough. `may_scan` says of a cell whether the robot has business
    /// there, `is_target` of an occupied and a free cell whether the face between them is to be seen.
    pub(crate) fn plan(
        storey: &Storey<'_>,
        options: &PlanOptions,
        centres: &[Centre],
        may_scan: impl Fn(usize) -> bool + Sync,
        is_target: impl Fn(usize, usize) -> bool,
    ) -> Self {
        let ground = storey.ground;
        let faces = Faces::of(storey.grid, is_target);
        let mut places = places(storey, options.spacing_m, centres, &may_scan);
        let reach = Reach::of(&options.sensor, ground.spec.resolution_m());
        let look = |p: &Place| reach.seen_around(&ground.sight, &faces, ground.in_cells(p.at));
        let mut seen: Vec<Vec<u32>> = places.par_iter().map(look).collect();
        let more = places_for_the_rest(storey, options.spacing_m, &reach, &faces, &seen, &may_scan);
        seen.par_extend(more.par_iter().map(look));
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
                let at = ground.in_cells(places[place].at);
                poses.push((place, yaw_rad));
                sets.push(reach.in_view(&faces, &seen, Pose { at, yaw_rad }));
            }
        }
        let groups = faces.all.iter().map(|f| u32::from(f.space)).collect();
        let instance = Instance::new(sets, groups, options.coverage, options.space_coverage);
        let chosen = cover(&instance, options.search_steps).into_iter().map(|set| set as usize).collect();
        Self { faces, places, poses, instance, chosen }
    }

    /// The faces that a pose sees.
    pub(crate) fn seen(&self, pose: usize) -> &[u32] {
        &self.instance.sets[pose]
    }

    /// Where a pose is.
    pub(crate) fn place(&self, pose: usize) -> Place {
        self.places[self.poses[pose].0]
    }
}

/// Headings of a sensor that does not see all around: they overlap by half.
fn headings(options: &PlanOptions) -> Vec<f64> {
    let n = (2.0 * TAU / options.sensor.field_of_view_rad).ceil() as u32;
    (0..n).map(|k| TAU * f64::from(k) / f64::from(n)).map(|a| if a > TAU / 2.0 { a - TAU } else { a }).collect()
}

/// One place in each square of the spacing that the robot gets to: the cell in its middle, else the nearest to that; and the
/// centres of the spaces. Squares are those of the map frame, so that places do not move with the size of the grid.
fn places(storey: &Storey<'_>, spacing_m: f64, centres: &[Centre], may_scan: &impl Fn(usize) -> bool) -> Vec<Place> {
    let ground = storey.ground;
    let spec = &ground.spec;
    let fits = |cell: usize| storey.is_reached(cell) && may_scan(cell);
    let mut side = (spacing_m / spec.resolution_m()).round().max(1.0) as i32;
    let cells = loop {
        let cells = one_per_square(spec, side, &fits);
        if cells.len() <= MAX_PLACES {
            break cells;
        }
        side *= 2;
    };
    let place = |cell: usize| Place { at: ground.middle(cell), part: ground.part(cell) };
    let mut places: Vec<Place> = cells.into_iter().map(place).collect();
    for centre in centres {
        let cell = spec.cell_at(centre.at).map(|c| spec.index(c)).filter(|&c| fits(c));
        places.extend(cell.map(|c| Place { at: centre.at, part: ground.part(c) }));
    }
    places
}

/// Places between the others that see faces which none of those sees: what shows through a door or past a column from a few
/// cells only. Tried at a half and at a quarter of the spacing.
fn places_for_the_rest(
    storey: &Storey<'_>,
    spacing_m: f64,
    reach: &Reach,
    faces: &Faces,
    seen: &[Vec<u32>],
    may_scan: &(impl Fn(usize) -> bool + Sync),
) -> Vec<Place> {
    let ground = storey.ground;
    let fits = |cell: usize| storey.is_reached(cell) && may_scan(cell);
    let mut is_seen = vec![false; faces.all.len()];
    seen.iter().flatten().for_each(|&face| is_seen[face as usize] = true);
    let mut places = Vec::new();
    for part in [2.0, 4.0] {
        let side = (spacing_m / part / ground.spec.resolution_m()).round().max(1.0) as i32;
        let rest = faces.without(&is_seen);
        let cells = one_per_square(&ground.spec, side, &fits);
        if rest.all.is_empty() || cells.len() > 4 * MAX_PLACES {
            break;
        }
        let look = |&cell: &usize| reach.seen_around(&ground.sight, &rest, ground.in_cells(ground.middle(cell)));
        let found: Vec<Vec<u32>> = cells.par_iter().map(look).collect();
        // The place that shows most of the rest first, as long as one shows any.
        let mut order: Vec<usize> = (0..cells.len()).filter(|&k| !found[k].is_empty()).collect();
        order.sort_by_key(|&k| (std::cmp::Reverse(found[k].len()), cells[k]));
        for k in order {
            let numbers = found[k].iter().map(|&face| rest.numbers[face as usize] as usize);
            let new: Vec<usize> = numbers.filter(|&face| !is_seen[face]).collect();
            if !new.is_empty() {
                new.into_iter().for_each(|face| is_seen[face] = true);
                places.push(Place { at: ground.middle(cells[k]), part: ground.part(cells[k]) });
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
