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

    /// At most `n` different indices drawn by weight, ascending.
    ///
    /// # Source
    /// Efraimidis and Spirakis, "Weighted random sampling with a reservoir", Information Processing Letters 97, 2006.
    pub(crate) fn draw(&mut self, weights: impl Iterator<Item = f64>, n: usize) -> Vec<u32> {
        let mut keys: Vec<(f64, u32)> =
            weights.zip(0..).map(|(w, k)| (-libm::log(1.0 - self.unit()) / w.max(1e-9), k)).collect();
        if keys.len() > n {
            keys.select_nth_unstable_by(n, |a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            keys.truncate(n);
        }
        let mut indices: Vec<u32> = keys.into_iter().map(|k| k.1).collect();
        indices.sort_unstable();
        indices
    }
}
