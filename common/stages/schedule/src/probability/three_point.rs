//! Durations drawn from three-point estimates: triangular distributions and a stream of random numbers for each task.

/// Shortest, most likely and longest duration in seconds, ascending.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ThreePoint {
    pub(crate) optimistic_s: f64,
    pub(crate) likely_s: f64,
    pub(crate) pessimistic_s: f64,
}

impl ThreePoint {
    /// The duration that is not exceeded with probability `p` from 0 to 1: the inverse of the triangular distribution.
    ///
    /// # Source
    /// Kotz and van Dorp, "Beyond Beta", 2004, chapter 1: the triangular distribution in place of the beta of PERT.
    pub(crate) fn quantile_s(self, p: f64) -> f64 {
        let Self { optimistic_s, likely_s, pessimistic_s } = self;
        let span_s = pessimistic_s - optimistic_s;
        if span_s <= 0.0 {
            return likely_s;
        }
        // Square roots are exact to the last bit on every machine.
        if p * span_s < likely_s - optimistic_s {
            optimistic_s + (p * span_s * (likely_s - optimistic_s)).sqrt()
        } else {
            pessimistic_s - ((1.0 - p) * span_s * (pessimistic_s - likely_s)).sqrt()
        }
    }
}

/// The random numbers of one task: that of a run depends on seed, task and run alone, in whatever order they are drawn.
///
/// # Source
/// SplitMix64: Steele, Lea and Flood, "Fast Splittable Pseudorandom Number Generators", OOPSLA 2014.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TaskStream {
    state: u64,
}

/// The odd number nearest to 2^64 divided by the golden ratio: the step of SplitMix64.
const STEP: u64 = 0x9E37_79B9_7F4A_7C15;

impl TaskStream {
    pub(crate) fn new(seed: u32, task: usize) -> Self {
        // Tasks take the numbers of the seed's own stream as seeds of theirs.
        Self { state: nth(u64::from(seed), task as u64) }
    }

    /// The number of a run, from 0 to less than 1, in steps of 2^-53.
    pub(crate) fn of_run(self, run: u32) -> f64 {
        (nth(self.state, u64::from(run)) >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }
}

/// The nth number of the stream of a seed.
fn nth(seed: u64, n: u64) -> u64 {
    let mut z = seed.wrapping_add(n.wrapping_add(1).wrapping_mul(STEP));
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_stream_of_a_seed_is_that_of_the_published_generator() {
        // The first numbers of SplitMix64 from the seed 1234567, as its reference implementation prints them.
        let expected = [
            6_457_827_717_110_365_317,
            3_203_168_211_198_807_973,
            9_817_491_932_198_370_423,
            4_593_380_528_125_082_431,
            16_408_922_859_458_223_821,
        ];
        assert_eq!([0, 1, 2, 3, 4].map(|n| nth(1_234_567, n)), expected);
    }

    #[test]
    fn quantiles_of_a_triangle_are_those_of_its_areas() {
        let triangle = ThreePoint { optimistic_s: 10.0, likely_s: 20.0, pessimistic_s: 50.0 };
        // Left of the likely one lies (20 - 10) / (50 - 10) of the area.
        let found = [0.0, 0.25 * 0.25, 0.25, 1.0 - 0.75 * 0.25, 1.0].map(|p| triangle.quantile_s(p));
        assert_eq!(found, [10.0, 15.0, 20.0, 35.0, 50.0]);
        let certain = ThreePoint { optimistic_s: 7.0, likely_s: 7.0, pessimistic_s: 7.0 };
        assert_eq!(certain.quantile_s(0.3), 7.0);
    }

    #[test]
    fn drawn_numbers_are_spread_evenly_and_tasks_differ() {
        let (a, b) = (TaskStream::new(1, 0), TaskStream::new(1, 1));
        let n = 20_000;
        let share = |is_in: &dyn Fn(u32) -> bool| (0..n).filter(|run| is_in(*run)).count() as f64 / f64::from(n);
        // Four standard deviations of a share of 20 000 draws are at most 0.0142.
        assert!((share(&|run| a.of_run(run) < 0.25) - 0.25).abs() < 0.0142);
        assert!((share(&|run| a.of_run(run) < 0.5 && b.of_run(run) < 0.5) - 0.25).abs() < 0.0142);
        assert!((0..n).all(|run| (0.0..1.0).contains(&a.of_run(run))));
    }
}
