//! Changes of a building against its plan: groups of elements that are removed, displaced, cut through, or planned for later.

use super::leafs::groups;
use super::model::{Element, ModelStorey};
use super::section::cells;
use crate::plane::{Rectangle, Vector, left_of, scaled};
use crate::random_generator::RandomGenerator;
use serde::Serialize;

/// Lengths of groups that are changed, thickness of what is cut.
const LENGTH_M: [f64; 2] = [0.3, 15.0];
const MAX_CUT_THICKNESS_M: f64 = 0.7;
const DISPLACED_M: [f64; 2] = [0.12, 0.4];
const HOLE_M: [f64; 2] = [0.8, 2.0];
/// Share of the place of a hole that the wall fills.
const SOLID_SHARE: f64 = 0.85;
const HOLE_TRIES: usize = 6;
/// What is left of a cut wall at each end of the hole.
const BESIDE_HOLE_M: f64 = 0.5;

/// Share of the changed groups that are planned for later: half of them stand.
const LATER_SHARE: f64 = 0.2;

/// What became of a group.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(tag = "change", rename_all = "snake_case")]
pub(crate) enum Change {
    Kept,
    Removed,
    Displaced {
        by_m: Vector,
    },
    /// A gap across the wall, from floor to ceiling; its ends on the middle line of the wall.
    Hole {
        ends_m: [Vector; 2],
    },
}

/// A change of the elements of a group.
#[derive(Debug, Clone)]
pub(crate) struct GroupChange {
    /// Indices of its elements.
    pub(crate) members: Vec<usize>,
    pub(crate) change: Change,
    /// Around all of them, as planned.
    pub(crate) rectangle: Rectangle,
    /// Not planned to stand yet: kept or removed.
    pub(crate) is_planned_later: bool,
}

/// Changes of a share of the groups of a storey.
pub(crate) fn drawn_changes(storey: &ModelStorey, share: f64, random: &mut RandomGenerator) -> Vec<GroupChange> {
    let elements = &storey.elements;
    let is_changeable = |members: &Vec<usize>| {
        let all = members.iter().map(|k| &elements[*k]);
        let length = 2.0 * elements[members[0]].rectangle.half[0];
        (LENGTH_M[0]..=LENGTH_M[1]).contains(&length) && !all.clone().any(Element::is_glass)
    };
    let mut candidates: Vec<Vec<usize>> = groups(elements).into_iter().filter(is_changeable).collect();
    let n = ((share * candidates.len() as f64).round() as usize).max(1).min(candidates.len());
    (0..n)
        .map(|_| {
            let members = candidates.swap_remove(random.below(candidates.len()));
            let rectangle = around_all(elements, &members);
            let is_planned_later = random.happens(LATER_SHARE);
            let change = match is_planned_later {
                true if random.happens(0.5) => Change::Kept,
                true => Change::Removed,
                false => drawn_change(storey, &members, &rectangle, random),
            };
            GroupChange { members, change, rectangle, is_planned_later }
        })
        .collect()
}

/// Along the first element.
fn around_all(elements: &[Element], members: &[usize]) -> Rectangle {
    let along = elements[members[0]].rectangle.along;
    let borders: Vec<_> = members.iter().flat_map(|k| elements[*k].borders.iter().copied()).collect();
    super::section::around_along(&borders, along)
}

fn drawn_change(
    storey: &ModelStorey,
    members: &[usize],
    rectangle: &Rectangle,
    random: &mut RandomGenerator,
) -> Change {
    let hole = (0..HOLE_TRIES).find_map(|_| drawn_hole(storey, members, rectangle, random));
    match (random.below(5), hole) {
        (0, Some(ends_m)) => Change::Hole { ends_m },
        (1 | 2, _) => Change::Removed,
        _ => {
            let is_wall = rectangle.half[0] >= 2.0 * rectangle.half[1];
            let across = is_wall || random.happens(0.5);
            let axis = if across { left_of(rectangle.along) } else { rectangle.along };
            let by = random.between(DISPLACED_M[0], DISPLACED_M[1]) * random.sign();
            Change::Displaced { by_m: scaled(axis, by) }
        }
    }
}

/// Ends of a hole where the wall has no opening in the model.
fn drawn_hole(
    storey: &ModelStorey,
    members: &[usize],
    rectangle: &Rectangle,
    random: &mut RandomGenerator,
) -> Option<[Vector; 2]> {
    let length = 2.0 * rectangle.half[0];
    if length < HOLE_M[0] + 2.0 * BESIDE_HOLE_M || 2.0 * rectangle.half[1] > MAX_CUT_THICKNESS_M {
        return None;
    }
    let width = random.between(HOLE_M[0], HOLE_M[1].min(length - 2.0 * BESIDE_HOLE_M));
    let most = rectangle.half[0] - BESIDE_HOLE_M - width / 2.0;
    let middle = random.between(-most, most);
    let hole = Rectangle { centre: rectangle.at([middle, 0.0]), half: [width / 2.0, rectangle.half[1]], ..*rectangle };
    let is_within = |cell: &usize| hole.contains(storey.grid.middle(*cell));
    let n: usize = members
        .iter()
        .map(|k| cells(&storey.grid, &storey.elements[*k].borders, [0.0; 2]).iter().filter(|c| is_within(c)).count())
        .sum();
    let solid_m2 = n as f64 * storey.grid.resolution_m * storey.grid.resolution_m;
    let is_solid = solid_m2 >= SOLID_SHARE * 4.0 * hole.half[0] * hole.half[1];
    is_solid.then(|| [middle - width / 2.0, middle + width / 2.0].map(|x| rectangle.at([x, 0.0])))
}
