//! Calendars of an XER file.

use super::calendar_data;
use super::tables::Tables;
use crate::PlanFileError;
use crate::assemble::WrittenPlan;
use crate::calendars::{WrittenCalendar, resolve};
use crate::p6::{Record, fill_week};
use crate::plan::{FindingKind, PlanCalendar};
use crate::projects::choose_default;

/// All calendars, with the exceptions of the global calendar that a calendar is based on; that of the first project is the default.
///
/// # Errors
/// More exceptions than a schedule has.
pub(super) fn read(tables: &Tables<'_>, plan: &mut WrittenPlan) -> Result<Vec<PlanCalendar>, PlanFileError> {
    tables.require("CALENDAR", &["clndr_id"])?;
    let mut written = Vec::new();
    for row in tables.rows("CALENDAR") {
        let (uid, name) = (row.cell("clndr_id").to_owned(), row.text("clndr_name").into_owned());
        let mut data = calendar_data::parse(row.cell("clndr_data"));
        if !data.unread.is_empty() {
            let message = format!("of calendar {name:?} {} cannot be read", data.unread.join(", "));
            plan.find(None, FindingKind::UnreadableValue, message);
        }
        fill_week(&mut data.week);
        let is_default = row.cell("default_flag") == "Y";
        let base = row.given("base_clndr_id").map(str::to_owned);
        written.push(WrittenCalendar { uid, name, is_default, base, week: data.week, exceptions: data.exceptions });
    }
    choose_default(&mut plan.projects, &mut written);
    resolve(&written, &mut plan.findings)
}
