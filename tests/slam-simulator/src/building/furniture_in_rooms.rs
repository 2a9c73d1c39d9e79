//! Furniture away from walls: tables, rows of desks, chairs, beds, boxes, pallets, racks.

use super::contents::Contents;
use super::places::{drawn_floor, drawn_place};
use crate::plane::{Rectangle, Vector, left_of};
use crate::random_generator::RandomGenerator;
use crate::reference::Reference;
use crate::strengths::Strengths;
use crate::world::{Material, World};

/// From this clearance around a place, it belongs to a hall.
const HALL_M: f64 = 3.5;

/// Furniture of all kinds at drawn places, in the direction of a wall.
pub(super) fn place(
    world: &mut World,
    reference: &Reference,
    strengths: &Strengths,
    random: &mut RandomGenerator,
    contents: &mut Contents,
) {
    for _ in 0..random.poisson(strengths.furniture_per_m2 * reference.grid.floor_m2()) {
        let Some(at) = drawn_floor(world, random) else { return };
        let Some((stretch, _)) = drawn_place(reference, random) else { return };
        let along = if random.happens(0.5) { stretch.along } else { left_of(stretch.along) };
        // Most of it is nearly parallel to a wall.
        let turn = if random.happens(0.12) { random.between(0.0, 3.1) } else { 0.03 * random.normal() };
        let along = crate::plane::turned(along, crate::plane::direction_of(turn));
        let is_hall = reference.wall_distance_m(at) > HALL_M;
        contents.furniture += usize::from(piece(world, at, along, is_hall, random));
    }
}

fn piece(world: &mut World, at: Vector, along: Vector, is_hall: bool, random: &mut RandomGenerator) -> bool {
    let block = |length: f64, width: f64| Rectangle::new(at, along, length, width);
    match random.below(if is_hall { 14 } else { 11 }) {
        0 | 1 => table(world, &block(random.between(0.8, 2.2), random.between(0.7, 1.0)), random),
        2 | 3 => desk_rows(world, &block(1.6, 0.8), random),
        4 => solid(world, &block(random.between(1.9, 2.1), random.between(0.9, 1.8)), random),
        5 => solid(world, &block(random.between(1.2, 2.4), random.between(0.5, 0.9)), random),
        6 | 7 => loose_chairs(world, at, random),
        8 => solid(world, &block(random.between(0.25, 0.7), random.between(0.25, 0.6)), random),
        9 => disc(world, at, random.between(0.1, 0.28)),
        10 => solid(world, &block(random.between(0.8, 2.0), random.between(0.04, 0.1)), random),
        11 | 12 => pallets(world, &block(1.2, 0.8), random),
        _ => solid(world, &block(random.between(2.7, 8.1), 1.1), random),
    }
}

/// Full down to the floor; a way around it stays.
fn solid(world: &mut World, rectangle: &Rectangle, random: &mut RandomGenerator) -> bool {
    let fits = world.has_room_for(&rectangle.grown(if random.happens(0.5) { 0.5 } else { 0.05 }));
    if fits {
        world.fill(rectangle, Material::Furniture);
    }
    fits
}

fn disc(world: &mut World, at: Vector, radius_m: f64) -> bool {
    let fits = world.has_room_for(&Rectangle::new(at, [1.0, 0.0], 2.0 * radius_m, 2.0 * radius_m));
    if fits {
        world.fill_disc(at, radius_m, Material::Furniture);
    }
    fits
}

/// Four legs, round or square.
pub(super) fn legs(world: &mut World, top: &Rectangle, random: &mut RandomGenerator) {
    let (side, is_round) = (random.between(0.035, 0.08), random.happens(0.5));
    for corner in [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]] {
        let leg = top.at([corner[0] * (top.half[0] - side), corner[1] * (top.half[1] - side)]);
        if is_round {
            world.fill_disc(leg, side / 2.0 + 0.01, Material::Furniture);
        } else {
            world.fill(&Rectangle::new(leg, top.along, side, side), Material::Furniture);
        }
    }
}

