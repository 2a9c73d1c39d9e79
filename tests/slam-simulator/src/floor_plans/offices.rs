//! Offices: cells along corridors, in one wing, at a right angle, or around a yard.

use super::drawing::Drawing;
use super::storeys::of_storey;
use crate::plane::{Rectangle, Vector};
use crate::random_generator::RandomGenerator;
use occupancy::Cell;

/// What the wings of a building have in common.
struct Style {
    corridor_m: f64,
    depth_m: f64,
    outer_m: f64,
    inner_m: f64,
    door_m: f64,
    /// Widths of rooms, one after the other on both sides of each wing.
    rooms_m: Vec<f64>,
    has_both_sides: bool,
}

/// The middle of the corridor of a wing, from its begin to its end.
#[derive(Clone, Copy)]
struct Wing {
    from: Vector,
    is_upright: bool,
    length: f64,
    /// How far the corridor goes on before the begin, to that of another wing.
    before: f64,
}

pub(super) fn office(random: &mut RandomGenerator, storey: usize) -> Drawing {
    let mut style = style(random);
    let (long, short) = (random.between(16.0, 42.0), random.between(12.0, 28.0));
    let (below, above) = style.beside();
    let across = below + above;
    let first = |length: f64| Wing { from: [0.0, below], is_upright: false, length, before: 0.0 };
    let upright = |x: f64| {
        let from = [x, across - style.outer_m];
        Wing { from, is_upright: true, length: short + style.outer_m, before: above - style.outer_m }
    };
    let (size, wings) = match random.below(4) {
        0 | 1 => ([long, across], vec![first(long)]),
        2 => ([long, across + short], vec![first(long), upright(below)]),
        _ => {
            let long = long.max(2.0 * across + 5.0);
            ([long, across + short], vec![first(long), upright(below), upright(long - above)])
        }
    };
    if storey > 0 {
        of_storey(random, storey);
        style.rooms_m = rooms_m(random);
    }
    let mut drawing = Drawing::new(size);
    for wing in &wings {
        outline(&mut drawing, &style, wing);
    }
    for wing in &wings {
        rooms(&mut drawing, &style, wing, random);
    }
    // Corridors meet: what one wing has drawn into the corridor of another goes.
    for wing in &wings {
        let [low, high] = strip(wing, -style.corridor_m / 2.0, style.corridor_m / 2.0, style.outer_m);
        drawing.fill_box(low, high, Cell::Free);
        if wing.before > 0.0 {
            let joint = Wing { from: at(wing, -wing.before, 0.0), length: wing.before + 1.0, ..*wing };
            let [low, high] = strip(&joint, -style.corridor_m / 2.0, style.corridor_m / 2.0, 0.0);
            drawing.fill_box(low, high, Cell::Free);
        }
    }
    drawing
}

impl Style {
    /// How far a wing extends on both sides of the middle of its corridor.
    fn beside(&self) -> (f64, f64) {
        let near = self.corridor_m / 2.0;
        (near + if self.has_both_sides { self.depth_m } else { self.outer_m }, near + self.depth_m)
    }
}

/// Widths of rooms, all alike or not.
fn rooms_m(random: &mut RandomGenerator) -> Vec<f64> {
    let repeats = random.happens(0.5);
    let room = random.between(2.4, 4.5);
    (0..40)
        .map(|_| match repeats {
            true => room,
            false if random.happens(0.2) => random.between(5.0, 9.0),
            false => random.between(2.2, 5.0),
        })
        .collect()
}

fn style(random: &mut RandomGenerator) -> Style {
    let rooms_m = rooms_m(random);
    Style {
        corridor_m: random.between(1.5, 2.8),
        depth_m: random.between(3.2, 6.0),
        outer_m: random.between(0.25, 0.4),
        inner_m: random.between(0.1, 0.2),
        door_m: random.between(0.8, 1.0),
        rooms_m,
        has_both_sides: random.happens(0.8),
    }
}

/// Corners of the part of a wing between two lines beside the middle of its corridor, shortened at both ends.
fn strip(wing: &Wing, below: f64, above: f64, short: f64) -> [Vector; 2] {
    let [x, y] = wing.from;
    if wing.is_upright {
        [[x + below, y + short], [x + above, y + wing.length - short]]
    } else {
        [[x + short, y + below], [x + wing.length - short, y + above]]
    }
}

fn outline(drawing: &mut Drawing, style: &Style, wing: &Wing) {
    let (below, above) = style.beside();
    let [low, high] = strip(wing, -below, above, 0.0);
    drawing.fill_box(low, high, Cell::Free);
    drawing.wall_around(low, high, style.outer_m);
}

/// Walls between corridor and rooms, walls between rooms, and a door for each.
fn rooms(drawing: &mut Drawing, style: &Style, wing: &Wing, random: &mut RandomGenerator) {
    let sides: &[f64] = if style.has_both_sides { &[1.0, -1.0] } else { &[1.0] };
    for side in sides {
        let (near, far) = (style.corridor_m / 2.0, style.corridor_m / 2.0 + style.depth_m);
        let across = |a: f64, b: f64| if *side > 0.0 { (a, b) } else { (-b, -a) };
        let between = |from: f64, to: f64, (below, above): (f64, f64)| {
            let part = Wing { length: to - from, from: at(wing, from, 0.0), ..*wing };
            strip(&part, below, above, 0.0)
        };
        let [low, high] = between(0.0, wing.length, across(near, near + style.inner_m));
        drawing.fill_box(low, high, Cell::Occupied);
        let mut begin = style.outer_m;
        for room in &style.rooms_m {
            let end = if begin + room + 2.0 > wing.length { wing.length - style.outer_m } else { begin + room };
            if end < wing.length - style.outer_m {
                let [low, high] = between(end, end + style.inner_m, across(near, far));
                drawing.fill_box(low, high, Cell::Occupied);
            }
            let slack = (end - begin - style.door_m - 0.4).max(0.0);
            let place = begin + 0.2 + style.door_m / 2.0 + if random.happens(0.5) { 0.0 } else { slack };
            let door = at(wing, place, side * (near + style.inner_m / 2.0));
            let along = if wing.is_upright { [0.0, 1.0] } else { [1.0, 0.0] };
            drawing.cut(&Rectangle::new(door, along, style.door_m, style.inner_m + 0.1));
            begin = end + style.inner_m;
            if end >= wing.length - style.outer_m {
                break;
            }
        }
    }
}

fn at(wing: &Wing, along: f64, across: f64) -> Vector {
    let [x, y] = wing.from;
    if wing.is_upright { [x + across, y + along] } else { [x + along, y + across] }
}
