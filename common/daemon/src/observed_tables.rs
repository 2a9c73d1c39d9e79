//! Progress that the robots of a site observed: a table for each, and the one of them all that is in force.
//!
//! A row counts until its robot gives another one, or none, for its element. Where several robots have a row for an element, that of
//! the newest look is in force: the row that was given last with another content than before.

use crate::kept_file::KeptFile;
use crate::save::Save;
use crate::state_files::OBSERVED_BY_ROBOTS;
use bus::RobotName;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::io;
use std::path::Path;

/// Observed progress by robot.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObservedTables {
    /// Tables that were given; a row has the number of the one with which it came.
    n_looks: u64,
    /// By robot, then by element.
    robots: BTreeMap<String, BTreeMap<String, ObservedRow>>,
}

/// What a robot says of an element, in the words of a table of progress.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObservedRow {
    /// When it began, or that it is absent.
    pub start: String,
    /// When it ended.
    pub finish: String,
    look: u64,
}

/// A row of a robot that is in force, and one of another robot that it goes before.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ObservedPair<'a> {
    /// The element.
    pub id: &'a str,
    /// The robot of the row in force, and the row.
    pub newer: (&'a str, &'a ObservedRow),
    /// Another robot with a row, and the row.
    pub older: (&'a str, &'a ObservedRow),
}

/// A table of progress with these rows: id, start, finish.
pub fn progress_table<'a>(rows: impl IntoIterator<Item = [&'a str; 3]>) -> String {
    let mut table = "id,start,finish\n".to_owned();
    for row in rows {
        let [id, start, finish] = row.map(|text| format!("\"{}\"", text.replace('"', "\"\"")));
        // Writing to a string does not fail.
        let _ = writeln!(table, "{id},{start},{finish}");
    }
    table
}

impl ObservedTables {
    /// The tables of a site, of the robots that it has; none where nothing was observed.
    ///
    /// # Errors
    /// A file that cannot be read, or holds something else.
    pub fn load(state: &Path, robots: &[RobotName]) -> io::Result<Self> {
        let Some(bytes) = KeptFile::at(state, OBSERVED_BY_ROBOTS).look()?.content else { return Ok(Self::default()) };
        let mut tables: Self = serde_json::from_slice(&bytes)?;
        tables.robots.retain(|name, _| robots.iter().any(|robot| robot.as_str() == name));
        Ok(tables)
    }

    /// The same with another table of a robot. Rows that are as before keep their look.
    #[must_use]
    pub fn with(&self, robot: RobotName, rows: impl IntoIterator<Item = [String; 3]>) -> Self {
        let (mut tables, look) = (self.clone(), self.n_looks + 1);
        let before = tables.robots.remove(robot.as_str()).unwrap_or_default();
        let rows = rows.into_iter().map(|[id, start, finish]| {
            let same = before.get(&id).filter(|row| row.start == start && row.finish == finish);
            let row = ObservedRow { start, finish, look: same.map_or(look, |row| row.look) };
            (id, row)
        });
        tables.robots.insert(robot.to_string(), rows.collect());
        tables.n_looks = look;
        tables
    }

    /// The rows of a robot by element; `None` if it never gave a table.
    pub fn rows_of(&self, robot: RobotName) -> Option<&BTreeMap<String, ObservedRow>> {
        self.robots.get(robot.as_str())
    }

    /// The table of all robots, as bytes of a table of progress.
    pub fn in_force(&self) -> Vec<u8> {
        let by_element = self.by_element();
        let newest = by_element.iter().filter_map(|(id, rows)| Some((*id, rows.first()?.1)));
        progress_table(newest.map(|(id, row)| [id, &row.start, &row.finish])).into_bytes()
    }

    /// Rows in force with each that they go before.
    pub fn pairs(&self) -> Vec<ObservedPair<'_>> {
        let pairs = self.by_element().into_iter().flat_map(|(id, rows)| {
            let newer = rows.first().copied();
            let older: Vec<_> = rows.into_iter().skip(1).collect();
            older.into_iter().filter_map(move |older| Some(ObservedPair { id, newer: newer?, older }))
        });
        pairs.collect()
    }

    /// Rows by element, from the newest look to the oldest.
    fn by_element(&self) -> BTreeMap<&str, Vec<(&str, &ObservedRow)>> {
        let mut found: BTreeMap<&str, Vec<(&str, &ObservedRow)>> = BTreeMap::new();
        for (robot, rows) in &self.robots {
            for (id, row) in rows {
                found.entry(id).or_default().push((robot, row));
            }
        }
        found.values_mut().for_each(|rows| rows.sort_by_key(|(_, row)| std::cmp::Reverse(row.look)));
        found
    }

    /// The tables, to be saved.
    ///
    /// # Errors
    /// They are none of JSON, which they always are.
    pub fn saving(&self, state: &Path) -> io::Result<Save> {
        Ok(KeptFile::at(state, OBSERVED_BY_ROBOTS).saving(serde_json::to_vec(self)?))
    }
}

/// The file of the tables, to be mended.
pub(crate) fn observed_tables_file(state: &Path) -> KeptFile {
    KeptFile::at(state, OBSERVED_BY_ROBOTS)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(id: &str, start: &str, finish: &str) -> [String; 3] {
        [id, start, finish].map(str::to_owned)
    }

    #[test]
    fn of_each_element_the_newest_look_is_in_force() {
        let [lift, scan]: [RobotName; 2] = ["lift", "scan"].map(|name| name.parse().unwrap());
        let text = |tables: &ObservedTables| String::from_utf8(tables.in_force()).unwrap();
        let tables = ObservedTables::default().with(lift, [row("wall", "absent", ""), row("door", "", "2024-03-04")]);
        let tables = tables.with(scan, [row("wall", "", "2024-03-05")]);
        assert_eq!(text(&tables), "id,start,finish\n\"door\",\"\",\"2024-03-04\"\n\"wall\",\"\",\"2024-03-05\"\n");
        let pairs = tables.pairs();
        assert_eq!(pairs.len(), 1);
        assert_eq!((pairs[0].id, pairs[0].newer.0, pairs[0].older.0), ("wall", "scan", "lift"));
        // The same look again is no newer one; another one is.
        let again = tables.with(lift, [row("wall", "absent", "")]);
        assert_eq!(text(&again), "id,start,finish\n\"wall\",\"\",\"2024-03-05\"\n");
        let newer = again.with(lift, []).with(lift, [row("wall", "absent", "")]);
        assert_eq!(text(&newer), "id,start,finish\n\"wall\",\"absent\",\"\"\n");
        assert_eq!((newer.pairs()[0].newer.0, newer.with(lift, []).pairs().len()), ("lift", 0));
    }

    #[test]
    fn tables_are_kept_and_those_of_robots_that_are_gone_do_not_count() {
        let state = tempfile::tempdir().unwrap();
        let [lift, scan]: [RobotName; 2] = ["lift", "scan"].map(|name| name.parse().unwrap());
        assert_eq!(ObservedTables::load(state.path(), &[lift]).unwrap(), ObservedTables::default());
        let tables = ObservedTables::default().with(lift, [row("a,\"b", "", "x")]).with(scan, [row("c", "", "y")]);
        tables.saving(state.path()).unwrap().write().unwrap();
        assert_eq!(ObservedTables::load(state.path(), &[lift, scan]).unwrap(), tables);
        let of_one = ObservedTables::load(state.path(), &[lift]).unwrap();
        assert_eq!(String::from_utf8(of_one.in_force()).unwrap(), "id,start,finish\n\"a,\"\"b\",\"\",\"x\"\n");
    }
}
