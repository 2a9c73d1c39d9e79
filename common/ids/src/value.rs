//! Values of an IDS file, and what of an IFC file they match.

use std::fmt;

use crate::pattern::Pattern;

/// Relative and absolute tolerance of comparisons of reals.
///
/// # Source
/// The test cases `tolerance` of IDS 1.0: `v` equals what lies within `v ± (|v| · 1e-6 + 1e-6)`.
const TOLERANCE: f64 = 1e-6;

/// What a parameter of a facet may be.
#[derive(Debug, Clone, PartialEq)]
pub enum Constraint {
    /// This value.
    Simple(String),
    /// One that meets all of these.
    Restriction(Box<Restriction>),
}

/// `xs:restriction`; what is not there does not restrict.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Restriction {
    /// Type of XML Schema, without its prefix.
    pub base: String,
    /// One of these.
    pub enumeration: Vec<String>,
    /// Matches one of these.
    pub patterns: Vec<Pattern>,
    /// Number of characters.
    pub length: Option<u64>,
    /// Least number of characters.
    pub min_length: Option<u64>,
    /// Largest number of characters.
    pub max_length: Option<u64>,
    /// Bounds of numbers and dates.
    pub bounds: Vec<Bound>,
}

/// A bound as the file writes it.
#[derive(Debug, Clone, PartialEq)]
pub struct Bound {
    /// Which bound it is.
    pub kind: BoundKind,
    /// Its value.
    pub value: String,
}

/// Kinds of bounds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BoundKind {
    /// At least.
    MinInclusive,
    /// More than.
    MinExclusive,
    /// At most.
    MaxInclusive,
    /// Less than.
    MaxExclusive,
}

/// A value of an IFC file, in units of SI.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Actual {
    Text(String),
    Real(f64),
    Integer(f64),
    Boolean(bool),
}

impl Constraint {
    /// True if the value is what is asked for.
    pub(crate) fn matches(&self, actual: &Actual) -> bool {
        match self {
            Self::Simple(value) => equals(value, actual),
            Self::Restriction(restriction) => restriction.matches(actual),
        }
    }

    pub(crate) fn matches_text(&self, text: &str) -> bool {
        match self {
            Self::Simple(value) => value == text,
            // Names are many and matched often.
            Self::Restriction(restriction) => restriction.matches(&Actual::Text(text.to_owned())),
        }
    }

    /// True if all values of a property that has several must match, not only one of them.
    pub(crate) fn is_range(&self) -> bool {
        matches!(self, Self::Restriction(restriction) if !restriction.bounds.is_empty())
    }
}

impl Restriction {
    fn matches(&self, actual: &Actual) -> bool {
        let has_length = |text: &str| {
            let n = text.chars().count() as u64;
            self.length.is_none_or(|length| n == length)
                && self.min_length.is_none_or(|least| least <= n)
                && self.max_length.is_none_or(|most| n <= most)
        };
        let restricts_length = self.length.or(self.min_length).or(self.max_length).is_some();
        let as_text = match actual {
            Actual::Text(text) => Some(text.as_str()),
            _ => None,
        };
        (self.enumeration.is_empty() || self.enumeration.iter().any(|value| equals(value, actual)))
            && (self.patterns.is_empty() || as_text.is_some_and(|text| self.patterns.iter().any(|p| p.matches(text))))
            && (!restricts_length || as_text.is_some_and(has_length))
            && self.bounds.iter().all(|bound| bound.admits(actual))
    }
}

impl Bound {
    fn admits(&self, actual: &Actual) -> bool {
        match actual {
            Actual::Real(x) | Actual::Integer(x) => {
                let Some(bound) = double(&self.value) else { return false };
                // Whole numbers are exact.
                let tolerance = if matches!(actual, Actual::Real(_)) { tolerance_of(bound) } else { 0.0 };
                match self.kind {
                    BoundKind::MinInclusive => bound - tolerance <= *x,
                    BoundKind::MinExclusive => bound + tolerance < *x,
                    BoundKind::MaxInclusive => *x <= bound + tolerance,
                    BoundKind::MaxExclusive => *x < bound - tolerance,
                }
            }
            // Dates and times of ISO 8601 without zones sort as texts.
            Actual::Text(text) => match self.kind {
                BoundKind::MinInclusive => self.value.as_str() <= text.as_str(),
                BoundKind::MinExclusive => self.value.as_str() < text.as_str(),
                BoundKind::MaxInclusive => text.as_str() <= self.value.as_str(),
                BoundKind::MaxExclusive => text.as_str() < self.value.as_str(),
            },
            Actual::Boolean(_) => false,
        }
    }
}

/// The tolerance at a value, with what rounding adds where a decimal fraction lies on its edge.
fn tolerance_of(value: f64) -> f64 {
    (value.abs() * TOLERANCE + TOLERANCE) * (1.0 + 1e-9)
}

fn equals(value: &str, actual: &Actual) -> bool {
    match actual {
        Actual::Text(text) => value == text,
        Actual::Real(x) => double(value).is_some_and(|v| v == *x || (x - v).abs() <= tolerance_of(v)),
        Actual::Integer(x) => double(value) == Some(*x),
        Actual::Boolean(b) => boolean(value) == Some(*b),
    }
}

