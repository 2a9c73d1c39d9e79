//! Regular expressions of XML Schema, which match a whole text, on an engine that takes time in proportion to the text.
//!
//! # Source
//! XML Schema Part 2: Datatypes, second edition, appendix F.

use std::iter::Peekable;
use std::str::Chars;

use regex::{Regex, RegexBuilder};

/// Bytes that a compiled expression may take.
const COMPILED_BYTES_MAX: usize = 4 << 20;
/// Deepest nesting of subtracted classes.
const CLASS_DEPTH_MAX: usize = 8;

/// Characters that begin a name of XML, as a class.
const NAME_START: &str = concat!(
    r":A-Z_a-z\x{C0}-\x{D6}\x{D8}-\x{F6}\x{F8}-\x{2FF}\x{370}-\x{37D}\x{37F}-\x{1FFF}\x{200C}-\x{200D}\x{2070}-\x{218F}",
    r"\x{2C00}-\x{2FEF}\x{3001}-\x{D7FF}\x{F900}-\x{FDCF}\x{FDF0}-\x{FFFD}\x{10000}-\x{EFFFF}"
);
/// What else may be in one.
const NAME_REST: &str = r"\-.0-9\x{B7}\x{300}-\x{36F}\x{203F}-\x{2040}";

/// Blocks of Unicode by the names that XML Schema has for them, without `Is`.
const BLOCKS: [(&str, u32, u32); 44] = [
    ("BasicLatin", 0x0000, 0x007F),
    ("Latin-1Supplement", 0x0080, 0x00FF),
    ("LatinExtended-A", 0x0100, 0x017F),
    ("LatinExtended-B", 0x0180, 0x024F),
    ("IPAExtensions", 0x0250, 0x02AF),
    ("SpacingModifierLetters", 0x02B0, 0x02FF),
    ("CombiningDiacriticalMarks", 0x0300, 0x036F),
    ("Greek", 0x0370, 0x03FF),
    ("GreekandCoptic", 0x0370, 0x03FF),
    ("Cyrillic", 0x0400, 0x04FF),
    ("Armenian", 0x0530, 0x058F),
    ("Hebrew", 0x0590, 0x05FF),
    ("Arabic", 0x0600, 0x06FF),
    ("Devanagari", 0x0900, 0x097F),
    ("Bengali", 0x0980, 0x09FF),
    ("Thai", 0x0E00, 0x0E7F),
    ("Georgian", 0x10A0, 0x10FF),
    ("HangulJamo", 0x1100, 0x11FF),
    ("LatinExtendedAdditional", 0x1E00, 0x1EFF),
    ("GreekExtended", 0x1F00, 0x1FFF),
    ("GeneralPunctuation", 0x2000, 0x206F),
    ("SuperscriptsandSubscripts", 0x2070, 0x209F),
    ("CurrencySymbols", 0x20A0, 0x20CF),
    ("LetterlikeSymbols", 0x2100, 0x214F),
    ("NumberForms", 0x2150, 0x218F),
    ("Arrows", 0x2190, 0x21FF),
    ("MathematicalOperators", 0x2200, 0x22FF),
    ("MiscellaneousTechnical", 0x2300, 0x23FF),
    ("EnclosedAlphanumerics", 0x2460, 0x24FF),
    ("BoxDrawing", 0x2500, 0x257F),
    ("BlockElements", 0x2580, 0x259F),
    ("GeometricShapes", 0x25A0, 0x25FF),
    ("MiscellaneousSymbols", 0x2600, 0x26FF),
    ("Dingbats", 0x2700, 0x27BF),
    ("CJKSymbolsandPunctuation", 0x3000, 0x303F),
    ("Hiragana", 0x3040, 0x309F),
    ("Katakana", 0x30A0, 0x30FF),
    ("Bopomofo", 0x3100, 0x312F),
    ("CJKUnifiedIdeographsExtensionA", 0x3400, 0x4DBF),
    ("CJKUnifiedIdeographs", 0x4E00, 0x9FFF),
    ("HangulSyllables", 0xAC00, 0xD7A3),
    ("PrivateUse", 0xE000, 0xF8FF),
    ("CJKCompatibilityIdeographs", 0xF900, 0xFAFF),
    ("HalfwidthandFullwidthForms", 0xFF00, 0xFFEF),
];

/// A compiled expression.
#[derive(Debug, Clone)]
pub struct Pattern {
    source: String,
    regex: Regex,
}

