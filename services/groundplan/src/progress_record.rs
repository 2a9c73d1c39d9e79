//! Describes what a conversion is doing: stage, steps, times, what it waits for.

use schemars::JsonSchema;
use serde::Serialize;
use std::fmt;
use std::time::Duration;

/// Time into a stage from which on what is left of it is told, and the shortest rest that is.
const KNOWN_FROM: Duration = Duration::from_secs(2);
const MIN_LEFT_S: f64 = 2.0;

/// What a conversion is doing. With `--json` each is a line on standard error: at every stage, once a second where work
/// advances, every five seconds where it does not.
#[derive(Debug, Clone, Default, PartialEq, Serialize, JsonSchema)]
pub(crate) struct ProgressRecord {
    /// The stage: `reading`, `meshing`, `joining`, `slicing`, `drawing`, `planning` or `writing`.
    pub(crate) stage: &'static str,
    /// Name of the file; null where the work is for all of them.
    pub(crate) file: Option<String>,
    /// Steps of the stage that are done: files read, elements meshed, elements sliced for a storey; null if they are not
    /// counted.
    pub(crate) done: Option<usize>,
    /// Steps of the stage; null if they are not counted.
    pub(crate) total: Option<usize>,
    /// Seconds since the beginning.
    pub(crate) elapsed_s: f64,
    /// Seconds until the end of the stage, as it went so far; null if that is not known.
    pub(crate) left_s: Option<f64>,
    /// Seconds for which nothing has advanced; null below five.
    pub(crate) stands_s: Option<f64>,
    /// STEP id, GlobalId and name of the most detailed element that is not meshed yet; null outside of meshing.
    pub(crate) waits_for: Option<String>,
}

impl ProgressRecord {
    /// Only the stage.
    pub(crate) fn of(stage: &'static str) -> Self {
        Self { stage, ..Self::default() }
    }

    /// True if both are of one stage of one file.
    pub(crate) fn is_same_stage(&self, other: &Self) -> bool {
        (self.stage, &self.file) == (other.stage, &other.file)
    }

    /// Seconds until the end of the stage, which has taken so long.
    pub(crate) fn left_s(&self, since: Duration) -> Option<f64> {
        let (done, total) = self.done.zip(self.total).filter(|(done, _)| *done > 0 && since >= KNOWN_FROM)?;
        let left_s = since.as_secs_f64() / done as f64 * total.saturating_sub(done) as f64;
        (left_s >= MIN_LEFT_S).then(|| left_s.round())
    }
}

impl fmt::Display for ProgressRecord {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.stage)?;
        if let Some(file) = &self.file {
            write!(f, " {file}")?;
        }
        if let Some((done, total)) = self.done.zip(self.total).filter(|(_, total)| *total > 1) {
            write!(f, " {done} of {total}")?;
        }
        match (self.stands_s, &self.waits_for, self.left_s) {
            (Some(stands_s), Some(element), _) => write!(f, ", for {stands_s:.0} s at {element} or another"),
            (Some(stands_s), None, _) => write!(f, ", for {stands_s:.0} s"),
            (None, _, Some(left_s)) => write!(f, ", about {left_s:.0} s left"),
            (None, _, None) => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shipped_schema::assert_shipped_schema;

    #[test]
    fn the_schema_is_that_of_the_record() {
        assert_shipped_schema("progress", &schemars::schema_for!(ProgressRecord));
    }

    #[test]
    fn what_is_left_is_told_when_it_can_be_known() {
        let record = ProgressRecord { done: Some(10), total: Some(40), ..ProgressRecord::of("slicing") };
        assert_eq!(record.left_s(Duration::from_secs(1)), None);
        assert_eq!(record.left_s(Duration::from_secs(4)), Some(12.0));
        assert_eq!(ProgressRecord::of("drawing").left_s(Duration::from_secs(9)), None);
    }
}
