//! Deterministic pseudo-random numbers (SplitMix64).

/// SplitMix64 generator with a fixed seed.
///
/// # Source
/// Steele, Lea, Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014.
#[derive(Debug, Clone)]
pub(crate) struct RandomGenerator(u64);

impl Default for RandomGenerator {
    fn default() -> Self {
        Self(0x9E37_79B9_7F4A_7C15)
    }
}

impl RandomGenerator {
    /// A pseudo-random number below `n`; 0 if `n` is 0.
    pub(crate) fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) % n.max(1) as u64) as usize
    }
}