impl Pattern {
    /// Compiles an expression of XML Schema.
    ///
    /// # Errors
    /// What is no such expression, is too large, or names a block of Unicode that is not known here; the text says which.
    pub fn new(source: &str) -> Result<Self, String> {
        let translated = translate(source)?;
        let regex = RegexBuilder::new(&translated).size_limit(COMPILED_BYTES_MAX).build();
        let regex =
            regex.map_err(|_| format!("the pattern {source:?} is no regular expression, or a too large one"))?;
        Ok(Self { source: source.to_owned(), regex })
    }

    /// As the file writes it.
    pub fn source(&self) -> &str {
        &self.source
    }

    /// True if the whole text matches.
    pub fn matches(&self, text: &str) -> bool {
        self.regex.is_match(text)
    }
}

impl PartialEq for Pattern {
    fn eq(&self, other: &Self) -> bool {
        self.source == other.source
    }
}

/// The expression in the language of the engine.
fn translate(source: &str) -> Result<String, String> {
    let wrong = |what: &str| format!("the pattern {source:?} is no regular expression of XML Schema: {what}");
    let mut out = String::from(r"\A(?:");
    let mut rest = source.chars().peekable();
    // False at the beginning of a branch and behind a quantifier, where no quantifier may stand.
    let mut has_atom = false;
    while let Some(c) = rest.next() {
        match c {
            '?' | '*' | '+' | '{' => {
                if !has_atom {
                    return Err(wrong(&format!("{c:?} stands behind nothing that can be repeated")));
                }
                out.push(c);
                if c == '{' {
                    let counts: String = std::iter::from_fn(|| rest.next_if(|c| *c != '}')).collect();
                    let is_count = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
                    let (least, most) = counts.split_once(',').unwrap_or((&counts, "0"));
                    if rest.next() != Some('}') || !is_count(least) || !(most.is_empty() || is_count(most)) {
                        return Err(wrong("braces hold one or two numbers"));
                    }
                    out.push_str(&counts);
                    out.push('}');
                }
                has_atom = false;
                continue;
            }
            '|' => {
                out.push('|');
                has_atom = false;
                continue;
            }
            '(' => {
                out.push_str("(?:");
                has_atom = false;
                continue;
            }
            ')' => out.push(')'),
            '.' => out.push_str(r"[^\n\r]"),
            '[' => out.push_str(&class(&mut rest, 0).map_err(|what| wrong(&what))?),
            '\\' => out.push_str(&escape(&mut rest).map_err(|what| wrong(&what))?.in_class()),
            _ => out.push_str(&literal(c)),
        }
        has_atom = true;
    }
    out.push_str(r")\z");
    Ok(out)
}

fn literal(c: char) -> String {
    format!(r"\x{{{:X}}}", u32::from(c))
}

/// What a backslash and what follows stand for.
enum Escape {
    Character(char),
    /// A class with its brackets.
    Class(String),
}

impl Escape {
    fn in_class(&self) -> String {
        match self {
            Self::Character(c) => literal(*c),
            Self::Class(class) => class.clone(),
        }
    }
}

fn escape(rest: &mut Peekable<Chars<'_>>) -> Result<Escape, String> {
    let class = |text: &str| Ok(Escape::Class(text.to_owned()));
    match rest.next() {
        Some('n') => Ok(Escape::Character('\n')),
        Some('r') => Ok(Escape::Character('\r')),
        Some('t') => Ok(Escape::Character('\t')),
        // XML Schema has no escaped slash, but many writers have.
        Some(c) if r"\|.?*+(){}-[]^$/".contains(c) => Ok(Escape::Character(c)),
        Some('s') => class(r"[ \t\n\r]"),
        Some('S') => class(r"[^ \t\n\r]"),
        Some('d') => class(r"[\p{Nd}]"),
        Some('D') => class(r"[\P{Nd}]"),
        Some('w') => class(r"[^\p{P}\p{Z}\p{C}]"),
        Some('W') => class(r"[\p{P}\p{Z}\p{C}]"),
        Some('i') => class(&format!("[{NAME_START}]")),
        Some('I') => class(&format!("[^{NAME_START}]")),
        Some('c') => class(&format!("[{NAME_START}{NAME_REST}]")),
        Some('C') => class(&format!("[^{NAME_START}{NAME_REST}]")),
        Some(p @ ('p' | 'P')) => {
            let name: String = match rest.next() {
                Some('{') => std::iter::from_fn(|| rest.next_if(|c| *c != '}')).collect(),
                _ => return Err(format!(r"\{p} needs a name in braces")),
            };
            rest.next();
            let not = if p == 'P' { "^" } else { "" };
            if let Some(block) = name.strip_prefix("Is") {
                let (_, first, last) = BLOCKS
                    .iter()
                    .find(|(name, ..)| *name == block)
                    .ok_or_else(|| format!("the block {name} is not known"))?;
                return class(&format!(r"[{not}\x{{{first:X}}}-\x{{{last:X}}}]"));
            }
            if !(1..=2).contains(&name.len()) || !name.bytes().all(|b| b.is_ascii_alphabetic()) {
                return Err(format!("the category {name:?} is not known"));
            }
            class(&format!(r"[{not}\p{{{name}}}]"))
        }
        Some(c) => Err(format!("{:?} is no escape", format!("\\{c}"))),
        None => Err("it ends with a backslash".to_owned()),
    }
}

