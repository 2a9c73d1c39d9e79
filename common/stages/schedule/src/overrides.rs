//! Schedule overrides: what-if delays and reported or observed progress.

use crate::durations::{WrittenDuration, parse_shift};
use crate::error::EvaluateError;
use crate::rules::Rules;
use diagnostics::nearest_names_hint;
use frames::written_date::{self, DateOrder, WrittenDate};
use messages::Site;
use serde::Deserialize;

/// Overrides of a schedule.
#[derive(Debug, Clone, Default)]
pub struct Overrides {
    /// Tasks to delay.
    pub delays: Vec<Delay>,
    /// Reported progress.
    pub actuals: Vec<Actual>,
    /// True if reported progress was accepted for an earlier revision of the model: elements and tasks that the model no
    /// longer has are a warning. Otherwise they are an error.
    pub is_of_earlier_revision: bool,
    /// Progress of elements that a robot observed; reports rank before it. Elements that the model no longer has are
    /// ignored.
    pub observed: Vec<Actual>,
    /// Elements of which robots observed the contrary of each other.
    pub conflicts: Vec<ObservationConflict>,
}

/// An element that one robot saw, and that is absent by another one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ObservationConflict {
    /// GlobalId of the element.
    pub id: String,
    /// The robot whose observation counts, because its look is the newest.
    pub counts: String,
    /// The other robot.
    pub other: String,
    /// True if the element is absent by the one that counts.
    pub is_absent: bool,
}

impl Overrides {
    /// Progress of a running site, reported and observed: it may be of an earlier revision of the model.
    pub fn in_force([actuals, observed]: [Vec<Actual>; 2]) -> Self {
        Self { actuals, observed, is_of_earlier_revision: true, delays: Vec::new(), conflicts: Vec::new() }
    }

    /// True if effective states may differ from planned ones.
    pub(crate) fn has_reports(&self) -> bool {
        !(self.actuals.is_empty() && self.observed.is_empty())
    }
}

/// A what-if delay of a task.
#[derive(Debug, Clone)]
pub struct Delay {
    /// GlobalId, Identification or Name of the task.
    pub task: String,
    pub(crate) by: WrittenDuration,
}

/// Actual start and finish of a task or an element.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Actual {
    /// GlobalId of a task or an element, or Identification of a task.
    pub id: String,
    /// When it began; may be empty. [`ABSENT`] for an element that is not there, also where it is planned.
    #[serde(default)]
    pub start: String,
    /// When it ended; empty while work goes on.
    #[serde(default)]
    pub finish: String,
    /// Line of the table, from 1.
    #[serde(skip)]
    pub(crate) line: u64,
}

impl Actual {
    /// Line of the table, from 1.
    pub fn line(&self) -> u64 {
        self.line
    }
}

/// The start of an element that is not there.
pub const ABSENT: &str = "absent";

/// Overrides that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum OverrideError {
    /// Not `TASK=5d`.
    #[error(
        "delay {text:?}: write TASK=5d with the task's GlobalId, identification or name, and days (d), hours (h) or weeks (w)"
    )]
    Delay {
        /// As written.
        text: String,
    },
    /// A delay that brings work forward.
    #[error("delay {text:?} is negative: a delay makes work later")]
    Negative {
        /// As written.
        text: String,
    },
    /// Other columns than `id,start,finish`.
    #[error("reported progress: the first line must name the columns id, start and finish, it is {first_line:?}")]
    Columns {
        /// As written.
        first_line: String,
    },
    /// A line that is none of such a table.
    #[error("reported progress: the table must have the columns id, start and finish")]
    Table(#[from] csv::Error),
}

impl Delay {
    /// Reads `TASK=5d`.
    ///
    /// # Errors
    /// No such form, or a negative delay.
    pub fn parse(text: &str) -> Result<Self, OverrideError> {
        let wrong = || OverrideError::Delay { text: text.to_owned() };
        let (task, by) = text.rsplit_once('=').ok_or_else(wrong)?;
        let by = parse_shift(by.trim()).map_err(|_| wrong())?;
        if by.seconds(crate::durations::DayLength::Elapsed) < 0 {
            return Err(OverrideError::Negative { text: text.to_owned() });
        }
        Ok(Self { task: task.trim().to_owned(), by })
    }
}

/// Columns of a table of progress.
const COLUMNS: [&str; 3] = ["id", "start", "finish"];

