//! Progress in an XER file of Primavera P6: cells of the table TASK.

use crate::planner_update::{Changed, PlannerFileError, TaskUpdates, number};
use std::ops::Range;

/// Places of the columns of TASK that are read or written.
struct Columns {
    n: usize,
    id: usize,
    status: usize,
    remaining: usize,
    target: usize,
    percent_type: Option<usize>,
    physical: Option<usize>,
    start: Option<usize>,
    finish: Option<usize>,
}

impl Columns {
    fn of(names: &[&[u8]]) -> Result<Self, PlannerFileError> {
        let place = |column: &str| names.iter().position(|name| *name == column.as_bytes());
        let needed = |column| place(column).ok_or(PlannerFileError::Column { column });
        Ok(Self {
            n: names.len(),
            id: needed("task_id")?,
            status: needed("status_code")?,
            remaining: needed("remain_drtn_hr_cnt")?,
            target: needed("target_drtn_hr_cnt")?,
            percent_type: place("complete_pct_type"),
            physical: place("phys_complete_pct"),
            start: place("act_start_date"),
            finish: place("act_end_date"),
        })
    }

    /// Columns of dates that the table lacks, which come behind the others.
    fn lacking(&self) -> impl Iterator<Item = &'static str> {
        let dates = [("act_start_date", self.start), ("act_end_date", self.finish)];
        dates.into_iter().filter(|(_, place)| place.is_none()).map(|(name, _)| name)
    }
}

/// The file with progress: status, actual dates, remaining duration, and the physical per cent of tasks that go by it. P6 works out
/// the other percentages. A table that has no columns of actual dates gets them behind its others.
///
/// # Errors
/// No table of tasks, or one without a column that is needed.
pub fn updated_xer(file: &[u8], updates: &TaskUpdates) -> Result<Vec<u8>, PlannerFileError> {
    let separator = if uses_commas(file) { ',' } else { '.' };
    let is_changed = updates.values().any(|update| Changed::of(update).is_some());
    let (mut columns, mut is_tasks, mut has_tasks) = (None, false, false);
    let (mut out, mut copied) = (Vec::with_capacity(file.len()), 0);
    for record in records(file) {
        let cells = cells(file, &record);
        let texts: Vec<&[u8]> = cells.iter().map(|cell| &file[cell.clone()]).collect();
        let mut edits: Vec<(Range<usize>, String)> = Vec::new();
        match texts[0] {
            b"%T" => {
                is_tasks = texts.get(1) == Some(&&b"TASK"[..]);
                has_tasks |= is_tasks;
            }
            b"%F" if is_tasks => {
                let found = Columns::of(&texts)?;
                let lacking = found.lacking().filter(|_| is_changed).map(|name| format!("\t{name}"));
                edits.push((record.end..record.end, lacking.collect()));
                columns = Some(found);
            }
            b"%R" if is_tasks => {
                let Some(columns) = &columns else { continue };
                let id = texts.get(columns.id).map(|id| String::from_utf8_lossy(id).into_owned()).unwrap_or_default();
                let changed = updates.get(&id).and_then(Changed::of);
                let lacking: Vec<&str> = columns.lacking().filter(|_| is_changed).collect();
                if !lacking.is_empty() {
                    // A row may leave out its last cells.
                    let mut added = "\t".repeat(columns.n.saturating_sub(cells.len()));
                    for name in lacking {
                        let dates =
                            changed.as_ref().map(|c| if name == "act_start_date" { &c.start } else { &c.finish });
                        let at = dates.and_then(|at| at.as_deref()).map_or(String::new(), date);
                        added.push('\t');
                        added.push_str(&at);
                    }
                    edits.push((record.end..record.end, added));
                }
                let new = changed.map(|changed| new_cells(columns, &texts, &changed, separator));
                let placed = new.into_iter().flatten().filter_map(|(k, text)| Some((cells.get(k)?.clone(), text)));
                edits.extend(placed);
            }
            _ => {}
        }
        edits.sort_by_key(|(place, _)| (place.start, place.end));
        for (place, text) in edits {
            out.extend_from_slice(&file[copied..place.start]);
            out.extend_from_slice(text.as_bytes());
            copied = place.end;
        }
    }
    out.extend_from_slice(&file[copied..]);
    if has_tasks { Ok(out) } else { Err(PlannerFileError::NoTasks) }
}

