//! One thing that was looked at, and what was found.

use serde::Serialize;

/// What was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Verdict {
    Ok,
    Warning,
    Failure,
}

/// One thing that was looked at.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub(super) struct Check {
    pub(super) what: &'static str,
    pub(super) verdict: Verdict,
    pub(super) found: String,
}

pub(super) fn ok(what: &'static str, found: impl Into<String>) -> Check {
    Check { what, verdict: Verdict::Ok, found: found.into() }
}

pub(super) fn warning(what: &'static str, found: impl Into<String>) -> Check {
    Check { what, verdict: Verdict::Warning, found: found.into() }
}

pub(super) fn failure(what: &'static str, found: impl Into<String>) -> Check {
    Check { what, verdict: Verdict::Failure, found: found.into() }
}
