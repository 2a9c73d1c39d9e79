//! The building as it is, made of the building as planned: changed walls, glass, door leaves, furniture, people who stand.

mod contents;
mod doors;
mod furniture_along_walls;
mod furniture_in_rooms;
mod places;
mod walls;

use crate::plane::{Rectangle, moved};
use crate::random_generator::RandomGenerator;
use crate::reference::Reference;
use crate::strengths::Strengths;
use crate::world::{CELL_M, Material, World};
use places::drawn_floor;

pub use contents::Contents;

/// Makes the building of a model map what it is in use.
pub(crate) fn fill(
    world: &mut World,
    reference: &Reference,
    strengths: &Strengths,
    random: &RandomGenerator,
) -> Contents {
    let mut contents = Contents::default();
    walls::change(world, reference, strengths, &mut random.part("walls"), &mut contents);
    walls::glaze(world, reference, strengths, &mut random.part("glass"), &mut contents);
    doors::hang(world, reference, strengths, &mut random.part("doors"), &mut contents);
    model_furniture(world, reference, strengths, &mut random.part("model furniture"));
    furniture_along_walls::place(world, reference, strengths, &mut random.part("along walls"), &mut contents);
    furniture_in_rooms::place(world, reference, strengths, &mut random.part("in rooms"), &mut contents);
    groups(world, strengths, &mut random.part("groups"), &mut contents);
    outdoors(world, strengths, &mut random.part("outdoors"));
    contents
}

/// What the model has on its floor is there, in part.
fn model_furniture(world: &mut World, reference: &Reference, strengths: &Strengths, random: &mut RandomGenerator) {
    if !random.happens(strengths.clutter) {
        return;
    }
    for index in (0..reference.furniture.len()).filter(|&k| reference.furniture[k]) {
        let side = reference.grid.resolution_m;
        world.fill(&Rectangle::new(reference.grid.middle(index), [1.0, 0.0], side, side), Material::Furniture);
    }
}

/// People who stand together and talk.
fn groups(world: &mut World, strengths: &Strengths, random: &mut RandomGenerator, contents: &mut Contents) {
    for _ in 0..strengths.standing_groups {
        let Some(middle) = drawn_floor(world, random) else { return };
        for k in 0..random.count(2, 5) {
            let towards = crate::plane::direction_of(k as f64 * 1.4 + random.between(-0.3, 0.3));
            let at = moved(middle, towards, random.between(0.5, 0.9));
            let body = Rectangle::new(at, towards, 0.4, 0.4);
            if !world.has_room_for(&body) {
                continue;
            }
            contents.people_standing += 1;
            let apart = random.between(0.09, 0.16);
            for side in [-1.0, 1.0] {
                world.fill_disc(body.at([0.0, side * apart]), random.between(0.06, 0.09), Material::Furniture);
            }
        }
    }
}

/// Trees, cars and walls beyond windows.
fn outdoors(world: &mut World, strengths: &Strengths, random: &mut RandomGenerator) {
    for _ in 0..strengths.outdoor_objects {
        let at = world.middle(random.below(world.cells.len()));
        let along = crate::plane::direction_of(random.between(0.0, 3.1));
        let size = [random.between(0.2, 4.0), random.between(0.1, 0.5)];
        let thing = Rectangle::new(at, along, size[0], size[1]);
        let near = thing.grown(16.0 * CELL_M);
        if world.cells_in(&near).all(|k| !world.floor[k] && world.cells[k] == Material::Empty) {
            world.fill(&thing, Material::Furniture);
        }
    }
}
