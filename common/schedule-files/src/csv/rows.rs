//! The task of a row.

use super::{dates, lengths, table::Table};
use crate::assemble::WrittenPlan;
use crate::options::CsvColumn;
use crate::plan::{FindingKind, Length, PlanDate, PlanTask, PlanTaskKind};
use crate::values::number;
use frames::written_date::DateOrder;

/// The task of a row, the next one of the plan, with findings about what cannot be read.
pub(super) fn task(table: &Table, row: usize, order: DateOrder, percent: [f64; 2], plan: &mut WrittenPlan) -> PlanTask {
    let mut cells = Cells { table, row, plan };
    let [current, planned, early, late, actual, baseline] =
        dates::COLUMNS.map(|pair| pair.map(|column| cells.date(column, order)));
    let duration = cells.length(CsvColumn::Duration);
    let complete = [CsvColumn::PercentComplete, CsvColumn::PhysicalPercentComplete];
    let [complete, physical_complete] = [0, 1].map(|k| cells.share(complete[k], percent[k]));
    let remaining = cells.length(CsvColumn::RemainingDuration);
    cells.check_level();
    if table.is_too_long(row) {
        let message = "its row has more cells than the heading; they are left out".to_owned();
        cells.plan.find(Some(cells.plan.next_task()), FindingKind::NotUnderstood, message);
    }
    let text = |column| table.cell(row, column).to_owned();
    let code = Some(text(CsvColumn::Code)).filter(|code| !code.is_empty()).unwrap_or_else(|| text(CsvColumn::Id));
    let mut task = PlanTask {
        uid: table.uid(row).to_owned(),
        code,
        wbs: text(CsvColumn::Wbs),
        name: text(CsvColumn::Name),
        kind: kind(table, row, duration),
        duration,
        remaining,
        complete,
        physical_complete,
        is_inactive: truth(table.cell(row, CsvColumn::Active)) == Some(false),
        ..Default::default()
    };
    task.dates.current = current;
    task.dates.planned = planned;
    task.dates.early = early;
    task.dates.late = late;
    task.dates.actual = actual;
    task.dates.baseline = baseline;
    task
}

/// A row, and where its findings go.
struct Cells<'a> {
    table: &'a Table,
    row: usize,
    plan: &'a mut WrittenPlan,
}

impl Cells<'_> {
    /// A value; none for an empty cell and for one that cannot be read, which is found.
    fn read<T>(&mut self, column: CsvColumn, read: impl Fn(&str) -> Option<T>) -> Option<T> {
        let text = self.table.cell(self.row, column);
        let is_empty = ["", "-", "NA", "N/A", "NV"].contains(&text);
        let value = if is_empty { None } else { read(text) };
        if value.is_none() && !is_empty {
            let place = self.table.place(self.row, column);
            let message = format!("its {} {text:?} cannot be read{place}", self.table.heading(column));
            self.plan.find(Some(self.plan.next_task()), FindingKind::UnreadableValue, message);
        }
        value
    }

    fn date(&mut self, column: CsvColumn, order: DateOrder) -> Option<PlanDate> {
        self.read(column, |text| dates::date(text, order))
    }

    fn length(&mut self, column: CsvColumn) -> Option<Length> {
        let unit = self.table.unit(column);
        self.read(column, |text| lengths::length(text, unit))
    }

    fn share(&mut self, column: CsvColumn, whole: f64) -> Option<f64> {
        self.read(column, |text| Some((number(text.trim_end_matches('%').trim_end())? / whole).clamp(0.0, 1.0)))
    }

    fn check_level(&mut self) {
        self.read(CsvColumn::OutlineLevel, |text| text.parse::<u32>().ok());
    }
}

/// By the type, by the mark of milestones, or as something that takes no time.
fn kind(table: &Table, row: usize, duration: Option<Length>) -> PlanTaskKind {
    let words = table.cell(row, CsvColumn::Type).to_lowercase();
    if ["summary", "sammelvorgang", "wbs summary"].contains(&words.as_str()) {
        return PlanTaskKind::Summary;
    }
    if ["level of effort", "hammock"].contains(&words.as_str()) {
        return PlanTaskKind::Span;
    }
    let is_milestone = truth(table.cell(row, CsvColumn::Milestone)) == Some(true)
        || ["milestone", "start milestone", "finish milestone", "meilenstein"].contains(&words.as_str());
    match duration {
        Some(length) if length.seconds == 0 => PlanTaskKind::Milestone,
        None if is_milestone => PlanTaskKind::Milestone,
        _ => PlanTaskKind::Task,
    }
}

fn truth(text: &str) -> Option<bool> {
    match text.to_lowercase().as_str() {
        "yes" | "ja" | "true" | "wahr" | "1" | "x" => Some(true),
        "no" | "nein" | "false" | "falsch" | "0" => Some(false),
        _ => None,
    }
}
