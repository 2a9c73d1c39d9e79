//! The next change of an answer, by later changes of the schedule.

use schemars::JsonSchema;
use serde::Serialize;

/// The first later change of the schedule at which the answer is the opposite: what changes in the meantime and back is found too,
/// because maps of every change are drawn in turn.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Later {
    /// When; null if the answer stays what it is, or nobody looked.
    pub at: Option<String>,
    /// For how many changes maps were drawn.
    pub n_changes: usize,
    /// Why no later maps were drawn; null if they were.
    pub why_not_searched: Option<String>,
}

impl Later {
    /// Nobody looked.
    pub fn not_searched(why: impl Into<String>) -> Self {
        Self { at: None, n_changes: 0, why_not_searched: Some(why.into()) }
    }

    /// For people, where `other` is what the answer becomes.
    pub(crate) fn text(&self, other: &str) -> String {
        match (self, &self.why_not_searched) {
            (_, Some(why)) => format!("whether that changes was not searched: {why}"),
            (Self { at: Some(at), .. }, None) => format!("{other} from {at} on, by the schedule"),
            (Self { n_changes: 0, .. }, None) => "the schedule has no later change".to_owned(),
            (Self { n_changes, .. }, None) => format!("that stays so at all {n_changes} later changes of the schedule"),
        }
    }
}
