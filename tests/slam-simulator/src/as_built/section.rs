//! Horizontal sections of triangle meshes, and the cells that they cover.

use crate::plane::{Rectangle, Vector, difference, distance, dot, left_of, moved, scaled};
use crate::wall_grid::WallGrid;

/// A straight piece of a section's border; the solid lies on its left.
pub(super) type Border = [Vector; 2];

/// Borders of a mesh at a height.
pub(super) fn borders(vertices: &[[f64; 3]], faces: &[[usize; 3]], z: f64) -> Vec<Border> {
    faces.iter().filter_map(|face| border(face.map(|k| vertices[k]), z)).collect()
}

fn border(triangle: [[f64; 3]; 3], z: f64) -> Option<Border> {
    let mut ends = Vec::with_capacity(2);
    for k in 0..3 {
        let (a, b) = (triangle[k], triangle[(k + 1) % 3]);
        if (a[2] <= z) != (b[2] <= z) {
            let part = (z - a[2]) / (b[2] - a[2]);
            ends.push([0, 1].map(|c| a[c] + part * (b[c] - a[c])));
        }
    }
    let [from, to] = ends[..] else { return None };
    let [u, v] = [1, 2].map(|k| [0, 1, 2].map(|c| triangle[k][c] - triangle[0][c]));
    let outward = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2]];
    let along = [to[0] - from[0], to[1] - from[1]];
    Some(if dot(left_of(along), outward) <= 0.0 { [from, to] } else { [to, from] })
}

/// The rectangle around a section along the direction that most of its border has.
pub(super) fn around(borders: &[Border]) -> Option<Rectangle> {
    let doubled = borders.iter().fold([0.0; 2], |sum: Vector, [a, b]| {
        let [x, y] = [b[0] - a[0], b[1] - a[1]];
        let length = libm::hypot(x, y).max(1e-9);
        [sum[0] + (x * x - y * y) / length, sum[1] + 2.0 * x * y / length]
    });
    let along = crate::plane::direction_of(libm::atan2(doubled[1], doubled[0]) / 2.0);
    let rectangle = around_along(borders, along);
    let turned = Rectangle { along: left_of(along), half: [rectangle.half[1], rectangle.half[0]], ..rectangle };
    (!borders.is_empty()).then_some(if rectangle.half[0] < rectangle.half[1] { turned } else { rectangle })
}

/// The rectangle of a given direction around a section, which is not empty.
pub(super) fn around_along(borders: &[Border], along: Vector) -> Rectangle {
    let range = |axis: Vector| {
        let all = borders.iter().flatten().map(|p| dot(*p, axis));
        all.fold([f64::INFINITY, f64::NEG_INFINITY], |[lo, hi], c| [lo.min(c), hi.max(c)])
    };
    let (x, y) = (range(along), range(left_of(along)));
    let centre = moved(scaled(along, (x[0] + x[1]) / 2.0), left_of(along), (y[0] + y[1]) / 2.0);
    Rectangle::new(centre, along, x[1] - x[0], y[1] - y[0])
}

/// Indices of the cells of a grid whose middles a section holds, and of those that its border crosses where it is thinner
/// than a cell.
pub(super) fn cells(grid: &WallGrid, borders: &[Border], by: Vector) -> Vec<usize> {
    let shifted: Vec<Border> = borders.iter().map(|b| b.map(|p| moved(p, by, 1.0))).collect();
    let mut found = Vec::new();
    let side = grid.resolution_m;
    for row in 0..grid.height {
        let y = grid.origin[1] + (row as f64 + 0.5) * side;
        let mut crossings: Vec<(f64, i32)> = shifted.iter().filter_map(|b| crossing(b, y)).collect();
        crossings.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut winding = 0;
        for k in 0..crossings.len() {
            winding += crossings[k].1;
            if winding != 0 && k + 1 < crossings.len() {
                let column = |x: f64| ((x - grid.origin[0]) / side - 0.5).ceil().clamp(0.0, grid.width as f64) as usize;
                found.extend((column(crossings[k].0)..column(crossings[k + 1].0)).map(|x| row * grid.width + x));
            }
        }
    }
    for [a, b] in &shifted {
        let length = distance(*a, *b).max(1e-9);
        let inside = scaled(left_of(difference(*b, *a)), 0.2 * side / length);
        let steps = (length / side * 2.0) as usize + 1;
        for k in 0..steps {
            let on_border = moved(*a, difference(*b, *a), (k as f64 + 0.5) / steps as f64);
            // A hair within the solid: a face on the border of a cell is not in the cell before it.
            found.extend(grid.index_at(moved(on_border, inside, 1.0)));
        }
    }
    found.sort_unstable();
    found.dedup();
    found
}

/// Where a border crosses a row, and whether the solid begins or ends there.
fn crossing([a, b]: &Border, y: f64) -> Option<(f64, i32)> {
    if (a[1] <= y) == (b[1] <= y) {
        return None;
    }
    let x = a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]);
    Some((x, if a[1] < b[1] { -1 } else { 1 }))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A box of 1.0 by 0.2 by 2 m, its faces outwards.
    fn box_mesh() -> (Vec<[f64; 3]>, Vec<[usize; 3]>) {
        let corner = |k: usize| [(k & 1) as f64, 0.2 * ((k >> 1) & 1) as f64, 2.0 * (k >> 2) as f64];
        let faces = [
            [0, 1, 5],
            [0, 5, 4],
            [1, 3, 7],
            [1, 7, 5],
            [3, 2, 6],
            [3, 6, 7],
            [2, 0, 4],
            [2, 4, 6],
            [0, 2, 3],
            [0, 3, 1],
            [4, 5, 7],
            [4, 7, 6],
        ];
        ((0..8).map(corner).collect(), faces.to_vec())
    }

    #[test]
    fn a_box_covers_the_cells_within_it_wherever_it_is_moved() {
        let (vertices, faces) = box_mesh();
        let borders = borders(&vertices, &faces, 0.3);
        let grid = WallGrid {
            width: 80,
            height: 60,
            resolution_m: 0.025,
            origin: [-0.5, -0.5],
            walls: Vec::new(),
            floor: Vec::new(),
        };
        for by in [[0.0, 0.0], [0.1, -0.3], [0.0113, 0.2071]] {
            let cells = cells(&grid, &borders, by);
            assert!((318..=380).contains(&cells.len()), "{}", cells.len());
            for k in cells {
                let [x, y] = grid.middle(k);
                assert!((-0.02..1.02).contains(&(x - by[0])) && (-0.02..0.22).contains(&(y - by[1])));
            }
        }
    }

    #[test]
    fn the_rectangle_around_a_turned_wall_is_along_it() {
        let (sin, cos) = libm::sincos(0.7);
        let (vertices, faces) = box_mesh();
        let turned: Vec<[f64; 3]> =
            vertices.iter().map(|[x, y, z]| [cos * x - sin * y, sin * x + cos * y, *z]).collect();
        let rectangle = around(&borders(&turned, &faces, 0.3)).unwrap();
        assert!((rectangle.half[0] - 0.5).abs() < 1e-9 && (rectangle.half[1] - 0.1).abs() < 1e-9, "{rectangle:?}");
        assert!((dot(rectangle.along, [cos, sin]).abs() - 1.0).abs() < 1e-9);
    }
}