/// Cells of a task that change, by their columns.
fn new_cells(columns: &Columns, texts: &[&[u8]], changed: &Changed, separator: char) -> Vec<(usize, String)> {
    let text = |k: usize| texts.get(k).and_then(|text| std::str::from_utf8(text).ok());
    let status = if changed.is_done { "TK_Complete" } else { "TK_Active" };
    let mut new = vec![(columns.status, status.to_owned())];
    new.extend(columns.start.zip(changed.start.as_deref()).map(|(k, at)| (k, date(at))));
    new.extend(columns.finish.zip(changed.finish.as_deref()).map(|(k, at)| (k, date(at))));
    if !changed.is_done {
        // A finish that the file has is that of a task which the report says is at work.
        new.extend(
            columns.finish.filter(|k| text(*k).is_some_and(|text| !text.is_empty())).map(|k| (k, String::new())),
        );
    }
    let planned_h = text(columns.target).and_then(|hours| hours.replace(',', ".").parse::<f64>().ok());
    let remaining_h = if changed.is_done { Some(0.0) } else { planned_h.and_then(|hours| changed.remaining_h(hours)) };
    new.extend(remaining_h.map(|hours| (columns.remaining, number(hours, separator))));
    if columns.percent_type.and_then(text) == Some("CP_Phys") {
        new.extend(columns.physical.zip(changed.percent).map(|(k, percent)| (k, number(percent, separator))));
    }
    new
}

/// `YYYY-MM-DDTHH:MM:SS` as P6 writes it.
fn date(at: &str) -> String {
    at.get(..16).unwrap_or(at).replace('T', " ")
}

/// Places of the records, without the line ends behind them. A record goes on over line breaks in its texts.
fn records(file: &[u8]) -> Vec<Range<usize>> {
    let is_start = |at: usize| file.get(at) == Some(&b'%') && (at == 0 || file[at - 1] == b'\n');
    let starts: Vec<usize> = memchr::memchr_iter(b'%', file).filter(|at| is_start(*at)).collect();
    let ends = starts.iter().skip(1).copied().chain([file.len()]);
    let without_line_end = |(start, end): (&usize, usize)| {
        let n = file[*start..end].iter().rev().take_while(|byte| matches!(byte, b'\r' | b'\n')).count();
        *start..end - n
    };
    starts.iter().zip(ends).map(without_line_end).collect()
}

/// Places of the cells of a record; there is one at least.
fn cells(file: &[u8], record: &Range<usize>) -> Vec<Range<usize>> {
    let tabs = memchr::memchr_iter(b'\t', &file[record.clone()]).map(|tab| record.start + tab);
    let ends: Vec<usize> = tabs.chain([record.end]).collect();
    let starts = std::iter::once(record.start).chain(ends.iter().map(|end| end + 1));
    starts.zip(&ends).map(|(start, end)| start..*end).collect()
}

