//! Tasks that span what they depend on: level of effort, hammocks.

/// What the predecessors of a span demand of its ends: it begins with the first and ends with the last of them.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct SpanBounds {
    /// The earliest of what bounds its start.
    pub(crate) start_s: Option<i64>,
    /// The latest of what bounds its finish.
    pub(crate) finish_s: Option<i64>,
}

impl SpanBounds {
    /// Takes in a bound of its start, or of its finish.
    pub(crate) fn add(&mut self, is_start: bool, bound_s: i64) {
        match is_start {
            true => self.start_s = Some(self.start_s.map_or(bound_s, |s| s.min(bound_s))),
            false => self.finish_s = Some(self.finish_s.map_or(bound_s, |s| s.max(bound_s))),
        }
    }
}

/// Start and finish of a span once its predecessors have moved: each end follows what bounds it, later only, and keeps the lead that the
/// plan gives it.
pub(crate) fn span_dates(planned_s: [i64; 2], before: SpanBounds, after: SpanBounds) -> [i64; 2] {
    let end = |planned_s: i64, before: Option<i64>, after: Option<i64>| match (before, after) {
        (Some(before_s), Some(after_s)) => {
            planned_s.max(after_s.saturating_sub(before_s.saturating_sub(planned_s).max(0)))
        }
        _ => planned_s,
    };
    let start_s = end(planned_s[0], before.start_s, after.start_s);
    [start_s, end(planned_s[1], before.finish_s, after.finish_s).max(start_s)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_end_follows_its_own_bounds() {
        let bounds = |starts: &[i64], finishes: &[i64]| {
            let mut bounds = SpanBounds::default();
            starts.iter().for_each(|s| bounds.add(true, *s));
            finishes.iter().for_each(|s| bounds.add(false, *s));
            bounds
        };
        let before = bounds(&[10, 30], &[40, 60]);
        assert_eq!(span_dates([10, 60], before, bounds(&[10, 35], &[40, 75])), [10, 75], "the last one ends later");
        assert_eq!(span_dates([10, 60], before, bounds(&[20, 30], &[50, 60])), [20, 60], "the first one begins later");
        assert_eq!(span_dates([10, 70], before, bounds(&[10], &[65])), [10, 70], "its float is used up first");
        assert_eq!(span_dates([10, 60], bounds(&[], &[]), bounds(&[], &[])), [10, 60]);
        assert_eq!(span_dates([5, 60], before, bounds(&[15], &[60])), [10, 60], "it keeps its lead");
    }
}
