//! Gaps in walls that are as wide as doors.

use crate::plane::{Vector, distance, moved, scaled, sum};
use crate::wall_grid::WallGrid;
use crate::wall_stretches::WallStretch;

const WIDTH_M: [f64; 2] = [0.6, 1.3];
/// Depth within the wall at which a gap is looked for.
const DEPTH_M: f64 = 0.06;
/// Two faces of a wall show the same gap.
const SAME_M: f64 = 0.55;

/// A gap between two ends of a wall.
#[derive(Debug, Clone, Copy)]
pub struct Opening {
    /// Its ends, within the wall.
    pub ends: [Vector; 2],
    /// Unit vector through it.
    pub normal: Vector,
}

impl Opening {
    /// Its middle.
    pub fn centre(&self) -> Vector {
        scaled(sum(self.ends[0], self.ends[1]), 0.5)
    }

    /// Its clear width.
    pub fn width_m(&self) -> f64 {
        distance(self.ends[0], self.ends[1])
    }
}

/// All openings between stretches of wall.
pub(crate) fn openings(grid: &WallGrid, stretches: &[WallStretch]) -> Vec<Opening> {
    let mut found: Vec<Opening> = Vec::new();
    for stretch in stretches {
        for (end, direction) in [(stretch.to, stretch.along), (stretch.from, scaled(stretch.along, -1.0))] {
            let within = moved(end, stretch.normal, -DEPTH_M.max(grid.resolution_m));
            let Some(ends) = gap(grid, within, direction) else { continue };
            let opening = Opening { ends, normal: stretch.normal };
            if found.iter().all(|other| distance(other.centre(), opening.centre()) > SAME_M) {
                found.push(opening);
            }
        }
    }
    found
}

/// Where the wall ends and where it goes on, seen from a point within it.
fn gap(grid: &WallGrid, from: Vector, direction: Vector) -> Option<[Vector; 2]> {
    let step = grid.resolution_m / 2.0;
    let at = |k: usize| moved(from, direction, k as f64 * step);
    let steps = |length_m: f64| (length_m / step).ceil() as usize;
    let begin = (0..steps(0.2)).find(|&k| !grid.is_wall(at(k)))?;
    let end = (begin..begin + steps(WIDTH_M[1]) + 2).find(|&k| grid.is_wall(at(k)))?;
    let is_floor = (begin..end).all(|k| grid.is_floor(at(k)));
    let goes_on = (end..end + steps(0.1)).all(|k| grid.is_wall(at(k)));
    let width_m = (end - begin) as f64 * step;
    let is_door = (WIDTH_M[0]..=WIDTH_M[1]).contains(&width_m);
    (is_floor && goes_on && is_door).then(|| [at(begin), at(end)])
}
