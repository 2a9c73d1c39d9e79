//! `actuals.csv`: elements observed before their planned finish, as reported progress for the schedule.

use super::input::DeviationExport;
use crate::csv::quoted;
use messages::{DeviationVerdict, plan_time};
use std::fmt::Write;

/// One line for each element that is early: it was finished by the plan time, and the start is not known. What seems to
/// be missing is never reported: it would erase an obstacle.
pub(super) fn table(input: &DeviationExport<'_>) -> String {
    let mut text = "id,start,finish\n".to_owned();
    let Some(seen) = plan_time(input.deviations.head.plan_time_s) else { return text };
    for element in input.deviations.elements.iter().filter(|e| e.verdict == DeviationVerdict::Early) {
        // Writing to a string does not fail.
        let _ = writeln!(text, "{},,{seen}", quoted(input.global_id(element)));
    }
    text
}
