//! Lengths and predecessors as planners' tools print them, in English and German.

use crate::plan::{DependencyKind, Length, PlanLag};
use crate::values::{number, seconds};

/// Working hours of a day, week and month: what MS Project presumes.
const UNITS: [(&[&str], f64, f64); 6] = [
    (&["m", "min", "mins", "minute", "minutes", "minuten"], 60.0, 60.0),
    (&["h", "hr", "hrs", "hour", "hours", "std", "stunde", "stunden"], 3600.0, 3600.0),
    (&["d", "dy", "day", "days", "t", "tag", "tage", ""], 8.0 * 3600.0, 86_400.0),
    (&["w", "wk", "wks", "week", "weeks", "woche", "wochen"], 40.0 * 3600.0, 7.0 * 86_400.0),
    (&["mo", "mon", "mons", "month", "months", "monat", "monate"], 160.0 * 3600.0, 30.0 * 86_400.0),
    (&["s", "sec", "sek"], 1.0, 1.0),
];

const KINDS: [(&str, DependencyKind); 8] = [
    ("FS", DependencyKind::FinishStart),
    ("SS", DependencyKind::StartStart),
    ("FF", DependencyKind::FinishFinish),
    ("SF", DependencyKind::StartFinish),
    ("EA", DependencyKind::FinishStart),
    ("AA", DependencyKind::StartStart),
    ("EE", DependencyKind::FinishFinish),
    ("AE", DependencyKind::StartFinish),
];

/// `5`, `5d`, `2,5 Tage`, `3 ew` (elapsed), `4 days?` (estimated); a number alone is in the usual unit, and without one in days.
pub(super) fn length(text: &str, usual_unit: &str) -> Option<Length> {
    let (value, unit) = measure(text)?;
    let unit = if unit.is_empty() { usual_unit.to_owned() } else { unit };
    let unit_of = |word: &str| UNITS.iter().find(|(words, ..)| words.contains(&word));
    let (unit_s, is_elapsed) = match (unit_of(&unit), unit.strip_prefix(['e', 'f'])) {
        (Some((_, working_s, _)), _) => (*working_s, false),
        (None, Some(rest)) if !rest.is_empty() => (unit_of(rest)?.2, true),
        _ => return None,
    };
    Some(Length { seconds: seconds(value, unit_s)?, is_elapsed })
}

/// As a length, or `50%` and `50e%` of the predecessor's.
fn lag(text: &str) -> Option<PlanLag> {
    match measure(text)? {
        (value, unit) if unit == "%" || unit == "e%" => {
            Some(PlanLag::Ratio { ratio: value / 100.0, is_elapsed: unit == "e%" })
        }
        _ => length(text, "").map(PlanLag::Length),
    }
}

/// Number and unit, which is in small letters without points.
fn measure(text: &str) -> Option<(f64, String)> {
    let text = text.trim().trim_end_matches('?').trim_end();
    let end = text.find(|c: char| !c.is_ascii_digit() && !"+-., ".contains(c)).unwrap_or(text.len());
    let digits: String = text[..end].chars().filter(|c| *c != ' ').collect();
    Some((number(&digits)?, text[end..].trim().trim_end_matches('.').to_lowercase()))
}

/// A predecessor: its id, how it is joined, and the lag.
#[derive(Debug, PartialEq)]
pub(super) struct Predecessor<'a> {
    pub(super) id: &'a str,
    pub(super) kind: DependencyKind,
    pub(super) lag: Option<PlanLag>,
}

/// The entries of a cell.
pub(super) fn entries(cell: &str) -> impl Iterator<Item = &str> {
    let separators: &[char] = if cell.contains([';', '\n']) { &[';', '\n'] } else { &[','] };
    cell.split(separators).map(str::trim).filter(|entry| !entry.is_empty())
}

