//! Places in a building, drawn.

use crate::plane::Vector;
use crate::random_generator::RandomGenerator;
use crate::reference::Reference;
use crate::wall_stretches::WallStretch;
use crate::world::World;

/// A stretch drawn by its length, and a place on it.
pub(super) fn drawn_place<'a>(
    reference: &'a Reference,
    random: &mut RandomGenerator,
) -> Option<(&'a WallStretch, f64)> {
    let whole: f64 = reference.stretches.iter().map(WallStretch::length_m).sum();
    let mut at = random.unit() * whole;
    for stretch in &reference.stretches {
        if at <= stretch.length_m() {
            return Some((stretch, at));
        }
        at -= stretch.length_m();
    }
    None
}

/// A point of the floor; `None` without floor.
pub(super) fn drawn_floor(world: &World, random: &mut RandomGenerator) -> Option<Vector> {
    (0..200).map(|_| random.below(world.cells.len())).find(|&k| world.floor[k]).map(|k| world.middle(k))
}
