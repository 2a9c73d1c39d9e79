//! The latest versions of a grid: where a copy of one of them differs from the newest.

use grid::CellRect;
use messages::ContentHash;
use std::collections::VecDeque;

/// As many as the memory of a topic may hold, and some more.
const KEPT: usize = 16;

/// The latest versions of a grid, oldest first.
#[derive(Debug, Default)]
pub(crate) struct VersionHistory {
    versions: VecDeque<Version>,
}

#[derive(Debug)]
struct Version {
    content_hash: ContentHash,
    /// Cells that may differ from the version before.
    changed: Vec<CellRect>,
}

impl VersionHistory {
    /// Adds a version in which nothing but these cells differs from the one before; the oldest gives its memory to it.
    pub(crate) fn push(&mut self, content_hash: ContentHash, changed: &[CellRect]) {
        let oldest = if self.versions.len() == KEPT { self.versions.pop_front() } else { None };
        let mut buffer = oldest.map(|version| version.changed).unwrap_or_default();
        buffer.clear();
        buffer.extend_from_slice(changed);
        self.versions.push_back(Version { content_hash, changed: buffer });
    }

    /// Cells in which the newest version may differ from the latest one of this content; `None` if that is not known any more.
    pub(crate) fn changed_since(&self, content_hash: ContentHash) -> Option<impl Iterator<Item = &CellRect>> {
        let at = self.versions.iter().rposition(|version| version.content_hash == content_hash)?;
        Some(self.versions.range(at + 1..).flat_map(|version| &version.changed))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_changed_since_a_version_is_known_while_that_is_kept() {
        let rect = |k: u32| CellRect { min: [k, 0], max: [k + 1, 1] };
        let hash = |k: u32| ContentHash::from_bits(u64::from(k));
        let mut history = VersionHistory::default();
        (0..4).for_each(|k| history.push(hash(k % 3), &[rect(k)]));
        let since = |history: &VersionHistory, k| history.changed_since(hash(k)).map(|rects| rects.copied().collect());
        assert_eq!(since(&history, 1), Some(vec![rect(2), rect(3)]));
        assert_eq!(since(&history, 0), Some(vec![]), "the latest of two with one content");
        assert_eq!(since(&history, 9), None);
        (4..2 + KEPT as u32).for_each(|k| history.push(hash(k), &[rect(k)]));
        assert_eq!(since(&history, 1), None);
        assert_eq!(since(&history, 2).unwrap().len(), KEPT - 1);
    }
}