/// `12`, `12FS`, `A-10 SS + 2 days`: of all ways to read it the first that has the id of a task, as ids may have letters and signs.
pub(super) fn predecessor<'a>(entry: &'a str, is_id: impl Fn(&str) -> bool) -> Option<Predecessor<'a>> {
    let signs = entry.char_indices().filter(|(_, c)| ['+', '-'].contains(c)).map(|(at, _)| at);
    for at in std::iter::once(entry.len()).chain(signs) {
        let (front, rest) = entry.split_at(at);
        let front = front.trim_end();
        let lag = if rest.is_empty() { None } else { lag(rest) };
        if lag.is_none() && !rest.is_empty() {
            continue;
        }
        let lag = lag.filter(|lag| !is_nothing(*lag));
        if is_id(front) {
            return Some(Predecessor { id: front, kind: DependencyKind::FinishStart, lag });
        }
        let split = front.len().checked_sub(2).filter(|at| front.is_char_boundary(*at));
        let Some((id, word)) = split.map(|at| front.split_at(at)) else { continue };
        let id = id.trim_end().trim_end_matches(':').trim_end();
        if let Some((_, kind)) = KINDS.iter().find(|(k, _)| k.eq_ignore_ascii_case(word)).filter(|_| is_id(id)) {
            return Some(Predecessor { id, kind: *kind, lag });
        }
    }
    None
}

fn is_nothing(lag: PlanLag) -> bool {
    match lag {
        PlanLag::Length(length) => length.seconds == 0,
        PlanLag::Ratio { ratio, .. } => ratio == 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use DependencyKind::{FinishFinish, FinishStart, StartStart};

    #[test]
    fn lengths_have_units_of_two_languages() {
        let check = |text: &str, seconds: i64, is_elapsed: bool| {
            assert_eq!(length(text, ""), Some(Length { seconds, is_elapsed }), "{text}");
        };
        check("5", 5 * 28_800, false);
        check("2,5 Tage?", 72_000, false);
        check("3 ed", 3 * 86_400, true);
        check("1 fwoche", 7 * 86_400, true);
        check("16 Std.", 57_600, false);
        check("-1 w", -144_000, false);
        assert_eq!(length("2", "w"), length("2 weeks", "h"));
        for text in ["", "d", "5 parsecs", "e", "1e", "1.2.3 d"] {
            assert_eq!(length(text, ""), None, "{text}");
        }
    }

    #[test]
    fn predecessors_are_read_by_the_ids_that_there_are() {
        let ids = ["12", "14", "A-10", "A-10SS", "ÄA"];
        let check = |entry: &str, id: &str, kind: DependencyKind, lag_s: i64| {
            let lag = (lag_s != 0).then_some(PlanLag::Length(Length { seconds: lag_s, is_elapsed: false }));
            let read = predecessor(entry, |id| ids.contains(&id));
            assert_eq!(read, Some(Predecessor { id, kind, lag }), "{entry}");
        };
        check("12", "12", FinishStart, 0);
        check("12FS+3d", "12", FinishStart, 86_400);
        check("14SS", "14", StartStart, 0);
        check("12EE-1 Tag", "12", FinishFinish, -28_800);
        check("A-10", "A-10", FinishStart, 0);
        check("A-10 ff + 2 days", "A-10", FinishFinish, 57_600);
        check("A-10SS", "A-10SS", FinishStart, 0);
        check("14: AA", "14", StartStart, 0);
        check("ÄA", "ÄA", FinishStart, 0);
        assert!(["13", "12XX", "12FS+x", "", "Ä"].iter().all(|e| predecessor(e, |id| ids.contains(&id)).is_none()));
        let half = predecessor("12SS+50%", |id| id == "12").unwrap();
        assert_eq!(half.lag, Some(PlanLag::Ratio { ratio: 0.5, is_elapsed: false }));
        assert_eq!(entries("12FS+2,5d; 14").collect::<Vec<_>>(), ["12FS+2,5d", "14"]);
        assert_eq!(entries("12,14").collect::<Vec<_>>(), ["12", "14"]);
    }
}
