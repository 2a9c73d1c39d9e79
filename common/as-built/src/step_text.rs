//! Values as STEP writes them: texts with escapes for everything beyond ASCII, numbers, dates, lists.

use frames::PlanTime;
use std::fmt::Write;

/// A text in quotes. Characters beyond ASCII are `\X2\`, those beyond the basic plane `\X4\`.
pub(crate) fn text(value: &str) -> String {
    let mut out = String::with_capacity(value.len() + 2);
    out.push('\'');
    let mut open = None;
    for character in value.chars() {
        let escape = match character {
            ' '..='~' => None,
            '\0'..='\u{ffff}' => Some("\\X2\\"),
            _ => Some("\\X4\\"),
        };
        if open != escape {
            out.push_str(if open.is_some() { "\\X0\\" } else { "" });
            out.push_str(escape.unwrap_or_default());
            open = escape;
        }
        // Writing to a string does not fail.
        let _ = match (escape, character) {
            (Some("\\X4\\"), _) => write!(out, "{:08X}", u32::from(character)),
            (Some(_), _) => write!(out, "{:04X}", u32::from(character)),
            (None, '\'') => write!(out, "''"),
            (None, '\\') => write!(out, "\\\\"),
            (None, _) => write!(out, "{character}"),
        };
    }
    out.push_str(if open.is_some() { "\\X0\\'" } else { "'" });
    out
}

/// What a file has in one of its encodings, UTF-8 or ISO 8859-1, with escapes for everything beyond ASCII.
pub(crate) fn ascii(written: &[u8]) -> String {
    let text =
        std::str::from_utf8(written).map_or_else(|_| written.iter().copied().map(char::from).collect(), str::to_owned);
    let mut out = String::with_capacity(text.len());
    for character in text.chars() {
        // Writing to a string does not fail.
        let _ = match character {
            '\0'..='\u{7f}' => write!(out, "{character}"),
            '\u{80}'..='\u{ffff}' => write!(out, "\\X2\\{:04X}\\X0\\", u32::from(character)),
            _ => write!(out, "\\X4\\{:08X}\\X0\\", u32::from(character)),
        };
    }
    out
}

/// A real number, with the point that STEP asks for.
pub(crate) fn real(value: f64) -> String {
    // Rust has no shorter text that reads back as the same number; minus zero is zero.
    let text = format!("{:?}", value + 0.0);
    match text.split_once('e') {
        Some((digits, exponent)) if digits.contains('.') => format!("{digits}E{exponent}"),
        Some((digits, exponent)) => format!("{digits}.E{exponent}"),
        None => text.strip_suffix('0').filter(|short| short.ends_with('.')).map_or(text.clone(), str::to_owned),
    }
}

/// A reference.
pub(crate) fn reference(id: u64) -> String {
    format!("#{id}")
}

/// A list of references.
pub(crate) fn list(ids: &[u64]) -> String {
    let ids: Vec<String> = ids.iter().map(|id| reference(*id)).collect();
    format!("({})", ids.join(","))
}

/// A date and time as ISO 8601 text.
pub(crate) fn date_text(at: PlanTime) -> String {
    format!("'{at}'")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_beyond_ascii_are_escaped() {
        assert_eq!(text("it's"), "'it''s'");
        assert_eq!(text(r"a\b"), r"'a\\b'");
        assert_eq!(text("Tür \u{1f6aa}é"), r"'T\X2\00FC\X0\r \X4\0001F6AA\X0\\X2\00E9\X0\'");
        assert_eq!(text("a\nb"), r"'a\X2\000A\X0\b'");
    }

    #[test]
    fn numbers_have_a_point() {
        assert_eq!([real(1.0), real(-0.0), real(0.25), real(1e-9), real(1e21)], ["1.", "0.", "0.25", "1.E-9", "1.E21"]);
    }
}
