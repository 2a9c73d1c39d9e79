//! Finds things of one file among those of earlier files, by GlobalId.

use std::collections::HashMap;

/// Where each of `new` comes to lie: at its namesake in `old`, else behind the last.
pub(crate) fn placed<T>(old: &[T], new: &[T], global_id: impl Fn(&T) -> &String) -> Vec<usize> {
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
