//! Groups what lies apart in the plane, so that each group can be worked on alone.

use crate::polygon::Bounds;
use std::ops::Range;

/// Indices in groups such that no bounds of one group lie within `gap` of bounds of another, without empty groups.
///
/// The plane is cut along lines that meet nothing, first across x, then across y, until no such line is left: n log n for
/// each level of cuts. Things that interlock without touching stay together.
pub(crate) fn clusters(bounds: &[Bounds], gap: i64) -> Vec<Vec<usize>> {
    let mut found = Vec::new();
    let mut open = vec![((0..bounds.len()).collect::<Vec<_>>(), 0, 0)];
    // Along which axis to cut next, and along how many axes no cut was found since the last.
    while let Some((mut group, axis, n_whole)) = open.pop() {
        if group.len() < 2 || n_whole == 2 {
            found.extend((!group.is_empty()).then_some(group));
            continue;
        }
        group.sort_unstable_by_key(|&k| (bounds[k].min[axis], k));
        let parts = apart(&group, |k| [bounds[k].min[axis], bounds[k].max[axis]].map(i64::from), gap);
        let n_whole = if parts.len() == 1 { n_whole + 1 } else { 1 };
        open.extend(parts.into_iter().rev().map(|part| (group[part].to_vec(), 1 - axis, n_whole)));
    }
    found
}

/// Runs of sorted intervals with more than `gap` between them.
fn apart(sorted: &[usize], interval: impl Fn(usize) -> [i64; 2], gap: i64) -> Vec<Range<usize>> {
    let (mut runs, mut start, mut reached) = (Vec::new(), 0, i64::MIN);
    for (place, &index) in sorted.iter().enumerate() {
        let [from, to] = interval(index);
        if place > 0 && from.saturating_sub(reached) > gap {
            runs.push(start..place);
            start = place;
        }
        reached = reached.max(to);
    }
    runs.push(start..sorted.len());
    runs
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn at(x: i32, y: i32, side: i32) -> Bounds {
        Bounds { min: [x, y], max: [x + side, y + side] }
    }

    #[test]
    fn a_chessboard_of_squares_falls_into_its_squares_and_touching_ones_stay_together() {
        let board: Vec<Bounds> = (0..64).map(|k| at(k % 8 * 20, k / 8 * 20, 10)).collect();
        assert_eq!(clusters(&board, 0).len(), 64);
        assert_eq!(clusters(&board, 9).len(), 64);
        assert_eq!(clusters(&board, 10).len(), 1);
        assert_eq!(clusters(&[at(0, 0, 10), at(10, 10, 10)], 0).len(), 1);
        assert!(clusters(&[], 0).is_empty());
    }

    proptest! {
        #[test]
        fn each_is_in_one_group_and_groups_lie_apart(
            places in prop::collection::vec((0..300, 0..300, 0..40), 0..60),
            gap in 0i64..20,
        ) {
            let bounds: Vec<Bounds> = places.iter().map(|&(x, y, side)| at(x, y, side)).collect();
            let groups = clusters(&bounds, gap);
            let mut all: Vec<usize> = groups.iter().flatten().copied().collect();
            all.sort_unstable();
            prop_assert_eq!(all, (0..bounds.len()).collect::<Vec<_>>());
            for (k, group) in groups.iter().enumerate() {
                for &a in group {
                    for &b in groups[..k].iter().flatten() {
                        let away = |axis: usize| {
                            let (a, b) = (bounds[a], bounds[b]);
                            (a.min[axis] - b.max[axis]).max(b.min[axis] - a.max[axis])
                        };
                        prop_assert!(i64::from(away(0).max(away(1))) > gap);
                    }
                }
            }
        }
    }
}
