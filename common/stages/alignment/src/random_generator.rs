//! Deterministic pseudo-random numbers (SplitMix64).

/// A generator of numbers with a fixed seed: SplitMix64, Steele, Lea, Flood, OOPSLA 2014.
pub(crate) struct RandomGenerator(u64);

impl RandomGenerator {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// At least 0 and below 1.
    pub(crate) fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Minus the logarithm of such a number that is not 0.
    fn log(&mut self) -> f64 {
        -libm::log(1.0 - self.unit())
    }

    /// At most `n` different indices drawn by weight, ascending.
    ///
    /// # Source
    /// Efraimidis and Spirakis, "Weighted random sampling with a reservoir", Information Processing Letters 97, 2006.
    pub(crate) fn draw(&mut self, weights: impl Iterator<Item = f64>, n: usize) -> Vec<u32> {
        least(weights.zip(0..).map(|(weight, k)| (key(self.log(), weight), k)).collect(), n)
    }

    /// The same of as many indices as there are `bounds`, which no `weight` exceeds: the weight of few is asked for.
    pub(crate) fn draw_with_bounds(
        &mut self,
        bounds: impl Iterator<Item = f64>,
        weight: impl Fn(u32) -> f64,
        n: usize,
    ) -> Vec<u32> {
        // The least key that the bound allows, and what it is made of.
        let possible = bounds.zip(0..).map(|(bound, k)| {
            let log = self.log();
            (key(log, bound), log, k)
        });
        let mut possible: Vec<(f64, f64, u32)> = possible.collect();
        let mut n_looked_at = 2 * n;
        loop {
            let mut least_beyond = f64::INFINITY;
            if n_looked_at < possible.len() {
                let order = |a: &(f64, f64, u32), b: &(f64, f64, u32)| a.0.total_cmp(&b.0);
                least_beyond = possible.select_nth_unstable_by(n_looked_at, order).1.0;
            }
            let looked_at = &possible[..n_looked_at.min(possible.len())];
            let keys = looked_at.iter().map(|(_, log, k)| (key(*log, weight(*k)), *k));
            let keys: Vec<(f64, u32)> = keys.filter(|(key, _)| *key < least_beyond).collect();
            if keys.len() >= n || n_looked_at >= possible.len() {
                return least(keys, n);
            }
            n_looked_at *= 2;
        }
    }

    /// The same of `count` indices of one weight: there the least numbers have the least keys, and few numbers are that small.
    pub(crate) fn draw_evenly(&mut self, count: usize, n: usize) -> Vec<u32> {
        let begun = self.0;
        let wanted = n as f64;
        // A bound with fewer numbers below it than six standard deviations allow is hardly ever seen.
        let bound = (wanted + 6.0 * (wanted + 1.0).sqrt()) / count as f64;
        let small: Vec<(f64, u32)> = (0..count as u32).map(|k| (self.unit(), k)).filter(|(u, _)| *u < bound).collect();
        if small.len() >= n.min(count) {
            return least(small, n);
        }
        self.0 = begun;
        self.draw((0..count).map(|_| 1.0), n)
    }
}

/// By which an index is drawn, from a logarithm and its weight.
fn key(log: f64, weight: f64) -> f64 {
    log / weight.max(1e-9)
}

/// The indices of the `n` least keys, ascending.
fn least(mut keys: Vec<(f64, u32)>, n: usize) -> Vec<u32> {
    if keys.len() > n {
        keys.select_nth_unstable_by(n, |a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        keys.truncate(n);
    }
    let mut indices: Vec<u32> = keys.into_iter().map(|k| k.1).collect();
    indices.sort_unstable();
    indices
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn what_is_drawn_with_bounds_is_what_is_drawn_by_weight(
            seed: u64,
            weights in prop::collection::vec((0.0..1.0f64, prop_oneof![Just(1.0), Just(0.4), Just(0.01)]), 0..600),
            n in 1usize..60,
        ) {
            let (mut bounded, mut by_weight) = (RandomGenerator::new(seed), RandomGenerator::new(seed));
            let weight = |k: u32| weights[k as usize].0 * weights[k as usize].1;
            prop_assert_eq!(
                bounded.draw_with_bounds(weights.iter().map(|w| w.0), weight, n),
                by_weight.draw((0..weights.len() as u32).map(weight), n)
            );
            prop_assert_eq!(bounded.unit(), by_weight.unit());
        }

        #[test]
        fn what_is_drawn_evenly_is_what_is_drawn_by_equal_weights(seed: u64, count in 0usize..3000, n in 0usize..400) {
            let (mut evenly, mut by_weight) = (RandomGenerator::new(seed), RandomGenerator::new(seed));
            prop_assert_eq!(evenly.draw_evenly(count, n), by_weight.draw((0..count).map(|_| 1.0), n));
            prop_assert_eq!(evenly.unit(), by_weight.unit());
        }
    }
}
