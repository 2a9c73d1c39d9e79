//! Walls that are missing, elsewhere, additional, or of glass.

use super::contents::Contents;
use super::places::drawn_place;
use crate::plane::{Rectangle, Vector, moved, scaled};
use crate::random_generator::RandomGenerator;
use crate::reference::Reference;
use crate::strengths::Strengths;
use crate::wall_stretches::WallStretch;
use crate::world::{CELL_M, Material, World};

const MAX_THICKNESS_M: f64 = 0.6;

/// A piece of wall behind a stretch of face, with its thickness.
fn piece(reference: &Reference, stretch: &WallStretch, at_m: f64, length_m: f64) -> Option<Rectangle> {
    let from = (at_m - length_m / 2.0).max(0.0);
    let to = (at_m + length_m / 2.0).min(stretch.length_m());
    let thickness = stretch.thickness_m(&reference.grid, (from + to) / 2.0, MAX_THICKNESS_M);
    // What is thicker is a shaft or a solid part of the building.
    if to - from < 0.4 || !(CELL_M..MAX_THICKNESS_M - CELL_M).contains(&thickness) {
        return None;
    }
    let middle = stretch.at((from + to) / 2.0, -thickness / 2.0);
    Some(Rectangle::new(middle, stretch.along, to - from, thickness + 2.0 * CELL_M))
}

/// Removes, moves and adds walls.
pub(super) fn change(
    world: &mut World,
    reference: &Reference,
    strengths: &Strengths,
    random: &mut RandomGenerator,
    contents: &mut Contents,
) {
    for _ in 0..random.poisson(strengths.wall_changes_per_100_m2 * reference.grid.floor_m2() / 100.0) {
        let Some((stretch, at)) = drawn_place(reference, random) else { return };
        match random.below(5) {
            0 | 1 => {
                let length = random.between(0.8, 3.0);
                let Some(gone) = piece(reference, stretch, at, length) else { continue };
                erase(world, &gone);
                contents.walls_removed += 1;
            }
            2 | 3 => {
                let length = random.between(1.0, 6.0);
                let Some(from) = piece(reference, stretch, at, length) else { continue };
                let by = random.between(0.1, 0.4) * random.sign();
                shift(world, &from, scaled(stretch.normal, by));
                contents.walls_moved += 1;
            }
            _ => {
                let wall = added(stretch, at, random);
                let is_new = world.cells_in(&wall).filter(|&k| world.can_be_furnished[k]).count();
                if is_new * 2 > world.cells_in(&wall).count() {
                    world.fill(&wall, Material::OtherWall);
                    contents.walls_added += 1;
                }
            }
        }
    }
}

fn erase(world: &mut World, rectangle: &Rectangle) {
    for index in world.cells_in(rectangle) {
        world.cells[index] = Material::Empty;
        world.floor[index] = true;
    }
}

fn shift(world: &mut World, from: &Rectangle, by: Vector) {
    erase(world, from);
    // Without the margin that made sure that nothing is left.
    let wall = Rectangle { half: [from.half[0], from.half[1] - CELL_M], ..from.shifted(by) };
    world.fill(&wall, Material::OtherWall);
}

/// A partition that leaves a wall at a right angle, or a wall set before another.
fn added(stretch: &WallStretch, at_m: f64, random: &mut RandomGenerator) -> Rectangle {
    let (length, thickness) = (random.between(0.8, 3.5), random.between(0.08, 0.2));
    if random.happens(0.6) {
        let from = stretch.at(at_m, 0.0);
        Rectangle::between(from, moved(from, stretch.normal, length), thickness)
    } else {
        Rectangle::new(stretch.at(at_m, random.between(0.3, 0.8)), stretch.along, length, thickness)
    }
}

/// Turns stretches of wall into glass.
pub(super) fn glaze(
    world: &mut World,
    reference: &Reference,
    strengths: &Strengths,
    random: &mut RandomGenerator,
    contents: &mut Contents,
) {
    // Both faces of a wall count, and glass takes both.
    let faces_m: f64 = reference.stretches.iter().map(WallStretch::length_m).sum();
    let wanted_m = faces_m / 2.0 * strengths.glass_share;
    for _ in 0..200 {
        if contents.glass_m >= wanted_m {
            return;
        }
        let Some((stretch, at)) = drawn_place(reference, random) else { return };
        let length = random.between(1.0, 4.0);
        let Some(wall) = piece(reference, stretch, at, length) else { continue };
        // A pane in the middle of what was the wall, between posts.
        erase(world, &wall);
        world.fill(&Rectangle { half: [wall.half[0], CELL_M], ..wall }, Material::Glass);
        for end in [-1.0, 1.0] {
            let post = Rectangle::new(wall.at([end * wall.half[0], 0.0]), wall.along, 0.06, 0.08);
            world.cells_in(&post).for_each(|k| world.cells[k] = Material::Wall);
        }
        contents.glass_m += 2.0 * wall.half[0];
    }
}
