//! Counts with their noun in the right number, for messages.

/// A count and its noun: `1 door`, `2 doors`, `0 entities`. The noun is given as of one; its last word is the noun itself.
#[must_use]
pub fn counted(n: usize, noun: &str) -> String {
    if n == 1 {
        return format!("1 {noun}");
    }
    let vowel_before_y = ["ay", "ey", "oy", "uy"].iter().any(|end| noun.ends_with(end));
    match noun.strip_suffix('y') {
        Some(stem) if !vowel_before_y => format!("{n} {stem}ies"),
        _ if ["s", "x", "ch", "sh"].iter().any(|end| noun.ends_with(end)) => format!("{n} {noun}es"),
        _ => format!("{n} {noun}s"),
    }
}

#[cfg(test)]
mod tests {
    use super::counted;

    #[test]
    fn one_is_singular_and_every_other_count_is_plural() {
        for (n, noun, expected) in [
            (1, "door", "1 door"),
            (0, "door", "0 doors"),
            (2, "map storey", "2 map storeys"),
            (3, "body", "3 bodies"),
            (2, "box", "2 boxes"),
            (2, "match", "2 matches"),
        ] {
            assert_eq!(counted(n, noun), expected);
        }
    }
}
