//! Leafs of one wall: parallel elements side by side, of the same length.

use super::model::Element;
use crate::plane::{Rectangle, Vector, dot, left_of};

const PARALLEL: f64 = 0.9995;
/// Gap between leafs, and how far they may overlap.
const GAP_M: f64 = 0.03;
const OVERLAP_M: f64 = 0.02;
/// Share of the length that two leafs have in common.
const COMMON_SHARE: f64 = 0.7;
/// Longer than this many thicknesses is a leaf.
const SLENDER: f64 = 1.5;

/// Elements that are removed or moved together: walls with all of their leafs, all else one by one. What only touches a
/// part of another along its length is in no group: it would be left standing on nothing.
pub(super) fn groups(elements: &[Element]) -> Vec<Vec<usize>> {
    let mut group_of: Vec<usize> = (0..elements.len()).collect();
    let mut is_attached = vec![false; elements.len()];
    for a in 0..elements.len() {
        for b in a + 1..elements.len() {
            let shares = common_shares(&elements[a].rectangle, &elements[b].rectangle);
            if shares.iter().all(|s| *s >= COMMON_SHARE) {
                let (from, to) = (group_of[b], group_of[a]);
                group_of.iter_mut().filter(|g| **g == from).for_each(|g| *g = to);
            } else if shares.iter().any(|s| *s > 0.1) {
                is_attached[a] = true;
                is_attached[b] = true;
            }
        }
    }
    let members = |g: usize| (0..elements.len()).filter(|k| group_of[*k] == g).collect::<Vec<_>>();
    let all = (0..elements.len()).map(members).filter(|members| !members.is_empty());
    all.filter(|members| !members.iter().any(|k| is_attached[*k])).collect()
}

/// Of each of two rectangles the share of its length on which the other lies directly beside it.
fn common_shares(a: &Rectangle, b: &Rectangle) -> [f64; 2] {
    let is_slender = |r: &Rectangle| r.half[0] >= SLENDER * r.half[1];
    if !is_slender(a) || !is_slender(b) || dot(a.along, b.along).abs() < PARALLEL {
        return [0.0; 2];
    }
    let between =
        |axis: Vector, reach: f64| dot([b.centre[0] - a.centre[0], b.centre[1] - a.centre[1]], axis).abs() - reach;
    let gap = between(left_of(a.along), a.half[1] + b.half[1]);
    if !(-OVERLAP_M..=GAP_M).contains(&gap) {
        return [0.0; 2];
    }
    let common = (-between(a.along, a.half[0] + b.half[0])).clamp(0.0, 2.0 * a.half[0].min(b.half[0]));
    [a, b].map(|r| common / (2.0 * r.half[0]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn element(centre: Vector, length: f64, width: f64) -> Element {
        let rectangle = Rectangle::new(centre, [1.0, 0.0], length, width);
        Element { global_id: String::new(), class: "wall".to_owned(), borders: Vec::new(), rectangle }
    }

    #[test]
    fn leafs_of_a_wall_are_one_group_and_what_touches_a_part_is_none() {
        let three = [element([0.0, 0.0], 4.0, 0.1), element([0.0, 0.1], 4.0, 0.1), element([0.1, 0.2], 3.8, 0.1)];
        assert_eq!(groups(&three), [vec![0, 1, 2]]);
        let apart = [element([0.0, 0.0], 4.0, 0.1), element([0.0, 0.5], 4.0, 0.1)];
        assert_eq!(groups(&apart), [vec![0], vec![1]]);
        let lining = [element([0.0, 0.0], 4.0, 0.1), element([1.0, 0.1], 1.5, 0.1)];
        assert!(groups(&lining).is_empty());
    }
}
