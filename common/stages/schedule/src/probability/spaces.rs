//! Probabilities that spaces are open, and the days on which they are most likely to be.

use super::{Probabilities, Samples};
use crate::closures::{Closure, ClosureReason};
use crate::timeline::Period;
use frames::written_date::DAY_S;
use rayon::prelude::*;

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
        let runs = self.uncertainty.runs;
        let of_space = |closures: &Vec<Closure>| {
            let is_open = |run: &u32| {
                !closures.iter().any(|closure| {
                    let [start_s, finish_s] = dates_s(&self.samples, closure, *run);
                    start_s < finish_s && start_s < end_s && period.from_s < finish_s
                })
            };
            (0..runs).filter(is_open).count() as f64 / f64::from(runs)
        };
        self.timeline.closures.par_iter().map(of_space).collect()
    }

    /// The days of a window on which each space is most likely to be open, the safest first, of equals the earlier.
    ///
    /// The window has `n_days` days, at most ten years, from `first_day` on, in days since 1970-01-01; of each space at most
    /// `n` are given.
    pub fn safest_days(&self, first_day: i64, n_days: u32, n: usize) -> Vec<Vec<SafeDay>> {
        let n_days = n_days.min(MAX_DAYS) as usize;
        let runs = self.uncertainty.runs;
        let of_space = |closures: &Vec<Closure>| {
            let mut n_blocked = vec![0u32; n_days];
            let mut last_blocked = vec![u32::MAX; n_days];
            for run in 0..runs {
                for closure in closures {
                    for day in days_of(dates_s(&self.samples, closure, run), first_day, n_days) {
                        if last_blocked[day] != run {
                            last_blocked[day] = run;
                            n_blocked[day] += 1;
                        }
                    }
                }
            }
            let mut days: Vec<(u32, usize)> = n_blocked.into_iter().zip(0..).collect();
            days.sort_unstable();
            let safe_day = |(n_blocked, day): (u32, usize)| SafeDay {
                day: first_day + day as i64,
                open: f64::from(runs - n_blocked) / f64::from(runs),
            };
            days.into_iter().take(n).map(safe_day).collect()
        };
        self.timeline.closures.par_iter().map(of_space).collect()
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
