//! Candidate places for scans: one per square of a lattice, the centres of spaces, more where a face is seen from nowhere else,
//! and those around other places.

use crate::space_centre::{SpaceCentre, StoreyInputs};
use crate::target_face::TargetFaces;
use crate::visible_faces::SensorLimits;
use frames::{Map, Point2};
use grid::Cell;
use std::collections::BTreeSet;

/// A candidate place for scans.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ScanPlace {
    pub(crate) at: Point2<Map>,
    /// Part of the free space in which it lies.
    pub(crate) part: u32,
}

/// Maximum number of places; the spacing is increased to stay below.
const MAX_PLACES: usize = 20_000;

/// One reachable place per square of the spacing, the cell nearest to its middle, and the centres of the spaces. The squares
/// are aligned to the map frame, so that places do not depend on the size of the grid.
pub(crate) fn places(
    storey: &StoreyInputs<'_>,
    spacing_m: f64,
    centres: &[SpaceCentre],
    may_scan: &impl Fn(usize) -> bool,
) -> Vec<ScanPlace> {
    let free_space = storey.free_space;
    let spec = &free_space.spec;
    let fits = |cell: usize| storey.can_scan_from(cell) && may_scan(cell);
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
/// cells only. They are looked for on rays from the faces: where a scan is preferred, and for what is left where it may be.
pub(crate) fn places_for_unseen(
    storey: &StoreyInputs<'_>,
    limits: &SensorLimits,
    faces: &TargetFaces,
    seen: &[Vec<u32>],
    may_scan: [&dyn Fn(usize) -> bool; 2],
) -> Vec<ScanPlace> {
    let free_space = storey.free_space;
    let mut is_seen = vec![false; faces.all.len()];
    seen.iter().flatten().for_each(|&face| is_seen[face as usize] = true);
    let rest = faces.without(&is_seen);
    if rest.all.is_empty() {
        return Vec::new();
    }
    let mut is_seen = vec![false; rest.all.len()];
    let mut places = Vec::new();
    let tries = if free_space.kept_off_hash().is_some() { &may_scan[..] } else { &may_scan[1..] };
    for may_scan in tries {
        let fits = |cell: usize| storey.can_scan_from(cell) && may_scan(cell);
        let can_be_seen = cells_connected_with(storey, fits);
        for k in 0..rest.all.len() {
            if is_seen[k] || !can_be_seen[rest.all[k].front as usize] {
                continue;
            }
            if let Some(cell) = limits.cell_that_sees(storey.sight, &rest.all[k], fits) {
                let at = free_space.middle(cell);
                let seen = limits.visible_around(storey.sight, &rest, free_space.in_cells(at));
                seen.into_iter().for_each(|face| is_seen[face as usize] = true);
                places.push(ScanPlace { at, part: free_space.part(cell) });
            }
        }
    }
    places
}

/// Cells that are connected over free cells, along sides and across corners, with those that fit: no line of sight leads to
/// others.
fn cells_connected_with(storey: &StoreyInputs<'_>, fits: impl Fn(usize) -> bool) -> Vec<bool> {
    let (spec, sight) = (&storey.free_space.spec, storey.sight);
    let mut connected: Vec<bool> = (0..spec.n_cells()).map(fits).collect();
    let mut waiting: Vec<usize> = (0..spec.n_cells()).filter(|&cell| connected[cell]).collect();
    let around = |at: u32, n: u32| at.saturating_sub(1)..(at + 2).min(n);
    while let Some(cell) = waiting.pop() {
        let Cell { column, row } = spec.cell_of(cell);
        for row in around(row, spec.height) {
            for next in around(column, spec.width).map(|column| spec.index(Cell { column, row })) {
                if sight.passes(next) && !std::mem::replace(&mut connected[next], true) {
                    waiting.push(next);
                }
            }
        }
    }
    connected
}

/// The places around some others at a distance along rows, columns and diagonals; without those that are known.
pub(crate) fn places_around(
    storey: &StoreyInputs<'_>,
    known: &[ScanPlace],
    around: impl Iterator<Item = usize>,
    spacing_m: f64,
    may_scan: &impl Fn(usize) -> bool,
) -> Vec<ScanPlace> {
    let free_space = storey.free_space;
    let spec = &free_space.spec;
    let cell_of = |at: Point2<Map>| spec.cell_at(at).map(|cell| spec.index(cell));
    let mut cells: BTreeSet<usize> = known.iter().filter_map(|place| cell_of(place.at)).collect();
    let mut places = Vec::new();
    for place in around.map(|k| known[k]) {
        for (x, y) in (0..9).filter(|k| *k != 4).map(|k| (f64::from(k % 3 - 1), f64::from(k / 3 - 1))) {
            let at = Point2::new(place.at.x_m() + x * spacing_m, place.at.y_m() + y * spacing_m);
            let cell = cell_of(at).filter(|&cell| storey.can_scan_from(cell) && may_scan(cell));
            if let Some(cell) = cell.filter(|&cell| cells.insert(cell)) {
                places.push(ScanPlace { at: free_space.middle(cell), part: free_space.part(cell) });
            }
        }
    }
    places
}

/// For each place the others at less than a distance, ascending.
pub(crate) fn near_places(places: &[ScanPlace], distance_m: f64) -> Vec<Vec<u32>> {
    // Places at this distance are not too near, whatever the last digit of a coordinate is.
    let distance_m = distance_m - 1e-6;
    if distance_m <= 0.0 {
        return vec![Vec::new(); places.len()];
    }
    let square = |at: Point2<Map>| at.coordinates_m().map(|c| (c / distance_m).floor() as i64);
    let mut sorted: Vec<([i64; 2], u32)> = places.iter().zip(0..).map(|(place, k)| (square(place.at), k)).collect();
    sorted.sort_unstable();
    let near = |(place, own): (&ScanPlace, u32)| {
        let [x, y] = square(place.at);
        let columns = (x - 1..=x + 1).flat_map(|x| {
            let first = sorted.partition_point(|(square, _)| *square < [x, y - 1]);
            sorted[first..].iter().take_while(move |(square, _)| *square <= [x, y + 1])
        });
        let is_near = |k: &u32| *k != own && places[*k as usize].at.distance_m(&place.at) < distance_m;
        let others = columns.map(|&(_, k)| k).filter(is_near);
        let mut near: Vec<u32> = others.collect();
        near.sort_unstable();
        near
    };
    places.iter().zip(0..).map(near).collect()
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
