//! Deterministic pseudo-random numbers with the distributions that the simulation draws from.

/// A generator with a fixed seed: SplitMix64.
///
/// # Source
/// Steele, Lea and Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014.
#[derive(Debug, Clone)]
pub struct RandomGenerator {
    state: u64,
}

impl RandomGenerator {
    /// The generator of these numbers; other numbers give an independent one.
    pub fn of(seeds: &[u64]) -> Self {
        let mut generator = Self { state: 0 };
        for &seed in seeds {
            generator.state = generator.next() ^ seed;
        }
        generator.next();
        generator
    }

    /// A generator of its own for one part of a simulation: how much it draws changes nothing elsewhere.
    #[must_use]
    pub fn part(&self, name: &str) -> Self {
        name.bytes().fold(self.clone(), |generator, byte| Self::of(&[generator.state, u64::from(byte)]))
    }

    fn next(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.state ^ (self.state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    /// At least 0 and below 1.
    pub fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Evenly between two numbers.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// True with this probability.
    pub fn happens(&mut self, probability: f64) -> bool {
        self.unit() < probability
    }

    /// A number below `n`, which is at least 1.
    pub fn below(&mut self, n: usize) -> usize {
        ((self.unit() * n as f64) as usize).min(n - 1)
    }

    /// A number from `low` to `high`, both included.
    pub fn count(&mut self, low: usize, high: usize) -> usize {
        low + self.below(high - low + 1)
    }

    /// One of the items, of which there is at least one.
    pub fn one_of<T: Copy>(&mut self, items: &[T]) -> T {
        items[self.below(items.len())]
    }

    /// 1 or -1.
    pub fn sign(&mut self) -> f64 {
        if self.happens(0.5) { 1.0 } else { -1.0 }
    }

    /// Close to a normal distribution of mean 0 and deviation 1: the sum of four even numbers, never beyond 3.5.
    pub fn normal(&mut self) -> f64 {
        let bits = self.next();
        let sum: u64 = (0..4).map(|k| (bits >> (16 * k)) & 0xffff).sum();
        (sum as f64 / 65_536.0 - 2.0) * 1.732
    }

    /// Poisson distribution of this mean.
    pub fn poisson(&mut self, mean: f64) -> usize {
        if mean > 30.0 {
            return (mean + mean.sqrt() * self.normal()).round().max(0.0) as usize;
        }
        let limit = libm::exp(-mean);
        let (mut n, mut product) = (0, self.unit());
        while product > limit {
            n += 1;
            product *= self.unit();
        }
        n
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distributions_have_their_moments() {
        let mut random = RandomGenerator::of(&[7, 1]);
        let mut moments = |draw: &mut dyn FnMut(&mut RandomGenerator) -> f64| {
            let drawn: Vec<f64> = (0..20_000).map(|_| draw(&mut random)).collect();
            let mean = drawn.iter().sum::<f64>() / 20_000.0;
            (mean, drawn.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / 20_000.0)
        };
        for (mean, variance, draw) in [
            (0.5, 1.0 / 12.0, &mut (|r: &mut RandomGenerator| r.unit()) as &mut dyn FnMut(&mut RandomGenerator) -> f64),
            (0.0, 1.0, &mut |r: &mut RandomGenerator| r.normal()),
            (3.0, 3.0, &mut |r: &mut RandomGenerator| r.poisson(3.0) as f64),
            (50.0, 50.0, &mut |r: &mut RandomGenerator| r.poisson(50.0) as f64),
        ] {
            let (m, v) = moments(draw);
            assert!(
                (m - mean).abs() < 0.02 * (1.0 + mean) && (v - variance).abs() < 0.05 * variance,
                "{mean}: {m} {v}"
            );
        }
    }

    #[test]
    fn parts_are_independent_of_each_other() {
        let random = RandomGenerator::of(&[7]);
        let first = random.part("doors").unit();
        assert!(first == random.part("doors").unit() && first != random.part("people").unit());
        assert_ne!(RandomGenerator::of(&[1, 2]).unit().to_bits(), RandomGenerator::of(&[2, 1]).unit().to_bits());
    }
}