/// Reads a CSV table of reported progress with the columns `id`, `start` and `finish`, in any order; others are not
/// accepted. A table may have no rows; no bytes at all are no table.
///
/// # Errors
/// Other columns, or bytes that are no CSV table.
pub fn parse_actuals(bytes: &[u8]) -> Result<Vec<Actual>, OverrideError> {
    // Spreadsheets begin a file with a byte order mark.
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).flexible(true).from_reader(bytes);
    let columns = reader.headers()?.clone();
    if columns.len() != COLUMNS.len() || COLUMNS.iter().any(|column| !columns.iter().any(|c| c == *column)) {
        return Err(OverrideError::Columns { first_line: columns.iter().collect::<Vec<_>>().join(",") });
    }
    let mut actuals = Vec::new();
    for record in reader.records() {
        let record = record?;
        let line = record.position().map_or(0, csv::Position::line);
        actuals.push(Actual { line, ..record.deserialize(Some(&columns))? });
    }
    Ok(actuals)
}

/// The task that an identifier refers to: by GlobalId, else by identification, else by name if only one has it.
///
/// # Errors
/// None that is called that, with the nearest names, or several.
pub fn find_task(site: &Site<'_>, wanted: &str) -> Result<usize, EvaluateError> {
    let by = |text: fn(&messages::TaskRecord) -> messages::ScheduleText| -> Vec<usize> {
        (0..site.schedule.tasks.len())
            .filter(|k| site.schedule.text(text(&site.schedule.tasks[*k])) == wanted)
            .collect()
    };
    let found = [by(|t| t.global_id), by(|t| t.identification), by(|t| t.name)].into_iter().find(|f| !f.is_empty());
    match found.as_deref() {
        Some(&[one]) => Ok(one),
        Some(several) => Err(EvaluateError::SeveralTasks { wanted: wanted.to_owned(), n: several.len() }),
        None => Err(EvaluateError::NoSuchTask {
            wanted: wanted.to_owned(),
            nearest: nearest_names_hint(wanted, task_names(site)),
        }),
    }
}

/// All that tasks may be called by: GlobalIds, identifications, names.
pub(crate) fn task_names<'s>(site: &Site<'s>) -> impl Iterator<Item = &'s str> {
    let texts = |t: &messages::TaskRecord| [t.name, t.identification, t.global_id];
    site.schedule.tasks.iter().flat_map(texts).map(|t| site.schedule.text(t))
}

/// A date of a report; without an order that the rules name only ISO 8601 is understood.
pub(crate) fn reported_date(text: &str, of: &Actual, rules: &Rules) -> Result<Option<WrittenDate>, EvaluateError> {
    if text.is_empty() {
        return Ok(None);
    }
    let order = rules.date_format.unwrap_or(DateOrder::Iso);
    let date = written_date::parse(text, order, rules.site_zone.as_ref());
    date.map(Some).map_err(|why| EvaluateError::Reported { line: of.line, id: of.id.clone(), why: why.to_string() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn delays_name_a_task_and_a_length() {
        let delay = Delay::parse("Walls = ground floor=5d").unwrap();
        assert_eq!(delay.task, "Walls = ground floor");
        assert!(matches!(Delay::parse("Walls"), Err(OverrideError::Delay { .. })));
        assert!(matches!(Delay::parse("Walls=soon"), Err(OverrideError::Delay { .. })));
        assert!(matches!(Delay::parse("Walls=-2d"), Err(OverrideError::Negative { .. })));
    }

    #[test]
    fn reports_are_tables_with_three_columns() {
        let read = parse_actuals(b"id, start, finish\n1.1, 2024-03-04, 2024-03-08\nabc,2024-03-05,\n").unwrap();
        assert_eq!((read[0].finish.as_str(), read[1].id.as_str(), read[1].finish.as_str()), ("2024-03-08", "abc", ""));
        assert_eq!(parse_actuals(b"finish,id,start\n,a,2024-03-05\n").unwrap()[0].start, "2024-03-05");
        assert_eq!(parse_actuals(b"\xef\xbb\xbfid,start,finish\na,,2024-03-05\n").unwrap()[0].id, "a");
        assert!(parse_actuals(b"id,start,finish\n").unwrap().is_empty());
        let wrong: [&[u8]; 5] =
            [b"", b"guid,begin\n1,2\n", b"guid,begin\n", b"id,start\n", b"id,start,finish,by\na,,,\n"];
        for table in wrong {
            assert!(matches!(parse_actuals(table), Err(OverrideError::Columns { .. })), "{table:?}");
        }
    }
}
