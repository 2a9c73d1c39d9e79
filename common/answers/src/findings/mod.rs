//! Findings: what model, schedule and mission plan say of one thing, and all that was found wrong, assumed, replaced or left out.

mod about;
mod document;
mod list;

pub use about::Finding;
pub use document::{ReportDocument, WaypointsDocument};
pub use list::{Findings, FindingsAnswer, ListedFindings, NamedFinding, findings};

pub(crate) use about::findings_about;
