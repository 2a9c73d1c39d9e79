//! Probabilities that spaces are open, and the days on which they are most likely to be.

use super::probabilities::Probabilities;
use super::samples::Samples;
use crate::closures::{Closure, ClosureReason};
use crate::timeline::Period;
use frames::written_date::DAY_S;

/// Most days of a window.
const MAX_DAYS: u32 = 3_660;

/// A day of a space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SafeDay {
    /// Days since 1970-01-01.
    pub day: i64,
    /// Probability that the space is open on all of it: released, and nothing being worked on in it.
    pub open: f64,
}

impl Probabilities<'_> {
    /// Probability for each space that it is open at an instant, or throughout a period.
    pub fn spaces_open(&self, period: Period) -> Vec<f64> {
        let end_s = period.until_s.unwrap_or(period.from_s.saturating_add(1));
        let spaces = &self.timeline.closures;
        let n_open = self.samples.sums(spaces.len(), |run, n_open| {
            for (n_open, closures) in n_open.iter_mut().zip(spaces) {
                let is_blocked = closures.iter().any(|closure| {
                    let [start_s, finish_s] = dates_s(&self.samples, closure, run);
                    start_s < finish_s && start_s < end_s && period.from_s < finish_s
                });
                *n_open += u32::from(!is_blocked);
            }
        });
        n_open.into_iter().map(|n| self.samples.share(n)).collect()
    }

    /// The days of a window on which each space is most likely to be open, the safest first, of equals the earlier.
    ///
    /// The window has `n_days` days, at most ten years, from `first_day` on, in days since 1970-01-01; of each space at most
    /// `n` are given.
    pub fn safest_days(&self, first_day: i64, n_days: u32, n: usize) -> Vec<Vec<SafeDay>> {
        let n_days = n_days.min(MAX_DAYS) as usize;
        let spaces = &self.timeline.closures;
        let n_blocked = self.samples.sums(spaces.len() * n_days, |run, n_blocked| {
            let mut is_blocked = vec![false; n_days];
            for (n_blocked, closures) in n_blocked.chunks_exact_mut(n_days.max(1)).zip(spaces) {
                is_blocked.fill(false);
                for closure in closures {
                    is_blocked[days_of(dates_s(&self.samples, closure, run), first_day, n_days)].fill(true);
                }
                n_blocked.iter_mut().zip(&is_blocked).for_each(|(n, is_blocked)| *n += u32::from(*is_blocked));
            }
        });
        let of_space = |n_blocked: &[u32]| {
            let mut days: Vec<(u32, i64)> = n_blocked.iter().copied().zip(first_day..).collect();
            days.sort_unstable();
            days.truncate(n);
            let safe_day =
                |(n_blocked, day)| SafeDay { day, open: self.samples.share(self.uncertainty.runs - n_blocked) };
            days.into_iter().map(safe_day).collect()
        };
        if n_days == 0 {
            return vec![Vec::new(); spaces.len()];
        }
        n_blocked.chunks_exact(n_days).map(of_space).collect()
    }
}

/// Start and finish of a closure in a run.
fn dates_s(samples: &Samples, closure: &Closure, run: u32) -> [i64; 2] {
    match closure.why {
        ClosureReason::Task(task) => samples.dates_s(run, task),
        _ => [closure.start_s, closure.finish_s],
    }
}

/// The days of a window that a closure reaches into.
fn days_of([start_s, finish_s]: [i64; 2], first_day: i64, n_days: usize) -> std::ops::Range<usize> {
    if finish_s <= start_s {
        return 0..0;
    }
    let within = |day: i64| (day.saturating_sub(first_day)).clamp(0, n_days as i64) as usize;
    within(start_s.div_euclid(DAY_S))..within((finish_s - 1).div_euclid(DAY_S) + 1)
}
