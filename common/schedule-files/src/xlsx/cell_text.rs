//! Values of cells as the texts that a CSV of the sheet would have.

use crate::iso;
use calamine::{DataRef, Style};
use jiff::ToSpan;
use jiff::civil::{Date, DateTime, date};

/// Serial numbers of dates end with the year 9999.
const MAX_SERIAL: f64 = 2_958_466.0;
/// Serial numbers that a number without a date's format may be in a column of dates: 1954 to 2119.
const PLAUSIBLE_SERIALS: std::ops::RangeInclusive<f64> = 20_000.0..=80_000.0;

/// A cell that is not empty.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Cell {
    Text(String),
    /// A number, and how the sheet shows it.
    Number {
        value: f64,
        text: String,
    },
    Date(DateTime),
}

impl Cell {
    /// The value of a cell with its style; `None` if it is empty.
    pub(super) fn of(value: &DataRef<'_>, style: Option<&Style>, is_1904: bool) -> Option<Self> {
        let code = style.and_then(|style| style.number_format.as_ref()).map_or("", |format| &format.format_code);
        let number = |value: f64| Self::Number { value, text: shown(value, code) };
        let text = |text: &str| Some(Self::Text(text.to_owned())).filter(|_| !text.trim().is_empty());
        match value {
            DataRef::Empty => None,
            DataRef::Int(value) => Some(number(*value as f64)),
            DataRef::Float(value) => Some(number(*value)),
            DataRef::String(value) => text(value),
            DataRef::SharedString(value) => text(value),
            DataRef::Bool(value) => text(if *value { "TRUE" } else { "FALSE" }),
            DataRef::DateTime(time) if time.is_duration() => {
                Some(Self::Number { value: time.as_f64(), text: format!("{} h", tidy(time.as_f64() * 24.0)) })
            }
            DataRef::DateTime(time) => Some(match date_of_serial(time.as_f64(), is_1904) {
                Some(at) if time.as_f64() >= 1.0 => Self::Date(at),
                Some(at) => Self::Text(at.time().to_string()),
                None => Self::Text(time.as_f64().to_string()),
            }),
            DataRef::DateTimeIso(value) => {
                Some(iso::date(value).map_or_else(|| Self::Text(value.clone()), |date| Self::Date(date.at.0)))
            }
            DataRef::DurationIso(value) => text(value),
            DataRef::Error(error) => text(&error.to_string()),
        }
    }

    /// As a CSV has it.
    pub(super) fn text(&self) -> String {
        match self {
            Self::Text(text) | Self::Number { text, .. } => text.clone(),
            Self::Date(at) => date_text(*at),
        }
    }

    /// As a CSV has it in a column of dates: a number may be the serial number of a date that lost its format.
    pub(super) fn date_text(&self, is_1904: bool) -> String {
        let serial = match self {
            Self::Number { value, .. } if PLAUSIBLE_SERIALS.contains(value) => date_of_serial(*value, is_1904),
            _ => None,
        };
        serial.map_or_else(|| self.text(), date_text)
    }

    /// Bytes of its text.
    pub(super) fn n_bytes(&self) -> usize {
        match self {
            Self::Text(text) | Self::Number { text, .. } => text.len(),
            Self::Date(_) => 0,
        }
    }

    /// The day of a date.
    pub(super) fn day(&self) -> Option<Date> {
        if let Self::Date(at) = self { Some(at.date()) } else { None }
    }
}

fn date_text(at: DateTime) -> String {
    if at.time() == jiff::civil::Time::midnight() { at.date().to_string() } else { at.to_string() }
}

/// The date of a serial number, to the second. Days of the system of 1900 are off by one before its 29 February, which never was.
fn date_of_serial(serial: f64, is_1904: bool) -> Option<DateTime> {
    if !(0.0..MAX_SERIAL).contains(&serial) {
        return None;
    }
    let first = match is_1904 {
        true => date(1904, 1, 1),
        false if serial < 60.0 => date(1899, 12, 31),
        false => date(1899, 12, 30),
    };
    let seconds = (serial * 86_400.0).round() as i64;
    first.at(0, 0, 0, 0).checked_add(seconds.seconds()).ok()
}

/// A number without the noise of its last digits.
fn tidy(value: f64) -> f64 {
    if value.abs() < 1e6 { (value * 1e9).round() / 1e9 } else { value }
}

/// A number with the texts, leading zeros and percent sign of its format; decimals and thousands are as in the number.
fn shown(value: f64, code: &str) -> String {
    let section = code.split(';').next().unwrap_or("");
    let (mut before, mut after) = (String::new(), String::new());
    let (mut n_zeros, mut is_percent, mut is_fraction, mut has_digits) = (0, false, false, false);
    let mut rest = section.chars();
    while let Some(c) = rest.next() {
        let literal = if has_digits { &mut after } else { &mut before };
        match c {
            '"' => literal.extend(rest.by_ref().take_while(|c| *c != '"')),
            '\\' => literal.extend(rest.next()),
            '_' | '*' => drop(rest.next()),
            '[' => drop(rest.by_ref().find(|c| *c == ']')),
            '0' | '#' | '?' => {
                has_digits = true;
                n_zeros += usize::from(c == '0' && !is_fraction);
            }
            '.' => is_fraction = true,
            ',' => {}
            '%' => is_percent = true,
            ' ' | '-' | '/' | '(' | ')' | ':' | '+' => literal.push(c),
            // A format of letters, such as General.
            _ => return tidy(value).to_string(),
        }
    }
    if !has_digits {
        return tidy(value).to_string();
    }
    let value = tidy(if is_percent { value * 100.0 } else { value });
    let digits = if value.fract() == 0.0 && value >= 0.0 && n_zeros > 1 && !is_percent {
        format!("{value:0n_zeros$}")
    } else {
        value.to_string()
    };
    format!("{before}{digits}{}{after}", if is_percent { "%" } else { "" }).trim().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn serial_numbers_are_dates_of_both_systems() {
        let check = |serial: f64, is_1904: bool, expected: &str| {
            assert_eq!(date_of_serial(serial, is_1904).map(date_text).unwrap_or_default(), expected, "{serial}");
        };
        check(45_397.0, false, "2024-04-15");
        check(43_935.0, true, "2024-04-15");
        check(45_397.0 + 1.0 / 3.0, false, "2024-04-15T08:00:00");
        check(1.0, false, "1900-01-01");
        check(59.0, false, "1900-02-28");
        check(61.0, false, "1900-03-01");
        for wrong in [-1.0, 3e6, f64::NAN, f64::INFINITY] {
            check(wrong, false, "");
        }
    }

    #[test]
    fn numbers_are_read_as_the_sheet_shows_them() {
        let check = |value: f64, code: &str, expected: &str| assert_eq!(shown(value, code), expected, "{code}");
        check(5.0, "General", "5");
        check(5.0, "", "5");
        check(0.75, "0%", "75%");
        check(0.07, "0.00%", "7%");
        check(20.0, "0000", "0020");
        check(20.0, "\"A-\"000", "A-020");
        check(2.0, "0\\ \"wks\"", "2 wks");
        check(2.5, "0.0 \"days\"", "2.5 days");
        check(1234.5, "#,##0.00_);[Red]\\(#,##0.00\\)", "1234.5");
        check(0.1 + 0.2, "General", "0.3");
    }
}
