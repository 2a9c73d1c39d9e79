//! Links as a table that planners complete in a spreadsheet: columns `global_id`, `task`, `effect`, others are for people.

use crate::effect::Effect;
use crate::links::{Links, Target, targets};
use crate::schedule_file::ScheduleFile;
use crate::target_values::{TargetValue, global_id};
use crate::task_values::all_tasks;
use messages::Site;
use schedule_files::{cell_of, text_of};
use std::collections::BTreeMap;

/// Most rows of a table.
const MAX_ROWS: usize = 4_000_000;

/// A row with a task.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TableLink {
    /// Line in the table, from 1.
    pub line: u64,
    /// GlobalId of an element or space.
    pub global_id: String,
    /// Code or id of a task.
    pub task: String,
    /// What it does.
    pub effect: Effect,
}

/// A table that cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum LinkTableError {
    /// It is no table, or not in UTF-8.
    #[error("the table of links cannot be read")]
    Csv(#[source] csv::Error),
    /// A column is missing.
    #[error("the table of links has no column {0:?}; its columns are global_id, task, effect and any others")]
    Column(&'static str),
    /// An effect that does not exist.
    #[error("line {line}: effect {effect:?} is none of builds, removes, works_in, uses")]
    Effect {
        /// From 1.
        line: u64,
        /// As written.
        effect: String,
    },
    /// Too large.
    #[error("the table of links has more than {MAX_ROWS} rows")]
    TooLong,
}

/// Reads a table: separated by commas or semicolons, one link a row. Rows without a task are passed over: the element has none.
///
/// # Errors
/// No table, a missing column, an unknown effect.
pub fn parse_link_table(bytes: &[u8]) -> Result<Vec<TableLink>, LinkTableError> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let header = bytes.split(|b| *b == b'\n').next().unwrap_or_default();
    let count = |separator: u8| header.iter().filter(|b| **b == separator).count();
    let separator = if count(b';') > count(b',') { b';' } else { b',' };
    let mut reader =
        csv::ReaderBuilder::new().delimiter(separator).flexible(true).trim(csv::Trim::All).from_reader(bytes);
    let headers = reader.headers().map_err(LinkTableError::Csv)?.clone();
    let column = |name: &str| headers.iter().position(|header| header.eq_ignore_ascii_case(name));
    let id = column("global_id").ok_or(LinkTableError::Column("global_id"))?;
    let task = column("task").ok_or(LinkTableError::Column("task"))?;
    let effect = column("effect");
    let mut links = Vec::new();
    let (mut line, mut counted) = (1, 0);
    for (k, record) in reader.into_records().enumerate() {
        if k == MAX_ROWS {
            return Err(LinkTableError::TooLong);
        }
        let record = record.map_err(LinkTableError::Csv)?;
        // The reader's own count is one short where lines end with a carriage return: the line feed begins the next record.
        let start = record.position().map_or(counted, |position| position.byte() as usize);
        let start = start + usize::from(bytes.get(start) == Some(&b'\n'));
        line += bytes[counted..start].iter().filter(|b| **b == b'\n').count() as u64;
        counted = start;
        let cell = |k: usize| text_of(record.get(k).unwrap_or_default());
        if cell(id).is_empty() || cell(task).is_empty() {
            continue;
        }
        let effect = match effect.map(cell).unwrap_or_default() {
            "" => Effect::Builds,
            name => Effect::named(name).ok_or_else(|| LinkTableError::Effect { line, effect: name.to_owned() })?,
        };
        links.push(TableLink { line, global_id: cell(id).to_owned(), task: cell(task).to_owned(), effect });
    }
    Ok(links)
}

/// The table of all elements and spaces with their links; one row for those without.
///
/// Reading it back gives the same links, unless several tasks have the same code. It begins with a byte order mark: without one
/// spreadsheets take it for a text of an old code page.
pub fn link_table(site: &Site<'_>, plans: &[ScheduleFile], links: &Links) -> String {
    let tasks = all_tasks(plans);
    let mut by_target: BTreeMap<Target, Vec<(&str, &str, &'static str)>> = BTreeMap::new();
    for link in &links.links {
        let task = tasks[link.task].task;
        let id = if task.code.is_empty() { &task.uid } else { &task.code };
        by_target.entry(link.target).or_default().push((id, &task.name, link.effect.name()));
    }
    let mut writer = csv::Writer::from_writer("\u{feff}".as_bytes().to_vec());
    let mut write = |row: [&str; 7]| {
        let cells = row.map(cell_of);
        writer.write_record(cells.iter().map(|cell| cell.as_bytes())).expect("memory takes every row");
    };
    write(["global_id", "task", "effect", "class", "name", "storey", "task_name"]);
    for target in targets(site) {
        let id = global_id(site, target);
        let [class, name] = described(site, target);
        let storey = TargetValue::Storey.of(site, target).into_iter().next().unwrap_or_default();
        match by_target.get(&target) {
            Some(rows) => rows.iter().for_each(|(task, task_name, effect)| {
                write([id, task, effect, class, name, &storey, task_name]);
            }),
            None => write([id, "", "", class, name, &storey, ""]),
        }
    }
    String::from_utf8(writer.into_inner().expect("memory takes every row")).expect("texts are UTF-8")
}

/// Entity and name of a target.
pub(crate) fn described<'s>(site: &Site<'s>, target: Target) -> [&'s str; 2] {
    match target {
        Target::Element(k) => {
            let element = &site.elements[k as usize];
            [site.text(element.ifc_type), site.text(element.name)]
        }
        Target::Space(k) => ["IfcSpace", site.text(site.spaces[k as usize].name)],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_of_spreadsheets_are_read() {
        for text in [
            "global_id,task,effect\nA,1020,\nB,,\nC, 1030 ,removes\n",
            "\u{feff}Global_ID;Name;Effect;Task\r\nA;wall, outer;;1020\r\nB;x;;\r\nC;;removes;1030\r\n",
        ] {
            let links = parse_link_table(text.as_bytes()).unwrap();
            let found: Vec<_> =
                links.iter().map(|l| (l.line, l.global_id.as_str(), l.task.as_str(), l.effect)).collect();
            assert_eq!(found, [(2, "A", "1020", Effect::Builds), (4, "C", "1030", Effect::Removes)]);
        }
    }

    #[test]
    fn tables_without_tasks_and_unknown_effects_are_refused() {
        let error = |text: &str| parse_link_table(text.as_bytes()).unwrap_err().to_string();
        assert!(error("global_id,effect\n").contains("no column \"task\""));
        assert!(error("global_id,task,effect\nA,1,breaks\n").contains("line 2"));
        assert!(error("").contains("global_id"));
    }
}
