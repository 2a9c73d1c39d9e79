//! Door leaves in openings: closed, half open, or against the wall.

use super::contents::Contents;
use crate::plane::{Rectangle, distance, moved, scaled};
use crate::random_generator::RandomGenerator;
use crate::reference::Reference;
use crate::strengths::Strengths;
use crate::world::{Material, World};

const LEAF_M: f64 = 0.05;
/// Floor before and behind an opening that furniture leaves free.
const FREE_DEPTH_M: f64 = 1.0;

/// Hangs leaves, and keeps furniture away from openings.
pub(super) fn hang(
    world: &mut World,
    reference: &Reference,
    strengths: &Strengths,
    random: &mut RandomGenerator,
    contents: &mut Contents,
) {
    for opening in &reference.openings {
        let (width, centre) = (opening.width_m(), opening.centre());
        let free = Rectangle::new(centre, opening.normal, 2.0 * FREE_DEPTH_M, width.max(0.9));
        for index in world.cells_in(&free) {
            world.can_be_furnished[index] = false;
        }
        if !random.happens(strengths.door_leaf_share) {
            continue;
        }
        let side = random.sign();
        let [hinge, lock] = if random.happens(0.5) { opening.ends } else { [opening.ends[1], opening.ends[0]] };
        let angle_deg = if random.happens(strengths.closed_door_share) {
            0.0
        } else if random.happens(0.6) {
            random.between(80.0, 115.0)
        } else {
            random.between(20.0, 80.0)
        };
        let closed = scaled([lock[0] - hinge[0], lock[1] - hinge[1]], 1.0 / distance(hinge, lock).max(1e-9));
        let (sin, cos) = libm::sincos(f64::to_radians(angle_deg));
        let normal = scaled(opening.normal, side);
        let along = [cos * closed[0] + sin * normal[0], cos * closed[1] + sin * normal[1]];
        // Inside of the wall when closed, before its face when open.
        let foot = if angle_deg > 0.0 { moved(hinge, normal, 0.08) } else { hinge };
        world.fill(&Rectangle::between(foot, moved(foot, along, width - 0.02), LEAF_M), Material::Furniture);
        contents.door_leaves += 1;
    }
}
