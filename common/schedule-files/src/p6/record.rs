//! A record of a file: cells with names, all of them text.

use crate::plan::{Finding, FindingKind, PlanDate};
use crate::values;
use std::borrow::Cow;

/// A row of XER, or an element of P6 XML with its children.
pub(crate) trait Record {
    /// The cell without spaces around it; empty if there is none.
    fn cell(&self, name: &str) -> &str;

    /// A text for people.
    fn text(&self, name: &str) -> Cow<'_, str> {
        self.cell(name).into()
    }

    /// The cell, if it is not empty.
    fn given(&self, name: &str) -> Option<&str> {
        Some(self.cell(name)).filter(|cell| !cell.is_empty())
    }

    /// A date with time of day.
    fn date(&self, name: &str, task: Option<usize>, findings: &mut Vec<Finding>) -> Option<PlanDate> {
        self.read(name, task, findings, values::date)
    }

    /// A number.
    fn number(&self, name: &str, task: Option<usize>, findings: &mut Vec<Finding>) -> Option<f64> {
        self.read(name, task, findings, values::number)
    }

    /// Hours as seconds.
    fn hours(&self, name: &str, task: Option<usize>, findings: &mut Vec<Finding>) -> Option<i64> {
        self.read(name, task, findings, |text| values::seconds(values::number(text)?, 3600.0))
    }

    /// What a cell says; a finding if it cannot be read, and nothing if it is empty.
    fn read<T>(
        &self,
        name: &str,
        task: Option<usize>,
        findings: &mut Vec<Finding>,
        read: impl Fn(&str) -> Option<T>,
    ) -> Option<T> {
        let text = self.given(name)?;
        let value = read(text);
        if value.is_none() {
            let message = format!("its {name} {text:?} cannot be read");
            findings.push(Finding { task, kind: FindingKind::UnreadableValue, message });
        }
        value
    }
}
