//! Suggestions of similar names for error messages.

use std::cmp::Reverse;

/// Names in a message.
const MAX_NAMES: usize = 3;
/// Names are compared up to this number of characters.
const MAX_CHARACTERS: usize = 200;
/// Least similarity of a name that is shown, from 0 to 1.
const MIN_SIMILARITY: f64 = 0.6;
/// Shorter texts are compared with whole names only.
const MIN_PART_CHARACTERS: usize = 4;
/// Weight of similarity to a part of a name: whole names rank before.
const PART_SHARE: f64 = 0.9;

/// The names that come nearest to `wanted`, the nearest first; none if all are quite different.
///
/// Case is ignored. A name is near, too, if it contains the wanted text or similar words.
///
/// # Source
/// Damerau, "A technique for computer detection and correction of spelling errors", CACM 7, 1964; as a share of the longer name.
pub fn nearest_names<'n>(wanted: &str, names: impl IntoIterator<Item = &'n str>) -> Vec<&'n str> {
    let folded = |text: &str| text.trim().chars().take(MAX_CHARACTERS).collect::<String>().to_lowercase();
    let wanted = folded(wanted);
    let mut near: Vec<(Reverse<u32>, &str)> = names
        .into_iter()
        .filter(|name| !name.trim().is_empty())
        .filter_map(|name| Some((Reverse(similarity(&wanted, &folded(name))?), name)))
        .collect();
    near.sort_unstable();
    near.dedup();
    near.into_iter().take(MAX_NAMES).map(|(_, name)| name).collect()
}

/// The nearest names as the end of an error message, e.g. `; nearest: "Lab 3", "Lab 2"`; empty if there is none.
pub fn nearest_names_hint<'n>(wanted: &str, names: impl IntoIterator<Item = &'n str>) -> String {
    hint(&nearest_names(wanted, names))
}

/// Names as the end of an error message; empty if there is none.
pub(crate) fn hint(nearest: &[impl AsRef<str>]) -> String {
    let quoted: Vec<String> = nearest.iter().map(|name| format!("{:?}", name.as_ref())).collect();
    if quoted.is_empty() { String::new() } else { format!("; nearest: {}", quoted.join(", ")) }
}

/// Similarity in thousandths; `None` if it is too small.
fn similarity(wanted: &str, name: &str) -> Option<u32> {
    let whole = strsim::normalized_damerau_levenshtein(wanted, name);
    let length = wanted.chars().count();
    let part = if length < MIN_PART_CHARACTERS { 0.0 } else { best_part(wanted, length, name) };
    let alike = whole.max(part * PART_SHARE);
    (alike >= MIN_SIMILARITY).then_some((alike * 1e3) as u32)
}

/// Similarity of what is wanted to the most similar part of a name that begins with a word and is as long, or longer by a
/// letter that was left out.
fn best_part(wanted: &str, length: usize, name: &str) -> f64 {
    let is_start = |at: usize| name[..at].chars().next_back().is_none_or(|c| !c.is_alphanumeric());
    let starts = name.char_indices().map(|(at, _)| at).filter(|at| is_start(*at));
    let parts = starts.flat_map(|at| [length, length + 1].map(|n| name[at..].chars().take(n).collect::<String>()));
    parts.map(|part| strsim::normalized_damerau_levenshtein(wanted, &part)).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROOMS: [&str; 5] = ["Lab 1", "Lab 2", "Corridor", "Open-plan office", ""];

    #[test]
    fn the_nearest_name_comes_first_and_strangers_do_not_come() {
        assert_eq!(nearest_names("coridor", ROOMS), ["Corridor"]);
        assert_eq!(nearest_names("Lab 3", ROOMS), ["Lab 1", "Lab 2"]);
        assert_eq!(nearest_names("office", ROOMS), ["Open-plan office"]);
        assert_eq!(nearest_names("ofice", ROOMS), ["Open-plan office"]);
        assert_eq!(nearest_names("Partiton walls", ["Partition walls, upper floor", "Walls"]).len(), 1);
        assert_eq!(nearest_names("Kitchen", ROOMS), [""; 0]);
        assert_eq!(nearest_names("", ROOMS), [""; 0]);
        // Letters that changed places, as fingers do it with GlobalIds.
        assert_eq!(nearest_names("1xS3BCk291UvhgP2dvNsgp", ["1xS3BCk219UvhgP2dvNsgp"]).len(), 1);
    }

    #[test]
    fn a_hint_ends_a_message_or_is_empty() {
        assert_eq!(nearest_names_hint("coridor", ROOMS), "; nearest: \"Corridor\"");
        assert_eq!(nearest_names_hint("Kitchen", ROOMS), "");
    }
}