/// A number as XML Schema writes doubles.
pub(crate) fn double(text: &str) -> Option<f64> {
    match text {
        "NaN" => return Some(f64::NAN),
        "INF" | "+INF" => return Some(f64::INFINITY),
        "-INF" => return Some(f64::NEG_INFINITY),
        _ => {}
    }
    // Rust also reads names such as "infinity".
    let is_number = text.bytes().all(|b| b.is_ascii_digit() || matches!(b, b'+' | b'-' | b'.' | b'e' | b'E'));
    is_number.then(|| text.parse().ok()).flatten()
}

pub(crate) fn boolean(text: &str) -> Option<bool> {
    match text {
        "true" | "1" => Some(true),
        "false" | "0" => Some(false),
        _ => None,
    }
}

/// True for a whole number as XML Schema writes it.
pub(crate) fn is_integer(text: &str) -> bool {
    let digits = text.strip_prefix(['+', '-']).unwrap_or(text);
    !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit())
}

impl fmt::Display for Constraint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Simple(value) => f.write_str(value),
            Self::Restriction(restriction) => restriction.fmt(f),
        }
    }
}

impl fmt::Display for Restriction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut parts = Vec::new();
        if !self.enumeration.is_empty() {
            parts.push(self.enumeration.join(" or "));
        }
        if !self.patterns.is_empty() {
            let sources: Vec<&str> = self.patterns.iter().map(Pattern::source).collect();
            parts.push(format!("matching {}", sources.join(" or ")));
        }
        let lengths = [("of", self.length), ("of at least", self.min_length), ("of at most", self.max_length)];
        parts.extend(lengths.iter().filter_map(|(word, n)| n.map(|n| format!("{word} {n} characters"))));
        parts.extend(self.bounds.iter().map(|bound| format!("{} {}", bound.kind.sign(), bound.value)));
        if parts.is_empty() { f.write_str("anything") } else { f.write_str(&parts.join(" and ")) }
    }
}

impl BoundKind {
    /// True for a bound from below.
    pub(crate) fn is_least(self) -> bool {
        matches!(self, Self::MinInclusive | Self::MinExclusive)
    }

    fn sign(self) -> &'static str {
        match self {
            Self::MinInclusive => ">=",
            Self::MinExclusive => ">",
            Self::MaxInclusive => "<=",
            Self::MaxExclusive => "<",
        }
    }
}

impl fmt::Display for Actual {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Text(text) => write!(f, "{text:?}"),
            // What conversion adds to a decimal fraction is not shown.
            Self::Real(x) | Self::Integer(x) => format!("{x:.8e}").parse::<f64>().unwrap_or(*x).fmt(f),
            Self::Boolean(b) => b.fmt(f),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn simple(value: &str) -> Constraint {
        Constraint::Simple(value.to_owned())
    }

    #[test]
    fn reals_are_equal_within_the_tolerance_and_whole_numbers_exactly() {
        assert!(simple("1.").matches(&Actual::Real(1.000_001_9)) && !simple("1").matches(&Actual::Real(1.000_002_1)));
        assert!(simple("-1e3").matches(&Actual::Real(-1000.001)) && !simple("x").matches(&Actual::Real(1.0)));
        assert!(simple("42").matches(&Actual::Integer(42.0)) && !simple("42").matches(&Actual::Integer(42.000_000_1)));
        assert!(simple("true").matches(&Actual::Boolean(true)) && !simple("TRUE").matches(&Actual::Boolean(true)));
        assert!(!simple("1").matches(&Actual::Text("1.0".to_owned())));
    }

    #[test]
    fn a_restriction_asks_for_all_that_it_says() {
        let restriction = |edit: fn(&mut Restriction)| {
            let mut restriction = Restriction::default();
            edit(&mut restriction);
            Constraint::Restriction(Box::new(restriction))
        };
        let text = |text: &str| Actual::Text(text.to_owned());
        let either = restriction(|r| r.enumeration = vec!["1".to_owned(), "x".to_owned()]);
        assert!(either.matches(&text("x")) && either.matches(&Actual::Real(1.0)) && !either.matches(&text("X")));
        let patterns = restriction(|r| r.patterns = vec![Pattern::new("a").unwrap(), Pattern::new("b+").unwrap()]);
        assert!(
            patterns.matches(&text("bb")) && !patterns.matches(&text("ab")) && !patterns.matches(&Actual::Real(1.0))
        );
        let lengths = restriction(|r| (r.min_length, r.max_length) = (Some(2), Some(3)));
        assert!(lengths.matches(&text("äöü")) && !lengths.matches(&text("a")) && !lengths.matches(&text("abcd")));
        let bound = |kind, value: &str| Bound { kind, value: value.to_owned() };
        let above = Constraint::Restriction(Box::new(Restriction {
            bounds: vec![bound(BoundKind::MinExclusive, "0"), bound(BoundKind::MaxInclusive, "10")],
            ..Restriction::default()
        }));
        assert!(above.matches(&Actual::Real(10.0)) && !above.matches(&Actual::Real(0.0)) && above.is_range());
        let since = Constraint::Restriction(Box::new(Restriction {
            bounds: vec![bound(BoundKind::MinInclusive, "2024-03-01")],
            ..Restriction::default()
        }));
        assert!(since.matches(&text("2024-03-01")) && !since.matches(&text("2024-02-29")));
    }
}
