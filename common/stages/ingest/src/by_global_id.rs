//! Matches records of a file with those of earlier files by GlobalId.

use std::collections::HashMap;

/// Index of each of `new` in the merged list: that of the record with its GlobalId in `old`, else after the last.
pub(crate) fn merged_indices<T>(old: &[T], new: &[T], global_id: impl Fn(&T) -> &String) -> Vec<usize> {
    let known: HashMap<&String, usize> = old.iter().enumerate().map(|(k, t)| (global_id(t), k)).collect();
    let mut next = old.len();
    new.iter()
        .map(|t| {
            known.get(global_id(t)).copied().unwrap_or_else(|| {
                next += 1;
                next - 1
            })
        })
        .collect()
}
