//! States of elements and spaces over time, and the spans of time in which those of two schedules differ.

use messages::{ElementState, Site};
use schedule::Timeline;

/// What maps show of an element.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum StandingState {
    /// Not there yet, or gone.
    Absent,
    /// Being built or removed: an obstacle, but no floor.
    WorkedOn,
    /// It stands.
    Stands,
}

impl From<ElementState> for StandingState {
    fn from(state: ElementState) -> Self {
        match state {
            ElementState::NotStarted | ElementState::Removed => Self::Absent,
            ElementState::InProgress | ElementState::BeingRemoved => Self::WorkedOn,
            ElementState::Built => Self::Stands,
        }
    }
}

/// States of all elements and spaces over time: instant and state, the first from [`i64::MIN`] on.
pub(super) struct StateHistory {
    pub(super) elements: Vec<Vec<(i64, StandingState)>>,
    /// Whether a space must not be entered.
    pub(super) blocked: Vec<Vec<(i64, bool)>>,
}

impl StateHistory {
    pub(super) fn of(site: &Site<'_>, timeline: &Timeline) -> Self {
        let first = |k| vec![(i64::MIN, timeline.element(k, i64::MIN).into())];
        let mut elements: Vec<Vec<(i64, StandingState)>> = (0..site.elements.len()).map(first).collect();
        let first = |k| vec![(i64::MIN, timeline.is_blocked(k, i64::MIN))];
        let mut blocked: Vec<Vec<(i64, bool)>> = (0..site.spaces.len()).map(first).collect();
        for change in timeline.changes() {
            for (k, _, after) in change.elements {
                elements[k as usize].push((change.at_s, after.into()));
            }
            for (k, _, after) in change.spaces {
                blocked[k as usize].push((change.at_s, after));
            }
        }
        Self { elements, blocked }
    }
}

/// The spans `[from, until)` in which two histories differ, ascending and apart from each other.
pub(super) fn differing_spans<S: Copy + PartialEq>(a: &[(i64, S)], b: &[(i64, S)]) -> Vec<[i64; 2]> {
    let mut instants_s: Vec<i64> = a.iter().chain(b).map(|step| step.0).collect();
    instants_s.sort_unstable();
    instants_s.dedup();
    let at = |steps: &[(i64, S)], at_s: i64| steps[steps.partition_point(|step| step.0 <= at_s).saturating_sub(1)].1;
    let mut spans: Vec<[i64; 2]> = Vec::new();
    let ends = instants_s.iter().skip(1).copied().chain([i64::MAX]);
    for (from_s, until_s) in instants_s.iter().copied().zip(ends) {
        if at(a, from_s) != at(b, from_s) {
            spans.push([from_s, until_s]);
        }
    }
    united(spans)
}

/// The same time as spans that do not meet, ascending.
pub(super) fn united(mut spans: Vec<[i64; 2]>) -> Vec<[i64; 2]> {
    spans.sort_unstable();
    let mut united: Vec<[i64; 2]> = Vec::new();
    for [from_s, until_s] in spans {
        match united.last_mut() {
            Some(last) if from_s <= last[1] => last[1] = last[1].max(until_s),
            _ => united.push([from_s, until_s]),
        }
    }
    united
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn histories_differ_between_their_changes() {
        let first = |state| (i64::MIN, state);
        let check = |a: &[(i64, u8)], b: &[(i64, u8)], expect: &[[i64; 2]]| {
            assert_eq!(differing_spans(a, b), expect, "{a:?} {b:?}");
            assert_eq!(differing_spans(b, a), expect, "{b:?} {a:?}");
        };
        check(&[first(0)], &[first(0)], &[]);
        check(&[first(0), (10, 1)], &[first(0), (15, 1)], &[[10, 15]]);
        check(&[first(0), (10, 1), (20, 2)], &[first(0), (15, 1), (20, 2)], &[[10, 15]]);
        check(&[first(0), (10, 1), (20, 2)], &[first(0), (20, 1), (30, 2)], &[[10, 30]]);
        check(&[first(0)], &[first(1), (5, 0), (9, 1)], &[[i64::MIN, 5], [9, i64::MAX]]);
    }

    #[test]
    fn spans_that_meet_are_one() {
        assert_eq!(united(vec![[5, 6], [1, 3], [3, 4], [2, 3]]), [[1, 4], [5, 6]]);
    }
}
