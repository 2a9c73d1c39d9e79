//! Homes: an outline that is divided again and again, with a door in every dividing wall.

use super::drawing::Drawing;
use super::storeys::of_storey;
use crate::plane::{Rectangle, Vector};
use crate::random_generator::RandomGenerator;
use occupancy::Cell;

const MIN_ROOM_M: f64 = 2.0;
/// Larger rooms are divided.
const MAX_ROOM_M2: [f64; 2] = [14.0, 34.0];

pub(super) fn home(random: &mut RandomGenerator, storey: usize) -> Drawing {
    let size = [random.between(8.0, 16.0), random.between(7.0, 13.0)];
    let mut drawing = Drawing::new(size);
    drawing.fill_box([0.0; 2], size, Cell::Free);
    let outer = random.between(0.25, 0.4);
    let mut doors = Vec::new();
    let inner = random.between(0.1, 0.2);
    let max_m2 = random.between(MAX_ROOM_M2[0], MAX_ROOM_M2[1]);
    let inside = [[outer; 2], size.map(|s| s - outer)];
    of_storey(random, storey);
    divide(&mut drawing, inside, inner, max_m2, &mut doors, random);
    for door in &doors {
        drawing.cut(door);
    }
    drawing.wall_around([0.0; 2], size, outer);
    drawing
}

/// Draws the walls that divide a rectangle into rooms, and collects their doors.
pub(super) fn divide(
    drawing: &mut Drawing,
    [low, high]: [Vector; 2],
    thickness: f64,
    max_m2: f64,
    doors: &mut Vec<Rectangle>,
    random: &mut RandomGenerator,
) {
    let size = [high[0] - low[0], high[1] - low[1]];
    // The longer side is cut.
    let k = usize::from(size[1] > size[0] * random.between(0.85, 1.15));
    if size[0] * size[1] < max_m2 || size[k] < 2.0 * MIN_ROOM_M + thickness || size[1 - k] < MIN_ROOM_M {
        return;
    }
    let share = random.between(0.3, 0.7);
    let at = low[k] + (size[k] * share).clamp(MIN_ROOM_M, size[k] - MIN_ROOM_M - thickness);
    let corner = |p: Vector, c: f64| if k == 0 { [c, p[1]] } else { [p[0], c] };
    drawing.fill_box(corner(low, at), corner(high, at + thickness), Cell::Occupied);
    let wide = if random.happens(0.2) { random.between(1.2, 2.0) } else { random.between(0.75, 1.0) };
    // Doors are near a corner of a room, seldom in the middle.
    let slack = (size[1 - k] - wide - 0.4).max(0.0);
    let place = match random.below(5) {
        0 | 1 => 0.0,
        2 | 3 => slack,
        _ => slack * random.unit(),
    };
    let middle = low[1 - k] + 0.2 + wide / 2.0 + place;
    let centre = if k == 0 { [at + thickness / 2.0, middle] } else { [middle, at + thickness / 2.0] };
    let along = if k == 0 { [0.0, 1.0] } else { [1.0, 0.0] };
    doors.push(Rectangle::new(centre, along, wide, thickness + 0.1));
    divide(drawing, [low, corner(high, at)], thickness, max_m2, doors, random);
    divide(drawing, [corner(low, at + thickness), high], thickness, max_m2, doors, random);
}
