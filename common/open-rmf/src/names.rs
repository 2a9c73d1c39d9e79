//! Names that no two share: Open-RMF knows levels, doors, lifts and waypoints by their names alone.

use std::collections::{BTreeMap, BTreeSet};

/// Names for things with a label and a GlobalId each, in their order: the label, with the GlobalId where others have the same, so
/// that a name is the same at every date; the GlobalId where there is none.
pub(crate) fn unique<'a>(things: impl Iterator<Item = (String, &'a str)>) -> Vec<String> {
    let things: Vec<(String, &str)> = things.map(|(label, id)| (printable(&label), id)).collect();
    let mut count: BTreeMap<&str, usize> = BTreeMap::new();
    for (label, _) in &things {
        *count.entry(label).or_default() += 1;
    }
    let mut names = UsedNames::default();
    let name = |(label, id): &(String, &str)| match label.as_str() {
        "" => (*id).to_owned(),
        label if count[label] > 1 => format!("{label} {id}"),
        label => label.to_owned(),
    };
    things.iter().map(|thing| names.take(name(thing))).collect()
}

/// Names that are taken.
#[derive(Debug, Default)]
pub(crate) struct UsedNames(BTreeSet<String>);

impl UsedNames {
    /// The name, with a number behind it if it is taken: broken models have GlobalIds twice.
    pub(crate) fn take(&mut self, name: String) -> String {
        let numbered = (2..).map(|k: usize| format!("{name} {k}"));
        let free = std::iter::once(name.clone()).chain(numbered).find(|name| !self.0.contains(name));
        let free = free.expect("there are more numbers than names");
        self.0.insert(free.clone());
        free
    }
}

/// Without characters that YAML refuses.
fn printable(text: &str) -> String {
    let is_bad =
        |c: char| c.is_control() || matches!(c, '\u{2028}' | '\u{2029}' | '\u{feff}' | '\u{fffe}' | '\u{ffff}');
    text.replace(is_bad, " ").trim().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_labels_are_told_apart_by_their_global_ids() {
        let of = |things: &[(&'static str, &'static str)]| unique(things.iter().map(|(l, id)| ((*l).to_owned(), *id)));
        assert_eq!(of(&[("Office", "a"), ("Store", "b"), ("Office", "c")]), ["Office a", "Store", "Office c"]);
        assert_eq!(of(&[("", "a"), (" ", "b"), ("x\u{7}\n", "c")]), ["a", "b", "x"]);
        assert_eq!(of(&[("A", "1"), ("A", "1"), ("A 1", "2")]), ["A 1", "A 1 2", "A 1 3"], "a GlobalId twice");
    }
}