/// True if durations have a comma.
fn uses_commas(file: &[u8]) -> bool {
    let mut target = None;
    let mut is_tasks = false;
    records(file).iter().any(|record| {
        let cells = cells(file, record);
        match &file[cells[0].clone()] {
            b"%T" => is_tasks = cells.get(1).is_some_and(|name| &file[name.clone()] == b"TASK"),
            b"%F" if is_tasks => target = cells.iter().position(|cell| &file[cell.clone()] == b"target_drtn_hr_cnt"),
            b"%R" if is_tasks => {
                return target.and_then(|k| cells.get(k)).is_some_and(|cell| file[cell.clone()].contains(&b','));
            }
            _ => {}
        }
        false
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planner_update::TaskUpdate;

    const FILE: &str = "ERMHDR\t20.12\r\n%T\tTASK\r\n%F\ttask_id\ttask_name\tstatus_code\tact_start_date\tact_end_date\tremain_drtn_hr_cnt\ttarget_drtn_hr_cnt\tcomplete_pct_type\tphys_complete_pct\ttask_type\r\n%R\t7\tWände\r\nOG\tTK_NotStart\t\t\t40,5\t40,5\tCP_Phys\t0\tTT_Task\r\n%R\t8\tT\tTK_NotStart\t\t\t40\t40\tCP_Drtn\t0\tTT_Task\r\n%R\t9\tU\tTK_NotStart\t\t\t8\t8\tCP_Drtn\t0\tTT_Task\r\n%T\tTASKPRED\r\n%F\ttask_id\r\n%R\t7\r\n%E\r\n";

    fn update(percent: f64, start: Option<&str>, finish: Option<&str>) -> TaskUpdate {
        TaskUpdate { percent: Some(percent), start: start.map(str::to_owned), finish: finish.map(str::to_owned) }
    }

    #[test]
    fn cells_of_tasks_change_and_nothing_else() {
        let (seen, done) = (Some("2024-03-04T08:00:00"), Some("2024-03-07T17:00:00"));
        let updates = TaskUpdates::from([
            ("7".to_owned(), update(20.0, seen, None)),
            ("8".to_owned(), update(100.0, seen, done)),
            ("9".to_owned(), update(0.0, None, None)),
        ]);
        let new = String::from_utf8(updated_xer(FILE.as_bytes(), &updates).unwrap()).unwrap();
        let expected = FILE
            .replace(
                "OG\tTK_NotStart\t\t\t40,5\t40,5\tCP_Phys\t0",
                "OG\tTK_Active\t2024-03-04 08:00\t\t32,4\t40,5\tCP_Phys\t20",
            )
            .replace("T\tTK_NotStart\t\t\t40\t40", "T\tTK_Complete\t2024-03-04 08:00\t2024-03-07 17:00\t0\t40");
        assert_eq!(new, expected);
        assert_eq!(updated_xer(FILE.as_bytes(), &TaskUpdates::new()).unwrap(), FILE.as_bytes());
    }

    #[test]
    fn columns_of_dates_that_are_lacking_come_behind_the_others() {
        let file = "%T\tTASK\n%F\ttask_id\tstatus_code\tremain_drtn_hr_cnt\ttarget_drtn_hr_cnt\n%R\t7\tTK_NotStart\t8\t8\n%R\t8\tTK_NotStart\t8\t8\n%E\n";
        let updates = TaskUpdates::from([("8".to_owned(), update(50.0, Some("2024-03-04T08:00:00"), None))]);
        let new = String::from_utf8(updated_xer(file.as_bytes(), &updates).unwrap()).unwrap();
        assert_eq!(
            new,
            "%T\tTASK\n%F\ttask_id\tstatus_code\tremain_drtn_hr_cnt\ttarget_drtn_hr_cnt\tact_start_date\tact_end_date\n\
             %R\t7\tTK_NotStart\t8\t8\t\t\n%R\t8\tTK_Active\t4\t8\t2024-03-04 08:00\t\n%E\n"
        );
        assert_eq!(updated_xer(file.as_bytes(), &TaskUpdates::new()).unwrap(), file.as_bytes());
    }

    #[test]
    fn a_table_without_a_column_is_refused_by_its_name() {
        let file = FILE.replace("status_code", "other");
        let error = updated_xer(file.as_bytes(), &TaskUpdates::new()).unwrap_err().to_string();
        assert!(error.contains("status_code"), "{error}");
        assert!(matches!(updated_xer(b"ERMHDR\n", &TaskUpdates::new()), Err(PlannerFileError::NoTasks)));
    }
}
