//! Straight stretches of wall faces in a model map.

use crate::plane::{Vector, difference, dot, left_of, moved, scaled};
use crate::wall_grid::WallGrid;

/// Around a face cell, in which its direction is estimated.
const REACH_M: f64 = 0.5;
/// Shorter stretches are left out.
const MIN_LENGTH_M: f64 = 0.3;
/// Floor before a wall face has at least this depth.
const MIN_FLOOR_DEPTH_M: f64 = 0.2;

/// A straight stretch of a wall face.
#[derive(Debug, Clone, Copy)]
pub struct WallStretch {
    /// Where it begins, on the face.
    pub from: Vector,
    /// Unit vector to its end.
    pub along: Vector,
    /// Unit vector into the room.
    pub normal: Vector,
    /// Where it ends.
    pub to: Vector,
}

impl WallStretch {
    /// Its length.
    pub fn length_m(&self) -> f64 {
        dot(difference(self.to, self.from), self.along)
    }

    /// The point this far from its begin and before its face.
    pub(crate) fn at(&self, along_m: f64, before_m: f64) -> Vector {
        moved(moved(self.from, self.along, along_m), self.normal, before_m)
    }

    /// Thickness of the wall behind it at a place, at most `limit_m`.
    pub(crate) fn thickness_m(&self, grid: &WallGrid, along_m: f64, limit_m: f64) -> f64 {
        let step = grid.resolution_m / 2.0;
        let steps = (limit_m / step) as usize;
        let is_wall = |k: &usize| grid.is_wall(self.at(along_m, -step * (*k as f64 + 0.5)));
        (0..steps).take_while(is_wall).count() as f64 * step
    }
}

/// A wall cell beside floor.
struct Face {
    at: Vector,
    direction: Vector,
    normal: Vector,
    linearity: f64,
}

/// All stretches, the straightest faces first.
pub(crate) fn wall_stretches(grid: &WallGrid) -> Vec<WallStretch> {
    let mut faces: Vec<Face> = (0..grid.walls.len()).filter_map(|k| face(grid, k)).collect();
    faces.sort_by(|a, b| b.linearity.total_cmp(&a.linearity));
    let mut is_covered = vec![false; faces.len()];
    let mut stretches: Vec<WallStretch> = Vec::new();
    for k in 0..faces.len() {
        if is_covered[k] {
            continue;
        }
        let stretch = traced(grid, &faces[k]);
        if stretch.length_m() < MIN_LENGTH_M {
            continue;
        }
        let reach = 1.6 * grid.resolution_m;
        for (face, covered) in faces.iter().zip(&mut is_covered) {
            let d = difference(face.at, stretch.from);
            let along = dot(d, stretch.along);
            let is_on = -reach <= along && along <= stretch.length_m() + reach && dot(d, stretch.normal).abs() <= reach;
            *covered |= is_on && dot(face.normal, stretch.normal) > 0.5;
        }
        stretches.push(stretch);
    }
    stretches
}

fn face(grid: &WallGrid, index: usize) -> Option<Face> {
    let (w, h) = (grid.width, grid.height);
    let (x, y) = (index % w, index / w);
    if !grid.walls[index] || x == 0 || y == 0 || x + 1 == w || y + 1 == h {
        return None;
    }
    let sides = [(index + 1, [1.0, 0.0]), (index - 1, [-1.0, 0.0]), (index + w, [0.0, 1.0]), (index - w, [0.0, -1.0])];
    let open = sides.iter().filter(|(beside, _)| grid.floor[*beside]);
    let outward = open.fold([0.0; 2], |s: Vector, (_, d)| [s[0] + d[0], s[1] + d[1]]);
    if outward == [0.0; 2] {
        return None;
    }
    // Second moments of the wall cells around that have floor on the same side.
    let reach = (REACH_M / grid.resolution_m) as usize;
    let (mut n, mut first, mut second) = (0.0, [0.0; 2], [0.0; 3]);
    for row in y.saturating_sub(reach)..(y + reach + 1).min(h) {
        for column in x.saturating_sub(reach)..(x + reach + 1).min(w) {
            let next = [column as f64 + outward[0], row as f64 + outward[1]];
            let is_inside = next[0] >= 0.0 && next[1] >= 0.0 && next[0] < w as f64 && next[1] < h as f64;
            if !is_inside || !grid.walls[row * w + column] {
                continue;
            }
            if grid.floor[next[1] as usize * w + next[0] as usize] {
                let [dx, dy] = [column as f64 - x as f64, row as f64 - y as f64];
                n += 1.0;
                first = [first[0] + dx, first[1] + dy];
                second = [second[0] + dx * dx, second[1] + dx * dy, second[2] + dy * dy];
            }
        }
    }
    if n < 3.0 {
        return None;
    }
    let [a, b, c] =
        [second[0] - first[0] * first[0] / n, second[1] - first[0] * first[1] / n, second[2] - first[1] * first[1] / n];
    let spread = libm::hypot(a - c, 2.0 * b);
    let direction = crate::plane::direction_of(libm::atan2(2.0 * b, a - c) / 2.0);
    let side = if dot(left_of(direction), outward) >= 0.0 { 1.0 } else { -1.0 };
    let normal = scaled(left_of(direction), side);
    if dot(normal, outward) < 0.3 {
        return None;
    }
    // The whole numbers of cells in a stretch count too: long straight faces come first.
    let linearity = spread / (a + c).max(1e-9) * n.sqrt();
    Some(Face { at: moved(grid.middle(index), normal, grid.resolution_m / 2.0), direction, normal, linearity })
}

/// The stretch through a face, as far as there is wall on one side and floor on the other.
fn traced(grid: &WallGrid, face: &Face) -> WallStretch {
    let cell = grid.resolution_m;
    let goes_on = |along: f64| {
        let p = moved(face.at, face.direction, along);
        let is_wall = [0.5, 1.4].iter().any(|k| grid.is_wall(moved(p, face.normal, -k * cell)));
        let is_open =
            grid.is_floor(moved(p, face.normal, MIN_FLOOR_DEPTH_M)) && !grid.is_wall(moved(p, face.normal, 1.4 * cell));
        is_wall && is_open
    };
    let reach = |sign: f64| (1..).map(|k| f64::from(k) * cell * sign).take_while(|&s| goes_on(s)).last().unwrap_or(0.0);
    let (back, ahead) = (reach(-1.0), reach(1.0));
    WallStretch {
        from: moved(face.at, face.direction, back - cell / 2.0),
        along: face.direction,
        normal: face.normal,
        to: moved(face.at, face.direction, ahead + cell / 2.0),
    }
}
