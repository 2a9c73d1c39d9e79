//! Dates of all tasks in every run of the simulation.

use super::network::{NEVER_S, Network};
use rayon::prelude::*;

/// Seconds by which drawn dates may lie before the first planned one: 34 years. They may lie 102 years behind it.
const BEFORE_S: i64 = 1 << 30;

/// Runs that are counted together at least, so that adding up counters costs little.
const MIN_RUNS: usize = 64;

/// Start and finish of every task in every run, as seconds from a common instant: half the memory of whole dates.
pub(crate) struct Samples {
    runs: u32,
    n_tasks: usize,
    base_s: i64,
    /// Run by run.
    dates: Vec<[u32; 2]>,
}

impl Samples {
    /// Runs the network so many times, on all threads. What a run draws depends on no other, so their number changes nothing.
    pub(crate) fn draw(network: &Network<'_>, n_tasks: usize, runs: u32) -> Self {
        let base_s = network.begins_s().unwrap_or(0) - BEFORE_S;
        let mut dates = vec![[0; 2]; n_tasks * runs as usize];
        if n_tasks > 0 {
            dates.par_chunks_mut(n_tasks).enumerate().for_each_init(Vec::new, |dates_s, (run, row)| {
                network.run(run as u32, dates_s);
                let short = |s: i64| (s - base_s).clamp(0, i64::from(u32::MAX)) as u32;
                row.iter_mut().zip(dates_s).for_each(|(row, dates_s)| *row = dates_s.map(short));
            });
        }
        Self { runs, n_tasks, base_s, dates }
    }

    /// Start and finish of a task in a run, civil seconds since 1970.
    pub(crate) fn dates_s(&self, run: u32, task: u32) -> [i64; 2] {
        let dates = self.dates[run as usize * self.n_tasks + task as usize];
        dates.map(|offset| if offset == u32::MAX { NEVER_S } else { self.base_s + i64::from(offset) })
    }

    /// So many counters, summed over all runs, run by run, because the dates of a run lie together.
    pub(super) fn sums(&self, n_counters: usize, count: impl Fn(u32, &mut [u32]) + Sync) -> Vec<u32> {
        let of_run = |mut sums: Vec<u32>, run: u32| {
            count(run, &mut sums);
            sums
        };
        let both = |mut sums: Vec<u32>, others: Vec<u32>| {
            sums.iter_mut().zip(others).for_each(|(sum, other)| *sum += other);
            sums
        };
        let none = || vec![0; n_counters];
        (0..self.runs).into_par_iter().with_min_len(MIN_RUNS).fold(none, of_run).reduce(none, both)
    }

    /// The share of the runs.
    pub(super) fn share(&self, n_runs: u32) -> f64 {
        f64::from(n_runs) / f64::from(self.runs)
    }
}
