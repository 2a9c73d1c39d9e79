//! Appending to a queue of bounded length.

use std::collections::VecDeque;

/// Appends an item; of `max` items the oldest gives way.
pub(crate) fn push_bounded<T>(queue: &mut VecDeque<T>, item: T, max: usize) {
    if queue.len() >= max {
        queue.pop_front();
    }
    queue.push_back(item);
}