/// A chair: four legs, or a column on a star of feet.
pub(super) fn chair(world: &mut World, at: Vector, random: &mut RandomGenerator) {
    let seat = Rectangle::new(at, crate::plane::direction_of(random.between(0.0, 6.2)), 0.42, 0.42);
    if !world.has_room_for(&Rectangle { half: [0.08, 0.08], ..seat }) {
        return;
    }
    match random.below(4) {
        0 | 1 => legs(world, &seat, random),
        2 => {
            world.fill_disc(at, 0.035, Material::Furniture);
            let (first, far) = (random.between(0.0, 1.2), random.between(0.22, 0.32));
            for k in 0..5 {
                // Not every foot is as high as the lidar.
                if random.happens(0.6) {
                    let towards = crate::plane::direction_of(first + f64::from(k) * 1.2566);
                    world.fill_disc(crate::plane::moved(at, towards, far), 0.025, Material::Furniture);
                }
            }
        }
        _ => world.fill_disc(at, random.between(0.15, 0.22), Material::Furniture),
    }
}

fn loose_chairs(world: &mut World, at: Vector, random: &mut RandomGenerator) -> bool {
    let area = Rectangle::new(at, [1.0, 0.0], 1.6, 1.6);
    if !world.has_room_for(&Rectangle { half: [0.3, 0.3], ..area }) {
        return false;
    }
    for _ in 0..random.count(1, 4) {
        let place = area.at([random.between(-0.8, 0.8), random.between(-0.8, 0.8)]);
        chair(world, place, random);
    }
    true
}

/// A table with chairs around it.
fn table(world: &mut World, top: &Rectangle, random: &mut RandomGenerator) -> bool {
    if !world.has_room_for(&top.grown(0.35)) {
        return false;
    }
    legs(world, top, random);
    let per_side = (top.half[0] / 0.4) as usize;
    for side in [-1.0, 1.0] {
        for k in 0..per_side {
            if random.happens(0.7) {
                let along = -top.half[0] + (k as f64 + 0.5) * 2.0 * top.half[0] / per_side as f64;
                let across = side * (top.half[1] + random.between(-0.1, 0.3));
                chair(world, top.at([along + random.between(-0.1, 0.1), across]), random);
            }
        }
    }
    true
}

/// Desks in rows as in offices and class rooms, as many as there is room for.
fn desk_rows(world: &mut World, first: &Rectangle, random: &mut RandomGenerator) -> bool {
    let (n_rows, n_columns) = (random.count(1, 4), random.count(1, 3));
    let (apart, has_panel) = (random.between(1.3, 2.2), random.happens(0.4));
    let drawers = random.between(0.0, 0.9);
    let mut placed = false;
    for row in 0..n_rows {
        for column in 0..n_columns {
            let offset = [column as f64 * (2.0 * first.half[0] + 0.05), row as f64 * apart];
            let desk = Rectangle { centre: first.at(offset), ..*first };
            if !world.has_room_for(&desk.grown(0.02)) {
                continue;
            }
            placed = true;
            legs(world, &desk, random);
            if has_panel {
                let panel =
                    Rectangle::new(desk.at([0.0, desk.half[1] - 0.1]), desk.along, 2.0 * desk.half[0] - 0.2, 0.03);
                world.fill(&panel, Material::Furniture);
            }
            if random.happens(drawers) {
                let at = desk.at([random.sign() * (desk.half[0] - 0.25), 0.05]);
                world.fill(&Rectangle::new(at, desk.along, 0.42, 0.6), Material::Furniture);
            }
            if random.happens(0.8) {
                let at = desk.at([random.between(-0.4, 0.4), -desk.half[1] - random.between(-0.1, 0.4)]);
                chair(world, at, random);
            }
        }
    }
    placed
}

/// Pallets with goods, not quite in line.
fn pallets(world: &mut World, first: &Rectangle, random: &mut RandomGenerator) -> bool {
    let mut placed = false;
    for k in 0..random.count(1, 6) {
        let offset = [f64::from(k as u32 % 3) * 1.3, f64::from(k as u32 / 3) * 0.9];
        let slip = [random.between(-0.08, 0.08), random.between(-0.08, 0.08)];
        let pallet = Rectangle { centre: first.at([offset[0] + slip[0], offset[1] + slip[1]]), ..*first };
        if world.has_room_for(&pallet) {
            world.fill(&pallet, Material::Furniture);
            placed = true;
        }
    }
    placed
}
