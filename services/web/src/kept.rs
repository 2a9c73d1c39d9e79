//! The newest of what was made, up to a size.

use std::collections::VecDeque;

/// The newest of what was made, up to a size.
pub(crate) struct Kept<K, V> {
    max_size: usize,
    size: usize,
    entries: VecDeque<(K, V, usize)>,
}

impl<K: PartialEq, V: Clone> Kept<K, V> {
    /// Nothing yet, and never more than this size.
    pub(crate) fn of(max_size: usize) -> Self {
        Self { max_size, size: 0, entries: VecDeque::new() }
    }

    /// What was kept under a key.
    pub(crate) fn get(&self, key: &K) -> Option<V> {
        self.entries.iter().find(|(k, ..)| k == key).map(|(_, value, _)| value.clone())
    }

    /// Keeps a value and gives up the oldest ones; one that is larger than all may be is not kept.
    pub(crate) fn insert(&mut self, key: K, value: V, size: usize) {
        if size > self.max_size || self.get(&key).is_some() {
            return;
        }
        self.entries.push_back((key, value, size));
        self.size += size;
        while self.size > self.max_size {
            self.size -= self.entries.pop_front().map_or(0, |(_, _, size)| size);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_newest_are_kept_up_to_a_size() {
        let mut kept = Kept::of(10);
        for (key, size) in [("a", 4), ("b", 4), ("c", 4), ("d", 11)] {
            kept.insert(key, size, size);
        }
        assert_eq!(["a", "b", "c", "d"].map(|key| kept.get(&key)), [None, Some(4), Some(4), None]);
    }
}
