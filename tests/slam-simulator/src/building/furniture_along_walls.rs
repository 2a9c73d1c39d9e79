//! Furniture along walls: shelves, cupboards, sofas, kitchens, desks, and what lies before walls.

use super::contents::Contents;
use super::furniture_in_rooms::{chair, legs};
use crate::plane::Rectangle;
use crate::random_generator::RandomGenerator;
use crate::reference::Reference;
use crate::strengths::Strengths;
use crate::wall_stretches::WallStretch;
use crate::world::{Material, World};

/// Floor that stays open before furniture.
const WAY_M: f64 = 0.7;

/// What a row of furniture is.
#[derive(Debug, Clone, Copy)]
enum Kind {
    Shelves,
    Cupboards,
    Kitchen,
    Sofa,
    Desks,
    /// Bags, bins, plants, boxes.
    Loose,
    /// Radiators, ledges and cables, close to the wall.
    Ragged,
}

/// Walks along every stretch and places furniture before the share of it that was drawn.
pub(super) fn place(
    world: &mut World,
    reference: &Reference,
    strengths: &Strengths,
    random: &mut RandomGenerator,
    contents: &mut Contents,
) {
    for stretch in &reference.stretches {
        // Some walls are full where others are empty.
        let share = (strengths.furnished_wall_share * random.between(0.5, 1.5)).min(1.0);
        let length = stretch.length_m();
        let mut at = random.between(0.0, 0.4);
        while at + 0.3 < length {
            if !random.happens(share) {
                at += random.between(0.3, 1.2);
                continue;
            }
            let kind = drawn_kind(length, random);
            // Where a long row does not fit, a short one may.
            let mut wide = row_length_m(kind, random).min(length - at);
            while wide >= 0.3 && !row(world, stretch, [at, at + wide], kind, random) {
                wide /= 2.0;
            }
            contents.furniture += usize::from(wide >= 0.3);
            at += wide + random.between(0.0, 0.3);
        }
    }
}

fn drawn_kind(length_m: f64, random: &mut RandomGenerator) -> Kind {
    use Kind::*;
    let kinds: &[Kind] = if length_m < 1.5 {
        &[Shelves, Cupboards, Loose, Loose, Ragged]
    } else {
        &[Shelves, Shelves, Cupboards, Cupboards, Cupboards, Kitchen, Sofa, Desks, Loose, Ragged]
    };
    random.one_of(kinds)
}

fn row_length_m(kind: Kind, random: &mut RandomGenerator) -> f64 {
    match kind {
        Kind::Shelves => random.between(0.8, 4.0),
        Kind::Cupboards => random.between(0.6, 3.0),
        Kind::Kitchen => random.between(1.8, 4.0),
        Kind::Sofa => random.between(1.5, 2.6),
        Kind::Desks => random.between(1.2, 3.2),
        Kind::Loose => random.between(0.3, 1.2),
        Kind::Ragged => random.between(0.8, 3.0),
    }
}

/// One row between two places of a stretch; false if there is no room for it.
fn row(world: &mut World, stretch: &WallStretch, place: [f64; 2], kind: Kind, random: &mut RandomGenerator) -> bool {
    let [from, to] = place;
    let depth = match kind {
        Kind::Shelves => random.between(0.3, 0.42),
        Kind::Cupboards => random.between(0.4, 0.65),
        Kind::Kitchen => random.between(0.58, 0.65),
        Kind::Sofa => random.between(0.65, 0.8),
        Kind::Desks => random.between(0.6, 0.8),
        Kind::Loose => random.between(0.2, 0.5),
        Kind::Ragged => 0.15,
    };
    let gap = random.between(0.03, 0.1);
    let block = |from: f64, to: f64, depth: f64| {
        Rectangle::new(stretch.at((from + to) / 2.0, gap + depth / 2.0), stretch.along, to - from, depth)
    };
    let whole = block(from, to, depth);
    let way = Rectangle::new(stretch.at((from + to) / 2.0, gap + depth + WAY_M / 2.0), stretch.along, to - from, WAY_M);
    if !world.has_room_for(&whole) || !world.is_open(&way) {
        return false;
    }
    match kind {
        Kind::Kitchen | Kind::Sofa => world.fill(&whole, Material::Furniture),
        Kind::Cupboards => pieces(world, [from, to], [0.4, 1.0], random, |random, from, to| {
            Some(block(from, to, depth * if random.happens(0.2) { random.between(0.7, 1.0) } else { 1.0 }))
        }),
        // Open shelves: the beam ends at what lies on them.
        Kind::Shelves => pieces(world, [from, to], [0.1, 0.5], random, |random, from, to| {
            Some(block(from, to, depth * if random.happens(0.4) { random.between(0.5, 1.0) } else { 1.0 }))
        }),
        Kind::Ragged => pieces(world, [from, to], [0.08, 0.4], random, |random, from, to| {
            random.happens(0.8).then(|| block(from, to, random.between(0.03, 0.15)))
        }),
        Kind::Loose => pieces(world, [from, to], [0.2, 0.45], random, |random, from, to| {
            random.happens(0.75).then(|| block(from, to, depth * random.between(0.5, 1.0)))
        }),
        Kind::Desks => desks(world, &whole, random),
    }
    true
}

/// Fills a row with pieces of different widths.
fn pieces(
    world: &mut World,
    [from, to]: [f64; 2],
    wide: [f64; 2],
    random: &mut RandomGenerator,
    shape: impl Fn(&mut RandomGenerator, f64, f64) -> Option<Rectangle>,
) {
    let mut at = from;
    while at < to - 0.05 {
        let end = (at + random.between(wide[0], wide[1])).min(to);
        if let Some(rectangle) = shape(random, at, end) {
            world.fill(&rectangle, Material::Furniture);
        }
        at = end;
    }
}

/// Legs of desks, sometimes a container below, a chair, and bags.
fn desks(world: &mut World, whole: &Rectangle, random: &mut RandomGenerator) {
    let n = ((whole.half[0] * 2.0 / 1.6).round() as usize).max(1);
    let wide = whole.half[0] * 2.0 / n as f64;
    for k in 0..n {
        let middle = whole.at([-whole.half[0] + (k as f64 + 0.5) * wide, 0.0]);
        let desk = Rectangle::new(middle, whole.along, wide - 0.06, whole.half[1] * 2.0 - 0.06);
        legs(world, &desk, random);
        if random.happens(0.6) {
            let drawers = Rectangle::new(desk.at([random.sign() * (desk.half[0] - 0.25), 0.0]), desk.along, 0.4, 0.5);
            world.fill(&drawers, Material::Furniture);
        }
        if random.happens(0.5) {
            chair(world, desk.at([random.between(-0.3, 0.3), 0.1]), random);
        }
    }
}
