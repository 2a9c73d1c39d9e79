//! Columns of a CSV by their headings.

use crate::options::CsvColumn::{self, *};
use crate::{PlanFileError, ReadOptions};
use std::collections::BTreeMap;

/// More columns are not a table of tasks.
const MAX_COLUMNS: usize = 4096;

/// Usual headings, in small letters and digits: the first of a column that the file has is taken.
const USUAL: [(CsvColumn, &[&str]); 26] = [
    (
        Id,
        &[
            "id",
            "taskid",
            "activityid",
            "vorgangsnummer",
            "vorgangsnr",
            "vorgangsid",
            "vorgangid",
            "nr",
            "nummer",
            "no",
            "number",
            "uid",
            "uniqueid",
            "eindeutigenr",
        ],
    ),
    (Code, &["code", "taskcode", "activitycode", "synchronizationid", "externalid", "vorgangscode"]),
    (Wbs, &["wbs", "wbscode", "psp", "pspcode", "pspnummer", "outlinenumber", "gliederungsnummer"]),
    (Parent, &["parent", "parentid", "parenttask", "übergeordnet", "übergeordnetervorgang", "elternvorgang"]),
    (OutlineLevel, &["outlinelevel", "gliederungsebene"]),
    (
        Name,
        &["name", "taskname", "activityname", "vorgangsname", "task", "activity", "vorgang", "bezeichnung", "title"],
    ),
    (Type, &["type", "tasktype", "activitytype", "typ", "vorgangstyp", "vorgangsart"]),
    (Milestone, &["milestone", "meilenstein"]),
    (Active, &["active", "aktiv"]),
    (Start, &["start", "startdate", "begin", "anfang", "beginn", "starttermin", "startdatum", "anfangstermin"]),
    (Finish, &["finish", "finishdate", "end", "enddate", "ende", "endtermin", "enddatum", "fertigstellungstermin"]),
    (PlannedStart, &["plannedstart", "plannedstartdate", "geplanteranfang", "geplanterstart", "geplanterbeginn"]),
    (PlannedFinish, &["plannedfinish", "plannedend", "plannedfinishdate", "geplantesende"]),
    (EarlyStart, &["earlystart", "frühesteranfang", "frühesterbeginn"]),
    (EarlyFinish, &["earlyfinish", "frühestesende"]),
    (LateStart, &["latestart", "spätesteranfang", "spätesterbeginn"]),
    (LateFinish, &["latefinish", "spätestesende"]),
    (ActualStart, &["actualstart", "actualstartdate", "tatsächlicheranfang", "istanfang", "istbeginn", "iststart"]),
    (ActualFinish, &["actualfinish", "actualend", "actualfinishdate", "tatsächlichesende", "istende"]),
    (BaselineStart, &["baselinestart", "bl1start", "basisplananfang", "sollanfang", "sollbeginn"]),
    (BaselineFinish, &["baselinefinish", "baselineend", "bl1finish", "basisplanende", "sollende"]),
    (
        Duration,
        &[
            "duration",
            "originalduration",
            "plannedduration",
            "durationdays",
            "durationindays",
            "durationweeks",
            "durationwks",
            "durationinweeks",
            "durationhours",
            "durationhrs",
            "dauer",
            "dauertage",
            "dauerintagen",
            "dauerwochen",
            "dauerinwochen",
            "dauerstunden",
            "dauerinstunden",
        ],
    ),
    (RemainingDuration, &["remainingduration", "verbleibendedauer", "restdauer"]),
    (
        PercentComplete,
        &[
            "complete",
            "percentcomplete",
            "durationcomplete",
            "progress",
            "abgeschlossen",
            "prozentabgeschlossen",
            "fortschritt",
            "fertigstellungsgrad",
        ],
    ),
    (PhysicalPercentComplete, &["physicalcomplete", "physicalpercentcomplete", "physischabgeschlossen"]),
    (Predecessors, &["predecessors", "predecessor", "vorgänger"]),
];

/// Which column holds what; those that hold nothing known are fields.
#[derive(Debug)]
pub(crate) struct Columns {
    known: BTreeMap<CsvColumn, usize>,
    /// Index and heading.
    pub(super) fields: Vec<(usize, String)>,
    headings: Vec<String>,
}

