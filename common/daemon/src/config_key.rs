//! Positions of keys in `site.toml`, for messages.

use toml::de::{DeTable, DeValue};

/// Line of a key in the text of a TOML file, from 1; `key` has the name of its table, as in `robot.profile`. `None` for a
/// key that is left out.
pub fn line_of_key(text: &str, key: &str) -> Option<usize> {
    let document = DeTable::parse(text).ok()?;
    let mut table = document.get_ref();
    let mut parts = key.split('.').peekable();
    loop {
        let part = parts.next()?;
        let (name, value) = table.iter().find(|(name, _)| name.get_ref() == part)?;
        if parts.peek().is_none() {
            return Some(1 + text.get(..name.span().start)?.matches('\n').count());
        }
        let DeValue::Table(inner) = value.get_ref() else { return None };
        table = inner;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_found_in_their_tables() {
        let text =
            "state = \"x\"\nalign.map = \"m\"\n\n[robot]\n# of the robot\nprofile = \"a\"\n[bus]\nroot = \"r\"\n";
        for (key, line) in [
            ("state", Some(1)),
            ("align.map", Some(2)),
            ("robot.profile", Some(6)),
            ("bus.root", Some(8)),
            ("robot.resolution_m", None),
            ("profile", None),
            ("state.profile", None),
        ] {
            assert_eq!(line_of_key(text, key), line, "{key}");
        }
        assert_eq!(line_of_key("state = ", "state"), None);
    }
}
