//! The robot's map: hits and passes of beams counted for each cell.

use super::drift::BelievedDrive;
use crate::plane::{Vector, moved, turned};
use crate::random_generator::RandomGenerator;
use crate::strengths::Strengths;
use occupancy::{Cell, OccupancyMap};

/// Beams without an answer free cells up to this distance, if they do.
const OPEN_M: f64 = 6.0;
const BORDER_CELLS: f64 = 4.0;

/// Beams that ended in a cell, and that went through it.
#[derive(Debug, Clone, Copy, Default)]
struct Count {
    hits: u16,
    passes: u16,
}

struct Counts {
    width: usize,
    counts: Vec<Count>,
}

/// The map of all scans as the robot believes that they were made.
pub(crate) fn slam_map(
    scans: &[Vec<f32>],
    drive: &BelievedDrive,
    beams: &[Vector],
    strengths: &Strengths,
    random: &mut RandomGenerator,
) -> OccupancyMap {
    let open_m = if strengths.clears_without_hit { OPEN_M.min(strengths.lidar.range_m) } else { 0.0 };
    let length = |range: f32| match range {
        _ if range.is_finite() => f64::from(range),
        _ if range.is_nan() => 0.0,
        _ => open_m,
    };
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for ((place, heading), ranges) in drive.places.iter().zip(&drive.headings).zip(scans) {
        for (&range, &beam) in ranges.iter().zip(beams) {
            let end = moved(*place, turned(beam, *heading), length(range));
            for k in 0..2 {
                low[k] = low[k].min(end[k]).min(place[k]);
                high[k] = high[k].max(end[k]).max(place[k]);
            }
        }
    }
    let cell = strengths.resolution_m;
    let origin = low.map(|c| ((c / cell).floor() - BORDER_CELLS) * cell);
    let [width, height] = [0, 1].map(|k| ((high[k] - origin[k]) / cell + BORDER_CELLS) as usize + 1);
    let mut counts = Counts { width, counts: vec![Count::default(); width * height] };
    for ((place, heading), ranges) in drive.places.iter().zip(&drive.headings).zip(scans) {
        let from = [0, 1].map(|k| (place[k] - origin[k]) / cell);
        for (&range, &beam) in ranges.iter().zip(beams) {
            if length(range) > 0.0 {
                counts.add(from, turned(beam, *heading), length(range) / cell, range.is_finite());
            }
        }
    }
    let cell_of = |count: &Count| match (count.hits, count.passes) {
        (0, 0) => Cell::Unknown,
        (0, _) => Cell::Free,
        (hits, passes) => {
            let share = f64::from(hits) / (f64::from(hits) + f64::from(passes));
            if share > strengths.occupied_share { Cell::Occupied } else { Cell::Free }
        }
    };
    let mut cells: Vec<Cell> = counts.counts.iter().map(cell_of).collect();
    if strengths.stray_share > 0.0 {
        for cell in cells.iter_mut().filter(|c| **c == Cell::Free) {
            if random.happens(strengths.stray_share) {
                *cell = Cell::Occupied;
            }
        }
    }
    OccupancyMap { width, cells, resolution_m: cell, origin: [origin[0], origin[1], 0.0] }
}

impl Counts {
    /// Counts a beam from a point in cells through all cells on its way.
    fn add(&mut self, from: Vector, direction: Vector, length: f64, ends: bool) {
        let cell = from.map(|c| c as isize);
        let end = moved(from, direction, length).map(|c| c as isize);
        let step = direction.map(|d| if d > 0.0 { 1isize } else { -1 });
        let per_cell = direction.map(|d| if d == 0.0 { f64::INFINITY } else { 1.0 / d.abs() });
        let mut due = [0, 1].map(|k| {
            let into = from[k] - cell[k] as f64;
            per_cell[k] * if direction[k] > 0.0 { 1.0 - into } else { into }
        });
        let n_steps = (end[0] - cell[0]).unsigned_abs() + (end[1] - cell[1]).unsigned_abs();
        // The border keeps indices within the map, wherever rounding leads a beam.
        let strides = [step[0], step[1] * self.width as isize];
        let mut index = cell[1] * self.width as isize + cell[0];
        for _ in 0..n_steps {
            let count = &mut self.counts[index as usize];
            count.passes = count.passes.saturating_add(1);
            let k = usize::from(due[1] < due[0]);
            due[k] += per_cell[k];
            index += strides[k];
        }
        if ends {
            let count = &mut self.counts[end[1] as usize * self.width + end[0] as usize];
            count.hits = count.hits.saturating_add(1);
        }
    }
}