impl Columns {
    /// The columns of a table, by the options and by usual headings.
    ///
    /// # Errors
    /// A heading of the options that is not there; no column that says what a task is called.
    pub(crate) fn of(headings: &[&str], options: &ReadOptions, line: usize) -> Result<Self, PlanFileError> {
        if headings.len() > MAX_COLUMNS {
            return Err(PlanFileError::TooMany { max: MAX_COLUMNS, what: "columns" });
        }
        let mut known = BTreeMap::new();
        let mut is_free = vec![true; headings.len()];
        for (column, heading) in &options.columns {
            let Some(k) = headings.iter().position(|h| h.trim() == heading.trim()) else {
                let why = format!("there is no column {heading:?}; there are {}", headings.join(", "));
                return Err(PlanFileError::Table { line, why });
            };
            known.insert(*column, k);
            is_free[k] = false;
        }
        let words: Vec<_> = headings.iter().map(|heading| letters(heading)).collect();
        for (column, usual) in USUAL {
            if known.contains_key(&column) {
                continue;
            }
            let place = |word: &&str| words.iter().position(|w| w == word).filter(|k| is_free[*k]);
            if let Some(k) = usual.iter().find_map(place) {
                known.insert(column, k);
                is_free[k] = false;
            }
        }
        if ![Id, Code, Name].iter().any(|column| known.contains_key(column)) {
            let why = format!("no column is known as the id, code or name of tasks; there are {}", headings.join(", "));
            return Err(PlanFileError::Table { line, why });
        }
        let is_field = |k: usize| (is_free[k] || known.get(&Type) == Some(&k)) && !headings[k].trim().is_empty();
        let fields = (0..headings.len()).filter(|k| is_field(*k)).map(|k| (k, headings[k].trim().to_owned())).collect();
        let headings = headings.iter().map(|heading| heading.trim().to_owned()).collect();
        Ok(Self { known, fields, headings })
    }

    /// The columns that are known, with their indices.
    pub(crate) fn known(&self) -> impl Iterator<Item = (CsvColumn, usize)> {
        self.known.iter().map(|(column, k)| (*column, *k))
    }

    /// Number of columns.
    pub(super) fn len(&self) -> usize {
        self.headings.len()
    }

    /// Heading of a column, empty if there is none.
    pub(super) fn heading(&self, column: CsvColumn) -> &str {
        self.index_of(column).map_or("", |k| &self.headings[k])
    }

    /// Index of a column.
    pub(crate) fn index_of(&self, column: CsvColumn) -> Option<usize> {
        self.known.get(&column).copied()
    }
}

/// Small letters and digits of a heading.
fn letters(heading: &str) -> String {
    heading.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headings_are_known_in_english_and_german_and_the_rest_are_fields() {
        let check = |headings: &[&str], expected: &[(CsvColumn, usize)], fields: &[usize]| {
            let columns = Columns::of(headings, &ReadOptions::default(), 1).unwrap();
            assert_eq!(columns.known.into_iter().collect::<Vec<_>>(), expected);
            assert_eq!(columns.fields.iter().map(|(k, _)| *k).collect::<Vec<_>>(), fields);
        };
        check(
            &["Unique ID", "ID", "Task Name", "% Complete", "4D_Number", ""],
            &[(Id, 1), (Name, 2), (PercentComplete, 3)],
            &[0, 4],
        );
        check(
            &["Nr.", "Vorgangsname", "Anfang", "Ende", "Vorgänger"],
            &[(Id, 0), (Name, 1), (Start, 2), (Finish, 3), (Predecessors, 4)],
            &[],
        );
        // TimeLiner writes what a task does as its type.
        check(&["Name", "Task Type"], &[(Name, 0), (Type, 1)], &[1]);
    }

    #[test]
    fn the_options_rank_before_usual_headings() {
        let options = ReadOptions { columns: [(Id, "Name".to_owned())].into(), ..Default::default() };
        let columns = Columns::of(&["Name", "ID"], &options, 1).unwrap();
        assert_eq!((columns.index_of(Id), columns.index_of(Name)), (Some(0), None));
        let missing = Columns::of(&["ID"], &options, 3).unwrap_err();
        assert_eq!(missing.to_string(), "line 3: there is no column \"Name\"; there are ID");
        assert!(Columns::of(&["Start", "x"], &ReadOptions::default(), 1).is_err());
    }
}
