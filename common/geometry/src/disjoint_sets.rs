//! Disjoint sets of things that are joined one by one.

/// Sets of the numbers below a bound; the least of a set stands for it.
#[derive(Debug)]
pub struct DisjointSets(Vec<u32>);

impl DisjointSets {
    /// Each number by itself.
    pub fn new(n: usize) -> Self {
        Self((0..n as u32).collect())
    }

    /// The least number of the set.
    pub fn first(&mut self, mut of: u32) -> u32 {
        while self.0[of as usize] != of {
            let next = self.0[of as usize];
            self.0[of as usize] = self.0[next as usize];
            of = next;
        }
        of
    }

    /// Makes two sets one.
    pub fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.first(a), self.first(b));
        self.0[a.max(b) as usize] = a.min(b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_joined_over_others_is_one_set_with_its_least_number() {
        let mut sets = DisjointSets::new(6);
        for (a, b) in [(5, 3), (1, 4), (3, 4)] {
            sets.join(a, b);
        }
        assert_eq!([0, 1, 2, 3, 4, 5].map(|k| sets.first(k)), [0, 1, 2, 1, 1, 1]);
    }
}
