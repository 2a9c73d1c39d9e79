//! Halls with columns, gates, and rooms along one side.

use super::drawing::Drawing;
use super::homes::divide;
use super::storeys::of_storey;
use crate::plane::Rectangle;
use crate::random_generator::RandomGenerator;
use occupancy::Cell;

pub(super) fn hall(random: &mut RandomGenerator, storey: usize) -> Drawing {
    let size = [random.between(18.0, 42.0), random.between(12.0, 26.0)];
    let outer = random.between(0.2, 0.4);
    let mut drawing = Drawing::new(size);
    drawing.fill_box([0.0; 2], size, Cell::Free);
    drawing.wall_around([0.0; 2], size, outer);
    of_storey(random, storey);
    let first_column = outer + rooms(&mut drawing, size, outer, random);
    columns(&mut drawing, [first_column, outer], size, random);
    for _ in 0..random.count(0, 4) {
        let wide = random.between(2.5, 4.5);
        let gate = match random.below(3) {
            0 => Rectangle::new([random.between(6.0, size[0] - 3.0), 0.0], [1.0, 0.0], wide, 2.0 * outer),
            1 => Rectangle::new([random.between(6.0, size[0] - 3.0), size[1]], [1.0, 0.0], wide, 2.0 * outer),
            _ => Rectangle::new([size[0], random.between(3.0, size[1] - 3.0)], [0.0, 1.0], wide, 2.0 * outer),
        };
        drawing.cut(&gate);
    }
    if random.happens(0.3) {
        oblique_wall(&mut drawing, size, random);
    }
    drawing
}

/// Rooms at the left end; the depth that they take.
fn rooms(drawing: &mut Drawing, size: [f64; 2], outer: f64, random: &mut RandomGenerator) -> f64 {
    if random.happens(0.3) {
        return 0.0;
    }
    let (depth, thickness) = (random.between(3.0, 6.0), random.between(0.1, 0.2));
    drawing.fill_box([outer + depth, outer], [outer + depth + thickness, size[1] - outer], Cell::Occupied);
    let door = |y: f64| Rectangle::new([outer + depth + thickness / 2.0, y], [0.0, 1.0], 1.0, thickness + 0.1);
    let mut doors = vec![door(random.between(1.2, size[1] - 1.2))];
    let inside = [[outer; 2], [outer + depth, size[1] - outer]];
    divide(drawing, inside, thickness, random.between(15.0, 30.0), &mut doors, random);
    doors.iter().for_each(|door| drawing.cut(door));
    depth + thickness
}

fn columns(drawing: &mut Drawing, from: [f64; 2], size: [f64; 2], random: &mut RandomGenerator) {
    if random.happens(0.25) {
        return;
    }
    let (apart, side) = ([random.between(4.5, 8.0), random.between(4.5, 8.0)], random.between(0.3, 0.6));
    let n = [0, 1].map(|k| ((size[k] - from[k]) / apart[k]) as usize);
    for k in 0..n[0] * n[1] {
        let at = [0, 1].map(|axis| {
            let step = if axis == 0 { k % n[0] } else { k / n[0] };
            from[axis] + (step as f64 + 0.8) * apart[axis]
        });
        drawing.build(&Rectangle::new(at, [1.0, 0.0], side, side));
    }
}

/// A partition that is parallel to nothing.
fn oblique_wall(drawing: &mut Drawing, size: [f64; 2], random: &mut RandomGenerator) {
    let from = [size[0] * random.between(0.4, 0.7), random.between(2.0, 4.0)];
    let along = crate::plane::direction_of(random.between(0.5, 1.1));
    let to = crate::plane::moved(from, along, size[1] * 0.6);
    drawing.build(&Rectangle::between(from, to, random.between(0.1, 0.25)));
}