/// The class behind an opening bracket.
fn class(rest: &mut Peekable<Chars<'_>>, depth: usize) -> Result<String, String> {
    if depth > CLASS_DEPTH_MAX {
        return Err(format!("classes nest deeper than {CLASS_DEPTH_MAX}"));
    }
    let not = if rest.next_if_eq(&'^').is_some() { "^" } else { "" };
    let mut items = String::new();
    let subtracted = loop {
        let item = match rest.next().ok_or("a bracket is not closed")? {
            ']' => break None,
            '[' => return Err("an opening bracket within a class is escaped".to_owned()),
            '-' if !items.is_empty() && rest.next_if_eq(&'[').is_some() => {
                let subtracted = class(rest, depth + 1)?;
                if rest.next() != Some(']') {
                    return Err("a subtracted class is the last in its class".to_owned());
                }
                break Some(subtracted);
            }
            '\\' => escape(rest)?,
            c => Escape::Character(c),
        };
        let Escape::Character(first) = item else {
            items.push_str(&item.in_class());
            continue;
        };
        items.push_str(&literal(first));
        let mut ahead = rest.clone();
        if ahead.next() == Some('-') && !matches!(ahead.peek(), Some(']' | '[') | None) {
            rest.next();
            let last = match rest.next() {
                Some('\\') => escape(rest)?,
                Some(c) => Escape::Character(c),
                None => return Err("a bracket is not closed".to_owned()),
            };
            match last {
                Escape::Character(last) if first <= last => items.push_str(&format!("-{}", literal(last))),
                _ => return Err(format!("the range from {first:?} is none")),
            }
        }
    };
    if items.is_empty() {
        return Err("a class is empty".to_owned());
    }
    let class = format!("[{not}{items}]");
    Ok(subtracted.map_or(class.clone(), |subtracted| format!("[{class}--{subtracted}]")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(pattern: &str, matching: &[&str], others: &[&str]) {
        let pattern = Pattern::new(pattern).unwrap();
        matching.iter().for_each(|text| assert!(pattern.matches(text), "{text:?}"));
        others.iter().for_each(|text| assert!(!pattern.matches(text), "{text:?}"));
    }

    #[test]
    fn the_whole_text_matches() {
        check("DT[0-9]{2}", &["DT01"], &["DT1", "DT011", "XDT01", "DT01\n"]);
        check("a|b", &["a", "b"], &["ab", "xa", "bx"]);
        check(".{1,3}", &["x", "äöü"], &["", "abcd", "a\n"]);
        check("", &[""], &["a"]);
    }

    #[test]
    fn anchors_are_characters_and_classes_are_those_of_xml_schema() {
        check("^a$", &["^a$"], &["a"]);
        check(r"\w+", &["aé1", "a+b"], &["a b", "a-b", ""]);
        check(r"\i\c*", &["_a-1", "É"], &["1a", "-"]);
        check(r"[\d\-x]+", &["1-x", "٣"], &["y"]);
        check("[a-z-[aeiou]]+", &["xyz"], &["xay"]);
        check("[^a-c-[x]]", &["d"], &["a", "x"]);
        check(r"\p{Lu}\P{Lu}", &["Äb"], &["bb", "BB"]);
        check(r"\p{IsCyrillic}+", &["Њет"], &["net"]);
        check(r"[\[\]\\^-]+", &["[]\\^-"], &["a"]);
        check("[-a]+", &["-a"], &["b"]);
        check(r"(-|[0-9]{2,3})\/(-|[0-9]{2,3})", &["30/-", "120/60"], &["3/60"]);
    }

    #[test]
    fn what_xml_schema_does_not_have_is_an_error() {
        for pattern in [
            "a+?",
            "(?i)a",
            "*",
            "a{1",
            "a{x}",
            r"\b",
            "[a",
            "[]",
            "a\\",
            "(",
            ")",
            r"\p{Xxx}",
            "[z-a]",
            "a{9999}{9999}",
        ] {
            assert!(Pattern::new(pattern).is_err(), "{pattern}");
        }
        assert!(Pattern::new(r"\p{IsNonsense}").unwrap_err().contains("IsNonsense"));
        assert!(Pattern::new(r"((\w{900}){900}){900}").is_err());
    }
}
